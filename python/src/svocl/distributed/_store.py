# SPDX-License-Identifier: MIT
"""Folders of parts in object stores, by an fsspec URL: s3://bucket/tree.parts.

A store replaces a rename by one operation alone, the put of an object that is not there yet. So plans are numbered:

    plan-00000003                 PLACE and the file `plan`; the one with the highest number is the folder's plan
    PLACE/LEVEL-CODE.tri          what this plan needs, PLACE/mesh too; no two plans have one place
    PLACE/LEVEL-CODE.part         what is built of it, PLACE/LEVEL-CODE.split too
    planner-00000004-0001.lease   who makes plan 4: the one with the highest second number
    run-TOKEN.lease               a run that builds or stitches

A planner that was stopped puts a number that is taken, or below another, and is refused; it never needs to know when
its lease was broken. A worker of an older plan writes to that plan's place, and a planner deletes places alone that
were there before its plan. So leases save work, and the numbers alone keep plans apart. All else is done in a folder on
a disk of this machine.
"""

import contextlib
import os
import re
import socket
import tempfile
import threading
import time
import uuid
from collections.abc import Iterable, Iterator
from typing import Callable, Optional

from .._errors import error, optional
from .._generated import Error
from .._native import lib
from .._parts import PartEntry, Parts

PROTOCOLS = {"s3": "s3fs", "s3a": "s3fs", "gs": "gcsfs", "gcs": "gcsfs", "memory": "fsspec"}
"""Those whose put-if-absent is known, and the package that they need."""
BLOCK_BYTES = 16 << 20
"""Of objects of several blocks, which travel one by one."""
BLOCKS_MAX = 10000
"""Of an object of S3."""
CONFLICTS = 5
"""Of one put at a time, which S3 answers by "try again"."""
PLAN = re.compile(r"plan-(\d{8})")
PLANNER = re.compile(r"planner-(\d{8})-(\d{4})\.lease")
RUN = re.compile(r"run-[0-9a-f]{32}\.lease")
PLACE = re.compile(r"[0-9a-f]{32}")
PLACE_BYTES = 32

_memory_lock = threading.Lock()


def is_url(path: str) -> bool:
    return "://" in path


def without_file_scheme(path: str) -> str:
    """file:///tmp/a -> /tmp/a: a folder on a disk needs no store."""
    return re.sub(r"^(file|local)://", "", path)


