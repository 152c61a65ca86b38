# SPDX-License-Identifier: MIT
"""Triangle meshes as numpy arrays."""

import os
from collections.abc import Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arrays, _generated, _opencl, _structs
from ._callbacks import call
from ._errors import error, text
from ._generated import Axes, Status, UnsupportedError, Wrap
from ._handle import Guard, Native, view
from ._native import ffi, lib

Path = Union[str, bytes, "os.PathLike[str]", "os.PathLike[bytes]"]


class Texture(NamedTuple):
    """An RGBA8 image, sampled bilinearly."""

    rgba: npt.NDArray[np.uint8]
    """(height, width, 4), top to bottom; v = 0 is the first row. Each side has 1 .. 16384 texels."""
    wrap_u: Wrap = Wrap.REPEAT
    wrap_v: Wrap = Wrap.REPEAT


class Material(NamedTuple):
    """A material. A triangle's color is vertex color * base color * texel."""

    rgba: tuple[int, int, int, int] = (255, 255, 255, 255)
    """Base color, 0 .. 255."""
    texture_index: Optional[int] = None
    """Into Mesh.textures; None: no texture."""


class Finish(NamedTuple):
    """What a material does besides its color."""

    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Radiance that it emits, linear red, green, blue, not negative."""
    specular: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Specular color, linear, 0 .. 1."""
    exponent: float = 0.0
    """Of the Phong lobe, not negative."""


class NormalMap(NamedTuple):
    """How a material bends normals, for pictures of light: a texture of unit vectors in tangent space, as glTF 2.0 has
    them."""

    texture_index: Optional[int] = None
    """Into Mesh.textures; None: no map."""
    scale: float = 1.0
    """What x and y are multiplied by, finite."""


