# SPDX-License-Identifier: MIT
"""Light field probes: rays and diffuse light without the geometry."""

import functools
from collections.abc import Iterable, Sequence
from typing import Any, Optional, Union

from . import _arrays, _generated, _opencl, _structs
from ._callbacks import call
from ._errors import error, text
from ._generated import InvalidArgumentError, ProbeBuffer, Status
from ._handle import Handle, Native
from ._light import Light
from ._native import ffi, lib
from ._scene import Scene
from ._tree import Tree


class Probes(Handle):
    """A grid of probes in a tree or a scene, each of which sees distances, normals and radiance in all directions. They
    keep what they were made from alive, which must stay as it is.

    Args:
        subject: a tree on a device, or a scene where its instances are now.
        counts: (3,) probes along x, y and z; all 0: 4, 4, 4.
        resolution: texels along a side of a probe's map, 64 .. 1024, a multiple of 16; 0: 256, or what max_bytes
            allows.
        start: (3,) of the first probe, world coordinates; read on axes with a step.
        step: (3,) between probes, world units; 0: the probes are at the centers of equal cells of the tree's grid.
        max_bytes: of the texels of all probes; 0: 1 GiB.
        field_size: cells of the field along an axis, 1 .. 256; 0: 64.
        keep_places: neither move probes nor switch them off.
        diffuse: maps of irradiance and distances for Probes.irradiance too; needs a light.
        cones: of the light, for the radiance of texels: 1, 5, 6, 16 or 64.
        light: of the same tree; None: no radiance. Scenes have none.
        queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

    Raises:
        InvalidArgumentError: an option out of its range, or texels of more than max_bytes.
        OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
    """

    def __init__(
        self,
        subject: Union[Tree, Scene],
        counts: Sequence[int] = (0, 0, 0),
        *,
        resolution: int = 0,
        start: Sequence[float] = (0.0, 0.0, 0.0),
        step: Sequence[float] = (0.0, 0.0, 0.0),
        max_bytes: int = 0,
        field_size: int = 0,
        keep_places: bool = False,
        diffuse: bool = False,
        cones: int = 16,
        light: Optional[Light] = None,
        queue: Any = None,
    ) -> None:
        if not isinstance(subject, (Tree, Scene)):
            raise TypeError(f"subject: {type(subject).__name__}, expected svocl.Tree or svocl.Scene")
        if light is not None and not isinstance(light, Light):
            raise TypeError(f"light: {type(light).__name__}, expected svocl.Light")
        options = _structs.new("svo_probe_options")
        if len(counts) != 3:
            raise ValueError(f"counts: {len(counts)} numbers, expected 3")
        options.counts = [_arrays.integer("counts", count) for count in counts]
        options.start, options.step = _arrays.three("start", start), _arrays.three("step", step)
        options.resolution = _arrays.integer("resolution", resolution)
        options.max_bytes = _arrays.integer("max_bytes", max_bytes, 64)
        options.field_size = _arrays.integer("field_size", field_size)
        options.keep_places, options.diffuse = bool(keep_places), bool(diffuse)
        options.cones = _arrays.integer("cones", cones)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_probes **")
        with subject._use() as pointer:
            if isinstance(subject, Tree) and not subject.on_device:
                problem = "Probes: the tree is on no device; call Tree.upload first"
                raise InvalidArgumentError(problem, Status.INVALID_ARGUMENT)
            if light is not None:
                if light.closed or light._native.guard is not subject._native.guard:
                    problem = "Probes: the light is closed, or not on the tree's device"
                    raise InvalidArgumentError(problem, Status.INVALID_ARGUMENT)
                options.light = light._native._pointer[0]
            if isinstance(subject, Tree):
                options.tree = pointer
            else:
                options.scene = pointer
            status = call(lib.svo_probes_create, options, cl_queue, out, undo=lambda: lib.svo_probes_destroy(out))
            if status != lib.SVO_OK:
                raise error(status, subject._native.device_message())
            # The light keeps the tree alive.
            parent = subject._native if light is None else light._native
            self._open(Native(out[0], _destroy, parent.guard, parent))

    @property
    def info(self) -> _generated.ProbeInfo:
        """What they are, and what making them took."""
        struct = _structs.new("svo_probe_info")
        self._call(lib.svo_probes_get_info, struct)
        return _structs.read_probe_info(struct)

    def relight(self, *, queue: Any = None) -> None:
        """Makes radiance, and the diffuse maps, anew from the light as it is now, and waits."""
        self._call(lib.svo_probes_relight, _opencl.pointer("cl_command_queue", queue, "queue"))

    def hash(self, *, queue: Any = None) -> str:
        """XXH3-128 of all that they store; without a light the same on every device."""
        out = ffi.new("char[]", lib.SVO_HASH_TEXT_BYTES)
        self._call(lib.svo_probes_hash, _opencl.pointer("cl_command_queue", queue, "queue"), out)
        return text(out)

    def buffer_int_ptr(self, buffer: ProbeBuffer) -> Optional[int]:
        """The cl_mem of a buffer; None: they do not hold it. pyopencl.Buffer.from_int_ptr retains it."""
        with self._use() as pointer:
            memory = lib.svo_probes_get_buffer(pointer, ProbeBuffer(buffer))
            return int(ffi.cast("uintptr_t", memory)) or None

    # --- queries ----------------------------------------------------------------------------------------------------

    def trace(
        self,
        rays: _arrays.Array,
        *,
        thickness: float = 1.0,
        out: Optional[_arrays.Array] = None,
        queue: Any = None,
    ) -> _arrays.Array:
        """Traces rays through the probes, and waits.

        Args:
            rays: (...) records of ray_dtype, as make_rays makes them. From a surface they should begin between a
                fiftieth of a leaf's edge and half of one above it.
            thickness: factor to how far behind their points surfaces hold, above 0.
            out: (...) records of probe_hit_dtype, C-contiguous; receives the result.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (...) records of probe_hit_dtype. state: 0 miss, 1 hit, 2 unknown.
        """
        records = _arrays.records("rays", rays, _arrays.ray_dtype)
        hits = _arrays.output("out", out, _arrays.probe_hit_dtype, records.shape)
        run = functools.partial(self._call, lib.svo_probes_trace)
        _opencl.wait(run, (records, hits), [_trace_options(thickness)], queue)
        return hits

    def trace_enqueue(
        self,
        rays: Any,
        hits: Any,
        ray_count: int,
        queue: Any,
        *,
        thickness: float = 1.0,
        wait_for: Iterable[Any] = (),
    ) -> _opencl.Event:
        """Probes.trace for device buffers; does not wait.

        Args:
            rays: a pyopencl.Buffer of ray_count records of ray_dtype, or its int_ptr.
            hits: a pyopencl.Buffer that receives ray_count records of probe_hit_dtype, or its int_ptr.
            ray_count, queue, wait_for: see Tree.trace_enqueue.
            thickness: see Probes.trace.

        Returns:
            As Tree.trace_enqueue.
        """
        run = functools.partial(self._call, lib.svo_probes_trace)
        return _opencl.enqueue(run, (rays, hits), ray_count, [_trace_options(thickness)], queue, wait_for)

    def irradiance(
        self, points: _arrays.Array, *, out: Optional[_arrays.Array] = None, queue: Any = None
    ) -> _arrays.Array:
        """Diffuse light at points, from the prefiltered maps of the probes around them, and waits. For probes with
        diffuse.

        Args:
            points: (...) records of gather_point_dtype, as make_gather_points makes them.
            out: (...) records of probe_irradiance_dtype, C-contiguous; receives the result.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (...) records of probe_irradiance_dtype.
        """
        records = _arrays.records("points", points, _arrays.gather_point_dtype)
        results = _arrays.output("out", out, _arrays.probe_irradiance_dtype, records.shape)
        run = functools.partial(self._call, lib.svo_probes_irradiance)
        _opencl.wait(run, (records, results), [], queue)
        return results

    def __repr__(self) -> str:
        if self.closed:
            return "<svocl.Probes: closed>"
        info = self.info
        return f"<svocl.Probes: {' x '.join(map(str, info.counts))}, {info.resolution} texels a side>"


def _trace_options(thickness: float) -> Any:
    options = _structs.new("svo_probe_trace_options")
    if not thickness > 0:  # in C, 0 is the default
        raise ValueError(f"thickness: {thickness} is not above 0")
    options.thickness = thickness
    return options


def _destroy(pointer: Any) -> None:
    lib.svo_probes_destroy(ffi.new("svo_probes **", pointer))
