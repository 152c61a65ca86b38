# SPDX-License-Identifier: MIT
"""Light in a tree: photons from sources, and rays or cones that gather ambient occlusion and indirect light."""

import contextlib
import functools
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _arrays, _generated, _opencl, _structs
from ._callbacks import call
from ._errors import error, text
from ._generated import InvalidArgumentError, LightBuffer, LightForm, Opacity, SourceKind, Status, View
from ._handle import Handle, Native
from ._mesh import Finish, Mesh, Path, finish_record, from_path, need_io, to_path
from ._native import ffi, lib
from ._tree import Camera, Tree, address, draw, framed, render_options


class LightSource(NamedTuple):
    """A source of light, in world coordinates and linear units."""

    kind: SourceKind
    value: tuple[float, float, float]
    """Red, green, blue, not negative: irradiance of SourceKind.DIRECTIONAL, intensity of the others."""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of all but SourceKind.DIRECTIONAL."""
    direction: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of all but SourceKind.POINT: where the light goes, any length above 0."""
    inner_angle: float = 0.0
    """Of SourceKind.SPOT: radians from the axis up to which it has its full value."""
    outer_angle: float = 0.0
    """Of SourceKind.SPOT: radians at which it ends, above inner_angle and below pi / 2."""
    radius: float = 0.0
    """Its size, which shadows show: of a ball around its position or of a disk, world units; of SourceKind.DIRECTIONAL
    radians from its axis, below pi / 2. Photons leave its middle."""


def make_gather_points(
    positions: npt.ArrayLike,
    normals: npt.ArrayLike,
    reflected: npt.ArrayLike = (0.0, 0.0, 0.0),
    exponents: npt.ArrayLike = 0.0,
) -> _arrays.Array:
    """Points for Light.gather, from arrays that are broadcast against each other.

    Args:
        positions: (..., 3) world coordinates, on a surface or in the open.
        normals: (..., 3) of any length above 0.
        reflected: (..., 3) directions of specular cones, of any length; zero: none.
        exponents: (...) or a number: of the specular lobes, not negative.

    Returns:
        (...) records of gather_point_dtype.
    """
    names = ("positions", "normals", "reflected", "exponents")
    parts = [_arrays.array(*given) for given in zip(names, (positions, normals, reflected, exponents))]
    for name, part in zip(names, parts):
        if part.dtype.kind not in "fiu":
            raise TypeError(f"{name}: dtype {part.dtype}, expected float32")
    for name, part in zip(names[:3], parts):
        if part.ndim < 1 or part.shape[-1] != 3:
            raise ValueError(f"{name}: shape {part.shape}, expected (..., 3)")
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts[:3]), parts[3].shape)
    points = np.zeros(shape, _arrays.gather_point_dtype)
    for name, part in zip(("position", "normal", "reflected", "exponent"), parts):
        points[name] = part
    return points


