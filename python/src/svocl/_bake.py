# SPDX-License-Identifier: MIT
"""Light baked into meshes: at their vertices, or at the texels of a lightmap."""

from typing import NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _arrays
from ._light import Light, make_gather_points
from ._mesh import Mesh

_PAIRS = 1 << 22  # of triangles and texels that are looked at together


class BakedVertices(NamedTuple):
    """Light at the vertices of a mesh."""

    irradiance: npt.NDArray[np.float32]
    """(vertex_count, 3): linear red, green, blue, of sources, surfaces and the sky together. A diffuse surface of
    albedo a shows the radiance a / pi of it."""
    openness: npt.NDArray[np.float32]
    """(vertex_count,): ambient occlusion: 1 is open, 0 closed."""


class Texels(NamedTuple):
    """The texels of a lightmap that lie in a chart: those with their center in a triangle of the mesh's uvs."""

    rows: npt.NDArray[np.int64]
    """(count,): from the top; v = 0 is the upper edge of row 0."""
    columns: npt.NDArray[np.int64]
    """(count,): u = 0 is the left edge of column 0."""
    triangles: npt.NDArray[np.int64]
    """(count,): of the mesh; where charts overlap, the first one."""
    positions: npt.NDArray[np.float64]
    """(count, 3): of their centers, on the triangles."""
    normals: npt.NDArray[np.float64]
    """(count, 3): of length 1, interpolated from the vertices."""


class Lightmap(NamedTuple):
    """Light at the texels of a map, rows from top to bottom."""

    irradiance: npt.NDArray[np.float32]
    """(height, width, 3): see BakedVertices. 0 where coverage is 0."""
    openness: npt.NDArray[np.float32]
    """(height, width): 0 where coverage is 0."""
    coverage: npt.NDArray[np.uint8]
    """(height, width): 1 of texels in a chart, 2 of those around charts that seams were dilated to, 0 of others."""
    triangles: npt.NDArray[np.int64]
    """(height, width): which triangle a texel lies in; -1: none."""


def vertex_normals(mesh: Mesh, weights: str = "angle", *, join: bool = True) -> npt.NDArray[np.float64]:
    """Normals at the vertices of a mesh: the weighted sum of the normals of the triangles around each, of length 1.

    Args:
        mesh: corners of triangles in counterclockwise order.
        weights: "angle": a triangle counts by its angle at the vertex, so that it does not matter how a face is cut
            into triangles (Thuermer and Wuethrich, "Computing Vertex Normals from Polygonal Facets", 1998). "area": by
            its area, so that slivers hardly count.
        join: vertices at the same position, as there are at the seams of charts, have one normal. False: each has that
            of its own triangles, so that edges between vertices that are not shared stay hard.

    Returns:
        (vertex_count, 3); zero where no triangle with an area is.
    """
    if weights not in ("angle", "area"):
        raise ValueError(f"weights: {weights!r} is neither 'angle' nor 'area'")
    indices = _indices(mesh)
    places = np.arange(mesh.vertex_count)
    if join and mesh.vertex_count:
        places = np.unique(mesh.positions + 0.0, axis=0, return_inverse=True)[1].reshape(-1)  # + 0.0: -0 is 0
    corners = mesh.positions[indices].astype(np.float64)
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros((len(places), 3))
    for corner in range(3):
        share = crossed
        if weights == "angle":
            after, before = corners[:, (corner + 1) % 3], corners[:, corner - 1]
            share = _unit(crossed) * _angle(after - corners[:, corner], before - corners[:, corner])[:, None]
        np.add.at(sums, places[indices[:, corner]], share)
    return _unit(sums)[places]


def bake_vertices(
    light: Light,
    mesh: Mesh,
    *,
    normals: Optional[npt.ArrayLike] = None,
    paths: int = 256,
    bounces: int = 4,
    error: float = 0.0,
    max_distance: float = np.inf,
) -> BakedVertices:
    """Gathers light at the vertices of a mesh, by rays.

    Args:
        light: of a tree of the mesh, or of a scene that it is a part of, after Light.set_sources.
        mesh: in the coordinates of the tree.
        normals: (vertex_count, 3) of any length, away from the surface; None: those of the mesh, or
            vertex_normals(mesh) if it has none. Vertices with a zero normal are open and dark.
        paths, bounces, error, max_distance: see Light.gather.

    Raises:
        as Light.gather
    """
    towards = _normals(mesh, normals)
    results = light.gather(
        make_gather_points(mesh.positions, towards),
        paths=paths,
        bounces=bounces,
        error=error,
        max_distance=max_distance,
    )
    return BakedVertices(results["direct"] + results["irradiance"], results["openness"].copy())


