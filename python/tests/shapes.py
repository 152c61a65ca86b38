# SPDX-License-Identifier: MIT
"""Meshes, and what the tests compare with: plain numpy in double precision, one triangle after the other."""

import numpy as np

CUBE_POSITIONS = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], np.float32)
# fmt: off
CUBE_INDICES = np.array(
    [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5],
    np.uint32,
).reshape(12, 3)
# fmt: on


def torus(around=24, across=12):
    """A closed torus around the z axis, of radii 1 and 0.4: positions (n, 3) float64, indices (2 n, 3) uint32."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    angle, turn = 2 * np.pi * u / around, 2 * np.pi * v / across
    radius = 1 + 0.4 * np.cos(turn)
    positions = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.4 * np.sin(turn)], axis=-1)
    corner = [((u + i) % around * across + (v + j) % across) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    triangles = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1)
    return positions.reshape(-1, 3), triangles.reshape(-1, 3).astype(np.uint32)


def trace(positions, indices, origin, direction):
    """The distance to the first triangle along a ray, or infinity (Moeller and Trumbore, 1997)."""
    corners = positions[indices].astype(np.float64)
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(direction, edge2)
    determinant = np.einsum("ij,ij->i", edge1, normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = origin - corners[:, 0]
        u = np.einsum("ij,ij->i", offset, normal) / determinant
        across = np.cross(offset, edge1)
        v = across @ direction / determinant
        t = np.einsum("ij,ij->i", edge2, across) / determinant
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0)
    return t[hit].min() if hit.any() else np.inf


def distances(positions, indices, points, steps=20):
    """The distance from each point to the nearest of all triangles, by samples: never below the true one."""
    i, j = np.meshgrid(np.arange(steps + 1), np.arange(steps + 1))
    weights = np.stack([i, j, steps - i - j], axis=-1).reshape(-1, 3)
    weights = weights[weights[:, 2] >= 0] / steps
    samples = np.einsum("wk,tkx->twx", weights, positions[indices]).reshape(-1, 3)
    return np.array([np.linalg.norm(samples - point, axis=1).min() for point in points])
