# SPDX-License-Identifier: MIT
"""What the client does: submits the parts that are missing, takes what arrives, and says why a job ended early."""

import asyncio
import importlib
import os
import time
import uuid
import warnings
from collections import deque
from typing import Any, Callable, NamedTuple, Optional

from .._generated import Error
from .._parts import Parts
from . import _tasks
from ._store import StoredParts, is_of_part

TRIES = 3
"""Of a part that fails. A worker's death is not counted here, but by Dask's allowed-failures."""
POLL_SECONDS = 0.02


class Interrupted(RuntimeError):
    """The job ended before all parts were there. It goes on from there when it is started again."""


class Refused(RuntimeError):
    """A part cannot be built, whoever tries."""


class Share(NamedTuple):
    """What a worker did."""

    parts: int
    seconds: float


class Summary(NamedTuple):
    """A job that is done."""

    parts: int
    """In the list."""
    kept: int
    """Of those, parts that were there before."""
    workers: dict[str, Share]
    """By address."""


def build_parts(
    client: Any,
    parts: Parts,
    *,
    shared_folder: bool = True,
    device: Optional[str] = None,
    patience: float = 900.0,
    report: Optional[Callable[[int, int, str], None]] = None,
    record: Optional[Callable[[str, float, float], None]] = None,
    stored: Optional[StoredParts] = None,
) -> Summary:
    """Builds the parts that are missing, the largest estimate first.

    Args:
        client: a distributed.Client.
        parts: a folder on a disk that this process sees.
        shared_folder: workers that see the folder write to it. Others, and with False all, get the plan and the
            triangles with the task, and the part comes back as bytes.
        device: a part of "platform: device" for all workers; a worker's environment, SVOCL_DEVICE, goes first.
        patience: seconds in which no part arrives, after which the job ends.
        report: called with the number of parts that are there, the number of all, and a line about what happened,
            or "".
        stored: the same folder in an object store, of which alone workers know; what they put there is gotten into the
            folder on the disk. shared_folder does not matter then.
        record: called with "build", or "first build" of a worker, and the seconds and CPU seconds of each part.

    Raises:
        Interrupted: the scheduler is gone, workers died or failed, or patience is over. str() says what is missing.
        Refused: a part cannot be built at all; str() is the library's message.
    """
    run = _Run(client, parts, shared_folder, device, patience, report or (lambda there, count, line: None))
    run.record = record
    run.stored = stored
    return run.run()


