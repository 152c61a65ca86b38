# SPDX-License-Identifier: MIT
"""Trees in parts by Dask's workers: one hash however many there are, and whatever happens to them.

Scheduler and workers are real processes. worker_faults.py makes workers kill, stop or delay at a certain part.
"""

import contextlib
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest
import shapes
from cluster import DEPTH, PART_BYTES, SECONDS, Pool, expect_tree, finish, long, run, start

import svocl
from svocl.distributed import _run, _tasks, model, plan_parts
from svocl.distributed.__main__ import read_options

pytest.importorskip("distributed", reason="Dask's distributed is not installed (pip install distributed)")
pytest.importorskip("tqdm", reason="tqdm is not installed (pip install tqdm)")
pytestmark = pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")


@pytest.fixture(scope="module")
def ply_file(mesh_file):
    """The same mesh as a file that is read by ranges."""
    positions, indices = shapes.torus(48, 24)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += f"element face {len(indices)}\nproperty list uchar uint vertex_indices\nend_header\n"
    faces = np.empty(len(indices), [("count", "u1"), ("corners", "<u4", 3)])
    faces["count"], faces["corners"] = 3, indices
    path = mesh_file.with_suffix(".ply")
    path.write_bytes(header.encode() + positions.astype("<f4").tobytes() + faces.tobytes())
    return path


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    """For tests that leave it alive."""
    with Pool(tmp_path_factory.mktemp("scheduler")) as made:
        made.scheduler()
        yield made.address


@pytest.fixture
def pool(scheduler, tmp_path):
    with Pool(tmp_path, scheduler) as made:
        yield made


# --- parts ----------------------------------------------------------------------------------------------------------


def test_parts_in_any_order_are_the_tree_in_one_piece(device, mesh, tmp_path, random):
    for need in (svocl.Need.DEFAULT, svocl.Need.RAYS | svocl.Need.NORMAL):
        with device.build(mesh, DEPTH, need=need) as tree:
            tree.save(tmp_path / "whole.svo")
        folder = tmp_path / "folder"
        with svocl.Parts.create(device, mesh, DEPTH, folder, max_bytes=PART_BYTES, need=need) as parts:
            assert len(parts) == len(parts.entries) > 10
            for index in random.permutation(len(parts)):
                assert not parts.is_built(index)
                with pytest.raises(svocl.FileError, match="is missing"):
                    parts.finish(tmp_path / "parts.svo")
                parts.build(index, device)
                assert parts.is_built(index)
            parts.finish(tmp_path / "parts.svo")
        svocl.Parts.remove(folder)
        assert (tmp_path / "parts.svo").read_bytes() == (tmp_path / "whole.svo").read_bytes()
        assert not folder.exists()


def test_parts_refuse_what_they_must(device, mesh, tmp_path):
    with pytest.raises(svocl.CapacityExceededError, match="max_bytes 1 is too small"):
        svocl.Parts.create(device, mesh, DEPTH, tmp_path / "small", max_bytes=1)
    with pytest.raises(svocl.FileError, match="nowhere"):
        svocl.Parts(tmp_path / "nowhere")
    with svocl.Parts.create(device, mesh, DEPTH, tmp_path / "folder") as parts:
        with pytest.raises(svocl.InvalidArgumentError, match="index"):
            parts.build(len(parts), device)
        with pytest.raises(svocl.InvalidArgumentError, match="index"):
            parts.is_built(len(parts))
    with pytest.raises(ValueError, match="Parts is closed"):
        parts.finish(tmp_path / "t.svo")


