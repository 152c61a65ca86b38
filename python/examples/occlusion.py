#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Ambient occlusion: how much of the sky each vertex of a mesh sees, as a gray PLY.

    python occlusion.py [MESH] [-o occlusion.ply] [--rays 64]

Without a file, the mesh is two tori that lie in each other.
"""

import argparse

import numpy as np

import svocl


def tori():
    """Two linked tori: positions (n, 3), indices (m, 3)."""
    around, across = 48, 24
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    angle, turn = 2 * np.pi * u / around, 2 * np.pi * v / across
    radius = 1 + 0.3 * np.cos(turn)
    one = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.3 * np.sin(turn)], axis=-1).reshape(-1, 3)
    corner = [(u + i) % around * across + (v + j) % across for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    triangles = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1).reshape(-1, 3)
    other = one[:, [0, 2, 1]] * [1, 1, -1] + [1, 0, 0]
    return np.concatenate([one, other]), np.concatenate([triangles, triangles + len(one)])


def vertex_normals(mesh):
    """(vertex_count, 3): the sum of the normals around each vertex, weighted by area, of length 1."""
    corners = mesh.positions[mesh.indices].astype(np.float64)
    normals = np.zeros((mesh.vertex_count, 3))
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for corner in range(3):
        np.add.at(normals, mesh.indices[:, corner], area)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def sky(tree, mesh, ray_count):
    """(vertex_count,) the part of the sky that each vertex sees, 0 .. 1."""
    random = np.random.default_rng(1)
    ball = random.normal(size=(ray_count, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    normals = vertex_normals(mesh)
    # A point of the sphere around the tip of the normal: directions weighted by their cosine.
    directions = normals[:, None] + 0.999 * ball
    begin = 1e-3 * tree.info.edge * normals  # off the surface
    rays = svocl.make_rays((mesh.positions + begin)[:, None], directions)
    hits = tree.trace(rays, mode=svocl.TraceMode.ANY)  # (vertex_count, ray_count)
    return np.isinf(hits["t"]).mean(axis=1)


def write_ply(path, mesh, gray):
    vertices = np.empty(mesh.vertex_count, [("position", "<f4", 3), ("color", "u1", 3)])
    vertices["position"], vertices["color"] = mesh.positions, np.round(255 * gray)[:, None]
    faces = np.empty(mesh.triangle_count, [("count", "u1"), ("indices", "<u4", 3)])
    faces["count"], faces["indices"] = 3, mesh.indices
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {mesh.vertex_count}"]
    head += [f"property float {axis}" for axis in "xyz"] + [
        f"property uchar {color}" for color in ("red", "green", "blue")
    ]
    head += [f"element face {mesh.triangle_count}", "property list uchar uint vertex_indices", "end_header\n"]
    with open(path, "wb") as file:
        file.write("\n".join(head).encode() + vertices.tobytes() + faces.tobytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="?", help="a mesh file with shared vertices: OBJ, PLY, glTF, ...")
    parser.add_argument("-o", "--output", default="occlusion.ply")
    parser.add_argument("--rays", type=int, default=64, help="rays a vertex")
    arguments = parser.parse_args()

    mesh = svocl.Mesh(*tori()) if arguments.mesh is None else svocl.read_mesh(arguments.mesh)
    if mesh.indices is None:
        mesh = svocl.Mesh(mesh.positions, np.arange(mesh.vertex_count).reshape(-1, 3))
    with svocl.Device() as device:
        print(device.name)
        with device.plan(mesh, 1) as probe:
            depth = probe.info.ray_depth
        with device.build(mesh, depth, need=svocl.Need.RAYS) as tree:
            gray = sky(tree, mesh, arguments.rays)
    write_ply(arguments.output, mesh, gray)
    print(f"{arguments.output}: {mesh.vertex_count} vertices see {gray.mean():.0%} of the sky")


if __name__ == "__main__":
    main()