class Mesh:
    """A triangle mesh in host memory.

    Arrays of the types below that are C-contiguous are used without a copy; the library reads them when a plan is made.
    Float arrays may also be float64; positions then keep their precision, the others are rounded. Integers may have
    other types. Everything else raises TypeError or ValueError.

    Args:
        positions: (vertex_count, 3) float32 or float64: x, y, z in any unit.
        indices: (triangle_count, 3) uint32; None: three consecutive vertices each are a triangle. Results name
            triangles by their row. Rows with an index out of range are refused by the plan, and counted.
        normals: (vertex_count, 3) float32, of any length; zero or not finite: the triangle's own.
        colors: (vertex_count, 4) uint8: RGBA.
        uvs: (vertex_count, 2) float32.
        triangle_materials: (triangle_count,) uint16: into materials.
        materials: at most 65535; none: white.
        textures: of the materials.
        finishes: one for each material; none: all are diffuse. Builds do not read them.
        normal_maps: one for each material, for Light.set_mesh; none: there are none. Builds do not read them.

    Attributes: the arguments, as arrays and tuples; of a mesh from read_mesh also import_info, and file_vertices,
    (count,) uint32: for each vertex of a PLY or OFF file and each "v" of an OBJ file one of the mesh's vertices that
    lie there, or NO_VERTEX where no face has it; None of other formats.
    """

    positions: _arrays.Array
    indices: Optional[npt.NDArray[np.uint32]]
    normals: Optional[npt.NDArray[np.float32]]
    colors: Optional[npt.NDArray[np.uint8]]
    uvs: Optional[npt.NDArray[np.float32]]
    triangle_materials: Optional[npt.NDArray[np.uint16]]
    materials: tuple[Material, ...]
    textures: tuple[Texture, ...]
    finishes: tuple[Finish, ...]
    normal_maps: tuple[NormalMap, ...]
    import_info: Optional[_generated.ImportInfo] = None
    file_vertices: Optional[npt.NDArray[np.uint32]] = None

    def __init__(
        self,
        positions: npt.ArrayLike,
        indices: Optional[npt.ArrayLike] = None,
        *,
        normals: Optional[npt.ArrayLike] = None,
        colors: Optional[npt.ArrayLike] = None,
        uvs: Optional[npt.ArrayLike] = None,
        triangle_materials: Optional[npt.ArrayLike] = None,
        materials: Sequence[Material] = (),
        textures: Sequence[Texture] = (),
        finishes: Sequence[Finish] = (),
        normal_maps: Sequence[NormalMap] = (),
    ) -> None:
        self.positions = _arrays.floats("positions", positions, ("vertex_count", 3), double=True)
        vertices = self.vertex_count
        self.indices = None
        if indices is not None:
            self.indices = _arrays.integers("indices", indices, np.uint32, ("triangle_count", 3))
        elif vertices % 3 != 0:
            raise ValueError(f"positions: shape ({vertices}, 3), expected (3 * triangle_count, 3) without indices")
        self.normals = None if normals is None else _arrays.floats("normals", normals, (vertices, 3))
        self.colors = None if colors is None else _arrays.integers("colors", colors, np.uint8, (vertices, 4))
        self.uvs = None if uvs is None else _arrays.floats("uvs", uvs, (vertices, 2))
        self.triangle_materials = None
        if triangle_materials is not None:
            shape = (self.triangle_count,)
            self.triangle_materials = _arrays.integers("triangle_materials", triangle_materials, np.uint16, shape)
        self.materials = tuple(materials)
        self.textures = tuple(_texture(f"textures[{i}]", texture) for i, texture in enumerate(textures))
        self.finishes = tuple(finishes)
        self.normal_maps = tuple(normal_maps)
        for name, items in (("finishes", self.finishes), ("normal_maps", self.normal_maps)):
            if items and len(items) != len(self.materials):
                raise ValueError(f"{name}: {len(items)}, expected {len(self.materials)}, one for each material")

    @property
    def vertex_count(self) -> int:
        return len(self.positions)

    @property
    def triangle_count(self) -> int:
        return self.vertex_count // 3 if self.indices is None else len(self.indices)

    @staticmethod
    def from_trimesh(source: Any, *, normals: bool = False) -> "Mesh":
        """svocl.from_trimesh."""
        from ._trimesh import from_trimesh  # which needs Mesh

        return from_trimesh(source, normals=normals)

    def to_trimesh(self) -> Any:
        """The mesh for trimesh: a trimesh.Trimesh, or where triangles have several materials a trimesh.Scene with a
        mesh for each of these. With texture coordinates it has PBRMaterials and their images, which need pillow; else
        the materials' base colors are in the colors of the vertices.

        Raises:
            ImportError: trimesh, or pillow for a texture, is not installed.
        """
        from ._trimesh import to_trimesh

        return to_trimesh(self)

    def voxel_grid(self, voxel_edge: float) -> tuple[tuple[float, float, float], float, int]:
        """The grid whose voxels have a given width, with planes at its whole multiples, and the least depth that holds
        the mesh: (origin, edge, depth) for Device.plan and Device.build.

        Args:
            voxel_edge: width of a voxel, world units, above 0.

        Raises:
            InvalidArgumentError: there would be more than 65,536 voxels along an axis.
        """
        mesh, _kept = self._struct()
        origin, edge = ffi.new("double[3]"), ffi.new("double *")
        depth, message = ffi.new("unsigned *"), ffi.new("svo_message *")
        status = lib.svo_mesh_voxel_grid(mesh, voxel_edge, origin, edge, depth, message)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        return (origin[0], origin[1], origin[2]), edge[0], depth[0]

    def __repr__(self) -> str:
        return f"<svocl.Mesh: {self.vertex_count} vertices, {self.triangle_count} triangles>"

    def _struct(self) -> tuple[Any, list[Any]]:
        """The svo_mesh, and what has to live as long as it does."""
        mesh = _structs.new("svo_mesh")
        kept: list[Any] = [mesh]

        def keep(pointer: Any) -> Any:
            kept.append(pointer)
            return pointer

        if self.positions.dtype == np.float64:
            mesh.positions_double = keep(_arrays.pointer(self.positions, "double"))
        else:
            mesh.positions = keep(_arrays.pointer(self.positions, "float"))
        mesh.vertex_count = self.vertex_count
        mesh.indices = keep(_arrays.pointer(self.indices, "uint32_t"))
        mesh.triangle_count = self.triangle_count
        mesh.normals = keep(_arrays.pointer(self.normals, "float"))
        mesh.colors = keep(_arrays.pointer(self.colors, "uint8_t"))
        mesh.uvs = keep(_arrays.pointer(self.uvs, "float"))
        mesh.triangle_materials = keep(_arrays.pointer(self.triangle_materials, "uint16_t"))
        if self.materials:
            mesh.materials = keep(ffi.new("svo_material[]", [_material(material) for material in self.materials]))
            mesh.material_count = len(self.materials)
        if self.finishes:
            mesh.finishes = keep(ffi.new("svo_finish[]", [finish_record(finish) for finish in self.finishes]))
        if self.normal_maps:
            mesh.normal_maps = keep(ffi.new("svo_normal_map[]", [_normal_map(map) for map in self.normal_maps]))
        if self.textures:
            mesh.textures = keep(ffi.new("svo_texture[]", len(self.textures)))
            mesh.texture_count = len(self.textures)
            for struct, texture in zip(mesh.textures[0 : len(self.textures)], self.textures):
                struct.rgba = keep(_arrays.pointer(texture.rgba, "uint8_t"))
                struct.height, struct.width = texture.rgba.shape[:2]
                struct.wrap_u, struct.wrap_v = int(texture.wrap_u), int(texture.wrap_v)
        return mesh, kept