def test_a_folder_has_one_plan_at_a_time(device, mesh, tmp_path):
    """Another process with a lease is named; what was opened before a new plan builds nothing more."""
    folder = tmp_path / "tree.svo.parts"
    with svocl.Parts.lease(folder):
        with svocl.Parts.create(device, mesh, DEPTH, folder, max_bytes=PART_BYTES) as parts:
            assert re.fullmatch("[0-9a-f]{32}", parts.identity) and (folder / parts.identity).is_dir()
            with svocl.Parts.create(device, mesh, DEPTH - 1, folder, max_bytes=PART_BYTES) as anew:
                assert anew.identity != parts.identity
            with pytest.raises(svocl.UnavailableError, match="planned anew meanwhile"):
                parts.build(0, device)
        assert len(list(folder.glob("run-*.lease"))) == 1
    assert not list(folder.glob("*.lease"))
    (folder / "run-7.lease").write_text("m p elsewhere 7\n")
    with pytest.raises(svocl.UnavailableError, match="process 7 on elsewhere builds or stitches its parts"):
        svocl.Parts.create(device, mesh, DEPTH, folder, max_bytes=PART_BYTES)


def test_a_folder_in_use_is_tried_again(mesh_file, whole, tmp_path):
    """The command ends with 75 and goes on when the other run has ended."""
    path = tmp_path / "tree.svo"
    folder = tmp_path / "tree.svo.parts"
    folder.mkdir()
    (folder / "run-7.lease").write_text("m p elsewhere 7\n")
    code, _, errors = run(mesh_file, path, "--workers", "1")
    assert code == 75 and "process 7 on elsewhere" in errors
    (folder / "run-7.lease").unlink()
    assert run(mesh_file, path, "--workers", "1")[0] == 0
    expect_tree(path, whole)


@pytest.mark.parametrize("options", [[], ["--no-shared-folder"]])
def test_a_folder_planned_anew_under_a_run(pool, device, mesh, mesh_file, whole, tmp_path, options):
    """As after a run that was stopped until its lease was stale: it ends, and what it made is in no other tree."""
    path = tmp_path / "tree.svo"
    folder = tmp_path / "tree.svo.parts"
    moved = svocl.Mesh(mesh.positions + np.array([0.002, 0, 0], mesh.positions.dtype), mesh.indices)
    pool.worker("slow=0.1")
    job = start(mesh_file, path, "--scheduler", pool.address, *options)
    wait_for_parts(folder, 3)
    with pytest.raises(svocl.UnavailableError, match="builds or stitches its parts"):
        svocl.Parts.create(device, moved, DEPTH, folder, max_bytes=PART_BYTES)
    for lease in folder.glob("run-*.lease"):
        os.utime(lease, (0, 0))
    with svocl.Parts.create(device, moved, DEPTH, folder, max_bytes=PART_BYTES) as parts:
        code, _, errors = finish(job)
        assert code == 75 and "planned anew meanwhile" in errors and not path.exists()
        for index in range(len(parts)):
            parts.build(index, device)
        parts.finish(path)
    svocl.Parts.remove(folder)
    with device.build(moved, DEPTH) as tree:
        moved_hash = tree.hash()
    assert moved_hash != whole
    expect_tree(path, moved_hash)


# --- workers that work ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("workers", [pytest.param(1, marks=long), 2, pytest.param(3, marks=long), 4])
def test_one_hash_for_any_number_of_workers(mesh_file, whole, tmp_path, workers):
    """Odd numbers share the folder, even ones get triangles and send bytes back. Dask's usual port is taken."""
    path = tmp_path / "tree.svo"
    options = ["--no-shared-folder"] if workers % 2 == 0 else []
    with socket.socket() as other:
        with contextlib.suppress(OSError):  # it is taken already
            other.bind(("127.0.0.1", 8787))
            other.listen()
        code, document, errors = run(mesh_file, path, "--workers", str(workers), *options)
    assert "in use" not in errors
    assert code == 0 and document["kept"] == 0 and 1 <= len(document["workers"]) <= workers
    assert sum(worker["parts"] for worker in document["workers"]) == document["parts"] > 10
    assert "100%" in errors
    expect_tree(path, whole)


