"""One mesh at four depths, by the same camera: 16, 32, 64 and 512 voxels along a side."""

import pathlib

import numpy as np

import svocl


def torus(around=192, across=96):
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    angle, turn = 2 * np.pi * u / around, 2 * np.pi * v / across
    radius = 1 + 0.42 * np.cos(turn) + 0.05 * np.cos(9 * angle)
    positions = np.stack([radius * np.cos(angle), 0.42 * np.sin(turn), radius * np.sin(angle)], axis=-1)
    corner = [(u + i) % around * across + (v + j) % across for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))]
    indices = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1)
    colors = 128 + 100 * np.cos(turn[..., None] + angle[..., None] + [0.3, 1.4, 2.6])
    colors = np.concatenate([colors, np.full_like(colors[..., :1], 255)], axis=-1).astype(np.uint8).reshape(-1, 4)
    return svocl.Mesh(positions.reshape(-1, 3), indices.reshape(-1, 3), colors=colors)


def picture(depth=9, width=480):
    parts = []
    with svocl.Device() as device:
        for levels in (4, 5, 6, depth):
            # A grid of its own choice, so that all trees have the same one.
            need = svocl.Need.COLOR | svocl.Need.NORMAL
            tree = device.build(torus(), levels, need=need, origin=(-1.5, -1.5, -1.5), edge=3)
            camera = svocl.Camera((1.5, 2.8, 3.7), (0, -0.08, 0), (0, 1, 0), 0.64)
            parts.append(tree.render(width // 2, width * 3 // 8, camera=camera))
    return np.concatenate([np.concatenate(parts[:2], axis=1), np.concatenate(parts[2:], axis=1)])


if __name__ == "__main__":
    pathlib.Path("depths.png").write_bytes(svocl.png(picture()))
