# SPDX-License-Identifier: MIT
"""Devices: an OpenCL context and device, the parent of plans and trees."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Optional

from . import _arrays, _opencl, _progress, _structs
from ._callbacks import call
from ._errors import error, text
from ._generated import Builder, Coverage, Need, Weights
from ._handle import DeviceHandle, Guard, Native
from ._mesh import DeviceMesh, mesh_of
from ._native import ffi, lib
from ._plan import Plan
from ._tree import Tree

_PLAN_PART = 0.1
"""Of Device.build, in its progress."""


class _Info(NamedTuple):
    """What svo_device_info tells, copied."""

    name: str
    compile_ms: float
    context: int
    device: int


class Device(DeviceHandle):
    """An OpenCL device as svocl uses it, with the kernels compiled for it.

    Calls that use one device, or what was made from it, run one after the other, whatever the threads; the GIL is
    released meanwhile. Different devices are independent, also when they share a context.

    Args:
        name: without a context: a part of "platform: device", or indices as in "0.1". None matches every device. Of
            those that match, the available GPU of most compute units with memory of its own is taken first.
        context: a pyopencl.Context, or the int_ptr of one; None: a context is made.
        device: a pyopencl.Device of the context, or its int_ptr; None: the context's only device.
        trust_driver: use kernels without a test of known answers (DeviceUnreliableError).

    Raises:
        NoDeviceError: there is no platform, or no device of that name.
        UnsupportedError: the device lacks what svocl needs.
    """

    def __init__(
        self, name: Optional[str] = None, *, context: Any = None, device: Any = None, trust_driver: bool = False
    ) -> None:
        options = _structs.new("svo_device_options")
        options.log = lib.svocl_python_log
        options.trust_driver = 1 if trust_driver else 0
        out = ffi.new("svo_device **")
        message = ffi.new("svo_message *")

        def undo() -> None:
            lib.svo_device_destroy(out)

        if context is None:
            if device is not None:
                raise ValueError("device: given without its context")
            kept = ffi.NULL if name is None else ffi.new("char[]", name.encode())
            options.device_name = kept
            status = call(lib.svo_device_create_default, options, out, message, undo=undo)
        else:
            if name is not None:
                raise ValueError("name: a context was given; choose its device with device")
            cl_context = _opencl.pointer("cl_context", context, "context")
            cl_device = _opencl.pointer("cl_device_id", _only_device(context, device), "device")
            status = call(lib.svo_device_create, cl_context, cl_device, options, out, message, undo=undo)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        self._open(Native(out[0], _destroy_device, Guard(), None))

    @property
    def name(self) -> str:
        """ "platform: device"."""
        return self._info().name

    @property
    def compile_ms(self) -> float:
        """Time spent on compiling kernels so far, or on loading them from the driver's cache, in milliseconds."""
        return self._info().compile_ms

    @property
    def context_int_ptr(self) -> int:
        """The cl_context: pyopencl.Context.from_int_ptr(device.context_int_ptr) retains it."""
        return self._info().context

    @property
    def device_int_ptr(self) -> int:
        """The cl_device_id: for pyopencl.Device.from_int_ptr."""
        return self._info().device

    def _info(self) -> _Info:
        struct = _structs.new("svo_device_info")
        with self._called(lib.svo_device_get_info, struct):
            context, device = (int(ffi.cast("uintptr_t", handle)) for handle in (struct.context, struct.device))
            return _Info(text(struct.name), struct.compile_ms, context, device)

    def plan(
        self,
        mesh: Any,
        depth: int,
        *,
        queue: Any = None,
        need: Need = Need.DEFAULT,
        coverage: Coverage = Coverage.HALF_OPEN,
        weights: Weights = Weights.AREA,
        builder: Builder = Builder.CL,
        payload_level: int = 0,
        origin: Optional[Sequence[float]] = None,
        edge: Optional[float] = None,
        fragment_capacity: int = 0,
        worst_case_nodes: bool = False,
        chunk_bytes: int = 0,
        weight_log2: int = 0,
        drop_alpha: float = 0.0,
        progress: Optional[_progress.Progress] = None,
    ) -> Plan:
        """Plans the build of a mesh: what it will do, and the size of every buffer. Allocates nothing on the device.

        Args:
            mesh: a Mesh; a DeviceMesh; or an object with vertices and faces (or triangles), such as a mesh of trimesh
                or Open3D, whose geometry is taken. Read now, and not needed afterwards.
            depth: 1 .. 16: the grid has 2**depth voxels per axis.
            queue: of a DeviceMesh: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's
                own.
            need: what the tree holds besides its occupancy.
            coverage: which voxels a triangle occupies.
            weights: of the payload. Need.FILL requires Weights.AREA.
            builder: how nodes are made; the tree is the same.
            payload_level: the first level with payload; 0 for all levels, depth for the leaves alone.
            origin: (3,) minimum corner of the grid, world coordinates; None: a grid fitted to the triangles.
            edge: width of the grid, world units, above 0; given with origin. Triangles outside occupy nothing.
            fragment_capacity: fragments the list has room for at first; 0: by the fragment estimate.
            worst_case_nodes: room for as many inner nodes as the fragments could require.
            chunk_bytes: upper limit for a chunk of the list, at least 16384; 0: that of the device.
            weight_log2: the weight of a voxel's face, as a power of two from 13 on, so that trees of different plans
                can be equal; 0: the largest without overflow.
            drop_alpha: 0 .. 1: pairs of a voxel and a triangle whose alpha, that of their color, is below it are left
                out, and voxels without pairs are empty; BuildReport.dropped counts them. 0: none are.
            progress: for this call, and for Plan.count and Plan.build that are not given another. A callable
                (stage, fraction): a name such as "grid" or "voxelize", and 0.0 .. 1.0 of the whole call, by predicted
                times, never less than before. It runs on the calling thread and must not use the device or what was
                made from it. When it returns True, the call ends with CanceledError; what it raises ends the call too
                and comes out of it. True: a bar of tqdm. None or False: nothing.

        Raises:
            InvalidArgumentError: a depth or option out of range, or a grid that cannot be scaled.
            CanceledError: progress returned True.
            ImportError: progress is True, and tqdm is not installed.
            OutOfDeviceMemoryError, OutOfHostMemoryError
        """
        given = mesh if isinstance(mesh, DeviceMesh) else mesh_of(mesh)
        options = plan_options(need, coverage, weights, builder, payload_level, origin, edge, drop_alpha)
        options.fragment_capacity = _arrays.integer("fragment_capacity", fragment_capacity, 64)
        options.worst_case_nodes = bool(worst_case_nodes)
        options.chunk_bytes = _arrays.integer("chunk_bytes", chunk_bytes, 64)
        options.weight_log2 = _arrays.integer("weight_log2", weight_log2)
        struct, kept = given._struct()
        out = ffi.new("svo_plan **")
        arguments: list[Any] = [struct, _arrays.integer("depth", depth), options]
        create = lib.svo_plan_create
        if isinstance(given, DeviceMesh):
            create = lib.svo_plan_create_from_buffers
            arguments += [_opencl.pointer("cl_command_queue", queue, "queue"), *_opencl.events(given._events())]
        with _progress.opened(progress) as function:
            if function is not None:
                user = ffi.new_handle(function)
                options.progress, options.progress_user = lib.svocl_python_progress, user
            with self._called(create, *arguments, out, undo=lambda: lib.svo_plan_destroy(out)):
                del kept
                lib.svo_plan_set_progress(out[0], ffi.NULL, ffi.NULL)
                return Plan(out[0], self._native, progress)

    def build(
        self,
        mesh: Any,
        depth: int,
        *,
        queue: Any = None,
        progress: Optional[_progress.Progress] = None,
        **options: Any,
    ) -> Tree:
        """Plans and builds in one call.

        Args:
            mesh, depth, options: see Device.plan.
            queue: see Plan.build.
            progress: see Device.plan. The plan is the first tenth of the call, whatever its time.
        """
        with _progress.opened(progress) as function:
            part = _progress.part(function, 0, _PLAN_PART)
            with self.plan(mesh, depth, queue=queue, progress=part, **options) as plan:
                return plan.build(queue=queue, progress=_progress.part(function, _PLAN_PART, 1))

    def __repr__(self) -> str:
        return "<svocl.Device: closed>" if self.closed else f"<svocl.Device: {self.name}>"