def lightmap_texels(
    mesh: Mesh,
    width: int,
    height: int,
    *,
    uvs: Optional[npt.ArrayLike] = None,
    normals: Optional[npt.ArrayLike] = None,
) -> Texels:
    """Where the texels of a lightmap lie on a mesh.

    Args:
        mesh: its triangles are charts, which should not overlap.
        width, height: texels, at least 1.
        uvs: (vertex_count, 2), 0 .. 1; None: those of the mesh. What is outside has no texels; nothing is repeated.
        normals: see bake_vertices.

    Raises:
        ValueError: neither the mesh has uvs nor were any given; a size.
    """
    given = mesh.uvs if uvs is None else uvs
    if given is None:
        raise ValueError("uvs: the mesh has none")
    if width < 1 or height < 1:
        raise ValueError(f"width, height: {width} x {height}, expected at least 1 x 1")
    chart = _arrays.floats("uvs", given, (mesh.vertex_count, 2), double=True).astype(np.float64)
    indices = _indices(mesh)
    corners = chart[indices] * [width, height] - 0.5  # centers of texels are whole numbers
    owner, weights = _rasterize(corners, width, height)
    rows, columns = np.nonzero(owner >= 0)
    triangles = owner[rows, columns]
    used = indices[triangles]
    shares = weights[rows, columns][:, :, None]
    places = mesh.positions[used].astype(np.float64)
    towards = _unit((_normals(mesh, normals)[used] * shares).sum(axis=1))
    flat = _unit(np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]))
    lost = ~towards.any(axis=1)
    towards[lost] = flat[lost]
    return Texels(rows, columns, triangles, (places * shares).sum(axis=1), towards)


def bake_lightmap(
    light: Light,
    mesh: Mesh,
    width: int,
    height: int,
    *,
    uvs: Optional[npt.ArrayLike] = None,
    normals: Optional[npt.ArrayLike] = None,
    dilate: int = 2,
    paths: int = 256,
    bounces: int = 4,
    error: float = 0.0,
    max_distance: float = np.inf,
) -> Lightmap:
    """Gathers light at the centers of a lightmap's texels, by rays, and dilates the seams.

    Args:
        light: of a tree of the mesh, or of a scene that it is a part of, after Light.set_sources.
        mesh, width, height, uvs, normals: see lightmap_texels.
        dilate: texels by which charts grow, so that bilinear filters and smaller levels find no black beside them. A
            texel of each round has the mean of those of its eight neighbors that were there before.
        paths, bounces, error, max_distance: see Light.gather.

    Raises:
        as lightmap_texels and Light.gather
    """
    texels = lightmap_texels(mesh, width, height, uvs=uvs, normals=normals)
    results = light.gather(
        make_gather_points(texels.positions, texels.normals),
        paths=paths,
        bounces=bounces,
        error=error,
        max_distance=max_distance,
    )
    values = np.zeros((height, width, 4), np.float32)
    values[texels.rows, texels.columns, :3] = results["direct"] + results["irradiance"]
    values[texels.rows, texels.columns, 3] = results["openness"]
    coverage = np.zeros((height, width), np.uint8)
    coverage[texels.rows, texels.columns] = 1
    triangles = np.full((height, width), -1, np.int64)
    triangles[texels.rows, texels.columns] = texels.triangles
    for _ in range(_arrays.integer("dilate", dilate)):
        _grow(values, coverage)
    return Lightmap(np.ascontiguousarray(values[..., :3]), np.ascontiguousarray(values[..., 3]), coverage, triangles)