def files_of(folder):
    """The bytes of a plan's files, by name."""
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_one_plan_for_any_number_of_ranges(device, mesh, ply_file, tmp_path):
    plans = []
    for ranges in (1, 5):
        folder = tmp_path / "folder"
        with svocl.PartsPlanning(device, ply_file, DEPTH, folder, PART_BYTES, ranges) as planning:
            steps = 0
            while count := planning.task_count():
                assert count == ranges
                tasks = [planning.task(index) for index in range(count)]
                for index in reversed(range(count)):
                    planning.take(index, svocl.PartsPlanning.work(device, tasks[index]))
                steps += 1
            assert steps == 3
            with planning.finish() as parts:
                assert len(parts) > 10
        plans.append(files_of(folder))
        svocl.Parts.remove(folder)
    with svocl.Parts.create_from_file(device, ply_file, DEPTH, folder, max_bytes=PART_BYTES):
        plans.append(files_of(folder))
    assert plans[0] == plans[1] == plans[2]
    with pytest.raises(svocl.UnsupportedError, match="binary"):
        svocl.PartsPlanning(device, ply_file.with_suffix(".obj"), DEPTH, folder, PART_BYTES, 2)
    with pytest.raises(svocl.InvalidArgumentError, match="task is none"):
        svocl.PartsPlanning.work(device, b"no task")
    svocl.Parts.remove(folder)
    with svocl.Parts.create_from_file(device, ply_file.with_suffix(".obj"), DEPTH, folder) as parts:
        assert len(parts) == 1
    svocl.Parts.remove(folder)


def test_workers_plan(ply_file, whole, tmp_path):
    path = tmp_path / "tree.svo"
    code, document, errors = run(ply_file, path, "--workers", "2", "--ranges", "3")
    assert code == 0 and document["parts"] > 10 and "in its place" not in errors
    expect_tree(path, whole)


@pytest.mark.parametrize("need", [svocl.Need.DEFAULT, svocl.Need.RAYS | svocl.Need.NORMAL])
def test_any_shares_are_the_file_in_one_piece(device, mesh, tmp_path, need):
    with device.build(mesh, DEPTH, need=need) as tree:
        tree.save(tmp_path / "whole.svo")
    with svocl.Parts.create(device, mesh, DEPTH, tmp_path / "folder", max_bytes=PART_BYTES, need=need) as parts:
        with pytest.raises(svocl.FileError, match="is missing"):
            parts.begin_shares(2)
        for index in range(len(parts)):
            parts.build(index, device)
        for count in (1, 3, 50):
            with pytest.raises(svocl.UnavailableError, match="has not been begun"):
                parts.write_share(0, count)
            parts.begin_shares(count)
            for index in reversed(range(count)):
                with pytest.raises(svocl.UnavailableError, match="share 0 of"):
                    parts.finish_shares(count, tmp_path / "shares.svo")
                parts.write_share(index, count)
            parts.finish_shares(count, tmp_path / "shares.svo")
            assert (tmp_path / "shares.svo").read_bytes() == (tmp_path / "whole.svo").read_bytes()
            (tmp_path / "shares.svo").unlink()


def test_workers_stitch(ply_file, whole, tmp_path):
    """The times of all tasks tell how long other numbers of workers take."""
    path = tmp_path / "tree.svo"
    options = ["--workers", "2", "--ranges", "3", "--shares", "5", "--times", str(tmp_path / "times.json")]
    code, document, errors = run(ply_file, path, *options)
    assert code == 0 and "in its place" not in errors
    expect_tree(path, whole)
    steps = model.read_steps(json.loads((tmp_path / "times.json").read_text()))
    assert [len(step.tasks) for step in steps] == [3, 3, 3, document["parts"], 5]
    assert all(step.bytes > 0 and min(step.tasks) > 0 for step in steps) and steps[-1].own > 0
    command = [sys.executable, "-m", "svocl.distributed.model", str(tmp_path / "times.json"), "--workers", "1,1000"]
    lines = subprocess.check_output(command, text=True).splitlines()
    assert len(lines) == 4 and lines[2].startswith("| 1 | ") and lines[3].startswith("| 1,000 | ")


