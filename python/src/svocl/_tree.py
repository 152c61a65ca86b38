# SPDX-License-Identifier: MIT
"""Trees: the octree's arrays, its hash, files, pictures, rays and nearest points."""

import functools
from collections.abc import Iterable
from typing import Any, Callable, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arrays, _generated, _grid, _opencl, _page, _structs
from ._callbacks import call
from ._errors import error, text
from ._generated import BvhQuality, TraceMode, TreeBuffer, View
from ._handle import Guard, Native, view
from ._mesh import Path, from_bytes, from_path, need_io
from ._native import ffi, lib
from ._resident import Resident


class TreeArrays(NamedTuple):
    """A tree's arrays on the host, read-only and without a copy; None where the tree does not hold them.

    Nodes are stored breadth-first, in Morton order within each level. The child of inner node i in octant
    o = x | y << 1 | z << 2 exists if bit o of child_mask[i] is set; it is node first_child[i] plus the number of lower
    bits set. payload_count is node_count - level_begin[payload_level].
    """

    child_mask: npt.NDArray[np.uint8]
    """(inner_count,)"""
    first_child: npt.NDArray[np.uint32]
    """(inner_count,): into all nodes."""
    colors: Optional[npt.NDArray[np.uint8]]
    """(payload_count, 4): RGBA."""
    normals: Optional[npt.NDArray[np.int16]]
    """(payload_count, 3): mean normal, 32767 = 1; its length is at most 1."""
    list_begin: Optional[npt.NDArray[np.uint32]]
    """(leaf_count + 1,): leaf k has list[list_begin[k]:list_begin[k + 1]]."""
    list: Optional[npt.NDArray[np.uint32]]
    """(list_count,): into triangle_ids."""
    vertices: Optional[npt.NDArray[np.int32]]
    """(vertex_count, 3): rounded to grid units."""
    indices: Optional[npt.NDArray[np.uint32]]
    """(list_triangle_count, 3): into vertices."""
    triangle_ids: Optional[npt.NDArray[np.uint32]]
    """(list_triangle_count,): rows of the mesh's indices."""
    materials: Optional[npt.NDArray[np.uint16]]
    """(payload_count,): into the mesh's materials."""
    fills: Optional[npt.NDArray[np.uint16]]
    """(payload_count,): surface area inside, 4096 = a face of the node; 65535 = that or more."""
    areas: Optional[npt.NDArray[np.uint16]]
    """(leaf_count, 6): the surface that rays along +x, -x, +y, -y, +z and -z see in a leaf, 4096 = a face of it."""
    positions: Optional[npt.NDArray[np.float32]]
    """(vertex_count, 3): the mesh's own vertices, which rays meet; 0 where no triangle has them."""
    positions_double: Optional[npt.NDArray[np.float64]]
    """The same of a mesh that was given in float64."""


class Camera(NamedTuple):
    """A pinhole camera in world coordinates."""

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    """A point in the middle of the picture."""
    up: tuple[float, float, float]
    """Not parallel to target - eye."""
    vertical_fov: float
    """Radians, above 0 and below pi."""


def make_rays(
    origins: npt.ArrayLike, directions: npt.ArrayLike, t_min: npt.ArrayLike = 0.0, t_max: npt.ArrayLike = np.inf
) -> _arrays.Array:
    """Rays for Tree.trace from origins and directions, which are broadcast against each other.

    Args:
        origins: (..., 3) world coordinates.
        directions: (..., 3) of any length above 0.
        t_min, t_max: (...) or numbers: the part of the ray that counts, in lengths of its direction.

    Returns:
        (...) records of ray_dtype.
    """
    names = ("origins", "directions", "t_min", "t_max")
    parts = [_arrays.array(*given) for given in zip(names, (origins, directions, t_min, t_max))]
    for name, part in zip(names, parts):
        if part.dtype.kind not in "fiu":
            raise TypeError(f"{name}: dtype {part.dtype}, expected float32")
    for name, part in zip(("origins", "directions"), parts):
        if part.ndim < 1 or part.shape[-1] != 3:
            raise ValueError(f"{name}: shape {part.shape}, expected (..., 3)")
    shape = np.broadcast_shapes(parts[0].shape[:-1], parts[1].shape[:-1], parts[2].shape, parts[3].shape)
    rays = np.empty(shape, _arrays.ray_dtype)
    for name, part in zip(rays.dtype.names or (), parts):
        rays[name] = part
    return rays


