# SPDX-License-Identifier: MIT
"""Meshes from trimesh and back, with what they look like. trimesh is imported where a mesh is made for it alone."""

from collections.abc import Iterator
from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from ._errors import optional
from ._mesh import Finish, Material, Mesh, Texture

_WHITE = (255, 255, 255, 255)


class _Piece(NamedTuple):
    """A geometry in the coordinates of the whole."""

    positions: npt.NDArray[np.float64]
    indices: npt.NDArray[np.int64]
    normals: Optional[npt.NDArray[np.float64]]
    colors: Optional[npt.NDArray[np.uint8]]
    uvs: Optional[npt.NDArray[np.float64]]
    materials: npt.NDArray[np.int64]
    """Of the triangles: into the materials of all."""


class _Materials:
    """The materials of all geometries, each once. The first is white, of what has none."""

    def __init__(self) -> None:
        self.materials = [Material()]
        self.finishes = [Finish()]
        self.textures: list[Texture] = []
        self._indices: dict[int, int] = {}
        self._images: dict[int, int] = {}
        self._kept: list[Any] = []  # so that no id is another's

    def index(self, material: Any) -> int:
        if material is None:
            return 0
        if id(material) not in self._indices:
            self._kept.append(material)
            self._indices[id(material)] = len(self.materials)
            rgba, image, finish = _look(material)
            self.materials.append(Material(rgba, None if image is None else self._texture(image)))
            self.finishes.append(finish)
        return self._indices[id(material)]

    def _texture(self, image: Any) -> int:
        if id(image) not in self._images:
            self._kept.append(image)
            self._images[id(image)] = len(self.textures)
            self.textures.append(Texture(np.asarray(image.convert("RGBA"), np.uint8)))
        return self._images[id(image)]


def from_trimesh(source: Any, *, normals: bool = False) -> Mesh:
    """A Mesh from a trimesh.Trimesh or a trimesh.Scene, with what it looks like.

    Of a scene each instance of a mesh is taken, in the scene's coordinates; other geometry, such as points and paths,
    is left out. Taken are colors of vertices and of faces (whose triangles then share no vertices), texture
    coordinates, and of materials the base color, its image and the emitted light. What else a material has, such as
    metal, roughness and further images, is left out. trimesh does not keep how a texture continues beyond its edges:
    it repeats.

    Args:
        source: a trimesh.Trimesh or a trimesh.Scene.
        normals: take the vertex normals, which trimesh computes where a file had none. Else triangles have their own.

    Raises:
        TypeError: neither a mesh nor a scene of trimesh.
        ValueError: a scene without a mesh.
    """
    looks = _Materials()
    pieces = [_piece(mesh, matrix, normals, looks) for mesh, matrix in _instances(source)]
    if not pieces:
        raise ValueError(f"source: {type(source).__name__} without a mesh")
    begins = np.cumsum([0] + [len(piece.positions) for piece in pieces])
    indices = np.concatenate([piece.indices + begin for piece, begin in zip(pieces, begins)])
    used, triangle_materials = np.unique(np.concatenate([piece.materials for piece in pieces]), return_inverse=True)
    plain = used.tolist() in ([], [0])
    return Mesh(
        np.concatenate([piece.positions for piece in pieces]),
        indices,
        normals=_joined(pieces, "normals", (0, 0, 0), np.float64),
        colors=_joined(pieces, "colors", _WHITE, np.uint8),
        uvs=_joined(pieces, "uvs", (0, 0), np.float64),
        triangle_materials=None if plain else triangle_materials.reshape(-1),
        materials=() if plain else [looks.materials[i] for i in used],
        textures=looks.textures,
        finishes=() if plain else [looks.finishes[i] for i in used],
    )


def to_trimesh(mesh: Mesh) -> Any:
    """See Mesh.to_trimesh."""
    trimesh = optional("trimesh", "Mesh.to_trimesh", "trimesh")
    indices = np.arange(mesh.vertex_count).reshape(-1, 3) if mesh.indices is None else mesh.indices.astype(np.int64)
    materials = np.zeros(len(indices), np.int64) if mesh.triangle_materials is None else mesh.triangle_materials
    used = np.unique(materials).tolist()
    if len(used) < 2:
        return _trimesh_of(trimesh, mesh, indices, used[0] if used else 0)
    scene = trimesh.Scene()
    for material in used:
        part = _trimesh_of(trimesh, mesh, indices[materials == material], material)
        part.remove_unreferenced_vertices()
        scene.add_geometry(part, geom_name=f"material_{material}")
    return scene


# --- from trimesh ---------------------------------------------------------------------------------------------------


def _instances(source: Any) -> Iterator[tuple[Any, npt.NDArray[np.float64]]]:
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        yield source, np.eye(4)
    elif hasattr(source, "graph") and hasattr(source, "geometry"):
        for node in source.graph.nodes_geometry:
            matrix, name = source.graph[node]
            if hasattr(source.geometry[name], "faces"):
                yield source.geometry[name], np.asarray(matrix, np.float64)
    else:
        raise TypeError(f"source: {type(source).__name__}, expected trimesh.Trimesh or trimesh.Scene")