def test_a_worker_killed_while_it_stitches(pool, ply_file, whole, tmp_path):
    """Its share is written by the other one."""
    killed = pool.worker(f"share=1 signal={signal.SIGKILL:d}")
    pool.worker("slow=0.05")
    options = ["--scheduler", pool.address, "--ranges", "1", "--shares", "8"]
    code, _, errors = run(ply_file, tmp_path / "tree.svo", *options)
    assert code == 0 and killed.wait(SECONDS) == -signal.SIGKILL and "is gone" in errors
    expect_tree(tmp_path / "tree.svo", whole)


def test_the_model_of_a_job():
    """Closed forms: equal tasks, one long task, the engine, the storage."""
    times = {"plan 2": [[1.0, 0.5]] * 64, "own plan 2": [[0.25, 0.1]], "build": [[1.0, 1.0]] * 63 + [[9.0, 9.0]]}
    steps = model.read_steps({"tasks": times, "bytes": {"mesh": 1 << 30, "parts": 1 << 30}})
    assert [step.name for step in steps] == ["plan 2", "build"]
    assert model.estimate(steps, 1).seconds == 64.25 + 72
    assert model.estimate(steps, 64).steps == {"plan 2": 1.25, "build": 9.0}
    assert model.estimate(steps, 64).bounds == {"plan 2": "tasks", "build": "one task"}
    assert model.estimate(steps, 4).steps["build"] == 18  # the long one is taken first
    assert model.estimate(steps, 1000, engine=0.5).bounds["build"] == "engine"
    assert model.estimate(steps, 1000, bandwidth=1 << 26).steps == {"plan 2": 16.25, "build": 16.0}
    cpu = model.read_steps({"tasks": times, "bytes": {}}, cpu=True)
    assert model.estimate(cpu, 64).steps["plan 2"] == 0.6
    opened = {"build": [[2.0, 2.0]] * 7, "first build": [[5.0, 5.0]]}
    assert model.estimate(model.read_steps({"tasks": opened, "bytes": {}}), 4).seconds == 7  # each opens its device
    waited = {"tasks": {"build": [[2.0, 2.0]] * 8, "own stitch": [[1.0, 1.0]]}, "bytes": {}, "seconds": {"build": 21.0}}
    assert model.read_latency(waited) == 0.5
    assert model.estimate(model.read_steps(waited), 4, latency=0.5).steps["build"] == 5


def test_what_workers_cannot_plan_is_planned_here(pool, device, ply_file, tmp_path):
    distributed = pytest.importorskip("distributed")
    pool.environment["SVOCL_DEVICE"] = "none of this name"
    pool.worker()
    lines = []
    folder = tmp_path / "folder"
    with distributed.Client(pool.address, set_as_default=False) as client:
        with svocl.PartsPlanning(device, ply_file, DEPTH, folder, PART_BYTES, 2) as planning:
            with plan_parts(client, planning, device, report=lines.append) as parts:
                assert len(parts) > 10
    assert len(lines) == 1 and "none of this name" in lines[0]


def test_a_tree_above_the_nodes_of_a_file(mesh_file, whole, tmp_path):
    """It is refused before a part is built, and its folder removed again; --parts-only makes the folder of any tree."""
    square, path = tmp_path / "square.obj", tmp_path / "square.svo"
    square.write_text("v 0 0 .5\nv 1 0 .5\nv 1 1 .5\nv 0 1 .5\nf 1 2 3\nf 1 3 4\n")
    command = [sys.executable, "-m", "svocl.distributed", str(square), "-d", "16", "-o", str(path)]
    done = subprocess.run([*command, "--max-memory", "1G"], stderr=subprocess.PIPE, text=True, timeout=SECONDS)
    # 65536^2 leaves and a third of that above them.
    found = re.search(r"about (\d+) nodes are expected at depth 16; .*at most 2\^32 - 2 .*svocl.PartsTree", done.stderr)
    assert done.returncode == 1 and found
    assert int(found[1]) == pytest.approx(65536**2 * 4 / 3, rel=1e-4)
    assert not list(tmp_path.glob("square.svo*"))
    path = tmp_path / "tree.svo"
    assert run(mesh_file, path, "--workers", "1", "--parts-only")[0] == 0 and not path.exists()
    with svocl.PartsTree(f"{path}.parts") as tree:
        assert tree.hash() == whole
    code, document, _ = run(mesh_file, path, "--workers", "1")
    assert code == 0 and document["kept"] == document["parts"]
    expect_tree(path, whole)