class Store:
    """Objects below a URL, by names. Each appears whole or not at all, and whoever asks after that sees it.

    Args:
        url: of a protocol of PROTOCOLS. Credentials and endpoints are those of the process's environment.

    Raises:
        FileError: the protocol is not known, or its package is missing.
    """

    def __init__(self, url: str) -> None:
        self.url = url.rstrip("/")
        self.protocol = url.split("://")[0]
        if self.protocol not in PROTOCOLS:
            known = ", ".join(f"{name}://" for name in PROTOCOLS)
            raise error(lib.SVO_FILE_ERROR, f"{url}: is none of {known}: no put-if-absent is known of others")
        try:
            core = optional("fsspec.core", "a folder by URL", "fsspec")
            with self._told(""):
                self.fs, self.root = core.url_to_fs(self.url, use_listings_cache=False)
        except ImportError as problem:
            package = PROTOCOLS[self.protocol]
            raise error(lib.SVO_FILE_ERROR, f"{url}: {problem} (pip install {package})") from problem

    def names(self, folder: str = "") -> list[str]:
        """Names of the objects and folders in a folder, sorted. What is not there has none."""
        place = self._path(folder) if folder else self.root
        with self._told(folder):
            try:
                found = self.fs.ls(place, detail=False, **({"refresh": True} if self.protocol != "memory" else {}))
            except FileNotFoundError:
                return []
        return sorted(path.rstrip("/").rsplit("/", 1)[1] for path in found if path.strip("/") != place.strip("/"))

    def get(self, name: str) -> bytes:
        with self._told(name):
            return bytes(self.fs.cat_file(self._path(name)))

    def put(self, name: str, content: bytes) -> None:
        """Makes or replaces an object."""
        with self._told(name):
            self.fs.pipe_file(self._path(name), content)

    def put_if_absent(self, name: str, content: bytes) -> bool:
        """Makes an object, unless there is one of that name: of all that try, one alone returns True.

        Also True where the object is there with this content: an answer that was lost is asked for again, and then this
        process's own object is there. So content that tells callers apart must say who they are.
        """
        with self._told(name), _memory_lock if self.protocol == "memory" else contextlib.nullcontext():
            for conflict in range(CONFLICTS):
                try:
                    self.fs.pipe_file(self._path(name), content, mode="create")
                    return True
                except Exception as problem:
                    code = answer_of(problem)
                    if code == "ConditionalRequestConflict" and conflict < CONFLICTS - 1:
                        time.sleep(0.1)
                    elif isinstance(problem, FileExistsError) or code == "PreconditionFailed":
                        break
                    else:
                        raise
        return self.get(name) == content

    def get_file(self, name: str, path: str) -> None:
        with self._told(name):
            self.fs.get_file(self._path(name), path)

    def put_file(self, path: str, name: str) -> None:
        """Makes or replaces an object; a large one by blocks, and it appears when all are there."""
        block_bytes = max(BLOCK_BYTES, -(-os.path.getsize(path) // BLOCKS_MAX))
        blocks = {} if self.protocol == "memory" else {"chunksize": block_bytes}
        with self._told(name):
            self.fs.put_file(path, self._path(name), **blocks)

    def delete(self, names: Iterable[str]) -> None:
        """Deletes objects, and all in folders. What is not there is passed over."""
        for name in names:
            with self._told(name), contextlib.suppress(FileNotFoundError):
                self.fs.rm(self._path(name), recursive=True)

    def modified(self, name: str) -> Optional[float]:
        """When an object was put, in seconds by the store's clock; None: it is not there."""
        with self._told(name):
            try:
                return float(self.fs.modified(self._path(name)).timestamp())
            except FileNotFoundError:
                return None

    def _path(self, name: str) -> str:
        return f"{self.root}/{name}"

    @contextlib.contextmanager
    def _told(self, name: str) -> Iterator[None]:
        """Failures of all packages become the library's: those that a later try may not have are UnavailableError."""
        try:
            yield
        except (Error, ImportError):
            raise
        except Exception as problem:
            is_final = isinstance(problem, (FileNotFoundError, PermissionError, ValueError, TypeError))
            is_final = is_final or type(problem).__name__ in ("NoCredentialsError", "ParamValidationError")
            status = lib.SVO_FILE_ERROR if is_final else lib.SVO_UNAVAILABLE
            place = f"{self.url}/{name}" if name else self.url
            raise error(status, f"{place}: {type(problem).__name__}: {problem}") from problem


def answer_of(problem: Optional[BaseException]) -> str:
    """The code that S3 answered, "" where there is none."""
    while problem is not None:
        response = getattr(problem, "response", None)
        if isinstance(response, dict):
            return str(response.get("Error", {}).get("Code", ""))
        problem = problem.__cause__
    return ""


class StoredParts:
    """The folder of parts in a store, and this run's place in it.

    Args:
        url: of the folder.
        plan: the name of the plan that this run belongs to; "": publish gives it one.
        place: of its files.
        identity: of that plan.
    """

    def __init__(self, url: str, plan: str = "", place: str = "", identity: str = "") -> None:
        self.store = Store(url)
        self.plan, self.place, self.identity = plan, place, identity
        self.number = 0
        self.token = uuid.uuid4().hex
        self.opened = contextlib.ExitStack()

    # --- plans ------------------------------------------------------------------------------------------------------

    @contextlib.contextmanager
    def planning(self, report: Callable[[str], None]) -> Iterator[None]:
        """Holds the lease of the folder's next plan: to be left when publish has returned.

        Raises:
            UnavailableError: another process plans, builds or stitches.
            FileError: the store knows no put-if-absent.
        """
        now = self._ask_clock()
        names = self.store.names()
        self.number = number_of(self._last(names)) + 1
        tries = [name for name in names if (found := PLANNER.fullmatch(name)) and int(found[1]) == self.number]
        if tries and self._is_live(tries[-1], now):
            raise self._busy(tries[-1], "plans it")
        count = int(tries[-1][17:21]) + 1 if tries else 0
        lease = f"planner-{self.number:08d}-{count:04d}.lease"
        if not self.store.put_if_absent(lease, self._owner()):
            raise self._busy(lease, "plans it")
        if tries:
            report(f"{self.store.url}: {self._words(tries[-1])} has not renewed its lease, which is broken")
        with self._renewed(lease):
            for name in filter(RUN.fullmatch, self.store.names()):
                if self._is_live(name, now):
                    raise self._busy(name, "builds or stitches its parts")
                report(f"{self.store.url}: {self._words(name)} has not renewed its lease, which is broken")
                self.store.delete([name])
            yield

    def publish(self, parts: Parts) -> None:
        """Puts what the plan of a folder on a disk needs, then the plan, in one step. Where the folder has this plan
        already, its parts stay. From then on this run has a lease of the folder, until close.

        Raises:
            UnavailableError: another process planned meanwhile.
        """
        with open(os.path.join(parts.folder, "plan"), "rb") as file:
            content = file.read()
        self.identity, self.place = parts.identity, self.token
        last = self._last(self.store.names())
        found = self.store.get(last) if last and number_of(last) == self.number - 1 else b""
        if found[PLACE_BYTES:] == content:
            self.plan, self.place = last, found[:PLACE_BYTES].decode()
        files = os.path.join(parts.folder, self.identity)
        for name in sorted(os.listdir(files)):
            if name == "mesh" or name.endswith(".tri"):
                self.store.put_file(os.path.join(files, name), f"{self.place}/{name}")
        names = self.store.names()
        if not self.plan:
            self.plan = f"plan-{self.number:08d}"
            if not self.store.put_if_absent(self.plan, self.place.encode() + content):
                self.store.delete([self.place])
                raise error(lib.SVO_UNAVAILABLE, f"{self.store.url}: another process made {self.plan} meanwhile")
        self.opened.enter_context(self._renewed(f"run-{self.token}.lease"))
        self.check()
        others = [name for name in names if PLACE.fullmatch(name) or PLAN.fullmatch(name)]
        self.store.delete(name for name in others if name not in (self.plan, self.place))

    def check(self) -> None:
        """Raises UnavailableError where the folder has another plan than this run."""
        if self._last(self.store.names()) != self.plan:
            raise self._anew()

    def get_plan(self) -> bytes:
        """The file `plan`."""
        return self.store.get(self.plan)[PLACE_BYTES:]

    def close(self) -> None:
        """Ends the run's lease."""
        self.opened.close()

    def remove(self) -> None:
        """Removes this run's plan and what it needed, unless the folder has another plan by now."""
        names = self.store.names()
        if self._last(names) == self.plan:
            self.store.delete(name for name in names if PLAN.fullmatch(name) or PLANNER.fullmatch(name))
            self.store.delete([self.place])

    # --- parts ------------------------------------------------------------------------------------------------------

    def get_triangles(self, name: str, folder: str) -> None:
        """Gets a part's triangles into a folder on a disk."""
        self.store.get_file(f"{self.place}/{name}.tri", os.path.join(folder, self.identity, f"{name}.tri"))

    def put_parts(self, folder: str) -> tuple[str, ...]:
        """Puts what was built in a folder on a disk; what says that a part was split comes last. Returns the names."""
        names = sorted(name for name in os.listdir(folder) if name.endswith(".part"))
        splits = sorted(name for name in os.listdir(os.path.join(folder, self.identity)) if name.endswith(".split"))
        for name in (*names, *splits):
            self.store.put_file(self._path(folder, name), f"{self.place}/{name}")
        return (*names, *splits)

    def get_part(self, name: str, folder: str) -> None:
        """Gets a file of put_parts into a folder on a disk."""
        self.store.get_file(f"{self.place}/{name}", self._path(folder, name))

    def names_of(self, entry: Optional[PartEntry] = None) -> list[str]:
        """What was built of a part, or of all."""
        names = self.store.names(self.place)
        return [name for name in names if (is_of_part(name, entry) if entry else name.endswith((".part", ".split")))]

    def discard(self, entry: PartEntry) -> None:
        """Deletes what was built of a part, so that it is built anew."""
        self.store.delete(f"{self.place}/{name}" for name in self.names_of(entry))

    def _path(self, folder: str, name: str) -> str:
        return os.path.join(folder, self.identity, name) if name.endswith(".split") else os.path.join(folder, name)

    # --- leases -----------------------------------------------------------------------------------------------------

    def _ask_clock(self) -> float:
        """The store's time; also whether it refuses what it must."""
        name = f"clock-{self.token}"
        try:
            for content, is_new in ((b"first", True), (b"second", False)):
                if self.store.put_if_absent(name, content) != is_new:
                    raise error(lib.SVO_FILE_ERROR, f"{self.store.url}: the store replaces an object that must be new")
            return self.store.modified(name) or 0.0
        finally:
            self.store.delete([name])

    def _is_live(self, lease: str, now: float) -> bool:
        renewed = self.store.modified(lease)
        return renewed is not None and renewed > now - lib.SVO_PARTS_LEASE_SECONDS

    @contextlib.contextmanager
    def _renewed(self, lease: str) -> Iterator[None]:
        """Keeps a lease, by a thread that renews it."""
        done = threading.Event()
        self.store.put(lease, self._owner())

        def renew() -> None:
            while not done.wait(lib.SVO_PARTS_LEASE_SECONDS / 4):
                with contextlib.suppress(Error):  # whatever it led to is told where plans are compared
                    self.store.put(lease, self._owner())

        thread = threading.Thread(target=renew, name="svocl lease", daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()
            with contextlib.suppress(Error):
                self.store.delete([lease])

    def _owner(self) -> bytes:
        return f"process {os.getpid()} on {socket.gethostname()}\n{self.token}\n".encode()

    def _words(self, lease: str) -> str:
        """Whose lease it is."""
        try:
            return self.store.get(lease).decode(errors="replace").split("\n")[0]
        except Error:
            return "another process"

    def _busy(self, lease: str, what: str) -> Error:
        return error(lib.SVO_UNAVAILABLE, f"{self.store.url}: {self._words(lease)} {what}")

    def _anew(self) -> Error:
        found = self._last(self.store.names()) or "none"
        return error(
            lib.SVO_UNAVAILABLE,
            f"{self.store.url}: planned anew meanwhile: this run belongs to {self.plan} of identity {self.identity}, "
            f"the folder's plan is {found}",
        )

    @staticmethod
    def _last(names: list[str]) -> str:
        plans = [name for name in names if PLAN.fullmatch(name)]
        return plans[-1] if plans else ""


def number_of(plan: str) -> int:
    found = PLAN.fullmatch(plan)
    return int(found[1]) if found else 0


def is_of_part(name: str, entry: PartEntry) -> bool:
    """Whether a file that a worker sends belongs in the folder: of the part, or of one that it was split into."""
    found = re.fullmatch(r"(0|[1-9][0-9]?)-(0|[1-9a-f][0-9a-f]*)\.(part|split)", name)
    if not found or int(found[1]) < entry.level:
        return False
    return int(found[2], 16) >> 3 * (int(found[1]) - entry.level) == entry.code


class Places:
    """Where the parts and the file lie: on disks, or in stores, of which this machine then has a copy until the job's
    end.

    Args:
        output, parts: names or URLs.
        scratch: a folder on a disk, for the copy; None: the system's.
        opened: ends with the job.
    """

    def __init__(self, output: str, parts: str, scratch: Optional[str], opened: contextlib.ExitStack) -> None:
        self.url = output if is_url(output) else ""
        self.stored = StoredParts(parts) if is_url(parts) else None
        self.output, self.folder = output, parts
        if self.url or self.stored:
            place = opened.enter_context(tempfile.TemporaryDirectory(prefix="svocl-", dir=scratch))
            self.output = os.path.join(place, "tree.svo") if self.url else self.output
            self.folder = os.path.join(place, "tree.svo.parts") if self.stored else self.folder
        if self.stored:
            opened.callback(self.stored.close)

    def planning(self, report: Callable[[str], None]) -> contextlib.AbstractContextManager[None]:
        return self.stored.planning(report) if self.stored else contextlib.nullcontext()

    def publish(self, parts: Parts) -> None:
        if self.stored:
            self.stored.publish(parts)
            for name in self.stored.names_of():
                self.stored.get_part(name, self.folder)

    def discard(self, parts: Parts, indices: list[int]) -> None:
        """The next try builds these parts, which are damaged."""
        if self.stored:
            for entry in [parts.entries[index] for index in indices]:
                self.stored.discard(entry)

    def put_output(self) -> None:
        if self.stored:
            self.stored.check()
        if self.url:
            folder, name = self.url.rsplit("/", 1)
            Store(folder).put_file(self.output, name)

    def remove(self) -> None:
        if self.stored:
            self.stored.remove()
        Parts.remove(self.folder)
