# SPDX-License-Identifier: MIT
"""What a worker does: plans a range, builds one part in a folder that it shares with the client, or in one of its own
for a store or for the client, writes a share of the file."""

import hashlib
import importlib
import os
import tempfile
import threading
import time
from typing import Any, NamedTuple, Optional

from .._device import Device
from .._generated import (
    CLError,
    CompileError,
    Error,
    FileError,
    GLError,
    NoDeviceError,
    OutOfDeviceMemoryError,
    OutOfHostMemoryError,
    UnavailableError,
)
from .._parts import Parts, PartsPlanning
from ._store import StoredParts

PLAN = "plan"
"""The file of a folder of parts that says what they are parts of."""

PASSING = (
    CLError,
    CompileError,
    GLError,
    NoDeviceError,
    OutOfDeviceMemoryError,
    OutOfHostMemoryError,
    UnavailableError,
)
"""What a later try may do without."""

RETRIED = (*PASSING, FileError)
"""What another worker may do without, too. Everything else fails the same way again."""


class Work(NamedTuple):
    """A part to build."""

    place: int
    """In the list of parts."""
    name: str
    """LEVEL-CODE."""
    folder: str
    """The client's folder of parts."""
    identity: str
    """Of the plan, which names the place of the part's triangles in the folder."""
    plan_digest: bytes
    """Of the folder's file `plan`: a folder of that name on another machine may be another one."""
    device: Optional[str]
    """A part of "platform: device"; the worker's environment, SVOCL_DEVICE, goes first."""


class Built(NamedTuple):
    """What comes of a part."""

    worker: str
    """Its address."""
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    """Of the worker's process."""
    is_first: bool = False
    """The worker opened its device for this part, and loaded the kernels."""
    is_shared: bool = True
    """False: the worker does not see the client's folder, and has built nothing."""
    files: Optional[dict[str, bytes]] = None
    """By name, what belongs in the client's folder; None: it is there."""
    stored: tuple[str, ...] = ()
    """Names of files in a store that belong in the client's folder."""
    failure: str = ""
    """Not "": why it was not built."""
    is_final: bool = False
    """No other try can succeed either."""


def digest(content: bytes) -> bytes:
    """By which a plan is known."""
    return hashlib.blake2b(content, digest_size=16).digest()


def build_shared(work: Work) -> Built:
    """Builds a part in the client's folder, if that is there."""
    try:
        with open(os.path.join(work.folder, PLAN), "rb") as file:
            is_shared = digest(file.read()) == work.plan_digest
    except OSError:
        is_shared = False
    return _build(work, work.folder) if is_shared else Built(_address(), is_shared=False)