def plan_options(
    need: Need,
    coverage: Coverage,
    weights: Weights,
    builder: Builder,
    payload_level: int,
    origin: Optional[Sequence[float]],
    edge: Optional[float],
    drop_alpha: float,
) -> Any:
    """svo_plan_options of what decides the tree, see Device.plan."""
    if (origin is None) != (edge is None):
        raise ValueError("origin and edge: give both or neither")
    options = _structs.new("svo_plan_options")
    options.need = _arrays.integer("need", need)
    options.coverage = Coverage(coverage)
    options.weights = Weights(weights)
    options.builder = Builder(builder)
    options.payload_level = _arrays.integer("payload_level", payload_level)
    options.drop_alpha = drop_alpha
    if origin is not None and edge is not None:
        if not edge > 0:  # in C, 0 is a fitted grid
            raise ValueError(f"edge: {edge} is not above 0")
        options.origin = _arrays.three("origin", origin)
        options.edge = edge
    return options


def _only_device(context: Any, device: Any) -> Any:
    if device is not None:
        return device
    devices = getattr(context, "devices", None)
    if devices is None:
        raise ValueError("device: needed with the address of a context")
    if len(devices) != 1:
        raise ValueError(f"device: the context has {len(devices)} devices; choose one")
    return devices[0]


def _destroy_device(pointer: Any) -> None:
    lib.svo_device_destroy(ffi.new("svo_device **", pointer))
