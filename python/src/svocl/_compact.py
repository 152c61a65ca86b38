# SPDX-License-Identifier: MIT
"""Compact trees: smaller forms of a built tree, and solids."""

import contextlib
import functools
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Callable, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arrays, _generated, _opencl, _structs
from ._callbacks import call
from ._errors import error, text
from ._generated import CompactBuffer, Form, InvalidArgumentError, Need, SolidRule, Status, View
from ._handle import Guard, Handle, Native, view
from ._mesh import Path, from_bytes, from_path, need_io
from ._native import ffi, lib
from ._resident import Resident
from ._tree import Camera, Tree, draw, framed, render_options, trace_voxels

if TYPE_CHECKING:
    from ._device import Device

_DIRECTORY_STEPS = {16: 4, 32: 5, 64: 6}
_PAYLOAD: dict[CompactBuffer, tuple[str, Any, tuple[int, ...]]] = {
    CompactBuffer.COLORS: ("colors", np.uint8, (4,)),
    CompactBuffer.NORMALS: ("normals", np.int16, (3,)),
    CompactBuffer.MATERIALS: ("materials", np.uint16, ()),
    CompactBuffer.FILLS: ("fills", np.uint16, ()),
}


class CompactArrays(NamedTuple):
    """A compact tree's arrays on the host, read-only and without a copy; None where it does not hold them. compact.h
    describes what each form has in them. Constant payload has one row."""

    nodes: Union[npt.NDArray[np.uint32], npt.NDArray[np.uint8]]
    """(stored_count,): words; child masks in Form.IMPLIED."""
    links: Optional[npt.NDArray[np.uint32]]
    """The directory of Form.IMPLIED; two numbers of Form.SHARED, and the begins of levels of Form.MIRRORED."""
    bases: Optional[npt.NDArray[np.uint32]]
    """Places of payload."""
    colors: Optional[npt.NDArray[np.uint8]]
    """(payload_count, 4): RGBA."""
    normals: Optional[npt.NDArray[np.int16]]
    """(payload_count, 3): mean normal, 32767 = 1."""
    materials: Optional[npt.NDArray[np.uint16]]
    """(payload_count,): into the mesh's materials."""
    fills: Optional[npt.NDArray[np.uint16]]
    """(payload_count,): surface area inside, 4096 = a face of the node."""
    packed: dict[str, npt.NDArray[np.uint32]]
    """The words of packed arrays by name, "colors" to "fills", which are None above; Compact.payload reads them."""


