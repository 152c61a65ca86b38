# SPDX-License-Identifier: MIT
"""Trees in parts: a folder with what each part needs, built by any number of processes and stitched to one file."""

import contextlib
import logging
import os
import threading
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, Optional

from . import _arrays, _structs
from ._callbacks import call
from ._device import Device, plan_options
from ._errors import error, text
from ._generated import Builder, Coverage, Need, UnsupportedError, Weights
from ._handle import Guard, Handle, Native
from ._mesh import Path, encode, mesh_of, need_io, read_mesh
from ._native import ffi, lib

FILE_NODES_MAX = (1 << 32) - 2
FILE_DEPTH_MAX = 16
"""Nodes of a .svo file, at most."""


class PartEntry(NamedTuple):
    """A part of the list."""

    level: int
    """Of the node that the part lies under."""
    code: int
    """The node's Morton code."""
    triangles: int
    """That may meet the part."""
    expected_bytes: int
    """Memory that its build is expected to take at most."""

    @property
    def name(self) -> str:
        """LEVEL-CODE, the code in hexadecimal: the front of its files' names."""
        return f"{self.level}-{self.code:x}"


class Parts(Handle):
    """A folder with the parts of one tree, as Parts.create or `svocl parts plan` fills it.

    Any number of processes may use one folder at once: files appear whole or not at all. len() is the number of parts
    in the list. Warnings about files that do not count go to the logger "svocl".

    Args:
        folder: of Parts.create.

    Raises:
        FileError: it cannot be read.
        FileDamagedError: its list of parts is damaged.
    """

    def __init__(self, folder: Path) -> None:
        need_io("Parts")
        self.folder: str = os.fsdecode(folder)
        out = ffi.new("svo_parts **")
        message = ffi.new("svo_message *")
        status = call(lib.svo_parts_open, encode(folder), out, message, undo=lambda: lib.svo_parts_close(out))
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        self._open(Native(out[0], _close, Guard(), None))

    @classmethod
    def create(
        cls,
        device: Device,
        mesh: Any,
        depth: int,
        folder: Path,
        *,
        max_bytes: int = 0,
        need: Need = Need.DEFAULT,
        coverage: Coverage = Coverage.HALF_OPEN,
        weights: Weights = Weights.AREA,
        payload_level: int = 0,
        origin: Optional[Sequence[float]] = None,
        edge: Optional[float] = None,
        drop_alpha: float = 0.0,
    ) -> "Parts":
        """Plans the parts of a mesh and fills a folder. Parts of this tree that are in it already stay.

        Args:
            device: whose memory the parts are planned for.
            mesh: the whole mesh, a Mesh or an object with vertices and faces, see Device.plan.
            depth: of the whole tree, 1 .. 20; above 16 the folder is never stitched.
            folder: is made where it is not there.
            max_bytes: for the buffers and the host's memory of one part's build; 0: a sixteenth of the whole's, and
                at least 16 MiB.
            need, coverage, weights, payload_level, origin, edge, drop_alpha: see Device.plan.

        Raises:
            CapacityExceededError: max_bytes is too small for any part.
            UnavailableError: another process plans, builds or stitches the parts of the folder.
            FileError, and what Device.plan raises.
        """
        need_io("Parts.create")
        options = plan_options(need, coverage, weights, Builder.CL, payload_level, origin, edge, drop_alpha)
        struct, kept = mesh_of(mesh)._struct()
        bytes_max = _arrays.integer("max_bytes", max_bytes, 64)
        message = ffi.new("svo_message *")
        arguments = (struct, _arrays.integer("depth", depth), options, bytes_max, encode(folder), message)
        with device._use() as pointer:
            status = call(lib.svo_parts_create, pointer, *arguments)
        del kept
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        return cls(folder)

    @classmethod
    def create_from_file(
        cls,
        device: Device,
        path: Path,
        depth: int,
        folder: Path,
        *,
        max_bytes: int = 0,
        need: Need = Need.DEFAULT,
        coverage: Coverage = Coverage.HALF_OPEN,
        weights: Weights = Weights.AREA,
        payload_level: int = 0,
        origin: Optional[Sequence[float]] = None,
        edge: Optional[float] = None,
        drop_alpha: float = 0.0,
    ) -> "Parts":
        """Plans the parts of a mesh file. Binary STL, and binary PLY with vertices and faces alone, are read in blocks:
        the mesh is never in memory as a whole. Other files are read by read_mesh, and so are all where rays or
        projected areas are needed.

        Args:
            path: the mesh file.
            device, depth, folder, max_bytes and the others: see create.

        Raises:
            ImportFailedError: the file cannot be read.
            What create raises.
        """
        options: dict[str, Any] = {
            "need": need,
            "coverage": coverage,
            "weights": weights,
            "origin": origin,
            "edge": edge,
        }
        options.update(payload_level=payload_level, drop_alpha=drop_alpha)
        try:
            with PartsPlanning(device, path, depth, folder, max_bytes, 1, **options) as planning:
                while planning.task_count():
                    planning.take(0, planning.work(device, planning.task(0)))
                return planning.finish()
        except UnsupportedError as problem:
            logging.getLogger("svocl").info("%s", problem)
        return cls.create(device, read_mesh(path), depth, folder, max_bytes=max_bytes, **options)

    @staticmethod
    @contextlib.contextmanager
    def lease(folder: Path) -> Iterator[None]:
        """Holds a lease of a folder, which is made where it is not there: meanwhile no other process plans or removes
        it. A thread renews the lease. Taken before create, it leaves no gap between a plan and its parts.

        Raises:
            UnavailableError: another process plans the folder.
            FileError: no file can be made in it.
        """
        need_io("Parts.lease")
        out = ffi.new("svo_parts_lease **")
        message = ffi.new("svo_message *")
        status = call(lib.svo_parts_lease_take, encode(folder), out, message)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        done = threading.Event()

        def renew() -> None:
            # A renewal that fails is not told: whatever it led to is, where files are of another plan.
            while not done.wait(lib.SVO_PARTS_LEASE_SECONDS / 4):
                lib.svo_parts_lease_renew(out[0], ffi.NULL)

        thread = threading.Thread(target=renew, name="svocl lease", daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()
            lib.svo_parts_lease_release(out)

    @staticmethod
    def remove(folder: Path) -> None:
        """Removes the files of a folder, and the folder if nothing else is in it.

        Raises:
            UnavailableError: another process has a lease of it.
            FileError: a file cannot be removed.
        """
        need_io("Parts.remove")
        message = ffi.new("svo_message *")
        status = call(lib.svo_parts_remove, encode(folder), message)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))

    def __len__(self) -> int:
        with self._use() as pointer:
            return int(lib.svo_parts_count(pointer))

    @property
    def identity(self) -> str:
        """Of the plan: 32 hexadecimal digits, which each of its files has. Those that are not parts are in the folder's
        folder of that name."""
        out = ffi.new("char[]", lib.SVO_PARTS_IDENTITY_BYTES)
        self._ask(lib.svo_parts_get_identity, out)
        return text(out)

    @property
    def expected_nodes(self) -> float:
        """Of the whole tree, as estimated from the mesh. More than FILE_NODES_MAX do not fit a .svo file: the folder
        alone is such a tree, see PartsTree."""
        header = _structs.new("svo_part_header")
        self._ask(lib.svo_parts_get_header, header)
        return float(header.expected_nodes)

    @property
    def entries(self) -> list[PartEntry]:
        """The list of parts."""
        found = []
        entry = _structs.new("svo_parts_entry")
        for index in range(len(self)):
            self._ask(lib.svo_parts_get, index, entry)
            found.append(PartEntry(entry.level, entry.code, entry.triangles, entry.expected_bytes))
        return found

    def is_built(self, index: int) -> bool:
        """Whether a part is there and every byte is right; it is read whole."""
        out = ffi.new("int *")
        words = self._ask(lib.svo_parts_is_built, _arrays.integer("index", index, 64), out)
        if words:
            logging.getLogger("svocl").warning("%s", words)
        return bool(out[0])

    def build(self, index: int, device: Device) -> None:
        """Builds a part, unless it is there and whole.

        Args:
            index: in the list.
            device: any.

        Raises:
            UnavailableError: the folder was planned anew since it was opened, or there is no space.
            FileError, FileDamagedError: the folder's files.
            CapacityExceededError: a part that cannot be split does not fit.
        """
        number = _arrays.integer("index", index, 64)
        with device._use() as on:
            self._ask(lib.svo_parts_build, number, on, ffi.NULL, ffi.NULL)

    def finish(self, path: Path) -> None:
        """Stitches all parts to a .svo file, which appears whole or not at all.

        Raises:
            FileError: a part is missing, or a file cannot be written.
            FileDamagedError: a part is damaged.
            CapacityExceededError: the tree has too many nodes for a file.
        """
        self._ask(lib.svo_parts_finish, encode(path))

    def begin_shares(self, count: int) -> None:
        """Begins to stitch by shares, which any number of processes write side by side: begin_shares once, write_share
        for each index, finish_shares when all are written. The file is the one of finish, byte for byte. Each may be
        called again; what is there stays.

        Args:
            count: of shares, 1 to 65536.

        Raises:
            FileError: a part is missing, or a file cannot be written.
            FileDamagedError: a part is damaged.
            UnavailableError: the folder was planned anew since it was opened, or there is no space.
            CapacityExceededError: the tree has too many nodes for a file.
        """
        self._ask(lib.svo_parts_shares_begin, _arrays.integer("count", count))

    def write_share(self, index: int, count: int) -> None:
        """Writes a share, unless it is written; in any process that sees the folder.

        Args:
            index: below count.
            count: as begin_shares was told.

        Raises:
            UnavailableError: the shares have not been begun, or are finished, and what begin_shares raises.
        """
        self._ask(lib.svo_parts_shares_write, _arrays.integer("index", index), _arrays.integer("count", count))

    def finish_shares(self, count: int, path: Path) -> None:
        """Completes the file and gives it its name, when all shares are written.

        Args:
            count: as begin_shares was told.
            path: on the file system of the folder.

        Raises:
            UnavailableError: a share is not written, or they have not been begun, and what begin_shares raises.
        """
        self._ask(lib.svo_parts_shares_finish, _arrays.integer("count", count), encode(path))

    def _ask(self, function: Any, *arguments: Any) -> str:
        """Calls function(pointer, *arguments, message); returns the message, raises the status."""
        message = ffi.new("svo_message *")
        with self._use() as pointer:
            status = call(function, pointer, *arguments, message)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        return text(message.text)

    def __repr__(self) -> str:
        return "<svocl.Parts: closed>" if self.closed else f"<svocl.Parts: {len(self)} parts in {self.folder}>"


