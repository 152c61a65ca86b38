# SPDX-License-Identifier: MIT
"""Folders of parts in object stores: what a store promises, planners that race, workers that are stale, one file.

The stores are fsspec's memory and moto's S3 on the loopback address.
"""

import os
import threading
import time

import numpy as np
import pytest
from cluster import DEPTH, PART_BYTES, SECONDS, Pool, finish, long, run, start

import svocl
from svocl.distributed import StoredParts, _store
from svocl.distributed.__main__ import read_options
from svocl.distributed._store import Store

pytest.importorskip("distributed", reason="Dask's distributed is not installed (pip install distributed)")
pytest.importorskip("tqdm", reason="tqdm is not installed (pip install tqdm)")
pytest.importorskip("s3fs", reason="s3fs is not installed (pip install s3fs)")
pytestmark = pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")


@pytest.fixture(scope="module")
def s3():
    """The endpoint's URL of an S3 with a bucket, in this process's environment, too.

    moto looks whether an object is there and puts it in two steps, so requests are served one by one.
    """
    pytest.importorskip("flask_cors", reason="flask-cors is not installed (pip install flask-cors)")
    backend = pytest.importorskip("moto.moto_server.werkzeug_app", reason="moto is not installed (pip install moto)")
    serving = pytest.importorskip("werkzeug.serving")
    app = backend.DomainDispatcherApplication(backend.create_backend_app)
    server = serving.make_server("127.0.0.1", 0, app, threaded=False)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    values = {"AWS_ENDPOINT_URL": f"http://127.0.0.1:{server.port}", "AWS_DEFAULT_REGION": "us-east-1"}
    values.update(AWS_ACCESS_KEY_ID="testing", AWS_SECRET_ACCESS_KEY="testing", AWS_CONFIG_FILE=os.devnull)
    with pytest.MonkeyPatch.context() as patch:
        for name, value in values.items():
            patch.setenv(name, value)
        Store("s3://bucket").fs.mkdir("bucket")
        yield values["AWS_ENDPOINT_URL"]
    server.shutdown()
    thread.join(SECONDS)


@pytest.fixture
def url(request, tmp_path):
    """A folder in a store, of its own for each test."""
    if request.param == "s3":
        request.getfixturevalue("s3")
        return f"s3://bucket/{tmp_path.name}"
    return f"memory://{tmp_path.name}"


@pytest.fixture(scope="module")
def moved(mesh):
    return svocl.Mesh(mesh.positions + np.array([0.002, 0, 0], mesh.positions.dtype), mesh.indices)


def file_of(device, mesh, tmp_path):
    """The file of the tree in one piece."""
    with device.build(mesh, DEPTH) as tree:
        tree.save(tmp_path / "whole.svo")
    return (tmp_path / "whole.svo").read_bytes()


def silent(line):
    pass


# --- stores ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("url", ["memory", "s3"], indirect=True)
def test_a_store(url, tmp_path, monkeypatch):
    store = Store(url)
    assert store.names() == [] and store.modified("a") is None
    with pytest.raises(svocl.FileError, match=f"{url}/a: FileNotFoundError"):
        store.get("a")
    assert store.put_if_absent("a", b"1") and not store.put_if_absent("a", b"2") and store.get("a") == b"1"
    assert store.put_if_absent("a", b"1")  # as an answer that was lost is asked for again
    store.put("a", b"3")
    store.put("b/c", b"4")
    store.put("b/d/e", b"")
    assert store.names() == ["a", "b"] and store.names("b") == ["c", "d"] and store.names("c") == []
    assert abs(store.modified("a") - time.time()) < 60
    monkeypatch.setattr(_store, "BLOCK_BYTES", 5 << 20)  # S3's least
    content = os.urandom((11 << 20) + 7)
    (tmp_path / "large").write_bytes(content)
    store.put_file(str(tmp_path / "large"), "large")
    store.get_file("large", str(tmp_path / "back"))
    assert (tmp_path / "back").read_bytes() == content
    if url.startswith("s3"):
        assert store.fs.info(f"{store.root}/large")["ETag"].strip('"').endswith("-3")  # of three blocks
    store.delete(["b", "nothing", "large"])
    assert store.names() == ["a"]
    store.delete(["a"])
    assert store.names() == []