class Tree(Resident):
    """A sparse voxel octree: on a device after Plan.build, on the host after Tree.load or Tree.download, or both."""

    _prefix = "svo_tree"
    _noun = "tree"

    report: Optional[_generated.BuildReport]
    """What the build did; None for a tree from a file or of Moving."""

    def __init__(self, pointer: Any, device: Optional[Native], report: Optional[_generated.BuildReport]) -> None:
        guard = Guard() if device is None else device.guard
        self._open(Native(pointer, _destroy_tree, guard, device))
        self.report = report

    @staticmethod
    def _of(native: Native) -> "Tree":
        """Of a handle that is another's (Native.lend). Under the guard."""
        tree = Tree.__new__(Tree)
        tree._open(native)
        tree.report = None
        return tree

    # --- files ------------------------------------------------------------------------------------------------------

    @staticmethod
    def load(path: Path, *, levels: int = 0) -> "Tree":
        """Reads a .svo file. Lengths, checksums and every index are checked. For rays and pictures, upload it then.

        Args:
            levels: 1 to the file's depth: levels 0 to this one alone, a tree of that depth with its payload and without
                triangles. 0: all.

        Raises:
            FileError: the file cannot be read.
            FileDamagedError: it is truncated, damaged or of another format.
        """
        need_io("Tree.load")
        source, _kept = from_path(path)
        return _loaded(source, levels)

    @staticmethod
    def load_bytes(content: Union[bytes, bytearray, memoryview], name: str = "bytes", *, levels: int = 0) -> "Tree":
        """Tree.load from memory.

        Args:
            content: of a .svo file.
            name: stands for the path in messages.
            levels: see Tree.load.
        """
        need_io("Tree.load_bytes")
        source, _kept = from_bytes(content, name)
        return _loaded(source, levels)

    # --- what it holds ----------------------------------------------------------------------------------------------

    @property
    def info(self) -> _generated.TreeInfo:
        """What describes the tree besides its arrays."""
        struct = _structs.new("svo_tree_info")
        self._call(lib.svo_tree_get_info, struct)
        return _structs.read_tree_info(struct)

    def download(self, *, queue: Any = None) -> TreeArrays:
        """The tree's arrays. The first call copies them from the device and waits; later ones copy nothing. The arrays
        stay valid when the tree is closed.

        Args:
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.
        """
        struct = _structs.new("svo_tree_arrays")
        info = self.info
        payload = info.node_count - info.level_begin[info.payload_level]
        shapes = {
            "child_mask": (np.uint8, (info.inner_count,)),
            "first_child": (np.uint32, (info.inner_count,)),
            "colors": (np.uint8, (payload, 4)),
            "normals": (np.int16, (payload, 3)),
            "list_begin": (np.uint32, (info.leaf_count + 1,)),
            "list": (np.uint32, (info.list_count,)),
            "vertices": (np.int32, (info.vertex_count, 3)),
            "indices": (np.uint32, (info.list_triangle_count, 3)),
            "triangle_ids": (np.uint32, (info.list_triangle_count,)),
            "materials": (np.uint16, (payload,)),
            "fills": (np.uint16, (payload,)),
            "areas": (np.uint16, (info.leaf_count, 6)),
            "positions": (np.float32, (info.vertex_count, 3)),
            "positions_double": (np.float64, (info.vertex_count, 3)),
        }
        with self._downloaded(queue) as pointer:
            status = call(lib.svo_tree_get_arrays, pointer, struct)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
            arrays: Any = {name: view(self._native, getattr(struct, name), *kind) for name, kind in shapes.items()}
            return TreeArrays(**arrays)

    @property
    def arrays(self) -> TreeArrays:
        """download() on the device's own queue."""
        return self.download()

    def voxels(self, level: Optional[int] = None) -> npt.NDArray[np.uint32]:
        """The integer coordinates of a level's nodes, in the order of the nodes.

        Args:
            level: 0 .. depth; None: depth, the leaves.

        Returns:
            (nodes of the level, 3): x, y, z in 0 .. 2**level - 1.
        """
        info = self.info
        last = info.depth if level is None else level
        if not 0 <= last <= info.depth:
            raise ValueError(f"level: {last} is not in 0 .. {info.depth}")
        masks = self.arrays.child_mask
        octants = np.arange(8, dtype=np.uint32)
        corners = np.stack([octants & 1, octants >> 1 & 1, octants >> 2 & 1], axis=1)
        # The empty tree has a root and nothing below.
        nodes = np.zeros((1, 3), np.uint32)
        for above in range(last):
            mask = masks[info.level_begin[above] : info.level_begin[above + 1]]
            parent, octant = np.nonzero((mask[:, None] >> octants) & 1)
            nodes = nodes[parent] * np.uint32(2) + corners[octant]
        return nodes

    def centers(self, level: Optional[int] = None) -> npt.NDArray[np.float64]:
        """The world coordinates of the centers of a level's nodes.

        Args:
            level: 0 .. depth; None: depth, the leaves.

        Returns:
            (nodes of the level, 3). Nodes are edge / 2**level wide.
        """
        info = self.info
        width = info.edge / 2 ** (info.depth if level is None else level)
        centers: npt.NDArray[np.float64] = (self.voxels(level) + 0.5) * width + np.array(info.origin)
        return centers

    def hash(self, *, nodes_only: bool = False) -> str:
        """32 hexadecimal digits, the same on every device, downloading the tree first if need be.

        Args:
            nodes_only: leave leaf lists and payload out.
        """
        digits = ffi.new("char[]", lib.SVO_HASH_TEXT_BYTES)
        scope = lib.SVO_HASH_NODES if nodes_only else lib.SVO_HASH_ALL
        with self._downloaded(None) as pointer:
            status = call(lib.svo_tree_hash, pointer, scope, digits)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
        return text(digits)

    # --- the device -------------------------------------------------------------------------------------------------

    def buffer_int_ptr(self, buffer: TreeBuffer) -> Optional[int]:
        """The cl_mem of one array: pyopencl.Buffer.from_int_ptr(...) retains it. Elements are those of TreeArrays, but
        payload that is constant (TreeInfo.constant) has one element.

        Returns:
            None where the tree does not hold the array or is on no device.
        """
        with self._use() as pointer:
            memory = lib.svo_tree_get_buffer(pointer, TreeBuffer(buffer))
            return None if memory == ffi.NULL else int(ffi.cast("uintptr_t", memory))

    def set_kernel_args(self, kernel: Any, first_index: int) -> None:
        """Sets the arguments that SVO_TREE_PARAMETERS declares (kernel_source) in a kernel of the caller's. Launch it
        with pyopencl.enqueue_nd_range_kernel; the tree must not be closed before it ends.

        Args:
            kernel: a pyopencl.Kernel, or its int_ptr.
            first_index: of TREE_ARGUMENTS consecutive arguments.
        """
        cl_kernel = _opencl.pointer("cl_kernel", kernel, "kernel")
        function = self._of_target(lib.svo_kernel_set_arguments)
        self._device_call("set_kernel_args", function, cl_kernel, _arrays.integer("first_index", first_index))

    # --- rays -------------------------------------------------------------------------------------------------------

    def prepare_rays(self, *, quality: BvhQuality = BvhQuality.BEST, queue: Any = None) -> None:
        """Makes the BVH for rays now, rather than with the first batch. One of the other quality is replaced."""
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        self._device_call("prepare_rays", lib.svo_tree_make_bvh, BvhQuality(quality), cl_queue)

    def trace(
        self,
        rays: _arrays.Array,
        *,
        mode: TraceMode = TraceMode.CLOSEST,
        out: Optional[_arrays.Array] = None,
        queue: Any = None,
    ) -> _arrays.Array:
        """Traces rays against the mesh's triangles and waits. The tree needs Need.RAYS, and coverage half-open or
        closed.

        Args:
            rays: (...) records of ray_dtype, as make_rays makes them, or (..., 8) float32 in the same order. Used
                without a copy if C-contiguous.
            mode: what is asked for.
            out: (...) records of hit_dtype, C-contiguous; receives the result.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (...) records of hit_dtype, in the order of the rays.
        """
        records = _arrays.records("rays", rays, _arrays.ray_dtype)
        hits = _arrays.output("out", out, _arrays.hit_dtype, records.shape)
        function = self._of_target(lib.svo_trace_triangles)
        self._wait("trace", function, (records, hits), [TraceMode(mode)], queue)
        return hits

    def trace_voxels(
        self,
        rays: _arrays.Array,
        *,
        footprint: float = 0.0,
        out: Optional[_arrays.Array] = None,
        queue: Any = None,
    ) -> _arrays.Array:
        """Traces rays against the tree's voxels and waits. Any tree will do.

        Args:
            rays: as Tree.trace.
            footprint: the width of a pixel's cone per unit of distance; nodes smaller than that are taken for leaves.
                0: leaves alone.
            out: (...) records of voxel_hit_dtype, C-contiguous; receives the result.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (...) records of voxel_hit_dtype, in the order of the rays.
        """
        return trace_voxels(self, rays, footprint, out, queue)

    def nearest(
        self,
        points: npt.ArrayLike,
        *,
        max_distance: npt.ArrayLike = np.inf,
        out: Optional[_arrays.Array] = None,
        queue: Any = None,
    ) -> _arrays.Array:
        """Finds the nearest triangle to each point and waits. The tree needs what Tree.trace needs.

        Args:
            points: (..., 3) float32 or float64 world coordinates; or records of query_dtype, used without a copy if
                C-contiguous, which have their own max_distance.
            max_distance: (...) or a number: triangles farther away are ignored, world units.
            out: (...) records of nearest_dtype, C-contiguous; receives the result.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (...) records of nearest_dtype, in the order of the points.
        """
        if isinstance(points, np.ndarray) and points.dtype == _arrays.query_dtype:
            records = _arrays.records("points", points, _arrays.query_dtype)
        else:
            array = _arrays.array("points", points)
            if array.dtype.kind not in "fiu":
                raise TypeError(f"points: dtype {array.dtype}, expected float32, float64 or svocl.query_dtype")
            if array.ndim < 1 or array.shape[-1] != 3:
                raise ValueError(f"points: shape {array.shape}, expected (..., 3)")
            records = np.empty(array.shape[:-1], _arrays.query_dtype)
            records["position"] = array
            records["max_distance"] = max_distance
        found = _arrays.output("out", out, _arrays.nearest_dtype, records.shape)
        self._wait("nearest", lib.svo_tree_nearest, (records, found), [], queue)
        return found

    def trace_enqueue(
        self,
        rays: Any,
        hits: Any,
        ray_count: int,
        queue: Any,
        *,
        mode: TraceMode = TraceMode.CLOSEST,
        wait_for: Iterable[Any] = (),
    ) -> _opencl.Event:
        """Tree.trace for device buffers; does not wait. Allocates nothing on the device after the first call.

        Args:
            rays: a pyopencl.Buffer of ray_count records of ray_dtype, or its int_ptr.
            hits: a pyopencl.Buffer that receives ray_count records of hit_dtype, or its int_ptr.
            ray_count: at most 2**31 - 1.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr.
            mode: what is asked for.
            wait_for: pyopencl.Events to wait for, or their int_ptrs.

        Returns:
            The event of the batch, which releases itself.
        """
        function = self._of_target(lib.svo_trace_triangles)
        return self._enqueue("trace_enqueue", function, (rays, hits), ray_count, [TraceMode(mode)], queue, wait_for)

    def nearest_enqueue(
        self, points: Any, results: Any, point_count: int, queue: Any, *, wait_for: Iterable[Any] = ()
    ) -> _opencl.Event:
        """Tree.nearest for device buffers; does not wait.

        Args:
            points: a pyopencl.Buffer of point_count records of query_dtype, or its int_ptr.
            results: a pyopencl.Buffer that receives point_count records of nearest_dtype, or its int_ptr.
            point_count, queue, wait_for: see Tree.trace_enqueue.

        Returns:
            As Tree.trace_enqueue.
        """
        buffers = (points, results)
        return self._enqueue("nearest_enqueue", lib.svo_tree_nearest, buffers, point_count, [], queue, wait_for)

    # --- pictures ---------------------------------------------------------------------------------------------------

    def frame(self, aspect: float = 1.0, camera: Optional[Camera] = None) -> Camera:
        """A camera that frames the occupied part of the tree from the front, a little from the right and from above, or
        from where another camera looks.

        Args:
            aspect: width / height of the picture, above 0.
            camera: one whose direction of sight, up and angle stay; None: from the front.

        Raises:
            InvalidArgumentError: the camera has no frame: its up is along its line of sight.
        """
        with self._downloaded(None) as pointer:
            return framed(lib.svo_tree_target(pointer), aspect, camera)

    def render(
        self,
        width: int,
        height: int,
        *,
        camera: Optional[Camera] = None,
        view: View = View.SHADED,
        queue: Any = None,
    ) -> npt.NDArray[np.uint8]:
        """Draws a picture of the tree's voxels and waits.

        Args:
            width, height: pixels, 1 .. 16384.
            camera: None: Tree.frame.
            view: what to show: View.SHADED, NORMAL, DEPTH, STEPS, LEVEL or TRIANGLES, which needs Need.RAYS.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (height, width, 4) uint8: RGBA, top to bottom.
        """
        used = self.frame(width / max(height, 1)) if camera is None else camera
        options, picture = render_options(width, height, used, view)
        return draw(functools.partial(self._device_call, "render"), lib.svo_tree_target, options, picture, queue)

    # --- elsewhere --------------------------------------------------------------------------------------------------

    def to_html(self, *, name: str = "tree", max_bytes: int = 1 << 25) -> str:
        """The page of `svocl export-web`: it shows the tree in a browser, with colors and normals as far as the tree
        has them, from a file that needs nothing else. docs/web.md describes it. The tree need not be on a device.

        Args:
            name: the page's heading.
            max_bytes: of the page. Of a larger tree it has the upper levels, down to the deepest that fits, and says
                so.

        Raises:
            ValueError: not even the first level fits.
        """
        return _page.page(self, name, _arrays.integer("max_bytes", max_bytes, 64))[0]

    def to_pyvista(self, level: Optional[int] = None) -> Any:
        """The voxels as a pyvista.UnstructuredGrid: a cube for each, in world coordinates and in the order of
        Tree.voxels, which share their corners. cell_data has "rgba" (uint8), "normal" (float32, mean) and "material"
        where the tree has them: tree.to_pyvista().plot(scalars="rgba", rgb=True).

        Args:
            level: 0 .. depth; None: depth, the leaves. Levels above payload_level have no cell_data.

        Raises:
            ImportError: pyvista is not installed.
        """
        return _grid.to_pyvista(self, level)

    def _repr_html_(self) -> Optional[str]:
        """For notebooks: the page, of at most 4 MiB."""
        return None if self.closed else _page.inline(self)

    def _repr_png_(self) -> Optional[bytes]:
        """For notebooks that show no page; None of a tree on no device."""
        return None if self.closed or not self.on_device else _page.png(self.render(640, 480))

    def __repr__(self) -> str:
        if self.closed:
            return "<svocl.Tree: closed>"
        info = self.info
        return f"<svocl.Tree: depth {info.depth}, {info.node_count} nodes, {info.leaf_count} leaves>"


