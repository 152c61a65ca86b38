# SPDX-License-Identifier: MIT
"""Edits of voxels: shapes and other voxels are set, added, cleared, kept, painted and copied, and steps are undone."""

import operator
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Callable, NamedTuple, Optional, Union

import numpy as np

from . import _arrays, _generated, _opencl, _structs
from ._callbacks import call
from ._compact import Compact
from ._errors import error, text
from ._generated import EditVerb, Form, Need
from ._handle import Guard, Handle, Native
from ._native import ffi, lib
from ._tree import Tree
from ._voxels import Voxels

if TYPE_CHECKING:
    from ._device import Device


class Box(NamedTuple):
    """A box of voxels: those whose centers are in it."""

    low: Sequence[float]
    """(3,): least corner, voxels."""
    high: Sequence[float]
    """(3,): greatest corner, voxels."""


class Sphere(NamedTuple):
    """A sphere of voxels: those whose centers are in it."""

    center: Sequence[float]
    """(3,), voxels."""
    radius: float
    """Voxels."""


class Capsule(NamedTuple):
    """All that is at most radius from the line between two points: those voxels whose centers are in it."""

    begin: Sequence[float]
    """(3,), voxels."""
    end: Sequence[float]
    """(3,), voxels."""
    radius: float
    """Voxels."""


Shape = Union[Box, Sphere, Capsule]


