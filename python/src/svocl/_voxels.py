# SPDX-License-Identifier: MIT
"""Voxels that are given, not made from triangles: lists, their files, and the trees of them."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arrays, _generated, _progress, _structs
from ._callbacks import call
from ._errors import error, text
from ._generated import Axes, Builder, Need
from ._handle import Guard, Handle, Native, view
from ._mesh import Path, from_bytes, from_path, need_io, to_path
from ._native import ffi, lib
from ._plan import Plan
from ._tree import Tree

if TYPE_CHECKING:
    from ._device import Device


def make_voxels(
    positions: npt.ArrayLike, colors: npt.ArrayLike = (255, 255, 255, 255), materials: npt.ArrayLike = 0
) -> _arrays.Array:
    """Records for Voxels from coordinates, colors and materials, which are broadcast against each other.

    Args:
        positions: (voxel_count, 3) whole numbers within 2**30 of 0.
        colors: (voxel_count, 4) RGBA, 0 .. 255.
        materials: (voxel_count,) numbers below 65535.

    Returns:
        (voxel_count,) records of voxel_dtype.
    """
    at, rgba = _arrays.array("positions", positions), _arrays.array("colors", colors)
    material = _arrays.array("materials", materials)
    for name, array, high in (("positions", at, 2**30), ("colors", rgba, 255), ("materials", material, 65534)):
        if array.dtype.kind not in "iu" and array.size:
            raise TypeError(f"{name}: dtype {array.dtype}, expected integers")
        low = -high if name == "positions" else 0
        if array.size and not (low <= int(array.min()) and int(array.max()) <= high):
            raise ValueError(f"{name}: not all in {low} .. {high}")
    if at.ndim != 2 or at.shape[1] != 3:
        raise ValueError(f"positions: shape {at.shape}, expected (voxel_count, 3)")
    voxels = np.zeros(len(at), _arrays.voxel_dtype)
    voxels["x"], voxels["y"], voxels["z"] = at.T
    voxels["rgba"] = rgba
    voxels["material"] = material
    return voxels


def make_points(positions: npt.ArrayLike, colors: npt.ArrayLike = 0, intensities: npt.ArrayLike = 0) -> _arrays.Array:
    """Records for Voxels.of_points from coordinates, colors and intensities, which are broadcast against each other.

    Args:
        positions: (point_count, 3) world coordinates.
        colors: (point_count, 3) RGB, 0 .. 65535.
        intensities: (point_count,) of returned light, 0 .. 65535.

    Returns:
        (point_count,) records of point_dtype.
    """
    at = np.asarray(positions, np.float64)
    if at.ndim != 2 or at.shape[1] != 3:
        raise ValueError(f"positions: shape {at.shape}, expected (point_count, 3)")
    points = np.zeros(len(at), _arrays.point_dtype)
    points["at"] = at
    for name, field, values in (("colors", "rgb", colors), ("intensities", "intensity", intensities)):
        array = _arrays.array(name, values)
        if array.dtype.kind not in "iu" and array.size:
            raise TypeError(f"{name}: dtype {array.dtype}, expected integers")
        if array.size and not (int(array.min()) >= 0 and int(array.max()) <= 65535):
            raise ValueError(f"{name}: not all in 0 .. 65535")
        points[field] = array
    return points


class Voxels(Handle):
    """A list of voxels. It holds each place once, in Morton order from its least corner on; of several voxels in one
    place the last one counts.

    Args:
        voxels: (voxel_count,) records of voxel_dtype, in any order, as make_voxels makes them.
        properties: of materials, texts by key: {material: {key: value}}.
        origin: (3,) world position of the least corner of voxel (0, 0, 0).
        voxel_edge: width of a voxel, world units, above 0.
        normals: (voxel_count, 3) int16 of the voxels, in 32767ths, of a length of at most 1; 0, 0, 0: none of that
            voxel. None: the voxels have no normals.

    Attributes:
        file_info: what the file holds, of a list from Voxels.load or Voxels.load_parts; else None.
        left_out: what the file holds and the list does not, in one line, such as "8 layers, 1 group"; else "".
        points_info: what the cloud holds, of a list from Voxels.load_points or Voxels.of_points; else None.

    Raises:
        InvalidArgumentError: a number is out of range, or the voxels are too far apart.
        OutOfHostMemoryError
    """

    file_info: Optional[_generated.VoxelFileInfo] = None
    left_out: str = ""
    points_info: Optional[_generated.PointsInfo] = None

    def __init__(
        self,
        voxels: _arrays.Array,
        *,
        properties: Optional[Mapping[int, Mapping[str, str]]] = None,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        voxel_edge: float = 1.0,
        normals: Optional[_arrays.Array] = None,
    ) -> None:
        records = _arrays.exact_records("voxels", voxels, _arrays.voxel_dtype, "voxel_dtype")
        if not voxel_edge > 0:  # in C, 0 is 1
            raise ValueError(f"voxel_edge: {voxel_edge} is not above 0")
        source = _structs.new("svo_voxels_source")
        source.voxels = ffi.cast("svo_voxel *", records.ctypes.data)
        source.voxel_count = records.size
        source.origin = _arrays.three("origin", origin)
        source.voxel_edge = voxel_edge
        kept: list[Any] = []
        rows = []
        for material, values in (properties or {}).items():
            for key, value in values.items():
                texts = [ffi.new("char[]", part.encode()) for part in (key, value)]
                kept += texts
                rows.append((_arrays.integer("material", material), *texts))
        if normals is not None:
            of_voxels = _arrays.integers("normals", normals, np.int16, (records.size, 3))
            kept.append(of_voxels)
            source.normals = ffi.cast("int16_t *", of_voxels.ctypes.data)
        source.properties = list_of_rows = ffi.new("svo_voxel_property[]", rows)
        source.property_count = len(rows)
        self._create(lib.svo_voxels_create, source)
        del kept, list_of_rows

    # --- files ------------------------------------------------------------------------------------------------------

    @classmethod
    def load(
        cls, path: Path, *, hidden: bool = False, frame: int = 0, voxels_max: int = 0, axes: Axes = Axes.AUTO
    ) -> "Voxels":
        """Reads a .vox, .svx, .binvox, .nvdb, .vdb or .bt file; its bytes say which. Warnings go to the logger "svocl".

        Args:
            path: of the file.
            hidden: .vox: what hidden layers and nodes hold is read too.
            frame: .vox: the frame, or in a file without a scene the model.
            voxels_max: more voxels, before those in one place become one, are refused; 0: as many as memory holds.
            axes: which axis is up in the file. In the list it is y, but for Axes.KEEP.

        Raises:
            FileError: the file cannot be read.
            FileDamagedError: it is truncated, damaged or of another format.
            InvalidArgumentError: no such frame, or too many voxels.
            UnsupportedError: .svx, .nvdb or .vdb, and svocl was built without what they need.
        """
        need_io("Voxels.load")
        source, _kept = from_path(path)
        return cls._load(source, hidden, frame, voxels_max, axes)

    @classmethod
    def load_bytes(
        cls,
        content: Union[bytes, bytearray, memoryview],
        name: str = "bytes",
        *,
        hidden: bool = False,
        frame: int = 0,
        voxels_max: int = 0,
        axes: Axes = Axes.AUTO,
    ) -> "Voxels":
        """Voxels.load from memory.

        Args:
            content: of a file.
            name: stands for the path in messages.
            hidden, frame, voxels_max, axes: see Voxels.load.
        """
        need_io("Voxels.load_bytes")
        source, _kept = from_bytes(content, name)
        return cls._load(source, hidden, frame, voxels_max, axes)

    @classmethod
    def load_parts(
        cls, path: Path, *, hidden: bool = False, frame: int = 0, voxels_max: int = 0, axes: Axes = Axes.AUTO
    ) -> "list[VoxelPart]":
        """Reads a .vox file by its models, not as one list: each that has voxels and that the scene places, once, with
        where it is placed. Put together by their transforms, the parts are the list of Voxels.load; where instances
        overlap, that has the later one. The transforms are those of make_instances.

        Args:
            path: of the file.
            hidden, frame, axes: see Voxels.load; the first two choose instances.
            voxels_max: of each model, see Voxels.load.

        Returns:
            The parts by ascending number of their model.

        Raises:
            FileError: the file cannot be read.
            FileDamagedError: it is truncated or damaged.
            InvalidArgumentError: no such frame, or too many voxels.
            UnsupportedError: it is no .vox file of MagicaVoxel.
        """
        need_io("Voxels.load_parts")
        source, _kept = from_path(path)
        return cls._load_parts(source, hidden, frame, voxels_max, axes)

    @classmethod
    def load_parts_bytes(
        cls,
        content: Union[bytes, bytearray, memoryview],
        name: str = "bytes",
        *,
        hidden: bool = False,
        frame: int = 0,
        voxels_max: int = 0,
        axes: Axes = Axes.AUTO,
    ) -> "list[VoxelPart]":
        """Voxels.load_parts from memory.

        Args:
            content: of a file.
            name: stands for the path in messages.
            hidden, frame, voxels_max, axes: see Voxels.load_parts.
        """
        need_io("Voxels.load_parts_bytes")
        source, _kept = from_bytes(content, name)
        return cls._load_parts(source, hidden, frame, voxels_max, axes)

    @classmethod
    def load_points(
        cls,
        path: Path,
        depth: int = 0,
        *,
        voxel_edge: float = 0.0,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        edge: float = 0.0,
        memory_bytes: int = 0,
        voxels_max: int = 0,
        counts: bool = False,
        axes: Axes = Axes.AUTO,
    ) -> "Voxels":
        """Reads a point cloud, .las or .ply: each voxel has the mean color of its points, and Voxels.counts their
        number. Points are read twice, in blocks. Warnings of what is left out go to the logger "svocl".

        Args:
            path: of the file.
            depth: 1 .. 16: 2**depth voxels along the longest axis, or with edge along each; 0: 8.
            voxel_edge: width of a voxel, world units, in place of depth: planes at its whole multiples.
            origin, edge: the least corner and the width of a cube; points outside are left out.
            memory_bytes: most host memory of the call and of a build of the list; 0: what there is.
            voxels_max: more voxels are refused; 0: as many as memory_bytes holds.
            counts: the material of a voxel is the number of its points, at most 65534.
            axes: which axis is up in the file: Axes.AUTO is z in .las, y in .ply. In the list it is y.

        Raises:
            FileError: the file cannot be read.
            FileDamagedError: it is truncated, damaged or of another format.
            UnsupportedError: it is a .laz file; Voxels.of_points takes what another reader gives.
            OutOfHostMemoryError: also when memory_bytes has no room for the voxels.
        """
        need_io("Voxels.load_points")
        source, _kept = from_path(path)
        options = _points_options(depth, voxel_edge, origin, edge, memory_bytes, voxels_max, counts, axes)
        return cls._collect(lib.svo_points_load, source, options)

    @classmethod
    def of_points(
        cls,
        points: _arrays.Array,
        depth: int = 0,
        *,
        rgb_max: int = 0,
        voxel_edge: float = 0.0,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        edge: float = 0.0,
        memory_bytes: int = 0,
        voxels_max: int = 0,
        counts: bool = False,
        axes: Axes = Axes.AUTO,
    ) -> "Voxels":
        """The same of points in memory, such as those of a .laz file that laspy has read.

        Args:
            points: (point_count,) records of point_dtype, as make_points makes them.
            rgb_max: the greatest value of a channel, 255 or 65535; 0: 255 if none is above.
            depth, voxel_edge, origin, edge, memory_bytes, voxels_max, counts, axes: see Voxels.load_points.
        """
        need_io("Voxels.of_points")
        records = _arrays.exact_records("points", points, _arrays.point_dtype, "point_dtype")
        source = _structs.new("svo_points_source")
        source.points = ffi.cast("svo_point *", records.ctypes.data)
        source.point_count = records.size
        source.rgb_max = _arrays.integer("rgb_max", rgb_max)
        options = _points_options(depth, voxel_edge, origin, edge, memory_bytes, voxels_max, counts, axes)
        return cls._collect(lib.svo_points_collect, source, options)

    @staticmethod
    def copy_vox(path: Path, to: Path) -> _generated.VoxelFileInfo:
        """Writes a .vox file again with all that it holds, after the checks of Voxels.load: models, instances, names,
        layers, groups, frames, palette, materials, cameras, settings, notes and chunks that svocl does not know.

        Args:
            path: of a .vox file of MagicaVoxel.
            to: of the file that is written, whole or not at all.

        Returns:
            What the file holds.

        Raises:
            FileError: a file cannot be read or written.
            FileDamagedError: it is truncated or damaged.
            UnsupportedError: it has another format.
        """
        need_io("Voxels.copy_vox")
        source, _kept = from_path(path)
        sink, _also_kept = to_path(to)
        info = _structs.new("svo_voxel_file_info")
        message = ffi.new("svo_message *")
        status = call(lib.svo_voxels_copy_vox, source, sink, ffi.NULL, info, message)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        return _structs.read_file_info(info, _generated.VoxelFileInfo)

    def set_axes(self, axes: Axes) -> None:
        """Says which axis is up in files that the list is written to: at first what Voxels.load was given, else
        Axes.AUTO.

        Args:
            axes: an Axes.
        """
        with self._use() as pointer:
            call(lib.svo_voxels_set_axes, pointer, Axes(axes))

    def save(self, path: Path) -> _generated.VoxelsSaveInfo:
        """Writes a file, whole or not at all; its suffix says the format: .vox, .svx, .binvox, .nvdb, .vdb, .bt, .ply
        (points) or .obj (the outer faces of cubes).

        Args:
            path: of the file.

        Returns:
            What was written.

        Raises:
            FileError: the file cannot be written.
            InvalidArgumentError: no known suffix, or more than the format can hold.
            UnsupportedError: .svx, .nvdb or .vdb, and svocl was built without what they need.
        """
        need_io("Voxels.save")
        return self._write(lib.svo_voxels_save, path)

    def save_faces(self, path: Path) -> _generated.VoxelsSaveInfo:
        """Writes the surface as a mesh of rectangles, whole or not at all: faces of one plane and color are merged. It
        is closed, sides may end in the middle of others, and on the same grid it is read back as the same voxels.

        Args:
            path: of the file, .ply or .obj.

        Returns:
            What was written: faces rectangles, of voxel_faces faces.

        Raises:
            FileError: the file cannot be written.
            InvalidArgumentError: another suffix, or voxels too far out for floats.
        """
        need_io("Voxels.save_faces")
        return self._write(lib.svo_voxels_save_faces, path)

    # --- trees ------------------------------------------------------------------------------------------------------

    @classmethod
    def of_tree(cls, tree: Tree) -> "Voxels":
        """The leaves of a tree, downloading it first if need be: each with the leaf's color, or white, and its
        material, or 0. Voxels.info has the origin and the width of a voxel."""
        made = cls.__new__(cls)
        with tree._downloaded(None) as pointer:
            made._create(lib.svo_tree_get_voxels, pointer)
        return made

    def plan(
        self,
        device: "Device",
        depth: int = 0,
        *,
        need: Need = Need.DEFAULT,
        worst_case_nodes: bool = False,
        chunk_bytes: int = 0,
        progress: Optional[_progress.Progress] = None,
    ) -> Plan:
        """Plans the tree of the list: one leaf per voxel, with its color and material.

        Args:
            device: where it is built.
            depth: Voxels.info.depth .. 16; 0: that least one.
            need: Need.COLOR, Need.MATERIAL, both, or Need.NONE; Need.DEFAULT is both.
            worst_case_nodes, chunk_bytes, progress: see Device.plan.

        Raises:
            InvalidArgumentError: a depth or option out of range.
            OutOfDeviceMemoryError, OutOfHostMemoryError
        """
        options = _structs.new("svo_plan_options")
        options.builder = Builder.SORTED
        options.need = _arrays.integer("need", need)
        options.worst_case_nodes = bool(worst_case_nodes)
        options.chunk_bytes = _arrays.integer("chunk_bytes", chunk_bytes, 64)
        if not isinstance(device, Handle):
            raise TypeError(f"device: {type(device).__name__}, expected svocl.Device")
        number = _arrays.integer("depth", depth)
        out = ffi.new("svo_plan **")
        with _progress.opened(progress) as function:
            if function is not None:
                user = ffi.new_handle(function)
                options.progress, options.progress_user = lib.svocl_python_progress, user
            with device._use() as at, self._use() as pointer:
                arguments = (at, pointer, number, options, out)
                status = call(lib.svo_voxels_plan, *arguments, undo=lambda: lib.svo_plan_destroy(out))
                if status != lib.SVO_OK:
                    raise error(status, device._native.device_message())
                lib.svo_plan_set_progress(out[0], ffi.NULL, ffi.NULL)
                return Plan(out[0], device._native, progress)

    def build(
        self,
        device: "Device",
        depth: int = 0,
        *,
        queue: Any = None,
        progress: Optional[_progress.Progress] = None,
        **options: Any,
    ) -> Tree:
        """Plans and builds the tree of the list in one call.

        Args:
            device, depth, options: see Voxels.plan.
            queue, progress: see Plan.build.
        """
        with self.plan(device, depth, **options) as plan:
            return plan.build(queue=queue, progress=progress)

    # --- what it holds ----------------------------------------------------------------------------------------------

    @property
    def info(self) -> _generated.VoxelsInfo:
        """What the list holds."""
        struct = _structs.new("svo_voxels_info")
        self._call(lib.svo_voxels_get_info, struct)
        return _structs.read(struct, _generated.VoxelsInfo)

    @property
    def records(self) -> _arrays.Array:
        """(voxel_count,) records of voxel_dtype in the list's memory, read-only; valid when the list is closed."""
        count = self.info.voxel_count
        with self._use() as pointer:
            found = view(self._native, lib.svo_voxels_get(pointer), np.uint8, (count * _arrays.voxel_dtype.itemsize,))
        return np.empty(0, _arrays.voxel_dtype) if found is None else found.view(_arrays.voxel_dtype)

    @property
    def counts(self) -> Optional[_arrays.Array]:
        """(voxel_count,) numbers of points, in the order of Voxels.records, read-only and valid when the list is
        closed; None: the list is of no point cloud."""
        count = self.info.voxel_count
        with self._use() as pointer:
            address = lib.svo_voxels_get_counts(pointer)
            if address == ffi.NULL:
                return None
            found = view(self._native, address, np.uint64, (count,))
        return np.empty(0, np.uint64) if found is None else found

    @property
    def normals(self) -> Optional[_arrays.Array]:
        """(voxel_count, 3) int16, in the order of Voxels.records, in 32767ths, read-only and valid when the list is
        closed; 0, 0, 0: none of that voxel. None: the voxels have no normals."""
        count = self.info.voxel_count
        with self._use() as pointer:
            address = lib.svo_voxels_get_normals(pointer)
            if address == ffi.NULL:
                return None
            found = view(self._native, address, np.int16, (count, 3))
        return np.empty((0, 3), np.int16) if found is None else found

    @property
    def properties(self) -> dict[int, dict[str, str]]:
        """The properties of materials: {material: {key: value}}."""
        count = self.info.property_count
        found: dict[int, dict[str, str]] = {}
        with self._use() as pointer:
            rows = lib.svo_voxels_get_properties(pointer)
            for index in range(count):
                row = rows[index]
                found.setdefault(int(row.material), {})[text(row.key)] = text(row.value)
        return found

    # --- shared -----------------------------------------------------------------------------------------------------

    @classmethod
    def _load(cls, source: Any, hidden: bool, frame: int, voxels_max: int, axes: Axes) -> "Voxels":
        options = _load_options(hidden, frame, voxels_max, axes)
        info = _structs.new("svo_voxel_file_info")
        made = cls.__new__(cls)
        made._create(lib.svo_voxels_load, source, options, info=info)
        made._describe(info)
        return made

    @classmethod
    def _load_parts(cls, source: Any, hidden: bool, frame: int, voxels_max: int, axes: Axes) -> "list[VoxelPart]":
        options = _load_options(hidden, frame, voxels_max, axes)
        info = _structs.new("svo_voxel_file_info")
        message = ffi.new("svo_message *")
        parts: list[VoxelPart] = []

        def take(part: Any) -> None:  # which is borrowed for the call
            count = int(part.transform_count)
            matrices = np.frombuffer(ffi.buffer(part.transforms, count * 12 * 8), np.float64)
            voxels = cls._copy(part.voxels, axes)
            parts.append(VoxelPart(int(part.model), voxels, matrices.reshape(count, 3, 4).copy()))

        user = ffi.new_handle(take)
        arguments = (source, options, lib.svocl_python_voxel_part, user, info, message)
        status = call(lib.svo_voxels_load_parts, *arguments)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        for part in parts:
            part.voxels._describe(info)
        return parts

    @classmethod
    def _copy(cls, pointer: Any, axes: Axes) -> "Voxels":
        """A list of its own, of one that is borrowed."""
        info = _structs.new("svo_voxels_info")
        call(lib.svo_voxels_get_info, pointer, info)
        source = _structs.new("svo_voxels_source")
        source.voxels, source.voxel_count = lib.svo_voxels_get(pointer), info.voxel_count
        source.normals = lib.svo_voxels_get_normals(pointer)
        source.properties, source.property_count = lib.svo_voxels_get_properties(pointer), info.property_count
        source.origin, source.voxel_edge = info.origin, info.voxel_edge
        made = cls.__new__(cls)
        made._create(lib.svo_voxels_create, source)
        made.set_axes(axes)
        return made

    def _describe(self, info: Any) -> None:
        message = ffi.new("svo_message *")
        call(lib.svo_voxels_left_out, info, message)
        self.file_info = _structs.read_file_info(info, _generated.VoxelFileInfo)
        self.left_out = text(message.text)

    @classmethod
    def _collect(cls, function: Any, source: Any, options: Any) -> "Voxels":
        info = _structs.new("svo_points_info")
        made = cls.__new__(cls)
        made._create(function, source, options, info=info)
        made.points_info = _structs.read_file_info(info, _generated.PointsInfo)
        return made

    def _write(self, function: Any, path: Path) -> _generated.VoxelsSaveInfo:
        sink, _kept = to_path(path)
        info = _structs.new("svo_voxels_save_info")
        message = ffi.new("svo_message *")
        with self._use() as pointer:
            status = call(function, pointer, sink, lib.SVO_VOXEL_FORMAT_AUTO, info, message)
            if status != lib.SVO_OK:
                raise error(status, text(message.text))
        return _structs.read_file_info(info, _generated.VoxelsSaveInfo)

    def _create(self, function: Any, *arguments: Any, info: Any = None) -> None:
        out = ffi.new("svo_voxels **")
        message = ffi.new("svo_message *")
        results = [out, message] if info is None else [out, info, message]
        status = call(function, *arguments, *results, undo=lambda: lib.svo_voxels_destroy(out))
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        self._open(Native(out[0], _destroy, Guard(), None))

    def __repr__(self) -> str:
        return "<svocl.Voxels: closed>" if self.closed else f"<svocl.Voxels: {self.info.voxel_count} voxels>"