class DeviceMesh:
    """A triangle mesh in OpenCL buffers, which stays on the device: Device.plan reads it there.

    Each array is a pyopencl.array.Array, or any object with shape, dtype and either base_data or __cl_mem__ (a cl_mem's
    address, or a function that returns it); offset (bytes) and strides are optional. Elements of a row are packed; rows
    may be apart, but for those of indices.

    Args:
        positions: (vertex_count, 3) float32.
        indices: (triangle_count, 3) uint32 or uint16; None: three consecutive vertices each are a triangle.
        normals: (vertex_count, 3) float32.
        colors: (vertex_count, 4) uint8.
        uvs: (vertex_count, 2) float32.
        triangle_materials: (triangle_count,) uint16.
        materials, textures: see Mesh; on the host.
        wait_for: pyopencl.Events that the buffers are ready after, or their int_ptrs. The events that an array has, as
            pyopencl's arrays do, are waited for too.
    """

    def __init__(
        self,
        positions: Any,
        indices: Any = None,
        *,
        normals: Any = None,
        colors: Any = None,
        uvs: Any = None,
        triangle_materials: Any = None,
        materials: Sequence[Material] = (),
        textures: Sequence[Texture] = (),
        wait_for: Sequence[Any] = (),
    ) -> None:
        self.vertex_count: int = _rows("positions", positions)
        if indices is None and self.vertex_count % 3 != 0:
            raise ValueError(f"positions: shape ({self.vertex_count}, 3), expected (3 * triangle_count, 3)")
        self.triangle_count: int = self.vertex_count // 3 if indices is None else _rows("indices", indices)
        vertices, triangles = self.vertex_count, self.triangle_count
        self._arrays = {
            "positions": _device_array("positions", positions, (vertices, 3), (np.float32,)),
            "indices": _device_array("indices", indices, (triangles, 3), (np.uint32, np.uint16)),
            "normals": _device_array("normals", normals, (vertices, 3), (np.float32,)),
            "colors": _device_array("colors", colors, (vertices, 4), (np.uint8,)),
            "uvs": _device_array("uvs", uvs, (vertices, 2), (np.float32,)),
            "triangle_materials": _device_array("triangle_materials", triangle_materials, (triangles,), (np.uint16,)),
        }
        if self._arrays["indices"] is not None and self._arrays["indices"][2] != 3 * np.dtype(indices.dtype).itemsize:
            raise ValueError(f"indices: strides {tuple(indices.strides)}, expected a packed array")
        self._kept = [positions, indices, normals, colors, uvs, triangle_materials]
        self._index_bytes = 4 if indices is None else np.dtype(indices.dtype).itemsize
        self.wait_for: tuple[Any, ...] = tuple(wait_for)
        # What is on the host is a mesh without vertices.
        self._host = Mesh(np.zeros((0, 3), np.float32), materials=materials, textures=textures)

    def _events(self) -> list[Any]:
        """What the buffers are ready after."""
        return [*self.wait_for, *(event for array in self._kept for event in getattr(array, "events", None) or ())]

    def __repr__(self) -> str:
        return f"<svocl.DeviceMesh: {self.vertex_count} vertices, {self.triangle_count} triangles>"

    def _struct(self) -> tuple[Any, list[Any]]:
        """The svo_mesh_buffers, and what has to live as long as it does."""
        host, kept = self._host._struct()
        buffers = _structs.new("svo_mesh_buffers")
        buffers.vertex_count, buffers.triangle_count = self.vertex_count, self.triangle_count
        buffers.index_bytes = self._index_bytes
        for name, place in self._arrays.items():
            if place is not None:
                target = getattr(buffers, name)
                target.memory, target.offset_bytes, target.stride_bytes = place
        buffers.indices.stride_bytes = 0  # of one index to the next, in C
        buffers.materials, buffers.material_count = host.materials, host.material_count
        buffers.textures, buffers.texture_count = host.textures, host.texture_count
        return buffers, [buffers, self._kept, *kept]


