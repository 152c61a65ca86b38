# SPDX-License-Identifier: MIT
"""Scenes that move: one tree of a static mesh and of objects that move through it."""

import functools
import weakref
from collections.abc import Iterable, Sequence
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _arrays, _generated, _opencl, _structs
from ._callbacks import call
from ._device import Device
from ._errors import error
from ._generated import BvhQuality, Coverage, Need, Weights
from ._handle import Handle, Native
from ._mesh import Mesh, mesh_of, read_struct
from ._native import ffi, lib
from ._tree import Tree, address


class Moving(Handle):
    """A static mesh and objects that move, in one tree. An update voxelizes the objects that changed alone. The tree
    is, byte for byte, that of a full build of Moving.mesh() with the same grid, need, coverage and weights, and the
    weight_log2 of Moving.info.

    What only moves rigidly, and needs no common tree, is better off as instances of a Scene.

    Args:
        device: of the tree.
        mesh: the static mesh, see Device.plan. Objects have the arrays of vertices that it has, and its materials and
            textures.
        depth: 1 .. 16: the grid has 2**depth voxels per axis.
        origin: minimum corner of the grid. What leaves the grid occupies nothing and is counted.
        edge: width of the grid, above 0.
        need: what the tree holds; Need.DEFAULT goes by the static mesh. For Need.PROJECTED_AREA each update finds
            whether the scene's mesh is closed.
        coverage, weights, payload_level: see Device.plan.
        max_area: the largest area that the scene will have inside the grid, square world units; 0: four times that of
            the static mesh.
        fragment_capacity: most (voxel, triangle) pairs of the scene; 0: as many as memory holds.
        weight_log2: see Device.plan; takes the place of max_area.
        drop_alpha: see Device.plan.
        queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

    Raises:
        InvalidArgumentError: a depth or option out of range.
        UnsupportedError: a device without doubles.
        CapacityExceededError, OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
    """

    def __init__(
        self,
        device: Device,
        mesh: Any,
        depth: int,
        *,
        origin: Sequence[float],
        edge: float,
        need: Need = Need.DEFAULT,
        coverage: Coverage = Coverage.HALF_OPEN,
        weights: Weights = Weights.AREA,
        payload_level: int = 0,
        max_area: float = 0.0,
        fragment_capacity: int = 0,
        weight_log2: int = 0,
        drop_alpha: float = 0.0,
        queue: Any = None,
    ) -> None:
        struct, kept = mesh_of(mesh)._struct()
        options = _structs.new("svo_moving_options")
        options.origin, options.edge = _arrays.three("origin", origin), edge
        options.need = _arrays.integer("need", need)
        options.coverage, options.weights = Coverage(coverage), Weights(weights)
        options.payload_level = _arrays.integer("payload_level", payload_level)
        options.max_area = max_area
        options.drop_alpha = drop_alpha
        options.fragment_capacity = _arrays.integer("fragment_capacity", fragment_capacity, 64)
        options.weight_log2 = _arrays.integer("weight_log2", weight_log2)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_moving **")
        arguments = (struct, _arrays.integer("depth", depth), options, cl_queue, out)
        self._trees: "weakref.WeakSet[Native]" = weakref.WeakSet()
        with device._use() as pointer:
            status = call(lib.svo_moving_create, pointer, *arguments, undo=lambda: lib.svo_moving_destroy(out))
            if status != lib.SVO_OK:
                raise error(status, device._native.device_message())
            # The library reads the static mesh's materials and textures as long as the scene lives.
            destroy = functools.partial(_destroy, kept)
            self._open(Native(out[0], destroy, device._native.guard, device._native, stays=False))

    # --- objects ----------------------------------------------------------------------------------------------------

    def add(self, mesh: Any, transform: Optional[npt.ArrayLike] = None) -> int:
        """Adds an object, which is visible. The tree changes with the next update.

        Args:
            mesh: with the arrays of vertices that the static mesh has; it is copied. Its materials and textures are
                not read: triangle_materials are those of the static mesh.
            transform: (3, 4) or (4, 4) matrix from the mesh to the world, rows first; None: the mesh is in the world.

        Returns:
            The object's number: the least that is free.

        Raises:
            InvalidArgumentError: a matrix that is not finite or flat, or a mesh with other arrays.
            OutOfDeviceMemoryError, OutOfHostMemoryError
        """
        struct, kept = mesh_of(mesh)._struct()
        matrix = ffi.NULL if transform is None else _matrix(transform)
        number = ffi.new("uint32_t *")
        self._call(lib.svo_moving_add, struct, matrix, number)
        del kept
        return int(number[0])

    def set_transform(self, number: int, transform: npt.ArrayLike) -> None:
        """Moves an object. The tree changes with the next update.

        Args:
            number: of the object.
            transform: (3, 4) or (4, 4) matrix from its mesh to the world, rows first.

        Raises:
            InvalidArgumentError: a matrix that is not finite or flat; nothing moves then.
        """
        self._call(lib.svo_moving_set_transform, _arrays.integer("number", number), _matrix(transform))

    def set_vertices(self, number: int, mesh: Any) -> None:
        """Replaces an object's vertices, to which its transform applies. The tree changes with the next update.

        Args:
            number: of the object.
            mesh: positions and normals as the object's mesh has them, and its counts; other arrays are not read.
        """
        struct, kept = mesh_of(mesh)._struct()
        self._call(lib.svo_moving_set_vertices, _arrays.integer("number", number), struct)
        del kept

    def show(self, number: int, visible: bool = True) -> None:
        """Shows or hides an object. The tree changes with the next update.

        Args:
            number: of the object.
            visible: it is part of the scene.
        """
        self._call(lib.svo_moving_show, _arrays.integer("number", number), bool(visible))

    def remove(self, number: int) -> None:
        """Removes an object; one that is added later may get its number. The tree changes with the next update.

        Args:
            number: of the object.
        """
        self._call(lib.svo_moving_remove, _arrays.integer("number", number))

    # --- updates ----------------------------------------------------------------------------------------------------

    def update(self, *, queue: Any = None, report: bool = False) -> Optional[_generated.MovingReport]:
        """Makes the tree of the scene as it is now, and waits. After a failure the tree before stays.

        Args:
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr, which is waited for between the
                stages; None: the device's own.
            report: measure the stages, which waits after each.

        Returns:
            What was done, with report; else None.

        Raises:
            CapacityExceededError: more pairs than fragment_capacity, or more area than max_area.
            OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
        """
        out = _structs.new("svo_moving_report") if report or queue is not None else ffi.NULL
        submit = _opencl.submit_to(queue) if queue is not None else ffi.NULL
        self._take(lib.svo_moving_update, submit, out)
        return _structs.read(out, _generated.MovingReport) if report else None

    def update_enqueue(self, queue: Any, *, wait_for: Iterable[Any] = ()) -> _opencl.Event:
        """Moving.update, but does not wait. Until Moving.finish the tree is the one before, and calls that change the
        scene are refused.

        Args:
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr.
            wait_for: pyopencl.Events to wait for, or their int_ptrs.

        Returns:
            The event of the update, which releases itself.
        """
        return _opencl.submit(lambda submit: self._call(lib.svo_moving_update, submit, ffi.NULL), (), queue, wait_for)

    def finish(self) -> _generated.MovingReport:
        """Waits for the update in flight, and takes its tree. After a failure the tree before stays.

        Returns:
            As Moving.update with report, without the times of stages; total_ms is the time since Moving.update_enqueue.

        Raises:
            CapacityExceededError: an object has more pairs than there was room for; the next update has room. Or as
                Moving.update.
            InvalidArgumentError: no update is in flight.
            OutOfDeviceMemoryError, CLError
        """
        out = _structs.new("svo_moving_report")
        self._take(lib.svo_moving_finish, out)
        return _structs.read(out, _generated.MovingReport)

    def make_bvh(
        self, *, quality: BvhQuality = BvhQuality.BEST, cost_ratio: float = 0.0, queue: Any = None
    ) -> _generated.MovingBvhReport:
        """Makes the BVH of the newest tree from those of its objects, which are kept, refit or made anew, and waits.
        Call it after an update, before rays; without it the first rays make a BVH of the whole mesh. Hits are the same.

        Args:
            quality: of objects' BVHs that are made.
            cost_ratio: a refit BVH is made anew when a random ray has so many times the work that it had when the BVH
                was made; 0: 1.5. Below 1: whatever has changed is made anew.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Raises:
            InvalidArgumentError: the scene lacks Need.RAYS.
            OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
        """
        report = _structs.new("svo_moving_bvh_report")
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        self._call(lib.svo_moving_make_bvh, BvhQuality(quality), cost_ratio, cl_queue, report)
        return _structs.read(report, _generated.MovingBvhReport)

    # --- what there is ----------------------------------------------------------------------------------------------

    @property
    def tree(self) -> Tree:
        """The tree of the newest update. The next update that succeeds ends it: it is closed then. Its arrays are
        copies, so they stay."""
        with self._use() as pointer:
            lent = self._native.lend(lib.svo_moving_tree(pointer))
            self._trees.add(lent)
            return Tree._of(lent)

    @property
    def changes(self) -> npt.NDArray[np.float64]:
        """(count, 2, 3): least and greatest corners, in world coordinates, of where the newest update changed the tree:
        the bounds of each object that changed, before it and after it. For Light.update."""
        count = ffi.new("size_t *")
        with self._use() as pointer:
            lib.svo_moving_get_changes(pointer, ffi.NULL, 0, count)
            boxes = np.empty((count[0], 2, 3), np.float64)
            lib.svo_moving_get_changes(pointer, address("svo_box *", boxes), len(boxes), count)
        return boxes

    def mesh(self) -> Mesh:
        """The scene's mesh as it will be after the next update, a copy: the static mesh, then the visible objects in
        the order of their numbers, in the world."""
        struct = _structs.new("svo_mesh")
        with self._called(lib.svo_moving_get_mesh, struct):
            return read_struct(self._native, struct)

    @property
    def info(self) -> _generated.MovingInfo:
        """The scene after its newest update."""
        struct = _structs.new("svo_moving_info")
        self._call(lib.svo_moving_get_info, struct)
        return _structs.read(struct, _generated.MovingInfo)

    def object_info(self, number: int) -> _generated.MovingObject:
        """An object after the newest update.

        Args:
            number: of the object.
        """
        struct = _structs.new("svo_moving_object")
        self._call(lib.svo_moving_get_object, _arrays.integer("number", number), struct)
        return _structs.read(struct, _generated.MovingObject)

    # --- shared -----------------------------------------------------------------------------------------------------

    def _take(self, function: Any, *arguments: Any) -> None:
        """Calls a function that replaces the tree, and ends the Trees that stood for the one before."""
        with self._called(function, *arguments):
            for lent in self._trees:
                lent.end()
            self._trees.clear()

    def __repr__(self) -> str:
        if self.closed:
            return "<svocl.Moving: closed>"
        info = self.info
        return f"<svocl.Moving: {info.object_count} objects, {info.fragments} fragments>"


def _matrix(transform: npt.ArrayLike) -> Any:
    """The 12 numbers of a matrix, in C."""
    array = _arrays.array("transform", transform)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"transform: dtype {array.dtype}, expected float64")
    if array.shape not in ((3, 4), (4, 4)):
        raise ValueError(f"transform: shape {array.shape}, expected (3, 4) or (4, 4)")
    if not np.array_equal(array[3:], np.eye(4)[3 : len(array)]):
        raise ValueError(f"transform: the last row is {array[3].tolist()}, expected [0, 0, 0, 1]")
    return _arrays.pointer(np.ascontiguousarray(array[:3], np.float64), "double")


def _destroy(_kept: list[Any], pointer: Any) -> None:
    lib.svo_moving_destroy(ffi.new("svo_moving **", pointer))