class Compact(Resident):
    """A smaller form of a tree, on a device, on the host after Compact.load or Compact.download, or both. It is
    independent of the tree that it was made from; leaf lists are not carried.

    Args:
        tree: complete; it stays as it is.
        form: how to store the nodes.
        leave_out: payload of the tree that is not carried.
        directory_step: Form.IMPLIED: an entry for 16, 32 or 64 nodes.
        minimize: a node whose eight children are leaves becomes a leaf if all payload below is equal, or within the
            tolerances of what the node stores.
        color_tolerance: minimize: most that red, green, blue, alpha of a voxel may change; 0 .. 255.
        normal_tolerance: minimize: most that a component of a voxel's normal may change; 0 .. 65534.
        fill_tolerance: minimize: most that a voxel's fill may change; 0 .. 65535.
        device: for a tree that is on the host alone; None: the tree's.
        queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

    Raises:
        InvalidArgumentError: an option out of range, or a tree on no device without `device`.
        UnsupportedError: more than 2**31 - 1 inner nodes.
        OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
    """

    _prefix = "svo_compact"
    _noun = "compact tree"

    def __init__(
        self,
        tree: Tree,
        form: Form = Form.DESCRIPTOR,
        *,
        leave_out: Need = Need(0),
        directory_step: int = 32,
        minimize: bool = False,
        color_tolerance: Sequence[int] = (0, 0, 0, 0),
        normal_tolerance: int = 0,
        fill_tolerance: int = 0,
        device: Optional["Device"] = None,
        queue: Any = None,
    ) -> None:
        options = _structs.new("svo_compact_options")
        options.form = Form(form)
        options.leave_out = _arrays.integer("leave_out", leave_out)
        if directory_step not in _DIRECTORY_STEPS:
            raise ValueError(f"directory_step: {directory_step} is not 16, 32 or 64")
        options.directory_step_log2 = _DIRECTORY_STEPS[directory_step] if options.form == lib.SVO_FORM_IMPLIED else 0
        options.minimize = bool(minimize)
        options.color_tolerance = _arrays.integers("color_tolerance", color_tolerance, np.uint32, (4,)).tolist()
        options.normal_tolerance = _arrays.integer("normal_tolerance", normal_tolerance)
        options.fill_tolerance = _arrays.integer("fill_tolerance", fill_tolerance)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_compact **")
        with _on("Compact", tree, device) as (native, pointer):
            at = native._pointer[0]
            status = call(lib.svo_compact_create, at, pointer, options, cl_queue, out, undo=lambda: _undo(out))
            if status != lib.SVO_OK:
                raise error(status, native.device_message())
            self._adopt(out[0], native)

    # --- files ------------------------------------------------------------------------------------------------------

    @staticmethod
    def load(path: Path) -> "Compact":
        """Reads a .svc file. Lengths, checksums and every node are checked. For rays and pictures, upload it then.

        Raises:
            FileError: the file cannot be read.
            FileDamagedError: it is truncated, damaged or of another format.
        """
        need_io("Compact.load")
        source, _kept = from_path(path)
        return _loaded(source)

    @staticmethod
    def load_bytes(content: Union[bytes, bytearray, memoryview], name: str = "bytes") -> "Compact":
        """Compact.load from memory.

        Args:
            content: of a .svc file.
            name: stands for the path in messages.
        """
        need_io("Compact.load_bytes")
        source, _kept = from_bytes(content, name)
        return _loaded(source)

    # --- what it holds ----------------------------------------------------------------------------------------------

    @property
    def info(self) -> _generated.CompactInfo:
        """What describes it besides its arrays."""
        struct = _structs.new("svo_compact_info")
        self._call(lib.svo_compact_get_info, struct)
        return _structs.read_compact_info(struct)

    def download(self, *, queue: Any = None) -> CompactArrays:
        """The arrays. The first call copies them from the device and waits; later ones copy nothing. The arrays stay
        valid when the compact tree is closed.

        Args:
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.
        """
        struct = _structs.new("svo_compact_arrays")
        info = self.info
        kinds: dict[str, tuple[Any, tuple[int, ...]]] = {
            "nodes": (np.uint8 if info.form == Form.IMPLIED else np.uint32, ()),
            "links": (np.uint32, ()),
            "bases": (np.uint32, ()),
            "colors": (np.uint8, (4,)),
            "normals": (np.int16, (3,)),
            "materials": (np.uint16, ()),
            "fills": (np.uint16, ()),
        }
        with self._downloaded(queue) as pointer:
            status = call(lib.svo_compact_get_arrays, pointer, struct)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
            arrays: dict[str, Any] = {}
            for byte_count, (name, (dtype, row)) in zip(info.bytes, kinds.items()):
                rows = byte_count // (np.dtype(dtype).itemsize * int(np.prod(row, dtype=int)))
                arrays[name] = view(self._native, getattr(struct, name), dtype, (rows, *row))
            packed: dict[str, Any] = {}
            for index, (buffer, (name, _dtype, _row)) in enumerate(_PAYLOAD.items()):
                words = view(self._native, struct.packed[index], np.uint32, (info.bytes[buffer] // 4,))
                if words is not None:
                    packed[name] = words
            return CompactArrays(**arrays, packed=packed)

    @property
    def arrays(self) -> CompactArrays:
        """download() on the device's own queue."""
        return self.download()

    def hash(self) -> str:
        """32 hexadecimal digits, the same on every device, downloading first if need be."""
        digits = ffi.new("char[]", lib.SVO_HASH_TEXT_BYTES)
        with self._downloaded(None) as pointer:
            status = call(lib.svo_compact_hash, pointer, digits)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
        return text(digits)

    def pack(
        self,
        *,
        color_error: int = 0,
        normal_bits: int = 0,
        fill_error: int = 0,
        leave_out: Need = Need(0),
        queue: Any = None,
    ) -> "Compact":
        """One with packed payload, made on the host: pictures and expand read it where it is. Arrays that are constant,
        packed already, or would not get smaller are those of this one. Its info.packed, bytes, largest_error and
        mean_error tell what that gave.

        Args:
            color_error: most that red, green and blue may change, 0 .. 255; alpha never changes.
            normal_bits: 0: exact; 4 .. 8: octahedral, with so many bits for each of two numbers.
            fill_error: most that fills may change, 0 .. 65535.
            leave_out: payload that stays as it is.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Raises:
            InvalidArgumentError: an option out of range.
        """
        options = _structs.new("svo_pack_options")
        options.color_error = _arrays.integer("color_error", color_error)
        options.normal_bits = _arrays.integer("normal_bits", normal_bits)
        options.fill_error = _arrays.integer("fill_error", fill_error)
        options.leave_out = _arrays.integer("leave_out", leave_out)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_compact **")
        with self._use() as pointer:
            native = self._native.parent
            status = call(lib.svo_compact_pack, pointer, options, cl_queue, out, undo=lambda: _undo(out))
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
            made = Compact.__new__(Compact)
            made._adopt(out[0], native)
        return made

    def payload(self, buffer: CompactBuffer, first: int = 0, count: Optional[int] = None) -> npt.NDArray[Any]:
        """Payload on the host, packed or not, downloading first if need be; constant payload once for each element.

        Args:
            buffer: COLORS, NORMALS, MATERIALS or FILLS, which it holds.
            first: the place of the first element.
            count: how many; None: all that follow.

        Returns:
            (count, 4) uint8, (count, 3) int16, or (count,) uint16.

        Raises:
            InvalidArgumentError: the array is not held, or has not so many elements.
        """
        kind = CompactBuffer(buffer)
        if kind not in _PAYLOAD:
            raise ValueError(f"buffer: {kind.name} is no payload")
        _name, dtype, row = _PAYLOAD[kind]
        begin = _arrays.integer("first", first, 64)
        rest = max(self.info.payload_count - begin, 0) if count is None else _arrays.integer("count", count, 64)
        elements = np.empty((rest, *row), dtype)
        with self._downloaded(None) as pointer:
            to = ffi.from_buffer(elements) if rest > 0 else ffi.NULL
            status = call(lib.svo_compact_read_payload, pointer, kind, begin, rest, to)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
        return elements

    def expand(self, *, queue: Any = None) -> Tree:
        """A tree with the same voxels, without leaf lists: of the same Tree.hash(nodes_only=True) as the one that this
        was made from, and with its payload as far as that is carried.

        Args:
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.
        """
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_tree **")
        with self._use() as pointer:
            native = self._device_native("expand")
            status = call(lib.svo_compact_expand, pointer, cl_queue, out, undo=lambda: lib.svo_tree_destroy(out))
            if status != lib.SVO_OK:
                raise error(status, native.device_message())
            return Tree(out[0], native, None)

    # --- the device -------------------------------------------------------------------------------------------------

    def buffer_int_ptr(self, buffer: CompactBuffer) -> Optional[int]:
        """The cl_mem of one array: pyopencl.Buffer.from_int_ptr(...) retains it.

        Returns:
            None where the array is not held, or on no device.
        """
        with self._use() as pointer:
            memory = lib.svo_compact_get_buffer(pointer, CompactBuffer(buffer))
            return None if memory == ffi.NULL else int(ffi.cast("uintptr_t", memory))

    def kernel_options(self) -> str:
        """Compiler options for svocl.kernel_source, by form: the same kernel then reads this in place of a tree."""
        with self._use() as pointer:
            return text(lib.svo_kernel_options(lib.svo_compact_target(pointer)))

    def set_kernel_args(self, kernel: Any, first_index: int) -> None:
        """Sets the arguments that SVO_TREE_PARAMETERS declares with kernel_options, as Tree.set_kernel_args.

        Args:
            kernel: a pyopencl.Kernel, or its int_ptr.
            first_index: of COMPACT_ARGUMENTS consecutive arguments.
        """
        cl_kernel = _opencl.pointer("cl_kernel", kernel, "kernel")
        index = _arrays.integer("first_index", first_index)
        function = self._of_target(lib.svo_kernel_set_arguments)
        self._device_call("set_kernel_args", function, cl_kernel, index)

    # --- rays and pictures ------------------------------------------------------------------------------------------

    def trace(
        self,
        rays: _arrays.Array,
        *,
        footprint: float = 0.0,
        out: Optional[_arrays.Array] = None,
        queue: Any = None,
    ) -> _arrays.Array:
        """Traces rays against the voxels and waits: with the hits of Tree.trace_voxels, but for node, which is the
        place of the node's payload.

        Args:
            rays, footprint, out, queue: see Tree.trace_voxels.

        Returns:
            (...) records of voxel_hit_dtype, in the order of the rays.
        """
        return trace_voxels(self, rays, footprint, out, queue)

    def trace_enqueue(
        self,
        rays: Any,
        hits: Any,
        ray_count: int,
        queue: Any,
        *,
        footprint: float = 0.0,
        wait_for: Iterable[Any] = (),
    ) -> _opencl.Event:
        """Compact.trace for device buffers; does not wait.

        Args:
            rays: a pyopencl.Buffer of ray_count records of ray_dtype, or its int_ptr.
            hits: a pyopencl.Buffer that receives ray_count records of voxel_hit_dtype, or its int_ptr.
            ray_count, queue, wait_for: see Tree.trace_enqueue.
            footprint: see Tree.trace_voxels.

        Returns:
            As Tree.trace_enqueue.
        """
        function = self._of_target(lib.svo_trace_voxels)
        return self._enqueue("trace_enqueue", function, (rays, hits), ray_count, [footprint, 0], queue, wait_for)

    def frame(self, aspect: float = 1.0, camera: Optional[Camera] = None) -> Camera:
        """Tree.frame of the tree that this was made from, downloading first if need be.

        Args:
            aspect, camera: see Tree.frame.

        Raises:
            InvalidArgumentError: the camera has no frame: its up is along its line of sight.
        """
        with self._downloaded(None) as pointer:
            return framed(lib.svo_compact_target(pointer), aspect, camera)

    def render(
        self,
        width: int,
        height: int,
        camera: Optional[Camera] = None,
        *,
        view: View = View.SHADED,
        queue: Any = None,
    ) -> npt.NDArray[np.uint8]:
        """Draws a picture and waits: the bytes of Tree.render of the tree that this was made from.

        Args:
            width, height: pixels, 1 .. 16384.
            camera: None: Compact.frame.
            view: what to show: View.SHADED, NORMAL, DEPTH, STEPS or LEVEL.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (height, width, 4) uint8: RGBA, top to bottom.
        """
        used = self.frame(width / max(height, 1)) if camera is None else camera
        options, picture = render_options(width, height, used, view)
        return draw(functools.partial(self._device_call, "render"), lib.svo_compact_target, options, picture, queue)

    # --- shared -----------------------------------------------------------------------------------------------------

    def _adopt(self, pointer: Any, device: Optional[Native]) -> None:
        self._open(Native(pointer, _destroy, Guard() if device is None else device.guard, device))

    def __repr__(self) -> str:
        name = f"svocl.{type(self).__name__}"
        if self.closed:
            return f"<{name}: closed>"
        info = self.info
        return f"<{name}: {info.form.name.lower()}, depth {info.depth}, {info.total_bytes} bytes>"


class Solid(Compact):
    """The inside of a closed mesh, found from its tree: a compact tree of Form.DESCRIPTOR with leaves for what is
    inside, each on the highest level that is full. Voxels that the surface touches stay leaves. On a mesh with holes
    two of three directions decide, and solid_info says where; SolidRule.GENERALIZED is for meshes with large holes.

    Args:
        tree: on a device, with Need.RAYS, coverage half-open or closed, and the whole mesh in its grid.
        rule: which sums of crossings mean inside.
        color: RGBA of interior leaves, 0 .. 255, for trees with colors.
        material: of interior leaves, for trees with materials: into the mesh's.
        queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.
        progress: called with the fraction that is done, 0 .. 1; True stops the call, which raises CanceledError. It
            must not use the device.

    Attributes:
        solid_info: the counts.

    Raises:
        InvalidArgumentError: the tree has no leaf lists, is thin, on no device, or not of the whole mesh.
        UnsupportedError: too many nodes.
        OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
    """

    solid_info: _generated.SolidInfo

    def __init__(
        self,
        tree: Tree,
        rule: SolidRule = SolidRule.WINDING,
        *,
        color: Sequence[int] = (255, 255, 255, 255),
        material: int = 0,
        queue: Any = None,
        progress: Optional[Callable[[float], Optional[bool]]] = None,
    ) -> None:
        options = _structs.new("svo_solid_options")
        options.rule = SolidRule(rule)
        options.color = _arrays.integers("color", color, np.uint8, (4,)).tolist()
        options.material = _arrays.integer("material", material, 16)
        if progress is not None:
            user = ffi.new_handle(progress)
            options.progress, options.progress_user = lib.svocl_python_fraction, user
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_compact **")
        info = _structs.new("svo_solid_info")
        with _on("Solid", tree, None) as (native, pointer):
            status = call(lib.svo_solid_create, pointer, options, cl_queue, out, info, undo=lambda: _undo(out))
            if status != lib.SVO_OK:
                raise error(status, native.device_message())
            self._adopt(out[0], native)
        self.solid_info = _structs.read(info, _generated.SolidInfo)


@contextlib.contextmanager
def _on(what: str, tree: Tree, device: Optional["Device"]) -> Iterator[tuple[Native, Any]]:
    """The device's handle and the tree's pointer, under the guards of both."""
    if not isinstance(tree, Tree):
        raise TypeError(f"tree: {type(tree).__name__}, expected svocl.Tree")
    if device is not None and not isinstance(device, Handle):
        raise TypeError(f"device: {type(device).__name__}, expected svocl.Device")
    if device is not None and not tree.on_device:
        with device._use(), tree._use() as pointer:
            yield device._native, pointer
        return
    with tree._use() as pointer:
        native = tree._native.parent
        if native is None or (device is not None and device._native is not native):
            problem = "on no device; call Tree.upload first" if native is None else "on another device"
            raise InvalidArgumentError(f"{what}: the tree is {problem}", Status.INVALID_ARGUMENT)
        yield native, pointer


def _loaded(source: Any) -> Compact:
    out = ffi.new("svo_compact **")
    message = ffi.new("svo_message *")
    status = call(lib.svo_compact_load, source, ffi.NULL, out, message, undo=lambda: _undo(out))
    if status != lib.SVO_OK:
        raise error(status, text(message.text))
    made = Compact.__new__(Compact)
    made._adopt(out[0], None)
    return made


def _undo(out: Any) -> None:
    lib.svo_compact_destroy(out)


def _destroy(pointer: Any) -> None:
    lib.svo_compact_destroy(ffi.new("svo_compact **", pointer))


COMPACT_ARGUMENTS: int = lib.SVO_COMPACT_ARGUMENTS
"""Number of kernel arguments that SVO_TREE_PARAMETERS declares with Compact.kernel_options."""