def build_sent(work: Work, plan: bytes, triangles: bytes) -> Built:
    """Builds a part from what the task brings along, and returns its files.

    Args:
        work: the part.
        plan: content of the client's file `plan`.
        triangles: content of the part's file of triangles.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="svocl-") as folder:
            os.mkdir(os.path.join(folder, work.identity))
            for name, content in ((PLAN, plan), (os.path.join(work.identity, f"{work.name}.tri"), triangles)):
                with open(os.path.join(folder, name), "wb") as file:
                    file.write(content)
            return _build(work, folder)._replace(files=_read_files(work, folder))
    except OSError as problem:
        return Built(_address(), failure=str(problem))


def build_stored(work: Work, url: str, plan_name: str, place: str) -> Built:
    """Builds a part of a folder in a store, on this machine's disk, and puts it there.

    Args:
        work: the part.
        url: of the folder; credentials are those of the worker's environment.
        plan_name, place: of the plan that the job belongs to.
    """
    try:
        stored = StoredParts(url, plan_name, place, work.identity)
        stored.check()
        plan = _get_plan(stored, work.plan_digest)
        with tempfile.TemporaryDirectory(prefix="svocl-") as folder:
            os.mkdir(os.path.join(folder, work.identity))
            with open(os.path.join(folder, PLAN), "wb") as file:
                file.write(plan)
            stored.get_triangles(work.name, folder)
            built = _build(work, folder)
            if not built.failure:
                stored.check()
                built = built._replace(stored=stored.put_parts(folder))
            return built
    except Error as problem:
        return Built(_address(), failure=str(problem), is_final=not isinstance(problem, RETRIED))
    except OSError as problem:
        return Built(_address(), failure=str(problem))


def _get_plan(stored: StoredParts, expected: bytes) -> bytes:
    """The plan of a store. A worker builds many parts of one plan, so it is kept."""
    plan = _plans.get(expected)
    if plan is None:
        plan = stored.get_plan()
        if digest(plan) != expected:
            raise OSError(f"{stored.store.url}/{stored.plan} is not the plan of this job")
        _plans.clear()
        _plans[expected] = plan
    return plan


def _read_files(work: Work, folder: str) -> dict[str, bytes]:
    """The parts in a folder, and which of them were split."""
    files = {}
    for place, suffix in ((folder, ".part"), (os.path.join(folder, work.identity), ".split")):
        for name in os.listdir(place):
            if name.endswith(suffix):
                with open(os.path.join(place, name), "rb") as file:
                    files[name] = file.read()
    return files


class Done(NamedTuple):
    """What comes of a task of svocl.PartsPlanning, or of a share of the file."""

    worker: str
    """Its address."""
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    """Of the thread that did it."""
    result: bytes = b""
    failure: str = ""
    """Not "": why there is no result."""


def plan_range(task: bytes, name: Optional[str]) -> Done:
    """Does a task of planning. A worker does one for each of its threads, each on a device of its own.

    Args:
        task: of svocl.PartsPlanning.task.
        name: of the device, see Work.device.
    """
    begin, begin_cpu = time.perf_counter(), time.thread_time()
    try:
        if getattr(_planner, "device", None) is None:
            _planner.device = Device(os.environ.get("SVOCL_DEVICE", name))
        result = PartsPlanning.work(_planner.device, task)
    except Error as problem:
        return Done(_address(), failure=str(problem))
    return Done(_address(), time.perf_counter() - begin, time.thread_time() - begin_cpu, result)


def write_share(folder: str, identity: str, index: int, count: int) -> Done:
    """Writes a share of the file.

    Args:
        folder: the client's folder of parts.
        identity: of its plan: a folder of that name on another machine may be another one.
        index, count: of svocl.Parts.write_share.
    """
    begin, begin_cpu = time.perf_counter(), time.thread_time()
    try:
        with Parts(folder) as parts:
            if parts.identity != identity:
                return Done(_address(), failure=f"{folder} is another folder here: it has plan {parts.identity}")
            parts.write_share(index, count)
    except Error as problem:
        return Done(_address(), failure=str(problem))
    return Done(_address(), time.perf_counter() - begin, time.thread_time() - begin_cpu)


def worker_ttl(dask_scheduler: Any) -> Optional[float]:
    """After how many seconds of silence a scheduler gives a worker up; None: never."""
    seconds = dask_scheduler.worker_ttl
    return None if seconds is None else float(seconds)


_lock = threading.Lock()
_planner = threading.local()
_devices: dict[Optional[str], Device] = {}
_plans: dict[bytes, bytes] = {}


def _build(work: Work, folder: str) -> Built:
    """Failures come back as words: an exception's traceback may be what the client cannot read."""
    # All threads of a worker are PoCL's, so a worker builds one part at a time.
    with _lock:
        begin, begin_cpu = time.perf_counter(), time.process_time()
        name = os.environ.get("SVOCL_DEVICE", work.device)
        is_first = name not in _devices
        try:
            with Parts(folder) as parts:
                parts.build(work.place, _open_device(name))
        except Error as problem:
            _close_device(name)
            return Built(_address(), failure=str(problem), is_final=not isinstance(problem, RETRIED))
        seconds, cpu_seconds = time.perf_counter() - begin, time.process_time() - begin_cpu
        return Built(_address(), seconds=seconds, cpu_seconds=cpu_seconds, is_first=is_first)


def _open_device(name: Optional[str]) -> Device:
    """The worker's device: opened once, since its kernels are compiled for it."""
    if name not in _devices:
        # PoCL reads this when it is loaded.
        os.environ.setdefault("POCL_MAX_PTHREAD_COUNT", str(_worker().state.nthreads))
        _devices[name] = Device(name)
    return _devices[name]


def _close_device(name: Optional[str]) -> None:
    """A device that failed may fail again; the next part opens it anew."""
    device = _devices.pop(name, None)
    if device is not None:
        device.close()


def _worker() -> Any:
    return importlib.import_module("distributed").get_worker()


def _address() -> str:
    return str(_worker().address)