def _rows(name: str, array: Any) -> int:
    shape = getattr(array, "shape", None)
    if not isinstance(shape, tuple) or len(shape) == 0:
        raise TypeError(f"{name}: {type(array).__name__}, expected an array in a device buffer, with a shape")
    return int(shape[0])


def _device_array(
    name: str, array: Any, shape: tuple[int, ...], kinds: tuple[Any, ...]
) -> Optional[tuple[Any, int, int]]:
    """The cl_mem, the offset and the stride of an array in a device buffer; None for None or an empty one."""
    if array is None or shape[0] == 0:
        return None
    expected = " or ".join(np.dtype(kind).name for kind in kinds)
    if not hasattr(array, "shape") or not hasattr(array, "dtype"):
        raise TypeError(f"{name}: {type(array).__name__}, expected an array in a device buffer, of {expected}")
    if tuple(array.shape) != shape:
        raise ValueError(f"{name}: shape {tuple(array.shape)}, expected {shape}")
    dtype = np.dtype(array.dtype)
    if dtype not in [np.dtype(kind) for kind in kinds]:
        raise TypeError(f"{name}: dtype {dtype}, expected {expected}")
    memory = getattr(array, "__cl_mem__", None)
    memory = memory() if callable(memory) else memory
    memory = getattr(array, "base_data", None) if memory is None else memory
    if memory is None:
        raise TypeError(f"{name}: {type(array).__name__} has neither __cl_mem__ nor base_data, a cl_mem")
    packed = dtype.itemsize * (shape[1] if len(shape) > 1 else 1)
    strides = getattr(array, "strides", None) or (packed, dtype.itemsize)[: len(shape)]
    if strides[0] < packed or (len(shape) > 1 and strides[1] != dtype.itemsize):
        raise ValueError(f"{name}: strides {tuple(strides)}, expected packed rows ({packed} bytes) in order")
    return _opencl.pointer("cl_mem", memory, name), int(getattr(array, "offset", 0)), int(strides[0])


def mesh_of(value: Any) -> Mesh:
    """The Mesh of an argument: a Mesh, or what has vertices and faces, or vertices and triangles, such as meshes of
    trimesh and Open3D. Their geometry is taken."""
    if isinstance(value, Mesh):
        return value
    vertices = getattr(value, "vertices", None)
    faces = getattr(value, "faces", None)
    if faces is None:  # trimesh has triangles too, of coordinates, which it makes when asked
        faces = getattr(value, "triangles", None)
    if vertices is None or faces is None:
        raise TypeError(f"mesh: {type(value).__name__}, expected svocl.Mesh or an object with vertices and faces")
    positions, indices = _arrays.array("vertices", vertices), _arrays.array("faces", faces)
    return Mesh(positions.astype(np.float64) if positions.dtype.kind in "iu" else positions, indices)


def _texture(name: str, texture: Texture) -> Texture:
    rgba = _arrays.integers(f"{name}.rgba", texture.rgba, np.uint8, ("height", "width", 4))
    return Texture(rgba, Wrap(texture.wrap_u), Wrap(texture.wrap_v))


