# SPDX-License-Identifier: MIT
"""Who may talk to whom on a cluster, and what is never taken out of a file: pickles."""

import ast
import os
import pathlib
import pickle
import shutil
import subprocess

import pytest
from cluster import DEPTH, PART_BYTES, Pool, expect_tree, run

import svocl
from svocl.distributed import _security, model

pytest.importorskip("distributed", reason="Dask's distributed is not installed (pip install distributed)")
pytest.importorskip("tqdm", reason="tqdm is not installed (pip install tqdm)")
pytestmark = pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")


class Authority:
    """Who signs certificates, and one that it signed."""

    def __init__(self, folder):
        folder.mkdir()
        self.ca, self.cert, self.key = (folder / name for name in ("ca.pem", "node.pem", "node.key"))
        new_key = "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes"
        for command in (
            f"req -x509 {new_key} -keyout ca.key -out ca.pem -subj /CN=authority -days 2",
            f"req {new_key} -keyout node.key -out node.csr -subj /CN=node",
            "x509 -req -in node.csr -CA ca.pem -CAkey ca.key -CAcreateserial -out node.pem -days 2",
        ):
            subprocess.run(["openssl", *command.split()], cwd=folder, check=True, capture_output=True)

    def options(self, ending=""):
        return [f"--tls-ca{ending}", str(self.ca), "--tls-cert", str(self.cert), "--tls-key", str(self.key)]


@pytest.fixture(scope="module")
def authority(tmp_path_factory):
    if not shutil.which("openssl"):
        pytest.skip("the program openssl is not installed, which makes certificates")
    return Authority(tmp_path_factory.mktemp("tls") / "ours")


def test_a_job_between_certificates(authority, mesh_file, whole, tmp_path):
    """All three parties show a certificate of one authority; those who show none, or a stranger's, are not let in."""
    path = tmp_path / "tree.svo"
    with Pool(tmp_path) as pool:
        pool.options = authority.options("-file")
        pool.scheduler("tls://127.0.0.1")
        pool.worker()
        assert pool.address.startswith("tls://")
        strangers = Authority(tmp_path / "strangers")
        code, _, errors = run(
            mesh_file, path, "--scheduler", pool.address, "--connect-timeout", "2", *strangers.options()
        )
        assert code == 1 and "certificate" in errors.lower()
        code, _, errors = run(mesh_file, path, "--scheduler", pool.address)
        assert code == 2 and "asks for certificates: --tls-ca" in errors
        plain = pool.address.replace("tls://", "tcp://")
        assert run(mesh_file, path, "--scheduler", plain, "--connect-timeout", "2")[0] == 75
        assert not path.exists()
        code, document, _ = run(mesh_file, path, "--scheduler", pool.address, *authority.options())
        assert code == 0 and [worker["worker"][:6] for worker in document["workers"]] == ["tls://"]
    expect_tree(path, whole)


def test_workers_of_the_command_show_certificates(authority, mesh_file, whole, tmp_path):
    path = tmp_path / "tree.svo"
    code, document, _ = run(mesh_file, path, "--workers", "1", *authority.options())
    assert code == 0 and [worker["worker"][:6] for worker in document["workers"]] == ["tls://"]
    expect_tree(path, whole)


def test_a_scheduler_elsewhere_needs_certificates(mesh_file, tmp_path):
    """192.0.2.1 is an address for documentation (RFC 5737), which nobody has."""
    path = tmp_path / "tree.svo"
    for address in ("tcp://192.0.2.1:8786", "192.0.2.1:8786", "ws://192.0.2.1:8786", "tcp://[2001:db8::1]:8786"):
        with pytest.raises(ValueError, match="is not on a loopback address"):
            _security.check_address(address, False)
        _security.check_address(address, True)
    for address in ("tcp://127.0.0.1:8786", "tcp://127.8.9.10:8786", "tcp://localhost:8786", "tcp://[::1]:8786"):
        _security.check_address(address, False)
    for address in ("tls://192.0.2.1:8786", "wss://192.0.2.1:8786", "inproc://192.0.2.1/7/1"):
        _security.check_address(address, False)
    code, _, errors = run(mesh_file, path, "--scheduler", "tcp://192.0.2.1:8786")
    assert code == 2 and "--tls-ca, --tls-cert and --tls-key, or --insecure" in errors
    assert not os.path.exists(f"{path}.parts")
    code, _, errors = run(
        mesh_file, path, "--scheduler", "tcp://192.0.2.1:8786", "--insecure", "--connect-timeout", "1"
    )
    assert code == 75 and "no scheduler answers at tcp://192.0.2.1:8786" in errors


