# SPDX-License-Identifier: MIT
"""Plans: what a build of one mesh will do, decided before anything is allocated on the device."""

from typing import Any, Optional, TypeVar

from . import _generated, _opencl, _progress, _structs
from ._errors import error
from ._handle import Handle, Native
from ._native import ffi, lib
from ._tree import Tree

_T = TypeVar("_T")


class Plan(Handle):
    """A plan for one mesh on one device, made by Device.plan. str() lists its buffers and what it leaves out."""

    def __init__(self, pointer: Any, device: Native, progress: Optional[_progress.Progress] = None) -> None:
        self._progress = progress
        self._open(Native(pointer, _destroy_plan, device.guard, device))

    @property
    def info(self) -> _generated.PlanInfo:
        """What the plan found out."""
        struct = _structs.new("svo_plan_info")
        self._call(lib.svo_plan_get_info, struct)
        return _structs.read(struct, _generated.PlanInfo)

    @property
    def buffers(self) -> tuple[_generated.PlanBuffer, ...]:
        """The buffers that a build allocates, in order. After a build: exactly those that it allocated."""
        return self._entries("buffer_count", "get_buffer", "svo_buffer_info", _generated.PlanBuffer)

    @property
    def kernels(self) -> tuple[_generated.Kernels, ...]:
        """The programs of kernels that a build compiles."""
        return self._entries("kernels_count", "get_kernels", "svo_kernels_info", _generated.Kernels)

    @property
    def left_out(self) -> tuple[_generated.LeftOut, ...]:
        """What a build does without, and why. The result is the same, bit for bit, as if nothing were left out."""
        return self._entries("left_out_count", "get_left_out", "svo_left_out", _generated.LeftOut)

    def count(self, *, queue: Any = None, progress: Optional[_progress.Progress] = None) -> int:
        """Counts the fragments without keeping them; their number becomes the plan's capacity. Costs about a
        voxelization.

        Args:
            queue, progress: see Plan.build.

        Returns:
            The exact number of fragments.
        """
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        with _progress.opened(self._progress if progress is None else progress) as function:
            self._call(_progress.reporting(lib.svo_plan_count, function), ffi.NULL, cl_queue)
        return self.info.fragments

    def build(self, *, queue: Any = None, progress: Optional[_progress.Progress] = None) -> Tree:
        """Builds the tree and waits for it, with the front end of OpenCL alone.

        Args:
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr. Stage times are those of events if
                it has profiling enabled, else of the wall clock. None: the device's own.
            progress: see Device.plan. None: what Device.plan was given; False: nothing. A build that reports waits for
                its launches as it goes, and divides large ones; the tree is the same.

        Returns:
            The tree; its report says what the build did.

        Raises:
            OutOfDeviceMemoryError: the message says how many bytes are needed.
            CanceledError: progress returned True. The plan can be built again.
            CompileError, CLError, OutOfHostMemoryError
        """
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_tree **")
        report = _structs.new("svo_build_report")
        arguments = (ffi.NULL, cl_queue, out, report)
        with _progress.opened(self._progress if progress is None else progress) as function:
            build = _progress.reporting(lib.svo_build, function)
            with self._called(build, *arguments, undo=lambda: lib.svo_tree_destroy(out)):
                return Tree(out[0], self._native.parent, _structs.read_report(report))

    def _entries(self, count: str, get: str, struct_name: str, kind: type[_T]) -> tuple[_T, ...]:
        """The entries of a list, which a build on another thread may change before and after, but not meanwhile."""
        entries: list[_T] = []
        info, struct = _structs.new("svo_plan_info"), _structs.new(struct_name)
        with self._called(lib.svo_plan_get_info, info):
            for index in range(getattr(info, count)):
                status = getattr(lib, f"svo_plan_{get}")(self._native._pointer[0], index, struct)
                if status != lib.SVO_OK:
                    raise error(status, self._native.device_message())
                entries.append(_structs.read(struct, kind))
        return tuple(entries)

    def __str__(self) -> str:
        if self.closed:
            return repr(self)
        lines = [f"depth {self.info.depth}, {self.info.triangles:,} triangles, peak {self.info.peak_bytes:,} bytes"]
        for buffer in self.buffers:
            use = "tree" if buffer.persistent else "scratch"
            lines.append(f"  {buffer.name:<20} {buffer.bytes:>15,} bytes  {buffer.certainty.name.lower():<8}  {use}")
        lines += [f"  without {entry.what}: {entry.reason}" for entry in self.left_out]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return "<svocl.Plan: closed>" if self.closed else f"<svocl.Plan: depth {self.info.depth}>"


def _destroy_plan(pointer: Any) -> None:
    lib.svo_plan_destroy(ffi.new("svo_plan **", pointer))