def _material(material: Material) -> tuple[list[int], int]:
    rgba = _arrays.integers("Material.rgba", material.rgba, np.uint8, (4,))
    index = material.texture_index
    return rgba.tolist(), lib.SVO_NO_TEXTURE if index is None else _arrays.integer("Material.texture_index", index)


def _normal_map(map: NormalMap) -> tuple[int, float]:
    index = map.texture_index
    named = lib.SVO_NO_TEXTURE if index is None else _arrays.integer("NormalMap.texture_index", index)
    return named, map.scale


def finish_record(finish: Finish) -> tuple[list[float], list[float], float]:
    emission = _arrays.floats("Finish.emission", finish.emission, (3,))
    specular = _arrays.floats("Finish.specular", finish.specular, (3,))
    return emission.tolist(), specular.tolist(), float(finish.exponent)


NO_VERTEX: int = 2**32 - 1
"""In Mesh.file_vertices: a vertex of the file that no face has."""

has_io: bool = hasattr(lib, "svo_import_file")
"""Whether the package was built with svocl::io: .svo files and mesh import."""


def need_io(function: str) -> None:
    if not has_io:
        raise UnsupportedError(f"{function}: svocl was built without files (SVOCL_IO=OFF)", Status.UNSUPPORTED)


def encode(path: Path) -> bytes:
    name = os.fsencode(path)
    if b"\0" in name:
        raise ValueError(f"path: {path!r} contains a null byte")
    return name


def from_path(path: Path) -> tuple[Any, list[Any]]:
    """The svo_source of a file, and what has to live as long as it does."""
    return _at_path("svo_source *", path)


def from_bytes(content: Union[bytes, bytearray, memoryview], name: str) -> tuple[Any, list[Any]]:
    """The svo_source of a file's content, and what has to live as long as it does; name stands for the path."""
    memory, chars = ffi.from_buffer(content), ffi.new("char[]", name.encode())
    source = ffi.new("svo_source *", {"bytes": memory, "byte_count": len(memory), "name": chars})
    return source[0], [source, memory, chars]


def to_path(path: Path) -> tuple[Any, list[Any]]:
    """The svo_sink of a file, and what has to live as long as it does."""
    return _at_path("svo_sink *", path)


def _at_path(kind: str, path: Path) -> tuple[Any, list[Any]]:
    chars = ffi.new("char[]", encode(path))
    struct = ffi.new(kind, {"path": chars})
    return struct[0], [struct, chars]


def read_mesh(
    path: Path,
    *,
    memory_limit_bytes: int = 0,
    time_limit_seconds: int = 0,
    strict: bool = False,
    axes: Axes = Axes.AUTO,
    weld: float = 0.0,
    normal_maps: bool = False,
) -> Mesh:
    """Reads a mesh file: OBJ with MTL, PLY, STL, OFF and glTF by the library's own readers, others by assimp.

    The file is read in a process of its own, so that a reader that crashes or hangs ends in an exception. Warnings go
    to the logger "svocl"; Mesh.import_info has the counts. The arrays of the mesh are read-only.

    Args:
        path: of the file.
        memory_limit_bytes: address space of that process; 0: the library's default.
        time_limit_seconds: wall clock, of all; 0: 5 s, and 1 s for each 10**6 bytes of the file, of the files that it
            names, and of the texels of its textures.
        strict: what would be a warning is an error.
        axes: Axes.Z_UP: z is up in the file, so that it is turned. Else it is as the file says.
        weld: a distance in the mesh's units, 0 or more. A vertex that lies no farther than this from an earlier one
            that stayed gets the position of the first of these, so that cracks close. 0: positions stay as they are.
        normal_maps: the mesh has the normal maps of its materials, and their textures, for Light.set_mesh.

    Raises:
        InvalidArgumentError: weld is negative or not finite.
        FileError: missing or unreadable.
        ImportFailedError: not understood, no triangle, a crash, a limit, or a warning where strict.
    """
    need_io("read_mesh")
    options = _structs.new("svo_import_options")
    options.memory_limit_bytes = _arrays.integer("memory_limit_bytes", memory_limit_bytes, 64)
    options.time_limit_seconds = _arrays.integer("time_limit_seconds", time_limit_seconds)
    options.strict = bool(strict)
    options.axes = Axes(axes)
    options.weld = weld
    options.normal_maps = bool(normal_maps)
    helper = os.path.join(os.path.dirname(os.path.abspath(__file__)), "svocl-import")
    program = ffi.new("char[]", encode(helper))  # the wheel's; Debian's package uses that of the shared library
    options.child_program = program if os.path.exists(helper) else ffi.NULL
    out = ffi.new("svo_import **")
    message = ffi.new("svo_message *")
    arguments = (encode(path), options, lib.svocl_python_log, ffi.NULL, out, message)
    status = call(lib.svo_import_file, *arguments, undo=lambda: lib.svo_import_destroy(out))
    if status != lib.SVO_OK:
        raise error(status, text(message.text))
    return _imported(Native(out[0], _destroy_import, Guard(), None))