def test_certificates_that_are_none(authority, mesh_file, tmp_path):
    path = tmp_path / "tree.svo"
    for ca, cert, key, address, words in (
        (str(authority.ca), None, None, None, "--tls-ca and --tls-cert go together"),
        (str(authority.ca), str(authority.cert), None, "tcp://127.0.0.1:1", "tcp://127.0.0.1:1 is none"),
        (str(tmp_path / "no.pem"), str(authority.cert), str(authority.key), None, "no.pem.* cannot be used"),
        (str(mesh_file), str(authority.cert), str(authority.key), None, "torus.obj.* cannot be used"),
        (str(authority.ca), str(authority.cert), str(authority.ca), None, "ca.pem cannot be used"),
    ):
        with pytest.raises(ValueError, match=words):
            _security.make_security(ca, cert, key, address)
    code, _, errors = run(mesh_file, path, "--tls-ca", str(authority.ca))
    assert code == 2 and "go together" in errors and not path.exists()


# --- files ----------------------------------------------------------------------------------------------------------


class Bomb:
    """Whoever unpickles it makes a file."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (open, (str(self.path), "w"))


def test_no_file_is_unpickled(device, mesh_file, tmp_path, monkeypatch):
    """A pickle that does something when it is loaded, in place of each file of a job."""
    mark = tmp_path / "mark"
    bomb = pickle.dumps(Bomb(mark))
    pickle.loads(bomb).close()
    assert mark.exists()
    mark.unlink()
    folder = tmp_path / "tree.svo.parts"
    with svocl.Parts.create(device, svocl.read_mesh(mesh_file), DEPTH, folder, max_bytes=PART_BYTES) as parts:
        name, place = parts.entries[0].name, folder / parts.identity
        parts.build(0, device)
        (folder / f"{name}.part").write_bytes(bomb)
        (place / f"{name}.tri").write_bytes(bomb)
        assert not parts.is_built(0)
        with pytest.raises(svocl.FileDamagedError):
            parts.build(0, device)
        (folder / "plan").write_bytes(bomb)
        with pytest.raises(svocl.FileDamagedError):
            svocl.Parts(folder)
        (folder / "run-7.lease").write_bytes(bomb)
        with pytest.raises(svocl.UnavailableError):
            svocl.Parts.remove(folder)
    for kind, load in (("svo", svocl.Tree.load), ("obj", svocl.read_mesh), ("ply", svocl.read_mesh)):
        (tmp_path / f"bomb.{kind}").write_bytes(bomb)
        with pytest.raises(svocl.Error):
            load(tmp_path / f"bomb.{kind}")
    (tmp_path / "times.json").write_bytes(bomb)
    monkeypatch.setattr("sys.argv", ["model", str(tmp_path / "times.json")])
    with pytest.raises(ValueError):
        model.main()
    assert not mark.exists()


def test_no_module_can_unpickle():
    """None of the package imports what runs code out of data, and no array is loaded with its pickles."""
    running = {"pickle", "_pickle", "cPickle", "cloudpickle", "dill", "joblib", "marshal", "shelve", "runpy", "code"}
    files = sorted(pathlib.Path(svocl.__file__).parent.rglob("*.py"))
    assert len(files) > 30
    for path in files:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            found = [name for name in names if name.split(".")[0] in running]
            if isinstance(node, ast.Call):
                called = node.func.id if isinstance(node.func, ast.Name) else ""
                found += [called] if called in ("eval", "exec", "__import__") else []
                found += [word.arg for word in node.keywords if word.arg == "allow_pickle"]
            assert not found, f"{path}:{getattr(node, 'lineno', 0)}: {found}"