def _indices(mesh: Mesh) -> npt.NDArray[np.int64]:
    """(triangle_count, 3). Triangles with an index out of range are left out of builds; here they are an error."""
    if mesh.indices is None:
        return np.arange(mesh.vertex_count).reshape(-1, 3)
    indices = mesh.indices.astype(np.int64)
    if len(indices) and indices.max() >= mesh.vertex_count:
        raise ValueError(f"mesh: index {indices.max()} is out of range, there are {mesh.vertex_count} vertices")
    return indices


def _normals(mesh: Mesh, normals: Optional[npt.ArrayLike]) -> npt.NDArray[np.float64]:
    if normals is None:
        normals = vertex_normals(mesh) if mesh.normals is None else mesh.normals
    return _arrays.floats("normals", normals, (mesh.vertex_count, 3), double=True).astype(np.float64)


def _unit(vectors: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Of length 1, or zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: npt.NDArray[np.float64] = np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0)
    return unit


def _angle(a: npt.NDArray[np.float64], b: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Between rows of two arrays; exact near 0 and pi, too."""
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    angle: npt.NDArray[np.float64] = np.arctan2(sine, (a * b).sum(axis=1))
    return angle


def _rasterize(
    corners: npt.NDArray[np.float64], width: int, height: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Which of the triangles (n, 3, 2) holds each point of a grid, the first one; (height, width), -1: none; and the
    barycentric weights there, (height, width, 3)."""
    owner = np.full((height, width), -1, np.int64)
    weights = np.zeros((height, width, 3))
    finite = np.isfinite(corners.reshape(len(corners), 6)).all(axis=1, keepdims=True)
    low = np.ceil(np.where(finite, corners.min(axis=1), 0).clip(-1, [width, height])).astype(np.int64)
    high = np.floor(np.where(finite, corners.max(axis=1), -1).clip(-1, [width, height])).astype(np.int64)
    rows = max(_PAIRS // width, 1)
    for top in range(0, height, rows):
        first = np.maximum(low, [0, top])
        extent = np.maximum(np.minimum(high, [width - 1, min(top + rows, height) - 1]) - first + 1, 0)
        counts = extent.prod(axis=1)
        ends = np.cumsum(counts)
        begin = 0
        while begin < len(counts):
            before = ends[begin] - counts[begin]
            end = max(int(np.searchsorted(ends, before + _PAIRS, side="right")), begin + 1)
            triangles = np.repeat(np.arange(begin, end), counts[begin:end])
            offset = np.arange(len(triangles)) - (ends - counts - before)[triangles]
            x = first[triangles, 0] + offset % extent[triangles, 0]
            y = first[triangles, 1] + offset // extent[triangles, 0]
            shares, inside = _barycentric(corners[triangles], np.stack([x, y], axis=1).astype(np.float64))
            inside &= owner[y, x] < 0
            # Of triangles that share a texel the first one is taken.
            first_of = np.flatnonzero(inside)[np.unique((y * width + x)[inside], return_index=True)[1]]
            place = y[first_of], x[first_of]
            owner[place], weights[place] = triangles[first_of], shares[first_of]
            begin = end
    return owner, weights


def _barycentric(
    corners: npt.NDArray[np.float64], points: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Weights (n, 3) of points (n, 2) in triangles (n, 3, 2), and which points lie inside or on an edge."""
    u, v, offset = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        second = (offset[:, 0] * v[:, 1] - offset[:, 1] * v[:, 0]) / area
        third = (u[:, 0] * offset[:, 1] - u[:, 1] * offset[:, 0]) / area
    weights = np.stack([1 - second - third, second, third], axis=1)
    with np.errstate(invalid="ignore"):
        inside = (weights >= -1e-9).all(axis=1) & (area != 0)
    return weights, inside


def _grow(values: npt.NDArray[np.float32], coverage: npt.NDArray[np.uint8]) -> None:
    """One round of dilation, in place."""
    height, width = coverage.shape
    sums = np.zeros((height + 2, width + 2, values.shape[2]))
    counts = np.zeros((height + 2, width + 2))
    there = coverage > 0
    for row in range(3):
        for column in range(3):
            sums[row : row + height, column : column + width] += values * there[..., None]
            counts[row : row + height, column : column + width] += there
    new = ~there & (counts[1:-1, 1:-1] > 0)
    values[new] = sums[1:-1, 1:-1][new] / counts[1:-1, 1:-1][new][:, None]
    coverage[new] = 2