@long
def test_a_worker_that_does_not_see_the_folder_gets_the_triangles(pool, mesh_file, whole, tmp_path):
    """Found by the worker itself: it has other files under that name, by a mount of its own."""
    hidden = tmp_path / "seen"
    hidden.mkdir()
    within = ("unshare", "-m", "sh", "-c", f'mount -t tmpfs none {hidden} && exec "$@"', "sh")
    if subprocess.run([*within, "true"], stderr=subprocess.DEVNULL).returncode != 0:
        pytest.skip("a mount of its own needs root: unshare -m fails")
    pool.worker(within=within)
    code, document, errors = run(mesh_file, hidden / "tree.svo", "--scheduler", pool.address)
    assert code == 0 and "does not see" in errors
    expect_tree(hidden / "tree.svo", whole)


def test_generated_meshes_are_the_programs(tmp_path):
    program = os.environ.get("SVOCL_PROGRAM") or shutil.which("svocl")
    if program is None:
        pytest.skip("the program svocl is not there (SVOCL_PROGRAM)")
    path = tmp_path / "cube.svo"
    # Without a limit there is one part; it is built at once.
    need = ["--need", "normal,rays"]
    options = [*need, "--workers", "1", "--program", program]
    command = [sys.executable, "-m", "svocl.distributed", "scene:cube", "-d", str(DEPTH), "-o", str(path), *options]
    subprocess.run(command, check=True, timeout=SECONDS)
    hash_line = subprocess.check_output([program, "hash", "scene:cube", "-d", str(DEPTH), *need], text=True)
    expect_tree(path, hash_line.split()[0])
    assert run("scene:cube", path, "--max-memory", "100K", *options)[0] == 0
    expect_tree(path, hash_line.split()[0])


def test_words_for_what_cannot_work(mesh_file, tmp_path):
    path = tmp_path / "tree.svo"
    code, _, errors = run(tmp_path / "nothing.obj", path)
    assert code == 1 and "nothing.obj" in errors
    code, _, errors = run(mesh_file, path, "--max-memory", "1")
    assert code == 1 and "max_bytes 1 is too small" in errors
    code, _, errors = run(mesh_file, path, "--scheduler", "tcp://127.0.0.1:1", "--connect-timeout", "1")
    assert code == 75 and "no scheduler answers at tcp://127.0.0.1:1" in errors
    assert run(mesh_file, path, "--max-memory", "1.5G")[0] == 2
    assert not path.exists()
    for options in (["--need", "colour"], ["--workers", "0"], ["--coverage", "all"], ["--patience", "long"]):
        with pytest.raises(SystemExit, match="2"):
            read_options([str(mesh_file), "-d", "6", "-o", str(path), *options])


def test_workers_send_files_of_their_parts_alone(device, mesh, tmp_path, monkeypatch):
    """Other names are refused: nothing is written, and the words say which."""
    distributed = pytest.importorskip("distributed")
    folder = tmp_path / "tree.svo.parts"
    with svocl.Parts.create(device, mesh, DEPTH, folder, max_bytes=PART_BYTES) as parts:
        first, last = parts.entries[0], parts.entries[-1]
        assert _run.is_of_part(f"{last.name}.part", last)
        assert _run.is_of_part(f"{last.level + 1}-{last.code << 3 | 7:x}.split", last)
        strange = [f"{first.name}.part", f"{last.level - 1}-{last.code >> 3:x}.split", f"{last.name}.tri", "plan"]
        strange += [f"../{last.name}.part", f"/{last.name}.part", f"{last.name}.part/..", f"0{last.name}.part", ""]
        assert not [name for name in strange if _run.is_of_part(name, last)]
        plan = (folder / "plan").read_bytes()
        there = sorted(tmp_path.rglob("*"))
        with distributed.Client(processes=False, n_workers=1, dashboard_address="127.0.0.1:0") as client:
            sent = _tasks.Built("a worker", files={"plan": b"", "../out.part": b""})
            monkeypatch.setattr(_tasks, "build_sent", lambda work, plan, triangles: sent)
            with pytest.raises(_run.Interrupted, match="a worker: 'plan' is no file of the part"):
                _run.build_parts(client, parts, shared_folder=False)
        assert sorted(tmp_path.rglob("*")) == there and (folder / "plan").read_bytes() == plan


