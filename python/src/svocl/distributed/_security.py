# SPDX-License-Identifier: MIT
"""Who may talk to whom: Dask's parties run what they are sent, so beyond this machine they show certificates first."""

import importlib
import ipaddress
import socket
import ssl
from typing import Any, Optional

SECURE = ("tls", "wss")
"""Schemes of addresses at which both sides show a certificate."""

SETTINGS = "Dask's settings distributed.comm.tls.ca-file, .client.cert and .client.key"


def check_address(address: str, allow_insecure: bool) -> None:
    """Refuses a scheduler that is not on this machine where nobody proves who they are.

    Raises:
        ValueError: str() says what to do.
    """
    addressing = importlib.import_module("distributed.comm.addressing")
    scheme, _ = addressing.parse_address(address)
    if scheme in SECURE or scheme == "inproc" or allow_insecure:
        return
    if not is_loopback(addressing.get_address_host(address)):
        raise ValueError(
            f"the scheduler {address} is not on a loopback address, and {scheme}:// proves nobody's identity: whoever "
            "reaches it can run code on its workers and here. Use tls:// with --tls-ca, --tls-cert and --tls-key, or "
            "--insecure in a network of your own"
        )


def is_loopback(host: str) -> bool:
    """Whether a host, by name or number, has loopback addresses alone."""
    try:
        found = socket.getaddrinfo(host, None)
    except (OSError, UnicodeError):
        return False
    return all(ipaddress.ip_address(str(place[0]).split("%")[0]).is_loopback for *_, place in found)


def make_security(ca: Optional[str], cert: Optional[str], key: Optional[str], address: Optional[str]) -> Any:
    """The distributed.Security of this command, and of the scheduler and the workers that it starts.

    Args:
        ca, cert, key: names of PEM files; all None: Dask's settings say.
        address: of the scheduler; None: it is started here.

    Returns:
        None where no certificates are asked for.

    Raises:
        ValueError: what is missing, or cannot be read.
    """
    security = importlib.import_module("distributed").Security
    if ca is None and cert is None and key is None:
        if address is None or address.split("://")[0] not in SECURE:
            return None
        made = security()
    elif ca is None or cert is None:
        raise ValueError("--tls-ca and --tls-cert go together; --tls-key may be in the file of --tls-cert")
    elif address is not None and address.split("://")[0] not in SECURE:
        raise ValueError(f"certificates are for schedulers at tls://, and {address} is none")
    else:
        made = security(
            tls_ca_file=ca,
            require_encryption=True,
            **{f"tls_{role}_cert": cert for role in ("client", "scheduler", "worker")},
            **{f"tls_{role}_key": key for role in ("client", "scheduler", "worker")},
        )
    files = made.get_tls_config_for_role("client")
    if not files.get("ca_file") or not files.get("cert"):
        raise ValueError(f"{address} asks for certificates: --tls-ca, --tls-cert and --tls-key, or {SETTINGS}")
    try:
        made.get_connection_args("client")
    except (OSError, ssl.SSLError) as problem:
        named = ", ".join(str(files[name]) for name in ("ca_file", "cert", "key") if files.get(name))
        raise ValueError(f"the certificates of {named} cannot be used: {problem}") from problem
    return made


def is_refused(problem: Optional[BaseException]) -> bool:
    """Whether a connection failed since a side did not trust the other's certificate; no later try can succeed."""
    while problem is not None:
        if isinstance(problem, ssl.SSLError):
            return True
        problem = problem.__cause__ or problem.__context__
    return False
