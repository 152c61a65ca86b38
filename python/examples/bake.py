#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Bakes the light of a sun and a sky into a mesh that stands on a floor: a colored PLY, and a lightmap.

    python bake.py [MESH] [-o baked.ply] [--lightmap map.png] [--size 256] [--paths 256] [--z-up]

Without a file, the mesh is a torus. Its lightmap needs texture coordinates without overlaps, of which read_mesh keeps
those that a texture uses; map.exr has linear light, map.png what it looks like.
"""

import argparse
import struct
import zlib

import numpy as np

import svocl

SUN = svocl.LightSource(svocl.SourceKind.DIRECTIONAL, (2.2, 2.05, 1.8), direction=(-0.5, -1, -0.35))
SKY = (0.3, 0.36, 0.45)
NEED = svocl.Need.COLOR | svocl.Need.NORMAL | svocl.Need.RAYS | svocl.Need.MATERIAL
FLOOR = 128  # squares along a side
ALBEDO = 0.7  # of what is shown, so that what lies in the sun is not white alone


def torus(around=96, across=48):
    """A torus on its edge, whose chart is the whole map; the seams have vertices of their own."""
    u, v = np.meshgrid(np.arange(around + 1), np.arange(across + 1), indexing="ij")
    angle, turn = 2 * np.pi * u / around, 2 * np.pi * v / across
    radius = 1 + 0.4 * np.cos(turn)
    positions = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.4 * np.sin(turn)], axis=-1).reshape(-1, 3)
    corner = [(u[:-1, :-1] + i) * (across + 1) + v[:-1, :-1] + j for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    triangles = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1).reshape(-1, 3)
    uvs = np.stack([u / around, v / across], axis=-1).reshape(-1, 2)
    return svocl.Mesh(positions, triangles, uvs=uvs)


def add_floor(mesh):
    """The mesh, and a floor below it: squares of vertices that catch its shadow."""
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() * 1.1
    x, z = np.meshgrid(np.linspace(-half, half, FLOOR + 1), np.linspace(-half, half, FLOOR + 1), indexing="ij")
    squares = np.stack([middle[0] + x, np.full_like(x, low[1]), middle[2] + z], axis=-1).reshape(-1, 3)
    first = (np.arange(FLOOR)[:, None] * (FLOOR + 1) + np.arange(FLOOR)).reshape(-1, 1)
    triangles = first + [[0, 1, FLOOR + 2, 0, FLOOR + 2, FLOOR + 1]]
    indices = np.arange(mesh.vertex_count).reshape(-1, 3) if mesh.indices is None else mesh.indices
    both = np.concatenate([indices, triangles.reshape(-1, 3) + mesh.vertex_count])
    materials = mesh.triangle_materials
    if materials is not None:
        materials = np.concatenate([materials, np.full(len(both) - len(indices), len(mesh.materials), np.uint16)])
    parts = {
        "normals": (mesh.normals, [0, 1, 0]),
        "colors": (mesh.colors, [255, 255, 255, 255]),
        "uvs": (mesh.uvs, [0, 0]),
    }
    rest = {
        name: np.concatenate([part, np.tile(np.array(value, part.dtype), (len(squares), 1))])
        for name, (part, value) in parts.items()
        if part is not None
    }
    return svocl.Mesh(
        np.concatenate([mesh.positions, squares]),
        both,
        triangle_materials=materials,
        materials=(*mesh.materials, svocl.Material()) if mesh.materials else (),
        textures=mesh.textures,
        **rest,
    )


def srgb(radiance):
    """Linear light as bytes; what is above 1 is white."""
    linear = np.clip(radiance, 0, 1)
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)
    return np.round(255 * coded).astype(np.uint8)


def write_ply(path, mesh, colors):
    vertices = np.empty(mesh.vertex_count, [("position", "<f4", 3), ("color", "u1", 3)])
    vertices["position"], vertices["color"] = mesh.positions, colors
    faces = np.empty(mesh.triangle_count, [("count", "u1"), ("indices", "<u4", 3)])
    faces["count"], faces["indices"] = 3, mesh.indices
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {mesh.vertex_count}"]
    head += [f"property float {axis}" for axis in "xyz"] + [
        f"property uchar {color}" for color in ("red", "green", "blue")
    ]
    head += [f"element face {mesh.triangle_count}", "property list uchar uint vertex_indices", "end_header\n"]
    with open(path, "wb") as file:
        file.write("\n".join(head).encode() + vertices.tobytes() + faces.tobytes())


def write_png(path, pixels):
    """(height, width, 3) uint8."""
    height, width, _ = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)
    chunks = [
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows.tobytes())),
    ]
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, content in [*chunks, (b"IEND", b"")]:
            file.write(struct.pack(">I", len(content)) + kind + content)
            file.write(struct.pack(">I", zlib.crc32(kind + content)))


def write_exr(path, pixels):
    """(height, width, 3) float32, uncompressed."""
    height, width, _ = pixels.shape
    channels = b"".join(name + struct.pack("<xiBxxxii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    fields = [
        (b"channels", b"chlist", channels),
        (b"compression", b"compression", b"\0"),
        (b"dataWindow", b"box2i", window),
        (b"displayWindow", b"box2i", window),
        (b"lineOrder", b"lineOrder", b"\0"),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        (b"screenWindowCenter", b"v2f", struct.pack("<ff", 0, 0)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1)),
    ]
    head = struct.pack("<II", 20000630, 2)
    head += b"".join(a + b"\0" + b + b"\0" + struct.pack("<I", len(c)) + c for a, b, c in fields) + b"\0"
    line_bytes = 12 * width
    offsets = len(head) + 8 * height + (8 + line_bytes) * np.arange(height)
    lines = np.ascontiguousarray(pixels[:, :, ::-1].transpose(0, 2, 1), "<f4")  # a row of each channel
    with open(path, "wb") as file:
        file.write(head + offsets.astype("<u8").tobytes())
        for row in range(height):
            file.write(struct.pack("<iI", row, line_bytes) + lines[row].tobytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", nargs="?", help="a mesh file: OBJ, PLY, glTF, ...")
    parser.add_argument("-o", "--output", default="baked.ply")
    parser.add_argument("--lightmap", metavar="FILE.png", help="also FILE.exr")
    parser.add_argument("--size", type=int, default=256, help="texels along a side of the lightmap")
    parser.add_argument("--paths", type=int, default=256, help="of a vertex or a texel")
    parser.add_argument("--z-up", action="store_true", help="z is up in the file")
    arguments = parser.parse_args()

    axes = svocl.Axes.Z_UP if arguments.z_up else svocl.Axes.AUTO
    mesh = torus() if arguments.mesh is None else svocl.read_mesh(arguments.mesh, axes=axes)
    scene = add_floor(mesh)
    with svocl.Device() as device, device.build(scene, 9, need=NEED) as tree, svocl.Light(tree) as light:
        print(device.name)
        light.set_sources([SUN], sky=SKY)
        baked = svocl.bake_vertices(light, scene, paths=arguments.paths)
        # A surface of an albedo shows the radiance albedo * irradiance / pi.
        write_ply(arguments.output, scene, srgb(ALBEDO * baked.irradiance / np.pi))
        print(f"{arguments.output}: {scene.vertex_count} vertices, mean irradiance {baked.irradiance.mean():.2f}")
        if arguments.lightmap is not None:
            map = svocl.bake_lightmap(light, mesh, arguments.size, arguments.size, paths=arguments.paths)
            write_png(arguments.lightmap, srgb(ALBEDO * map.irradiance / np.pi))
            write_exr(arguments.lightmap.rsplit(".", 1)[0] + ".exr", map.irradiance)
            print(f"{arguments.lightmap}: {(map.coverage == 1).mean():.0%} of the texels lie in charts")


if __name__ == "__main__":
    main()