def _piece(mesh: Any, matrix: npt.NDArray[np.float64], with_normals: bool, looks: _Materials) -> _Piece:
    positions = np.asarray(mesh.vertices, np.float64)
    indices = np.asarray(mesh.faces, np.int64)
    normals = np.asarray(mesh.vertex_normals, np.float64) if with_normals else None
    if not np.array_equal(matrix, np.eye(4)):
        positions = positions @ matrix[:3, :3].T + matrix[:3, 3]
        if normals is not None:
            normals = normals @ _cofactors(matrix[:3, :3]).T
    visual: Any = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    colors, uvs, materials = None, None, np.zeros(len(indices), np.int64)
    if kind == "vertex":
        colors = _rgba(visual.vertex_colors, len(positions))
    elif kind == "face":
        colors = np.repeat(_rgba(visual.face_colors, len(indices)), 3, axis=0)
        positions = positions[indices.reshape(-1)]
        normals = None if normals is None else normals[indices.reshape(-1)]
        indices = np.arange(len(positions)).reshape(-1, 3)
    elif kind == "texture":
        if visual.uv is not None and len(visual.uv) == len(positions):
            uvs = np.asarray(visual.uv, np.float64)[:, :2] * [1, -1] + [0, 1]  # v points up there
        attributes = getattr(visual, "vertex_attributes", None)
        if attributes is not None and "color" in attributes:
            colors = _rgba(attributes["color"], len(positions))
        materials = _face_materials(visual, len(indices), looks)
    if np.linalg.det(matrix[:3, :3]) < 0:
        indices = indices[:, ::-1]  # a mirror: outside stays outside
    return _Piece(positions, indices, normals, colors, uvs, materials)


def _face_materials(visual: Any, count: int, looks: _Materials) -> npt.NDArray[np.int64]:
    several = getattr(visual.material, "materials", None)
    of_faces = getattr(visual, "face_materials", None)
    if several is None or of_faces is None:
        return np.full(count, looks.index(visual.material if several is None else (several or [None])[0]))
    chosen: npt.NDArray[np.int64] = np.array([looks.index(material) for material in several])[np.asarray(of_faces)]
    return chosen


def _look(material: Any) -> tuple[tuple[int, int, int, int], Any, Finish]:
    """Base color, image and finish of a SimpleMaterial or a PBRMaterial. Factors of the latter are linear, as in glTF;
    those of the former, as in MTL, are not."""
    if not hasattr(material, "baseColorFactor"):
        diffuse = getattr(material, "diffuse", None)
        rgba = _rgba([_WHITE if diffuse is None else diffuse], 1)[0]
        return _four(rgba), getattr(material, "image", None), Finish()
    factor = material.baseColorFactor
    linear = _rgba([_WHITE if factor is None else factor], 1)[0] / 255
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)
    coded[3] = linear[3] if material.alphaMode in ("BLEND", "MASK") else 1
    emitted = getattr(material, "emissiveFactor", None)
    finish = Finish() if emitted is None else Finish(_three(emitted))
    return _four(np.rint(255 * coded)), material.baseColorTexture, finish


def _four(rgba: Any) -> tuple[int, int, int, int]:
    red, green, blue, alpha = (int(value) for value in rgba)
    return red, green, blue, alpha


def _three(values: Any) -> tuple[float, float, float]:
    red, green, blue = (float(value) for value in values)
    return red, green, blue


def _rgba(colors: Any, count: int) -> npt.NDArray[np.uint8]:
    """(count, 4): of bytes, of 16-bit numbers, or of floats 0 .. 1; without alpha it is 255."""
    given = np.asarray(colors)
    if given.dtype.kind == "f":
        given = np.rint(255 * given.clip(0, 1))
    elif given.dtype == np.uint16:
        given = given >> 8
    rgba = np.full((count, 4), 255, np.uint8)
    rgba[:, : given.shape[-1]] = given
    return rgba


def _cofactors(matrix: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """What normals are multiplied by, of mirrors too."""
    x, y, z = matrix
    cofactors: npt.NDArray[np.float64] = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)])
    return cofactors * (1 if np.linalg.det(matrix) >= 0 else -1)


def _joined(pieces: list[_Piece], name: str, missing: Any, dtype: Any) -> Optional[npt.NDArray[Any]]:
    """The arrays of all pieces; None if none has one."""
    parts = [getattr(piece, name) for piece in pieces]
    if all(part is None for part in parts):
        return None
    fill = [np.tile(np.array(missing, dtype), (len(piece.positions), 1)) for piece in pieces]
    return np.concatenate([other if part is None else part for part, other in zip(parts, fill)])


# --- to trimesh -----------------------------------------------------------------------------------------------------


def _trimesh_of(trimesh: Any, mesh: Mesh, indices: Any, material_index: int) -> Any:
    """The triangles of one material."""
    material = mesh.materials[material_index] if material_index < len(mesh.materials) else Material()
    finish = mesh.finishes[material_index] if material_index < len(mesh.finishes) else Finish()
    made = trimesh.Trimesh(mesh.positions, indices, vertex_normals=mesh.normals, process=False)
    if mesh.uvs is None:
        tinted = mesh.colors
        if material.rgba != _WHITE:
            white = np.full((mesh.vertex_count, 4), 255, np.uint8)
            tinted = np.rint((white if mesh.colors is None else mesh.colors) * (np.array(material.rgba) / 255))
        if tinted is not None:
            made.visual = trimesh.visual.ColorVisuals(made, vertex_colors=tinted.astype(np.uint8))
        return made
    coded = np.array(material.rgba) / 255
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    linear[3] = coded[3]
    look = {"baseColorFactor": np.rint(255 * linear).astype(np.uint8), "emissiveFactor": np.array(finish.emission)}
    if material.rgba[3] < 255:
        look["alphaMode"] = "BLEND"
    if material.texture_index is not None:
        pixels = mesh.textures[material.texture_index].rgba
        image = optional("PIL.Image", "Mesh.to_trimesh with a texture", "pillow")
        look["baseColorTexture"] = image.fromarray(np.ascontiguousarray(pixels))
    made.visual = trimesh.visual.TextureVisuals(
        uv=mesh.uvs * [1, -1] + [0, 1], material=trimesh.visual.material.PBRMaterial(**look)
    )
    if mesh.colors is not None:
        made.visual.vertex_attributes["color"] = mesh.colors
    return made
