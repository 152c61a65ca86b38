# SPDX-License-Identifier: MIT
"""Which OpenCL drivers there are: the system's, or else PoCL as PyPI has it (pip install svocl[cpu])."""

import atexit
import glob
import importlib.util
import os
import shlex
import shutil
import tempfile
import warnings
from typing import Optional

_CHOICES = ("OCL_ICD_VENDORS", "OPENCL_VENDOR_PATH")  # variables of the loader, ocl-icd


def use_pocl_of_pip() -> None:
    """Where the system has no driver and the environment names none, the loader is given that of
    pocl-binary-distribution, if it is installed. Child processes inherit it."""
    if any(name in os.environ for name in _CHOICES) or glob.glob("/etc/OpenCL/vendors/*.icd"):
        return
    packages = _folder("pocl_binary_distribution")
    # It was made for pyopencl, and lies in that package's folder, whether that is installed or not.
    drivers = [] if packages is None else glob.glob(f"{glob.escape(packages)}/pyopencl/.libs/libpocl*.so*")
    if not drivers:
        return
    has_compiler = any(map(shutil.which, ("gcc", "clang", "cc"))) and shutil.which("ld") is not None
    if not has_compiler and not _use_linker_of_pip():
        warnings.warn(
            "svocl: PoCL of pip links kernels by ld and libgcc, which are not installed (Debian: apt install gcc, or "
            "pip install svocl[linker]), so it is not used",
            RuntimeWarning,
            stacklevel=3,
        )
        return
    os.environ["OCL_ICD_VENDORS"] = sorted(drivers)[0]


_LINKER = """#!/bin/sh
# The linker of PoCL's kernels, which use none of these libraries.
for word; do
    shift
    case $word in
    -lgcc | -lgcc_s | -lc) ;;
    *) set -- "$@" "$word" ;;
    esac
done
exec {} ld.lld "$@"
"""


def _use_linker_of_pip() -> bool:
    """Lets ld be the linker of ziglang, LLVM's, if that is installed. Without a linker PoCL would end the process."""
    packages = _folder("ziglang")
    program = "" if packages is None else os.path.join(packages, "ziglang", "zig")
    if not os.access(program, os.X_OK):
        return False
    folder = tempfile.mkdtemp(prefix="svocl-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    with open(os.path.join(folder, "ld"), "w", encoding="utf-8") as file:
        file.write(_LINKER.format(shlex.quote(program)))
    os.chmod(file.name, 0o700)
    os.environ["PATH"] = folder + os.pathsep + os.environ.get("PATH", os.defpath)
    return True


def _folder(package: str) -> Optional[str]:
    """The folder that a package is in; None: it is not installed."""
    found = importlib.util.find_spec(package)
    return None if found is None or found.origin is None else os.path.dirname(os.path.dirname(found.origin))