class VoxelPart(NamedTuple):
    """A model of a .vox file, and where its scene places it."""

    model: int
    """Its number in the file, from 0 on."""
    voxels: Voxels
    """Around the origin, as turned as the list of the file; at least one voxel."""
    transforms: "np.ndarray[Any, Any]"
    """(instance_count, 3, 4) float64: where the list is in that of the file, with rows of one 1 or -1 and a whole
    number, so that voxels come to lie on voxels."""


def _load_options(hidden: bool, frame: int, voxels_max: int, axes: Axes) -> Any:
    options = _structs.new("svo_voxels_load_options")
    options.hidden = bool(hidden)
    options.frame = _arrays.integer("frame", frame)
    options.voxels_max = _arrays.integer("voxels_max", voxels_max, 64)
    options.axes = Axes(axes)
    options.log = lib.svocl_python_log
    return options


def _points_options(
    depth: int,
    voxel_edge: float,
    origin: Sequence[float],
    edge: float,
    memory_bytes: int,
    voxels_max: int,
    counts: bool,
    axes: Axes,
) -> Any:
    options = _structs.new("svo_points_options")
    options.depth = _arrays.integer("depth", depth)
    options.voxel_edge = voxel_edge
    options.origin = _arrays.three("origin", origin)
    options.edge = edge
    options.memory_bytes = _arrays.integer("memory_bytes", memory_bytes, 64)
    options.voxels_max = _arrays.integer("voxels_max", voxels_max, 64)
    options.counts = bool(counts)
    options.axes = Axes(axes)
    options.log = lib.svocl_python_log
    return options


def _destroy(pointer: Any) -> None:
    lib.svo_voxels_destroy(ffi.new("svo_voxels **", pointer))