# --- workers that do not --------------------------------------------------------------------------------------------


def test_workers_killed(pool, mesh_file, whole, tmp_path):
    """At the first and in the midst of a later part; the third worker builds what they had."""
    killed = [pool.worker(f"{fault} signal={signal.SIGKILL:d} slow=0.02") for fault in ("at=1", "at=5 when=amid")]
    pool.worker("slow=0.1")
    code, _, errors = run(mesh_file, tmp_path / "tree.svo", "--scheduler", pool.address)
    assert code == 0 and [worker.wait(SECONDS) for worker in killed] == [-signal.SIGKILL] * 2
    assert re.search(r"the worker tcp://\S+ is gone", errors)
    expect_tree(tmp_path / "tree.svo", whole)


def test_damaged_triangles(pool, mesh_file, whole, tmp_path):
    """Nobody can build the part; the same command plans again, which writes them."""
    path = tmp_path / "tree.svo"
    pool.worker(f"at=3 damage=1 once={tmp_path / 'once'}")
    code, _, errors = run(mesh_file, path, "--scheduler", pool.address)
    assert code == 75 and "planning the parts again writes" in errors and "the same command does so" in errors
    code, document, _ = run(mesh_file, path, "--scheduler", pool.address)
    assert code == 0 and document["kept"] >= 2
    expect_tree(path, whole)


@long
def test_the_only_worker_killed_at_its_last_part(pool, device, mesh, mesh_file, whole, tmp_path):
    """The part is there, but nobody has been told. The worker's nanny starts it again."""
    with svocl.Parts.create(device, mesh, DEPTH, tmp_path / "count", max_bytes=PART_BYTES) as parts:
        last = len(parts)
    pool.worker(f"at={last} when=after signal={signal.SIGKILL:d} once={tmp_path / 'once'}", nanny=True)
    code, document, _ = run(mesh_file, tmp_path / "tree.svo", "--scheduler", pool.address)
    assert code == 0 and (tmp_path / "once").exists()
    assert document["kept"] == 0 and sum(worker["parts"] for worker in document["workers"]) == last
    expect_tree(tmp_path / "tree.svo", whole)


@long
def test_a_part_that_kills_its_workers(pool, device, mesh, mesh_file, whole, tmp_path):
    """The others are built; the words name the part; a later run builds that alone."""
    with svocl.Parts.create(device, mesh, DEPTH, tmp_path / "count", max_bytes=PART_BYTES) as parts:
        count, deadly = len(parts), min(parts.entries, key=lambda entry: entry.expected_bytes).name
    path = tmp_path / "tree.svo"
    pool.worker(f"name={deadly} signal={signal.SIGKILL:d}", nanny=True)
    code, _, errors = run(mesh_file, path, "--scheduler", pool.address)
    assert code == 75 and f"the part {deadly}: 2 workers died while they had it" in errors
    assert f"{count - 1} of {count} parts are in {path}.parts; the same command goes on from there" in errors
    assert not path.exists()
    code, document, _ = run(mesh_file, path, "--workers", "1")
    assert code == 0 and document["kept"] == count - 1
    expect_tree(path, whole)


@long
def test_a_worker_stopped(pool, mesh_file, whole, tmp_path):
    """The scheduler gives it up, and the other worker builds what it had. It does no harm when it goes on."""
    path = tmp_path / "tree.svo"
    pool.scheduler(ttl="1s")
    stopped = pool.worker(f"at=2 signal={signal.SIGSTOP:d} slow=0.02")
    pool.worker("slow=0.02")
    code, _, errors = run(mesh_file, path, "--scheduler", pool.address)
    assert code == 0 and "is gone" in errors and stopped.poll() is None
    expect_tree(path, whole)
    os.kill(stopped.pid, signal.SIGCONT)
    assert run(mesh_file, path, "--scheduler", pool.address)[0] == 0
    expect_tree(path, whole)


