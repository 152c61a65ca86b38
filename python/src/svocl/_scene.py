# SPDX-License-Identifier: MIT
"""Scenes: many placed trees that rays traverse together."""

import functools
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arrays, _generated, _opencl, _structs
from ._callbacks import call
from ._compact import Compact
from ._errors import error
from ._generated import InvalidArgumentError, Need, SceneTrace, Status, View
from ._handle import Handle, Native
from ._native import ffi, lib
from ._resident import Resident
from ._tree import Camera, Tree, address, draw, framed, render_options


class SceneLight(NamedTuple):
    """A light from one direction."""

    direction: tuple[float, float, float]
    """Towards the light, any length above 0."""
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Linear red, green, blue, not negative; 1 lights a white surface that faces it fully."""
    shadows: bool = True
    """Instances cast shadows in it."""


def make_instances(trees: npt.ArrayLike, transforms: npt.ArrayLike) -> _arrays.Array:
    """Instances for Scene from trees and matrices, which are broadcast against each other.

    Args:
        trees: (instance_count,) numbers of the scene's trees, or one for all.
        transforms: (instance_count, 3, 4) matrices, or one for all: world = transform * (x, y, z, 1), where x, y, z
            are in the tree's world coordinates.

    Returns:
        (instance_count,) records of instance_dtype.
    """
    tree, transform = _arrays.array("trees", trees), _arrays.array("transforms", transforms)
    if tree.dtype.kind not in "iu":
        raise TypeError(f"trees: dtype {tree.dtype}, expected integers")
    if tree.size and int(tree.min()) < 0:
        raise ValueError(f"trees: {int(tree.min())} is below 0")
    if transform.dtype.kind not in "fiu":
        raise TypeError(f"transforms: dtype {transform.dtype}, expected float32")
    if transform.ndim < 2 or transform.shape[-2:] != (3, 4):
        raise ValueError(f"transforms: shape {transform.shape}, expected (..., 3, 4)")
    shape = np.broadcast_shapes(tree.shape, transform.shape[:-2])
    if len(shape) > 1:
        raise ValueError(f"instances: shape {shape}, expected (instance_count,)")
    instances = np.empty(shape or (1,), _arrays.instance_dtype)
    instances["tree"] = tree
    instances["transform"] = transform
    return instances


class Scene(Handle):
    """Instances of trees, or of compact trees of one form, under one hierarchy. The scene copies what it needs of the
    trees; they may be closed.

    Args:
        trees: all of Tree, or all of Compact and one form, and on one device.
        instances: (instance_count,) records of instance_dtype, as make_instances makes them.
        need: what of the trees to copy besides their nodes: Need.COLOR and Need.NORMAL for pictures, Need.RAYS for
            triangles. Need.DEFAULT: colors and normals; Need.NONE: nothing.
        queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

    Raises:
        InvalidArgumentError: a matrix that is not finite or flat, named by its instance; trees that do not go together.
        OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
    """

    def __init__(
        self,
        trees: Union[Sequence[Tree], Sequence[Compact]],
        instances: _arrays.Array,
        *,
        need: Need = Need.DEFAULT,
        queue: Any = None,
    ) -> None:
        records = _arrays.exact_records("instances", instances, _arrays.instance_dtype, "instance_dtype")
        options = _structs.new("svo_scene_options")
        options.instances, options.instance_count = address("svo_instance *", records), records.size
        options.need = _arrays.integer("need", need)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        device = _common_device(trees)
        out = ffi.new("svo_scene **")
        with device.use("Device") as at:
            pointers = [_pointer_of(tree, device) for tree in trees]
            is_tree = isinstance(trees[0], Tree)
            handles = ffi.new("svo_tree *[]" if is_tree else "svo_compact *[]", pointers)
            setattr(options, "trees" if is_tree else "compacts", handles)
            options.tree_count = len(pointers)
            status = call(lib.svo_scene_create, at, options, cl_queue, out, undo=lambda: lib.svo_scene_destroy(out))
            if status != lib.SVO_OK:
                raise error(status, device.device_message())
            self._open(Native(out[0], _destroy, device.guard, device))

    @property
    def info(self) -> _generated.SceneInfo:
        """The scene in numbers."""
        struct = _structs.new("svo_scene_info")
        self._call(lib.svo_scene_get_info, struct)
        return _structs.read(struct, _generated.SceneInfo)

    # --- moving -----------------------------------------------------------------------------------------------------

    def set_transforms(self, transforms: npt.ArrayLike, first: int = 0, *, queue: Any = None) -> None:
        """Moves consecutive instances, refits the hierarchy's boxes, and waits. If a matrix is refused, nothing moves.

        Args:
            transforms: (count, 3, 4) float32.
            first: the first instance.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.
        """
        array = _arrays.floats("transforms", transforms, ("count", 3, 4))
        number = _arrays.integer("first", first)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        floats = ffi.cast("float *", array.ctypes.data)
        self._call(lib.svo_scene_set_transforms, number, _arrays.integer("count", len(array)), floats, cl_queue)

    def rebuild(self, *, queue: Any = None) -> None:
        """Builds the hierarchy anew from where the instances are now, and waits: rays are faster then after instances
        moved far. Their hits are the same.

        Args:
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.
        """
        self._call(lib.svo_scene_rebuild, _opencl.pointer("cl_command_queue", queue, "queue"))

    # --- rays -------------------------------------------------------------------------------------------------------

    def trace(
        self,
        rays: _arrays.Array,
        *,
        footprint: float = 0.0,
        mode: SceneTrace = SceneTrace.CLOSEST,
        out: Optional[_arrays.Array] = None,
        queue: Any = None,
    ) -> _arrays.Array:
        """Traces rays against the voxels of the scene and waits.

        Args:
            rays: as Tree.trace.
            footprint: see Tree.trace_voxels.
            mode: what is asked for.
            out: (...) records of scene_hit_dtype, C-contiguous; receives the result.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (...) records of scene_hit_dtype, in the order of the rays.
        """
        flags = [footprint, SceneTrace(mode)]
        return self._trace(lib.svo_trace_voxels, rays, out, _arrays.scene_hit_dtype, flags, queue)

    def trace_triangles(
        self,
        rays: _arrays.Array,
        *,
        mode: SceneTrace = SceneTrace.CLOSEST,
        out: Optional[_arrays.Array] = None,
        queue: Any = None,
    ) -> _arrays.Array:
        """Traces rays against the triangles of the scene and waits. The scene needs Need.RAYS.

        Args:
            rays, mode, queue: see Scene.trace.
            out: (...) records of scene_triangle_hit_dtype, C-contiguous; receives the result.

        Returns:
            (...) records of scene_triangle_hit_dtype, in the order of the rays.
        """
        dtype = _arrays.scene_triangle_hit_dtype
        return self._trace(lib.svo_trace_triangles, rays, out, dtype, [SceneTrace(mode)], queue)

    def trace_enqueue(
        self,
        rays: Any,
        hits: Any,
        ray_count: int,
        queue: Any,
        *,
        footprint: float = 0.0,
        mode: SceneTrace = SceneTrace.CLOSEST,
        wait_for: Iterable[Any] = (),
    ) -> _opencl.Event:
        """Scene.trace for device buffers; does not wait.

        Args:
            rays: a pyopencl.Buffer of ray_count records of ray_dtype, or its int_ptr.
            hits: a pyopencl.Buffer that receives ray_count records of scene_hit_dtype, or its int_ptr.
            ray_count, queue, wait_for: see Tree.trace_enqueue.
            footprint, mode: see Scene.trace.

        Returns:
            As Tree.trace_enqueue.
        """
        run = functools.partial(self._call, _opencl.of_target(lib.svo_scene_target, lib.svo_trace_voxels))
        flags = (footprint, SceneTrace(mode))
        return _opencl.enqueue(run, (rays, hits), ray_count, flags, queue, wait_for)

    # --- pictures ---------------------------------------------------------------------------------------------------

    def frame(self, aspect: float = 1.0, camera: Optional[Camera] = None) -> Camera:
        """A camera that frames all instances, from where Tree.frame looks or another camera does.

        Args:
            aspect: width / height of the picture, above 0.
            camera: one whose direction of sight, up and angle stay; None: as Tree.frame.

        Raises:
            InvalidArgumentError: the camera has no frame: its up is along its line of sight.
        """
        with self._use() as pointer:
            return framed(lib.svo_scene_target(pointer), aspect, camera)

    def render(
        self,
        width: int,
        height: int,
        *,
        camera: Optional[Camera] = None,
        lights: Sequence[SceneLight] = (),
        occlusion_range: float = 0.0,
        queue: Any = None,
    ) -> npt.NDArray[np.uint8]:
        """Draws a picture of the scene and waits: voxels by color and normal, Lambert shading, shadows, the light of
        the sky.

        Args:
            width, height: pixels, 1 .. 16384.
            camera: None: Scene.frame.
            lights: at most 8; none: the light of Tree.render.
            occlusion_range: within which neighbors darken a surface, world units; 0: a fraction of an instance's mean
                width.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (height, width, 4) uint8: RGBA, top to bottom.
        """
        used = self.frame(width / max(height, 1)) if camera is None else camera
        options, picture = render_options(width, height, used, View.SHADED)
        given = ffi.new("svo_scene_light[]", [_light(light) for light in lights])
        options.lights, options.light_count = given if lights else ffi.NULL, len(lights)
        options.occlusion_range = occlusion_range
        return draw(self._call, lib.svo_scene_target, options, picture, queue)

    # --- shared -----------------------------------------------------------------------------------------------------

    def _trace(
        self,
        function: Any,
        rays: _arrays.Array,
        out: Optional[_arrays.Array],
        dtype: "np.dtype[Any]",
        flags: list[Any],
        queue: Any,
    ) -> _arrays.Array:
        records = _arrays.records("rays", rays, _arrays.ray_dtype)
        hits = _arrays.output("out", out, dtype, records.shape)
        run = functools.partial(self._call, _opencl.of_target(lib.svo_scene_target, function))
        _opencl.wait(run, (records, hits), flags, queue)
        return hits

    def __repr__(self) -> str:
        if self.closed:
            return "<svocl.Scene: closed>"
        info = self.info
        return f"<svocl.Scene: {info.instance_count} instances of {info.tree_count} trees>"


def _common_device(trees: Sequence[Resident]) -> Native:
    """The handle of the first tree's device."""
    if len(trees) == 0:
        raise ValueError("trees: none")
    kind = Tree if isinstance(trees[0], Tree) else Compact
    for tree in trees:
        if not isinstance(tree, kind):
            raise TypeError(f"trees: {type(tree).__name__}, expected svocl.{kind.__name__} as the others")
    device = trees[0]._native.parent
    if device is None:
        raise InvalidArgumentError("Scene: trees[0] is on no device; upload it first", Status.INVALID_ARGUMENT)
    return device


def _pointer_of(tree: Resident, device: Native) -> Any:
    """A tree's pointer, under the guard of the device."""
    if tree.closed:
        raise ValueError(f"{type(tree).__name__} is closed")
    if tree._native.parent is not device:
        raise InvalidArgumentError("Scene: the trees are not all on one device", Status.INVALID_ARGUMENT)
    return tree._native._pointer[0]


def _light(light: SceneLight) -> dict[str, Any]:
    return {
        "direction": _arrays.three("light.direction", light.direction),
        "color": _arrays.three("light.color", light.color),
        "shadows": bool(light.shadows),
    }


def _destroy(pointer: Any) -> None:
    lib.svo_scene_destroy(ffi.new("svo_scene **", pointer))