def framed(target: Any, aspect: float, start: Optional[Camera] = None) -> Camera:
    """The camera that the library moves to where it frames a target, under the guard."""
    camera = ffi.new("svo_camera *")
    if start is not None:
        write_camera(camera, start)
    status = call(lib.svo_camera_fit, target, aspect, camera)
    if status != lib.SVO_OK:
        raise error(status, f"{start} has no frame: its up is along its line of sight, or a number is not finite")
    return Camera(tuple(camera.eye), tuple(camera.target), tuple(camera.up), camera.vertical_fov)


def write_camera(struct: Any, camera: Camera) -> None:
    for name in ("eye", "target", "up"):
        setattr(struct, name, _arrays.three(f"camera.{name}", getattr(camera, name)))
    struct.vertical_fov = camera.vertical_fov


def new_picture(width: int, height: int) -> npt.NDArray[np.uint8]:
    """The library checks the size before it writes; an array of a refused size is not made."""
    fits = 0 < width <= 16384 and 0 < height <= 16384
    return np.empty((height, width, 4) if fits else (1, 1, 4), np.uint8)


def render_options(width: int, height: int, camera: Camera, view: View) -> tuple[Any, npt.NDArray[np.uint8]]:
    """svo_render_options, and the array that receives the picture."""
    options = _structs.new("svo_render_options")
    options.width, options.height = _arrays.integer("width", width), _arrays.integer("height", height)
    options.view = View(view)
    write_camera(options.camera, camera)
    return options, new_picture(width, height)