@long
def test_no_part_arrives(pool, mesh_file, tmp_path):
    """The wait ends where there is no worker."""
    path = tmp_path / "tree.svo"
    code, _, errors = run(mesh_file, path, "--scheduler", pool.address, "--patience", "0.5")
    assert code == 75 and "no part arrived for 0.5 s" in errors and "0 of " in errors


def test_the_scheduler_killed(pool, mesh_file, whole, tmp_path):
    path = tmp_path / "tree.svo"
    scheduler = pool.scheduler()
    pool.worker(f"at=6 signal={signal.SIGKILL:d} pid={scheduler.pid} slow=0.02")
    code, _, errors = run(mesh_file, path, "--scheduler", pool.address)
    found = re.search(r"the connection to the scheduler is lost\n.*: (\d+) of \d+ parts are in", errors)
    assert code == 75 and found and not path.exists()
    pool.scheduler()
    pool.worker()
    code, document, _ = run(mesh_file, path, "--scheduler", pool.address)
    assert code == 0 and document["kept"] >= int(found[1]) > 0
    expect_tree(path, whole)


# --- a network that is cut --------------------------------------------------------------------------------------------


class Network:
    """A namespace with a cable to this one."""

    def __init__(self):
        self.name = f"svocl{os.getpid()}"
        self.near, self.far = f"sva{os.getpid()}", f"svb{os.getpid()}"
        self.within = ("ip", "netns", "exec", self.name)

    def __enter__(self):
        if not shutil.which("ip") or self._ip("netns", "add", self.name) != 0:
            pytest.skip("a network of its own needs root and iproute2: ip netns add fails")
        if self._ip("link", "add", self.near, "type", "veth", "peer", "name", self.far, "netns", self.name) != 0:
            self._ip("netns", "delete", self.name)
            pytest.skip("a network of its own needs the kernel's veth: ip link add fails")
        for place, name, address in (((), self.near, "10.251.19.1"), (("-n", self.name), self.far, "10.251.19.2")):
            self._ip(*place, "address", "add", f"{address}/30", "dev", name)
            self._ip(*place, "link", "set", name, "up")
        self._ip("-n", self.name, "link", "set", "lo", "up")
        return self

    def __exit__(self, *_):
        self._ip("link", "delete", self.near)
        self._ip("netns", "delete", self.name)

    def _ip(self, *arguments):
        return subprocess.run(["ip", *arguments], stderr=subprocess.DEVNULL).returncode

    def cut(self):
        self._ip("-n", self.name, "link", "set", self.far, "down")

    def restore(self):
        self._ip("-n", self.name, "link", "set", self.far, "up")


def wait_for_parts(folder, count):
    end = time.monotonic() + SECONDS
    while not folder.exists() or len([name for name in os.listdir(folder) if name.endswith(".part")]) < count:
        assert time.monotonic() < end, "no parts arrive"
        time.sleep(0.02)


@long
def test_a_network_cut_and_restored(pool, mesh_file, whole, tmp_path):
    """Between the scheduler and its only worker: for a moment, and for so long that the worker is given up."""
    path = tmp_path / "tree.svo"
    with Network() as network, pool:
        pool.scheduler("10.251.19.1", ttl="1s")
        pool.worker("slow=0.05", nanny=True, within=network.within)
        job = start(mesh_file, path, "--scheduler", pool.address, "--no-shared-folder")
        for parts, seconds in ((5, 0.5), (15, 7)):
            wait_for_parts(tmp_path / "tree.svo.parts", parts)
            network.cut()
            time.sleep(seconds)
            assert job.poll() is None
            network.restore()
        code, _, errors = finish(job)
        assert code == 0 and "is gone" in errors
        expect_tree(path, whole)