@pytest.mark.parametrize("url", ["memory", "s3"], indirect=True)
def test_one_of_many_puts(url):
    store = Store(url)
    for turn in range(10):
        start_line, won = threading.Barrier(4), []

        def put(number, turn=turn, start_line=start_line, won=won):
            start_line.wait()
            if store.put_if_absent(f"turn-{turn}", b"%d" % number):
                won.append(b"%d" % number)

        threads = [threading.Thread(target=put, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert won == [store.get(f"turn-{turn}")]


def test_stores_that_are_none(s3, tmp_path, monkeypatch):
    with pytest.raises(svocl.FileError, match="no put-if-absent is known of others"):
        Store("ftp://host/folder")
    with pytest.raises(svocl.FileError, match="bucket does not exist") as found:
        Store("s3://nowhere").put("a", b"")
    assert not isinstance(found.value, svocl.UnavailableError)
    with StoredParts("memory://x").planning(silent):
        pass
    # A store that replaces what must be new, as some that speak S3 do, is refused before anything else is put.
    careless = StoredParts("memory://careless")
    pipe = type(careless.store.fs).pipe_file
    monkeypatch.setattr(
        type(careless.store.fs), "pipe_file", lambda self, path, value, mode="": pipe(self, path, value)
    )
    with pytest.raises(svocl.FileError, match="replaces an object that must be new"):
        careless.planning(silent).__enter__()
    assert careless.store.names() == []


def test_a_store_that_does_not_answer(tmp_path):
    store = Store("memory://silent")
    store.fs = type("Gone", (), {"cat_file": lambda self, path: (_ for _ in ()).throw(ConnectionError("reset"))})()
    with pytest.raises(svocl.UnavailableError, match="memory://silent/a: ConnectionError: reset"):
        store.get("a")


# --- planners -------------------------------------------------------------------------------------------------------


class Plan:
    """What publish reads of a folder on a disk."""

    def __init__(self, folder, name):
        self.folder, self.identity = str(folder / name), name * 32
        (folder / name / self.identity).mkdir(parents=True)
        (folder / name / "plan").write_text(name)
        for file in ("0-0.tri", "mesh"):
            (folder / name / self.identity / file).write_text(f"{name} {file}")


def publish(url, plan):
    stored = StoredParts(url)
    with stored.planning(silent):
        stored.publish(plan)
    return stored


def expect_plan(stored, name):
    """The folder has this plan and all of its files."""
    stored.check()
    assert stored.get_plan() == name.encode()
    for file in ("0-0.tri", "mesh"):
        assert stored.store.get(f"{stored.place}/{file}") == f"{name} {file}".encode()


def test_plans_follow_one_another(tmp_path):
    url, (a, b) = "memory://follow", (Plan(tmp_path, name) for name in "ab")
    first = publish(url, a)
    expect_plan(first, "a")
    first.store.put(f"{first.place}/0-0.part", b"built")
    with pytest.raises(svocl.UnavailableError, match=rf"process {os.getpid()} on .* builds or stitches its parts"):
        publish(url, b)
    first.close()
    again = publish(url, a)  # what is built of this plan stays
    assert (again.plan, again.place, again.names_of()) == (first.plan, first.place, ["0-0.part"])
    again.close()
    other = publish(url, b)
    expect_plan(other, "b")
    with pytest.raises(svocl.UnavailableError, match="belongs to plan-00000001 of identity a{32}, .* plan-00000002"):
        first.check()
    first.remove()  # of a plan that is not the folder's: nothing
    expect_plan(other, "b")
    assert first.place not in other.store.names()
    other.close()
    with StoredParts(url).planning(silent):
        with pytest.raises(svocl.UnavailableError, match="plans it"):
            publish(url, a)
    other.remove()
    assert other.store.names() == []


def test_stale_leases_are_broken(tmp_path, monkeypatch):
    url, lines = "memory://stale", []
    publish(url, Plan(tmp_path, "a"))
    stopped = StoredParts(url).planning(silent)
    later = time.time() + 61
    with pytest.raises(svocl.UnavailableError, match="builds or stitches"):
        stopped.__enter__()
    Store(url).put("planner-00000002-0000.lease", b"process 7 on elsewhere\n")
    monkeypatch.setattr(StoredParts, "_ask_clock", lambda self: later)
    with StoredParts(url).planning(lines.append):
        assert "planner-00000002-0001.lease" in Store(url).names()
    assert len(lines) == 2 and "process 7 on elsewhere has not renewed its lease" in lines[0]


class Turns:
    """Two threads of which one moves, one operation of the store at a time; schedule says how many of each, and after
    its end each goes on until it is done."""

    def __init__(self, schedule):
        self.schedule, self.state, self.ready = list(schedule), {}, threading.Condition()
        self.mover = 0

    def wait(self):
        me = self.state[threading.get_ident()]
        with self.ready:
            assert self.ready.wait_for(lambda: self.mover == me, SECONDS)
            while self.schedule and self.schedule[0] == 0:
                self.schedule.pop(0)
                self.pass_on(me)
                assert self.ready.wait_for(lambda: self.mover == me, SECONDS)
            if self.schedule:
                self.schedule[0] -= 1

    def pass_on(self, me):
        self.mover = 1 - me if 1 - me in self.state.values() else me
        self.ready.notify_all()

    def leave(self):
        with self.ready:
            me = self.state.pop(threading.get_ident())
            self.schedule = self.schedule[1:]
            self.mover = 1 - me
            self.ready.notify_all()


def test_two_planners_in_any_order(tmp_path, monkeypatch):
    """Every schedule that changes between them up to three times, where each takes the other's leases for stale: the
    folder's plan is whole and of one that was told so, and the other knows."""
    plans = [Plan(tmp_path, name) for name in "ab"]
    monkeypatch.setattr(StoredParts, "_ask_clock", lambda self: 0.0)
    monkeypatch.setattr(StoredParts, "_is_live", lambda self, lease, now: False)
    operations = ("names", "put_if_absent", "put", "put_file", "delete")
    current = [None]
    for name in operations:
        whole = getattr(Store, name)

        def turned(self, *arguments, whole=whole):
            if threading.get_ident() in current[0].state:
                current[0].wait()
            return whole(self, *arguments)

        monkeypatch.setattr(Store, name, turned)

    def go(index, turns, url, told, both):
        turns.state[threading.get_ident()] = index
        both.wait()
        try:
            told[index] = publish(url, plans[index])
        except svocl.UnavailableError as problem:
            told[index] = problem
        finally:
            turns.leave()

    seen, most = set(), 16
    schedules = [(i, j, k) for i in range(most) for j in range(0, most, 2) for k in range(0, most, 5)]
    for number, schedule in enumerate(schedules):
        url = f"memory://turns-{number}"
        turns = current[0] = Turns(schedule)
        told, both = {}, threading.Barrier(2)
        threads = [threading.Thread(target=go, args=(index, turns, url, told, both)) for index in (0, 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(SECONDS)
        last = []
        for index, result in told.items():
            if isinstance(result, StoredParts):
                try:
                    expect_plan(result, "ab"[index])
                    last.append(index)
                except svocl.UnavailableError:
                    pass
                result.close()
            else:
                assert (
                    "another process made plan-" in str(result)
                    or "planned anew" in str(result)
                    or "plans it" in str(result)
                )
        assert len(last) == 1, (schedule, told)
        seen.add(tuple(type(told[index]).__name__ for index in (0, 1)))
    assert len(seen) == 3  # the one, the other and both, one after the other


# --- jobs -----------------------------------------------------------------------------------------------------------


def expect_file(url, content, others=()):
    """The file is there, and beside it nothing but others."""
    folder, name = url.rsplit("/", 1)
    assert Store(folder).get(name) == content
    assert Store(folder).names() == sorted([name, *others])


def test_a_job_in_a_bucket(s3, device, mesh, mesh_file, tmp_path):
    """The file of one process, byte for byte, from a bucket to a bucket. What is there stays, what is damaged is built
    again; then nothing but the file is left."""
    whole = file_of(device, mesh, tmp_path)
    folder = f"s3://bucket/{tmp_path.name}"
    url = f"{folder}/A.svo"
    code, document, _ = run(mesh_file, url, "--workers", "2", "--keep", "--scratch", str(tmp_path))
    assert code == 0 and document["kept"] == 0 and document["parts"] > 10
    expect_file(url, whole, ["A.svo.parts"])
    store = Store(f"{url}.parts")
    plan, place = sorted(store.names(), key=len)
    built = [name for name in store.names(place) if name.endswith(".part")]
    assert plan == "plan-00000001" and len(built) == document["parts"]
    store.put(f"{place}/{built[3]}", b"damaged")
    store.delete([f"{place}/{built[5]}"])
    Store(folder).delete(["A.svo"])
    code, again, _ = run(mesh_file, tmp_path / "local.svo", "--parts", f"{url}.parts", "--workers", "1")
    assert code == 0 and again["kept"] == document["parts"] - 2
    assert (tmp_path / "local.svo").read_bytes() == whole and Store(folder).names() == []
    assert not [entry for entry in tmp_path.iterdir() if entry.name.startswith("svocl-")]
    options = read_options([str(mesh_file), "-d", "6", "-o", f"file://{tmp_path}/A.svo"])
    assert (options.output, options.parts) == (f"{tmp_path}/A.svo", f"{tmp_path}/A.svo.parts")


@long
def test_two_jobs_that_race_for_a_folder(s3, device, mesh, mesh_file, moved, tmp_path):
    """Of two jobs with one folder and two meshes each ends with its own file, or is told to try again."""
    other_file = tmp_path / "moved.obj"
    lines = ["v {!r} {!r} {!r}".format(*map(float, place)) for place in moved.positions]
    other_file.write_text(
        "\n".join([*lines, *("f {} {} {}".format(*(corners + 1)) for corners in moved.indices)]) + "\n"
    )
    folder = f"s3://bucket/{tmp_path.name}"
    jobs = []
    for name, path in (("a", mesh_file), ("b", other_file)):
        (tmp_path / name).mkdir()
        jobs.append((f"{folder}-{name}/{name}.svo", path, file_of(device, svocl.read_mesh(path), tmp_path / name)))
    assert jobs[0][2] != jobs[1][2]
    options = ("--parts", f"{folder}.parts", "--workers", "1")
    started = [start(path, url, *options) for url, path, _ in jobs]
    ended = [finish(process) for process in started]
    assert sorted(code for code, *_ in ended)[0] == 0
    for (url, path, content), (code, _, errors) in zip(jobs, ended):
        if code != 0:
            assert code == 75 and ("plans it" in errors or "builds or stitches its parts" in errors)
            assert run(path, url, *options)[0] == 0
        expect_file(url, content)
    assert Store(f"{folder}.parts").names() == []


@long
def test_a_stale_job_is_refused_by_name(s3, device, mesh, mesh_file, moved, tmp_path, monkeypatch):
    """As after a run that was stopped until its lease was stale: its worker's parts are in no other tree."""
    url = f"s3://bucket/{tmp_path.name}/A.svo"
    with Pool(tmp_path) as pool:
        pool.scheduler()
        pool.worker("slow=0.1")
        job = start(mesh_file, url, "--scheduler", pool.address)
        end = time.monotonic() + SECONDS
        stored = StoredParts(f"{url}.parts")
        while len([name for place in stored.store.names() for name in stored.store.names(place) if "part" in name]) < 3:
            assert time.monotonic() < end, "no parts arrive"
            time.sleep(0.1)
        with svocl.Parts.create(device, moved, DEPTH, tmp_path / "anew", max_bytes=PART_BYTES) as parts:
            with pytest.raises(svocl.UnavailableError, match=r"process \d+ on .* builds or stitches its parts"):
                publish(f"{url}.parts", parts)
            monkeypatch.setattr(StoredParts, "_is_live", lambda self, lease, now: False)
            with stored.planning(silent):
                stored.publish(parts)
            code, _, errors = finish(job)
            assert code == 75 and "planned anew meanwhile: this run belongs to plan-00000001 of identity" in errors
            assert "the folder's plan is plan-00000002" in errors and Store(url.rsplit("/", 1)[0]).names() == [
                "A.svo.parts"
            ]
            # A part of the old plan below the new one's name is refused, too.
            folder = tmp_path / "mirror"
            with svocl.Parts.create(device, mesh, DEPTH, folder, max_bytes=PART_BYTES) as old:
                old.build(0, device)
                name = f"{old.entries[0].name}.part"
                stored.store.put_file(str(folder / name), f"{stored.place}/{name}")
            stored.get_part(name, parts.folder)
            assert not parts.is_built(0)
            stored.discard(parts.entries[0])
            assert stored.names_of() == []
            for index in range(len(parts)):
                parts.build(index, device)
            parts.finish(tmp_path / "anew.svo")
        stored.close()
        stored.remove()
        assert stored.store.names() == []
    assert (tmp_path / "anew.svo").read_bytes() == file_of(device, moved, tmp_path)


def test_what_cannot_work_in_stores(s3, mesh_file, monkeypatch):
    for path, options, words in (
        ("memory://tree.svo", [], "do not see this one's memory"),
        ("s3://bucket/none.svo", ["--parts-only"], "must be on a disk"),
    ):
        code, _, errors = run(mesh_file, path, *options)
        assert code == 2 and words in errors
    code, _, errors = run(mesh_file, "s3://nowhere/tree.svo", "--workers", "1")
    assert code == 1 and "bucket does not exist" in errors
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:1")
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    code, _, errors = run(mesh_file, "s3://bucket/tree.svo", "--workers", "1")
    assert code == 75 and "s3://bucket/tree.svo.parts" in errors