class PartsPlanning(Handle):
    """Planning from a mesh file by any number of processes, in steps: work does a task anywhere, also several at once,
    and take brings back what it returned. After the last result of a step, the next one's tasks are there.

        with svocl.PartsPlanning(device, path, depth, folder, max_bytes, 8) as planning:
            while count := planning.task_count():
                for index in range(count):  # in any order, in any process
                    planning.take(index, svocl.PartsPlanning.work(device, planning.task(index)))
            parts = planning.finish()

    The folder gets the same bytes whatever the number of ranges.

    Args:
        device: whose memory the parts are planned for.
        path: binary STL, or binary PLY with vertices and faces alone; the same name where tasks are done.
        depth: of the whole tree.
        folder: is made where it is not there; the same name where tasks are done.
        max_bytes: see Parts.create.
        ranges: of the file that may be read side by side.
        need, coverage, weights, payload_level, origin, edge, drop_alpha: see Device.plan.

    Raises:
        UnsupportedError: a file or a request for which the mesh must be in memory; see Parts.create.
        UnavailableError: another process plans, builds or stitches the parts of the folder.
        FileError, ImportFailedError: the file.
    """

    def __init__(
        self,
        device: Device,
        path: Path,
        depth: int,
        folder: Path,
        max_bytes: int,
        ranges: int,
        need: Need = Need.DEFAULT,
        coverage: Coverage = Coverage.HALF_OPEN,
        weights: Weights = Weights.AREA,
        payload_level: int = 0,
        origin: Optional[Sequence[float]] = None,
        edge: Optional[float] = None,
        drop_alpha: float = 0.0,
    ) -> None:
        need_io("PartsPlanning")
        self.folder = os.fsdecode(folder)
        options = plan_options(need, coverage, weights, Builder.CL, payload_level, origin, edge, drop_alpha)
        out = ffi.new("svo_parts_planning **")
        message = ffi.new("svo_message *")
        numbers = (_arrays.integer("depth", depth), options, _arrays.integer("max_bytes", max_bytes, 64))
        names = (encode(folder), _arrays.integer("ranges", ranges), out, message)
        with device._use() as pointer:
            status = call(lib.svo_parts_planning_begin, pointer, encode(path), *numbers, *names)
            if status != lib.SVO_OK:
                raise error(status, text(message.text))
            self._open(Native(out[0], _end, device._native.guard, device._native))

    def task_count(self) -> int:
        """Of this step; 0: all is done. To be called every 20 seconds or more often, so that the folder stays ours."""
        out = ffi.new("size_t *")
        self._ask(lib.svo_parts_planning_tasks, out)
        return int(out[0])

    def task(self, index: int) -> bytes:
        """A task of this step."""
        task = ffi.new("void const **")
        count = ffi.new("size_t *")
        message = ffi.new("svo_message *")
        with self._use() as pointer:
            status = call(lib.svo_parts_planning_task, pointer, index, task, count, message)
            if status != lib.SVO_OK:
                raise error(status, text(message.text))
            return bytes(ffi.buffer(task[0], count[0]))

    @staticmethod
    def work(device: Device, task: bytes) -> bytes:
        """Does a task, in any process that sees the mesh and the folder; returns its result.

        Raises:
            FileError: the mesh or the folder is not there, or the mesh has changed.
            UnavailableError: there is no space.
            InvalidArgumentError: a task of another version of svocl.
        """
        out = ffi.new("void **")
        count = ffi.new("size_t *")
        message = ffi.new("svo_message *")
        with device._use() as pointer:
            status = call(lib.svo_parts_planning_work, pointer, task, len(task), out, count, message)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        try:
            return bytes(ffi.buffer(out[0], count[0]))
        finally:
            lib.svo_parts_planning_free(out[0])

    def take(self, index: int, result: bytes) -> None:
        """Takes the result of a task."""
        self._ask(lib.svo_parts_planning_take, index, result, len(result))

    def finish(self) -> Parts:
        """Puts the plan in its place, when all tasks are done; returns its parts."""
        self._ask(lib.svo_parts_planning_finish)
        return Parts(self.folder)

    def _ask(self, function: Any, *arguments: Any) -> None:
        message = ffi.new("svo_message *")
        with self._use() as pointer:
            status = call(function, pointer, *arguments, message)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))


def _end(pointer: Any) -> None:
    lib.svo_parts_planning_end(ffi.new("svo_parts_planning **", pointer))


def _close(pointer: Any) -> None:
    lib.svo_parts_close(ffi.new("svo_parts **", pointer))