class _Run:
    def __init__(self, client: Any, parts: Parts, shared: bool, device: Any, patience: float, report: Any) -> None:
        self.client, self.shared, self.device, self.patience, self.report = client, shared, device, patience, report
        self.record: Optional[Callable[[str, float, float], None]] = None
        self.stored: Optional[StoredParts] = None
        self.folder = os.path.abspath(parts.folder)
        self.entries = parts.entries
        missing = [index for index in range(len(self.entries)) if not parts.is_built(index)]
        self.waiting = deque(sorted(missing, key=lambda index: -self.entries[index].expected_bytes))
        self.kept = self.there = len(self.entries) - len(missing)
        self.identity = parts.identity
        self.plan = self._read(_tasks.PLAN)
        self.digest = _tasks.digest(self.plan)
        self.file = self._file_of_plan()
        self.futures: dict[str, int] = {}
        self.arrival = time.monotonic()
        self.tries = [0] * len(self.entries)
        self.failures: dict[int, str] = {}
        self.workers: dict[str, Share] = {}
        self.completed = importlib.import_module("distributed").as_completed(loop=client.loop)

    def run(self) -> Summary:
        self._say("")
        try:
            self._loop()
        finally:
            for future in list(self.completed.futures):
                future.release()
        if self.failures:
            lines = [f"the part {self.entries[index].name}: {words}" for index, words in self.failures.items()]
            raise Interrupted("\n".join([*lines, self._what_is_there()]))
        return Summary(len(self.entries), self.kept, self.workers)

    def _loop(self) -> None:
        self._fill()
        while self.futures:
            batch = self.completed.next_batch(block=False)
            for future in batch:
                self._take(future)
            if batch:
                self._fill()
            elif time.monotonic() - self.arrival > self.patience:
                raise Interrupted(f"no part arrived for {self.patience:g} s\n{self._what_is_there()}")
            else:
                time.sleep(POLL_SECONDS)

    # --- submitting -------------------------------------------------------------------------------------------------

    def _fill(self) -> None:
        """Submits what is waiting: to workers that share the folder all at once; else as many as keep workers busy,
        since the triangles of each are in memory meanwhile."""
        room = len(self.waiting) if self.shared or self.stored else self._window() - len(self.futures)
        for _ in range(min(room, len(self.waiting))):
            self._submit(self.waiting.popleft())

    def _window(self) -> int:
        """Two parts a thread: one that is built and one that lies ready."""
        threads = self._ask(self.client.scheduler.ncores)
        return 2 + 2 * int(sum(threads.values()))

    def _submit(self, index: int) -> None:
        entry = self.entries[index]
        work = _tasks.Work(index, entry.name, self.folder, self.identity, self.digest, self.device)
        # The key is never one of an earlier job, whose results may be lost.
        options = {"key": f"svocl_part-{entry.name}-{uuid.uuid4().hex}", "priority": entry.expected_bytes}
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph")  # the triangles, once
            if self.stored:
                place = (self.stored.store.url, self.stored.plan, self.stored.place)
                future = self.client.submit(_tasks.build_stored, work, *place, **options)
            elif self.shared:
                future = self.client.submit(_tasks.build_shared, work, **options)
            else:
                triangles = self._read(os.path.join(self.identity, f"{entry.name}.tri"))
                future = self.client.submit(_tasks.build_sent, work, self.plan, triangles, **options)
        self.futures[future.key] = index
        self.completed.add(future)

    def _read(self, name: str) -> bytes:
        try:
            with open(os.path.join(self.folder, name), "rb") as file:
                return file.read()
        except OSError:
            self._check_plan()  # which says why, if there is a new one
            raise

    def _file_of_plan(self) -> tuple[int, int, int]:
        """Another plan is another file."""
        try:
            found = os.stat(os.path.join(self.folder, _tasks.PLAN))
        except OSError:
            return 0, 0, 0
        return found.st_ino, found.st_mtime_ns, found.st_size

    def _check_plan(self) -> None:
        """The folder's plan is that of this job. A job that was stopped until its lease was stale may find another."""
        if self.stored:
            self.stored.check()
        if self._file_of_plan() == self.file:
            return
        try:
            with Parts(self.folder) as found:
                identity = found.identity
        except Error:
            return  # it is said by who needs it
        if identity != self.identity:
            raise Interrupted(
                f"{self.folder}: planned anew meanwhile: this job belongs to plan {self.identity}, "
                f"the folder's plan is {identity}"
            )

    # --- taking -----------------------------------------------------------------------------------------------------

    def _take(self, future: Any) -> None:
        if future.status == "cancelled":
            raise self._lost()
        if future.status not in ("finished", "error"):
            self.completed.add(future)  # the worker died with the result, and another makes it again
            return
        index = self.futures.pop(future.key)
        self.arrival = time.monotonic()
        try:
            built = future.result(timeout=self.patience)
        except (asyncio.CancelledError, asyncio.TimeoutError, OSError) as problem:
            raise self._lost() from problem
        except Exception as problem:  # Dask's: a task returns its failures
            self._failed(index, words_of(problem))
        else:
            self._built(index, built)
        future.release()

    def _built(self, index: int, built: _tasks.Built) -> None:
        entry = self.entries[index]
        if built.is_final or built.failure or not built.is_shared:
            self._check_plan()
        if built.is_final:
            raise Refused(f"the part {entry.name}: {built.failure}")
        if built.failure:
            self._try_again(index, f"{built.worker}: {built.failure}")
            return
        if not built.is_shared:
            if self.shared:
                self._say(f"{built.worker} does not see {self.folder}: parts are sent")
            self.shared = False
            self.waiting.append(index)
            return
        files = built.files or {}
        strangers = [name for name in (*files, *built.stored) if not is_of_part(name, entry)]
        if strangers:
            self._try_again(index, f"{built.worker}: {strangers[0]!r} is no file of the part")
            return
        if files:
            self._check_plan()
        try:
            for name in built.stored if self.stored else ():
                self.stored.get_part(name, self.folder)  # type: ignore[union-attr]
        except Error as problem:
            self._check_plan()
            self._try_again(index, str(problem))
            return
        # A part may have been split. What says so comes last, when its children are there.
        for name, content in sorted(files.items(), key=lambda file: file[0].endswith(".split")):
            self._write(name, content)
        share = self.workers.get(built.worker, Share(0, 0.0))
        self.workers[built.worker] = Share(share.parts + 1, share.seconds + built.seconds)
        if self.record:
            self.record("first build" if built.is_first else "build", built.seconds, built.cpu_seconds)
        self.there += 1
        self._say("")

    def _write(self, name: str, content: bytes) -> None:
        """The file appears whole or not at all."""
        # What says that a part was split lies in the place of the plan.
        place = os.path.join(self.folder, self.identity) if name.endswith(".split") else self.folder
        part = os.path.join(place, f".{os.getpid()}-{name}")
        try:
            with open(part, "wb") as file:
                file.write(content)
            os.replace(part, os.path.join(place, name))
        except OSError as problem:
            if os.path.exists(part):
                os.unlink(part)
            raise Interrupted(f"{problem}\n{self._what_is_there()}") from problem

    # --- what went wrong --------------------------------------------------------------------------------------------

    def _try_again(self, index: int, words: str) -> None:
        self.tries[index] += 1
        if self.tries[index] == TRIES:
            self._failed(index, words)
        else:
            self.waiting.append(index)
            self._say(f"the part {self.entries[index].name} is tried again: {words}")

    def _failed(self, index: int, words: str) -> None:
        """Goes on with the other parts."""
        self.failures[index] = words
        self._say(f"the part {self.entries[index].name}: {words}")

    def _say(self, line: str) -> None:
        self.report(self.there, len(self.entries), line)

    def _lost(self) -> Interrupted:
        return Interrupted(f"the connection to the scheduler is lost\n{self._what_is_there()}")

    def _what_is_there(self) -> str:
        return f"{self.there} of {len(self.entries)} parts are in {self.folder}; the same command goes on from there"

    def _ask(self, function: Callable[[], Any]) -> Any:
        """Asks the scheduler something, with an end."""
        try:
            return self.client.sync(function, callback_timeout=30)
        except (asyncio.TimeoutError, OSError) as problem:
            raise self._lost() from problem


def words_of(problem: BaseException) -> str:
    """Of a task that Dask gave up."""
    if type(problem).__name__ != "KilledWorker":
        return f"{type(problem).__name__}: {problem}"
    deaths = getattr(problem, "allowed_failures", 3) + 1
    last = getattr(getattr(problem, "last_worker", None), "address", "unknown")
    return f"{deaths} workers died while they had it, the last one at {last}"