class Light(Handle):
    """The light of a tree: opacity on all levels, and radiance after set_sources. It keeps the tree alive, which must
    stay as it is; when Moving.tree ends, Light.update takes the next. There is no light at first, and the sky is black.

    Args:
        tree: on a device. Colors give albedo and opacity (without: opaque, albedo 0.6); Need.NORMAL,
            Need.PROJECTED_AREA and Need.RAYS make cones, opacity and photons exact.
        form: how to store opacity and radiance. Walls leak in BRICKS and VOXELS.
        opacity: how opaque leaves are.
        one_side: of closed meshes, the front alone holds cones back, by the winding of the triangles.
        no_cones: nothing is stored, since rays alone gather; cones are refused.
        queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

    Raises:
        InvalidArgumentError: the tree is on no device, or its payload does not begin at level 0.
        OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
    """

    def __init__(
        self,
        tree: Tree,
        form: LightForm = LightForm.FACES,
        *,
        opacity: Opacity = Opacity.AREA,
        one_side: bool = False,
        no_cones: bool = False,
        queue: Any = None,
    ) -> None:
        if not isinstance(tree, Tree):
            raise TypeError(f"tree: {type(tree).__name__}, expected svocl.Tree")
        options = _structs.new("svo_light_options")
        options.form, options.opacity = LightForm(form), Opacity(opacity)
        options.one_side, options.no_cones = bool(one_side), bool(no_cones)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out = ffi.new("svo_light **")
        with tree._use() as pointer:
            if not tree.on_device:
                problem = "Light: the tree is on no device; call Tree.upload first"
                raise InvalidArgumentError(problem, Status.INVALID_ARGUMENT)
            status = call(
                lib.svo_light_create, pointer, options, cl_queue, out, undo=lambda: lib.svo_light_destroy(out)
            )
            if status != lib.SVO_OK:
                raise error(status, tree._native.device_message())
            self._open(Native(out[0], _destroy, tree._native.guard, tree._native))

    @property
    def info(self) -> _generated.LightInfo:
        """What it holds, and what its last stages did."""
        struct = _structs.new("svo_light_info")
        with super()._use() as pointer:  # whatever became of the tree
            lib.svo_light_get_info(pointer, struct)
        return _structs.read_light_info(struct)

    # --- files ------------------------------------------------------------------------------------------------------

    @staticmethod
    def load(tree: Tree, path: Path, *, queue: Any = None) -> "Light":
        """Reads the file of a light of this tree. It has the hash of the light that was saved, and gives the same
        pictures; the first update shoots all photons.

        Args:
            tree: on a device.
            path: of the file.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Raises:
            FileError: the file cannot be read.
            FileDamagedError: it is truncated, damaged or of another format.
            InvalidArgumentError: the light is of another tree.
        """
        need_io("Light.load")
        if not isinstance(tree, Tree):
            raise TypeError(f"tree: {type(tree).__name__}, expected svocl.Tree")
        source, _kept = from_path(path)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        out, message = ffi.new("svo_light **"), ffi.new("svo_message *")
        with tree._downloaded(queue) as pointer:
            status = call(
                lib.svo_light_load,
                pointer,
                source,
                ffi.NULL,
                cl_queue,
                out,
                message,
                undo=lambda: lib.svo_light_destroy(out),
            )
            if status != lib.SVO_OK:
                raise error(status, text(message.text))
            made = Light.__new__(Light)
            made._open(Native(out[0], _destroy, tree._native.guard, tree._native))
        return made

    def save(self, path: Path, *, compress: bool = False, queue: Any = None) -> None:
        """Writes a file of the light, bound to its tree, whose arrays are downloaded first if need be. An existing file
        is replaced at once, or stays.

        Args:
            path: of the file.
            compress: zstd for each array that becomes smaller.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Raises:
            FileError: the file cannot be written.
        """
        need_io("Light.save")
        sink, _kept = to_path(path)
        options = _structs.new("svo_save_options")
        options.compress = bool(compress)
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        message = ffi.new("svo_message *")
        with self._use() as pointer:
            tree = self._native.parent
            if tree is not None:
                status = call(lib.svo_tree_download, tree._pointer[0], cl_queue)
                if status != lib.SVO_OK:
                    raise error(status, tree.device_message())
            status = call(lib.svo_light_save, pointer, sink, options, cl_queue, message)
            if status != lib.SVO_OK:
                raise error(status, text(message.text))

    # --- sources ----------------------------------------------------------------------------------------------------

    def set_sources(
        self,
        sources: Sequence[LightSource] = (),
        *,
        finishes: Sequence[Finish] = (),
        sky: Sequence[float] = (0.0, 0.0, 0.0),
        sky_map: Optional[npt.ArrayLike] = None,
        view_resolution: int = 0,
        photons: bool = True,
        diagnose: bool = False,
        updatable: bool = False,
        emission_photons: int = 0,
        bounces: int = 1,
        photon_alpha: bool = False,
        queue: Any = None,
    ) -> None:
        """Lights the tree and waits: shoots photons, sums them in the leaves, and filters radiance upwards. Replaces
        the light of earlier calls; a failed call leaves it dark. Opacity stays.

        Args:
            sources: at most 1024.
            finishes: by material, for trees with Need.MATERIAL: Mesh.finishes. Materials beyond are diffuse.
            sky: radiance from outside: linear red, green, blue, not negative.
            sky_map: (rows, columns, 3): radiance from outside by direction, on top of sky, at most 4096 x 8192.
                Equirectangular, as seen from inside: rows from the zenith, +y, down, and columns to the right around
                y with -z in the middle. The light keeps a copy.
            view_resolution: photons along a side of each source's view, 1 .. 16384; 0: four per facing leaf.
            photons: False: sources light the surfaces of pictures, but these light no others.
            diagnose: also count LightInfo.missed_leaves.
            updatable: keep photons on the device, so that Light.update shoots few of them again.
            emission_photons: so many leave the triangles that emit, for cones: at most 2**30, best a power of two.
            bounces: so often do surfaces reflect the light of photons, for cones, 1 .. 64.
            photon_alpha: photons go through what shows in part, as rays do.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Raises:
            InvalidArgumentError: a value that is not finite or is negative, a zero direction, angles.
            OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
        """
        setup = _structs.new("svo_light_setup")
        given = ffi.new("svo_light_source[]", [_source(source) for source in sources])
        finished = ffi.new("svo_finish[]", [finish_record(finish) for finish in finishes])
        setup.sources, setup.source_count = given if sources else ffi.NULL, len(sources)
        setup.finishes, setup.finish_count = finished if finishes else ffi.NULL, len(finishes)
        setup.sky = _arrays.three("sky", sky)
        if sky_map is not None:
            texels = _arrays.floats("sky_map", sky_map, ("rows", "columns", 3))
            setup.sky_map = address("float *", texels)
            setup.sky_height, setup.sky_width = texels.shape[:2]
        setup.view_resolution = _arrays.integer("view_resolution", view_resolution)
        setup.diagnose, setup.no_photons, setup.updatable = bool(diagnose), not photons, bool(updatable)
        setup.emission_photons = _arrays.integer("emission_photons", emission_photons)
        setup.bounces, setup.photon_alpha = _arrays.integer("bounces", bounces), bool(photon_alpha)
        self._call(lib.svo_light_set_sources, setup, _opencl.pointer("cl_command_queue", queue, "queue"))

    def set_mesh(self, mesh: Optional[Mesh], *, queue: Any = None) -> None:
        """Gives the light the mesh that its tree was made of, in place of an earlier one. Pictures then show textures,
        vertex colors, materials and vertex normals at the point where a ray meets the mesh, as long as rays are
        narrower than leaves; all rays of light go through what shows in part by the alpha there. Light.update takes
        the mesh away.

        Args:
            mesh: of as many triangles as the tree was made of, in their order; the device has a copy. None: none from
                now on.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Raises:
            InvalidArgumentError: another number of triangles, or a tree without rays.
            OutOfDeviceMemoryError, OutOfHostMemoryError, CLError
        """
        if mesh is not None and not isinstance(mesh, Mesh):
            raise TypeError(f"mesh: {type(mesh).__name__}, expected svocl.Mesh")
        struct, _kept = mesh._struct() if mesh is not None else (ffi.NULL, [])
        self._call(lib.svo_light_set_mesh, struct, _opencl.pointer("cl_command_queue", queue, "queue"))

    def update(self, tree: Tree, changed: npt.ArrayLike, *, queue: Any = None) -> None:
        """Makes the light that of another tree, with the same sources, and waits: byte for byte that of Light(tree) and
        Light.set_sources. The tree before may be gone, as after Moving.update. A failed call leaves the light that of
        the tree before.

        Args:
            tree: on the light's device; the light keeps it alive from now on.
            changed: (count, 2, 3): least and greatest corners of boxes that hold all triangles that have come, gone or
                moved since the tree before, where they were and where they are: Moving.changes.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Raises:
            InvalidArgumentError: a box that is not finite or empty, a tree of another device, or changes elsewhere.
            OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
        """
        if not isinstance(tree, Tree):
            raise TypeError(f"tree: {type(tree).__name__}, expected svocl.Tree")
        array = _arrays.floats("changed", changed, ("count", 2, 3), double=True).astype(np.float64)
        boxes = address("svo_box *", array) if len(array) else ffi.NULL
        cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
        with super()._use() as pointer:
            if tree.closed:
                raise ValueError("Tree is closed")
            if tree._native.guard is not self._native.guard:
                raise InvalidArgumentError(
                    "Light.update: the tree is not on the light's device", Status.INVALID_ARGUMENT
                )
            status = call(lib.svo_light_update, pointer, tree._native._pointer[0], boxes, len(array), cl_queue)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
            self._native.set_parent(tree._native)

    @contextlib.contextmanager
    def _use(self) -> Iterator[Any]:
        with super()._use() as pointer:
            tree = self._native.parent
            if tree is not None and tree.ended:
                raise ValueError("Light: Moving has replaced its tree; call Light.update first")
            yield pointer

    # --- light at points --------------------------------------------------------------------------------------------

    def gather(
        self,
        points: _arrays.Array,
        *,
        paths: int = 64,
        bounces: int = 1,
        error: float = 0.0,
        cones: int = 0,
        step: float = 0.5,
        max_distance: float = np.inf,
        falloff: float = 0.0,
        with_light: bool = True,
        out: Optional[_arrays.Array] = None,
        queue: Any = None,
    ) -> _arrays.Array:
        """Gathers ambient occlusion, direct light, irradiance and specular radiance at points, and waits. Irradiance is
        what surfaces reflect and emit, and the sky. Points outside the grid, and those with a zero normal, are open and
        dark.

        Args:
            points: (...) records of gather_point_dtype, as make_gather_points makes them. Used without a copy if
                C-contiguous.
            paths: of exact rays that a point has, at most: a power of two, 16 .. 65536.
            bounces: rays of a path, 1 .. 64: so often are sources reflected.
            error: a point has paths enough when the standard error of its openness is at most this, and that of its
                irradiance as a share of it; 0: it has all.
            cones: 1, 5, 6, 16 or 64: cones in place of paths, of which the three above say nothing then; 0: none.
            step: of a cone, in its widths: 0.25 .. 1.
            max_distance: that occlusion reaches, above 0, world units; cones end there.
            falloff: occlusion at a distance t counts 1 / (1 + falloff * t); per world unit, not negative.
            with_light: False: ambient occlusion alone; all light is 0.
            out: (...) records of gather_result_dtype, C-contiguous; receives the result.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (...) records of gather_result_dtype, in the order of the points.
        """
        records = _arrays.records("points", points, _arrays.gather_point_dtype)
        results = _arrays.output("out", out, _arrays.gather_result_dtype, records.shape)
        options = _gather_options(cones, step, max_distance, falloff, with_light)
        if cones == 0:
            _set_paths(options, paths, bounces, error)
        _opencl.wait(functools.partial(self._call, lib.svo_gather), (records, results), [options], queue)
        return results

    def gather_enqueue(
        self,
        points: Any,
        results: Any,
        point_count: int,
        queue: Any,
        *,
        paths: int = 64,
        bounces: int = 1,
        error: float = 0.0,
        cones: int = 0,
        step: float = 0.5,
        max_distance: float = np.inf,
        falloff: float = 0.0,
        with_light: bool = True,
        wait_for: Iterable[Any] = (),
    ) -> _opencl.Event:
        """Light.gather for device buffers; does not wait.

        Args:
            points: a pyopencl.Buffer of point_count records of gather_point_dtype, or its int_ptr.
            results: a pyopencl.Buffer that receives point_count records of gather_result_dtype, or its int_ptr.
            point_count, queue, wait_for: see Tree.trace_enqueue.
            paths, bounces, error, cones, step, max_distance, falloff, with_light: see Light.gather.

        Returns:
            As Tree.trace_enqueue.
        """
        options = _gather_options(cones, step, max_distance, falloff, with_light)
        if cones == 0:
            _set_paths(options, paths, bounces, error)
        run = functools.partial(self._call, lib.svo_gather)
        return _opencl.enqueue(run, (points, results), point_count, [options], queue, wait_for)

    # --- pictures ---------------------------------------------------------------------------------------------------

    def render(
        self,
        width: int,
        height: int,
        *,
        camera: Optional[Camera] = None,
        view: View = View.SHADED,
        exposure: float = 1.0,
        paths: int = 16,
        bounces: int = 3,
        cones: int = 0,
        step: float = 0.5,
        max_distance: float = np.inf,
        falloff: float = 0.0,
        with_light: bool = True,
        queue: Any = None,
    ) -> npt.NDArray[np.uint8]:
        """Draws a picture of the lit tree and waits, by exact rays; reflections are cones.

        Args:
            width, height: pixels, 1 .. 16384.
            camera: None: Tree.frame of the tree.
            view: what to show: View.SHADED, all that the light brings, or View.AO, DIRECT, INDIRECT or SPECULAR.
            exposure: radiance is multiplied by it before the tone curve, above 0.
            paths: of 2 x 2 pixels, which are smoothed over surfaces: a power of two, 16 .. 65536.
            bounces, cones, step, max_distance, falloff, with_light: see Light.gather.
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

        Returns:
            (height, width, 4) uint8: RGBA, top to bottom.
        """
        used = self._frame(width / max(height, 1)) if camera is None else camera
        options, picture = render_options(width, height, used, view)
        gather = _gather_options(cones, step, max_distance, falloff, with_light)
        if cones == 0:
            _set_paths(gather, paths, bounces, 0.0)
        options.gather, options.exposure = gather, exposure
        return draw(self._call, lib.svo_light_target, options, picture, queue)

    def _frame(self, aspect: float) -> Camera:
        """Tree.frame of the tree, which may be closed."""
        tree = self._native.parent
        assert tree is not None
        with self._use():
            pointer = tree._pointer[0]
            status = call(lib.svo_tree_download, pointer, ffi.NULL)
            if status != lib.SVO_OK:
                raise error(status, self._native.device_message())
            return framed(lib.svo_tree_target(pointer), aspect)

    # --- the device -------------------------------------------------------------------------------------------------

    def hash(self, *, queue: Any = None) -> str:
        """32 hexadecimal digits of all that it stores, the same on every device.

        Args:
            queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.
        """
        digits = ffi.new("char[]", lib.SVO_HASH_TEXT_BYTES)
        self._call(lib.svo_light_hash, _opencl.pointer("cl_command_queue", queue, "queue"), digits)
        return text(digits)

    def buffer_int_ptr(self, buffer: LightBuffer) -> Optional[int]:
        """The cl_mem of one buffer: pyopencl.Buffer.from_int_ptr(...) retains it. LightInfo.bytes has its length.

        Returns:
            None where it is not held.
        """
        with self._use() as pointer:
            memory = lib.svo_light_get_buffer(pointer, LightBuffer(buffer))
            return None if memory == ffi.NULL else int(ffi.cast("uintptr_t", memory))

    def kernel_options(self) -> str:
        """Compiler options for svocl.light_kernel_source: they select the form."""
        with self._use() as pointer:
            return text(lib.svo_kernel_options(lib.svo_light_target(pointer)))

    def set_kernel_args(self, kernel: Any, first_index: int) -> None:
        """Sets the arguments that SVO_LIGHT_PARAMETERS declares (light_kernel_source) in a kernel of the caller's. They
        hold until Light.set_sources; the light must not be closed before the kernel's launches end.

        Args:
            kernel: a pyopencl.Kernel, or its int_ptr.
            first_index: of LIGHT_ARGUMENTS consecutive arguments.
        """
        cl_kernel = _opencl.pointer("cl_kernel", kernel, "kernel")
        function = _opencl.of_target(lib.svo_light_target, lib.svo_kernel_set_arguments)
        self._call(function, cl_kernel, _arrays.integer("first_index", first_index))

    def __repr__(self) -> str:
        if self.closed:
            return "<svocl.Light: closed>"
        info = self.info
        return f"<svocl.Light: {info.form.name.lower()}, {info.lit_leaves} lit leaves, {info.total_bytes} bytes>"