class Edit(Handle):
    """An octree of voxels that changes step by step and keeps its versions. A step costs what it changes. After one
    that fails the edit is as it was before.

    Args:
        voxels: to begin with; None: no voxels.
        max_bytes: most memory of all nodes; 0: half of what the machine and the process's limits allow.
        undo_count: steps that can be undone, at most 2**20; the oldest is forgotten. 0: 64.
        progress: called during each step with the fraction that is done, 0 .. 1; True stops the step, which raises
            CanceledError. It must not use the edit.

    Raises:
        InvalidArgumentError: a number is out of range, or the voxels are too far apart.
        CapacityExceededError: the voxels need more than max_bytes.
        OutOfHostMemoryError
    """

    def __init__(
        self,
        voxels: Optional[Voxels] = None,
        *,
        max_bytes: int = 0,
        undo_count: int = 0,
        progress: Optional[Callable[[float], Optional[bool]]] = None,
    ) -> None:
        options = _structs.new("svo_edit_options")
        if progress is not None:
            self._progress = ffi.new_handle(progress)
            options.progress, options.progress_user = lib.svocl_python_fraction, self._progress
        options.max_bytes = _arrays.integer("max_bytes", max_bytes, 64)
        options.undo_count = _arrays.integer("undo_count", undo_count)
        if voxels is None:
            self._create(ffi.NULL, options)
        else:
            with voxels._use() as pointer:
                self._create(pointer, options)

    # --- steps ------------------------------------------------------------------------------------------------------

    def apply(
        self, verb: EditVerb, shape: Shape, *, color: Sequence[int] = (255, 255, 255, 255), material: int = 0
    ) -> None:
        """Does a step with a shape.

        Args:
            verb: what it does with the voxels inside.
            shape: a Box, a Sphere or a Capsule, within Edit.info.low .. high with its radius.
            color: (4,) RGBA, 0 .. 255, of what is set, added or painted.
            material: of the same, below 65535.

        Raises:
            InvalidArgumentError: a number is out of range.
            CapacityExceededError: the nodes need more than max_bytes.
            OutOfHostMemoryError
        """
        step = _step(verb, shape)
        step.rgba = [operator.index(part) for part in color]
        step.material = _arrays.integer("material", material)
        self._run(lib.svo_edit_apply, step)

    def combine(self, verb: EditVerb, other: "Edit", offset: Sequence[int] = (0, 0, 0)) -> None:
        """Does a step with the voxels of another edit, each with its own color and material. EditVerb.SET and ADD make
        the union, CLEAR the difference, KEEP the intersection.

        Args:
            verb: what it does with the places of the other's voxels.
            other: an Edit; may be this one.
            offset: (3,) whole numbers that are added to the other's coordinates.

        Raises:
            InvalidArgumentError: what is set or added does not lie within Edit.info.low .. high.
            CapacityExceededError: the nodes need more than max_bytes.
            OutOfHostMemoryError
        """
        step = _structs.new("svo_edit_step")
        step.verb = EditVerb(verb)
        step.shape = lib.SVO_EDIT_VOXELS
        step.offset = [operator.index(part) for part in offset]
        if not isinstance(other, Edit):
            raise TypeError(f"other: {type(other).__name__}, expected svocl.Edit")
        if other is self:
            with self._use() as pointer:
                step.other = pointer
                self._check(lib.svo_edit_apply, pointer, step)
            return
        with other._use() as source:
            step.other = source
            self._run(lib.svo_edit_apply, step)

    def copy(self, shape: Shape, offset: Sequence[int], *, verb: EditVerb = EditVerb.SET) -> None:
        """Copies the voxels inside a shape to another place, as one step.

        Args:
            shape: a Box, a Sphere or a Capsule.
            offset: (3,) whole numbers that are added to coordinates, within 2**21 of 0.
            verb: what happens with the places of the copy.

        Raises:
            InvalidArgumentError: a number is out of range, or the copy does not lie within Edit.info.low .. high.
            CapacityExceededError: the nodes need more than max_bytes.
            OutOfHostMemoryError
        """
        by = ffi.new("int32_t[3]", [operator.index(part) for part in offset])
        self._run(lib.svo_edit_copy, _step(verb, shape), by)

    def undo(self) -> None:
        """Goes back by one step.

        Raises:
            IndexError: there is none; see Edit.info.undo_count.
        """
        with self._use() as pointer:
            if call(lib.svo_edit_undo, pointer) != lib.SVO_OK:
                raise IndexError("there is no step to undo")

    def redo(self) -> None:
        """Does the step again that was undone last.

        Raises:
            IndexError: there is none; see Edit.info.redo_count.
        """
        with self._use() as pointer:
            if call(lib.svo_edit_redo, pointer) != lib.SVO_OK:
                raise IndexError("there is no step to redo")

    def forget(self) -> None:
        """Forgets all versions but the current one: nothing can be undone or done again."""
        with self._use() as pointer:
            call(lib.svo_edit_forget, pointer)

    def collect(self) -> None:
        """Releases the memory of nodes that no version has any more, in place, in proportion to what the edit holds.
        Steps do it by themselves when there are many of them."""
        with self._use() as pointer:
            call(lib.svo_edit_collect, pointer)

    # --- what it holds ----------------------------------------------------------------------------------------------

    @property
    def info(self) -> _generated.EditInfo:
        """What the edit holds."""
        struct = _structs.new("svo_edit_info")
        self._call(lib.svo_edit_get_info, struct)
        return _structs.read(struct, _generated.EditInfo)

    def find(self, place: Sequence[int]) -> Optional[_arrays.Array]:
        """The voxel at a place, one record of voxel_dtype; None where there is none.

        Args:
            place: (3,) whole numbers within 2**31 of 0.
        """
        at = ffi.new("int32_t[3]", [operator.index(part) for part in place])
        found = np.zeros(1, _arrays.voxel_dtype)
        with self._use() as pointer:
            is_there = call(lib.svo_edit_find, pointer, at, ffi.cast("svo_voxel *", found.ctypes.data))
        return found[0] if is_there else None

    def voxels(self) -> Voxels:
        """The voxels as a list, the same that Voxels makes of them.

        Raises:
            InvalidArgumentError: there are more than 2**31.
            OutOfHostMemoryError
        """
        made = Voxels.__new__(Voxels)
        with self._use() as pointer:
            made._create(lib.svo_edit_get_voxels, pointer)
        return made

    def build(self, device: "Device", depth: int = 0, **options: Any) -> Tree:
        """Builds the tree of the voxels: Edit.voxels, Voxels.build. It has the bytes of every tree of these voxels.

        Args:
            device, depth, options: see Voxels.build.
        """
        with self.voxels() as voxels:
            return voxels.build(device, depth, **options)

    def compact(
        self,
        device: "Device",
        depth: int = 0,
        form: Form = Form.DESCRIPTOR,
        *,
        leave_out: Need = Need(0),
        minimize: bool = False,
        queue: Any = None,
    ) -> Compact:
        """The compact tree of the voxels, with the bytes of Compact of Edit.build. It is made without a list, and in
        Form.SHARED without a tree on the device.

        Args:
            device, depth: see Voxels.plan.
            form, leave_out, minimize, queue: see Compact.
        """
        options = _structs.new("svo_compact_options")
        options.form, options.minimize = Form(form), bool(minimize)
        options.leave_out = _arrays.integer("leave_out", leave_out)
        number = _arrays.integer("depth", depth)
        if not isinstance(device, Handle):
            raise TypeError(f"device: {type(device).__name__}, expected svocl.Device")
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_compact **")
        made = Compact.__new__(Compact)
        with device._use() as at, self._use() as pointer:
            arguments = (pointer, at, number, ffi.NULL, options, cl_queue, out)
            status = call(lib.svo_edit_commit_compact, *arguments, undo=lambda: lib.svo_compact_destroy(out))
            if status != lib.SVO_OK:
                raise error(status, device._native.device_message())
            made._adopt(out[0], device._native)
        return made

    # --- shared -----------------------------------------------------------------------------------------------------

    def _run(self, function: Any, *arguments: Any) -> None:
        with self._use() as pointer:
            self._check(function, pointer, *arguments)

    @staticmethod
    def _check(function: Any, *arguments: Any) -> None:
        message = ffi.new("svo_message *")
        status = call(function, *arguments, message)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))

    def _create(self, voxels: Any, options: Any) -> None:
        out = ffi.new("svo_edit **")
        self._check(lib.svo_edit_create, voxels, options, out)
        self._open(Native(out[0], _destroy, Guard(), None))

    def __repr__(self) -> str:
        return "<svocl.Edit: closed>" if self.closed else f"<svocl.Edit: {self.info.voxel_count} voxels>"


def _step(verb: EditVerb, shape: Shape) -> Any:
    step = _structs.new("svo_edit_step")
    step.verb = EditVerb(verb)
    if isinstance(shape, Box):
        step.shape = lib.SVO_EDIT_BOX
        step.begin = _arrays.three("low", shape.low)
        step.end = _arrays.three("high", shape.high)
    elif isinstance(shape, Sphere):
        step.shape = lib.SVO_EDIT_SPHERE
        step.begin = _arrays.three("center", shape.center)
        step.radius = float(shape.radius)
    elif isinstance(shape, Capsule):
        step.shape = lib.SVO_EDIT_CAPSULE
        step.begin = _arrays.three("begin", shape.begin)
        step.end = _arrays.three("end", shape.end)
        step.radius = float(shape.radius)
    else:
        raise TypeError(f"shape: {type(shape).__name__}, expected svocl.Box, svocl.Sphere or svocl.Capsule")
    return step


def _destroy(pointer: Any) -> None:
    lib.svo_edit_destroy(ffi.new("svo_edit **", pointer))