def draw(
    run: Callable[..., None], target: Callable[..., Any], options: Any, picture: npt.NDArray[np.uint8], queue: Any
) -> npt.NDArray[np.uint8]:
    """Draws what render_options made by run(function, arguments...), which calls a function with a handle; target makes
    an svo_target of that. Waits."""
    function = _opencl.of_target(target, lib.svo_render)
    run(function, options, _opencl.in_host(address("void *", picture)), _opencl.submit_to(queue))
    return picture


def address(kind: str, array: _arrays.Array) -> Any:
    """The address of an array's records, which cffi's from_buffer does not take; the array must stay alive."""
    return ffi.cast(kind, array.ctypes.data)


def trace_voxels(
    resident: Resident, rays: _arrays.Array, footprint: float, out: Optional[_arrays.Array], queue: Any
) -> _arrays.Array:
    """Of trees and compact trees."""
    records = _arrays.records("rays", rays, _arrays.ray_dtype)
    hits = _arrays.output("out", out, _arrays.voxel_hit_dtype, records.shape)
    name = "trace_voxels" if isinstance(resident, Tree) else "trace"
    resident._wait(name, resident._of_target(lib.svo_trace_voxels), (records, hits), [footprint, 0], queue)
    return hits


def _loaded(source: Any, levels: int) -> Tree:
    options = _structs.new("svo_load_options")
    options.last_level = _arrays.integer("levels", levels)
    out = ffi.new("svo_tree **")
    message = ffi.new("svo_message *")
    status = call(lib.svo_tree_load, source, options, out, message, undo=lambda: lib.svo_tree_destroy(out))
    if status != lib.SVO_OK:
        raise error(status, text(message.text))
    return Tree(out[0], None, None)


def _destroy_tree(pointer: Any) -> None:
    lib.svo_tree_destroy(ffi.new("svo_tree **", pointer))


TREE_ARGUMENTS: int = lib.SVO_TREE_ARGUMENTS
"""Number of kernel arguments that SVO_TREE_PARAMETERS declares."""


def kernel_source() -> str:
    """OpenCL C to put before the source of a kernel that traces rays itself; trace.h describes what it declares."""
    return text(lib.svo_kernel_source(lib.svo_tree_target(ffi.NULL)))


def kernel_options() -> str:
    """Compiler options for kernel_source."""
    return text(lib.svo_kernel_options(lib.svo_tree_target(ffi.NULL)))