def _source(source: LightSource) -> dict[str, Any]:
    return {
        "kind": SourceKind(source.kind),
        "position": _arrays.three("LightSource.position", source.position),
        "direction": _arrays.three("LightSource.direction", source.direction),
        "value": _arrays.three("LightSource.value", source.value),
        "inner_angle": source.inner_angle,
        "outer_angle": source.outer_angle,
        "radius": source.radius,
    }


def _gather_options(cones: int, step: float, max_distance: float, falloff: float, with_light: bool) -> Any:
    options = _structs.new("svo_gather_options")
    options.cones = _arrays.integer("cones", cones)
    options.step = step if cones != 0 else 0
    options.range = 0 if max_distance == np.inf else max_distance
    options.falloff = falloff
    options.no_light = not with_light
    return options


def _set_paths(options: Any, paths: int, bounces: int, error: float) -> None:
    options.method = lib.SVO_GATHER_RAYS
    options.paths = _arrays.integer("paths", paths)
    options.bounces = _arrays.integer("bounces", bounces)
    options.error = error


def _destroy(pointer: Any) -> None:
    lib.svo_light_destroy(ffi.new("svo_light **", pointer))


LIGHT_ARGUMENTS: int = lib.SVO_LIGHT_ARGUMENTS
"""Number of kernel arguments that SVO_LIGHT_PARAMETERS declares."""


def light_kernel_source() -> str:
    """OpenCL C to put before the source of a kernel that traces cones itself; light.h describes what it declares."""
    return text(lib.svo_kernel_source(lib.svo_light_target(ffi.NULL)))