def _destroy_import(pointer: Any) -> None:
    lib.svo_import_destroy(ffi.new("svo_import **", pointer))


def _imported(native: Native) -> Mesh:
    """The mesh of an import, whose arrays look into its memory."""
    hold = native.hold()
    try:
        with native.use("import") as pointer:
            mesh = read_struct(native, lib.svo_import_mesh(pointer))
            info = _structs.new("svo_import_info")
            lib.svo_import_get_info(pointer, info)
            mesh.import_info = _structs.read(info, _generated.ImportInfo)
            count = ffi.new("size_t *")
            file_vertices = lib.svo_import_file_vertices(pointer, count)
            mesh.file_vertices = view(native, file_vertices, np.uint32, (count[0],))
            return mesh
    finally:
        native.drop(hold)


def read_struct(native: Native, struct: Any) -> Mesh:
    """The mesh of an svo_mesh in native memory. Under the guard."""
    vertices, triangles = struct.vertex_count, struct.triangle_count
    mesh = Mesh.__new__(Mesh)
    double = struct.positions == ffi.NULL
    positions = struct.positions_double if double else struct.positions
    found = view(native, positions, np.float64 if double else np.float32, (vertices, 3))
    mesh.positions = np.empty((0, 3), np.float32) if found is None else found
    mesh.indices = view(native, struct.indices, np.uint32, (triangles, 3))
    mesh.normals = view(native, struct.normals, np.float32, (vertices, 3))
    mesh.colors = view(native, struct.colors, np.uint8, (vertices, 4))
    mesh.uvs = view(native, struct.uvs, np.float32, (vertices, 2))
    mesh.triangle_materials = view(native, struct.triangle_materials, np.uint16, (triangles,))
    mesh.materials = tuple(_read_material(struct.materials[i]) for i in range(struct.material_count))
    mesh.textures = tuple(_read_texture(native, struct.textures[i]) for i in range(struct.texture_count))
    finish_count = 0 if struct.finishes == ffi.NULL else struct.material_count
    mesh.finishes = tuple(_read_finish(struct.finishes[i]) for i in range(finish_count))
    map_count = 0 if struct.normal_maps == ffi.NULL else struct.material_count
    mesh.normal_maps = tuple(_read_normal_map(struct.normal_maps[i]) for i in range(map_count))
    return mesh


def _read_material(struct: Any) -> Material:
    red, green, blue, alpha = struct.rgba
    index = struct.texture_index
    return Material((red, green, blue, alpha), None if index == lib.SVO_NO_TEXTURE else index)


def _read_finish(struct: Any) -> Finish:
    return Finish(tuple(struct.emission), tuple(struct.specular), struct.exponent)


def _read_normal_map(struct: Any) -> NormalMap:
    index = struct.texture_index
    return NormalMap(None if index == lib.SVO_NO_TEXTURE else index, struct.scale)


def _read_texture(native: Native, struct: Any) -> Texture:
    rgba = view(native, struct.rgba, np.uint8, (struct.height, struct.width, 4))
    assert rgba is not None
    return Texture(rgba, Wrap(struct.wrap_u), Wrap(struct.wrap_v))
