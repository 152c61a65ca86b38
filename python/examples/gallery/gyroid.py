"""Voxels that are given: a gyroid in a ball, a condition on a numpy grid, with colors by place."""

import pathlib

import numpy as np

import svocl


def picture(depth=7, width=480):
    size = 2**depth
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, size)] * 3, indexing="ij")
    a, b, c = 9 * x, 9 * y, 9 * z
    gyroid = np.sin(a) * np.cos(b) + np.sin(b) * np.cos(c) + np.sin(c) * np.cos(a)
    cells = np.argwhere((np.abs(gyroid) < 0.35) & (x * x + y * y + z * z < 1))
    place = 2 * cells / (size - 1) - 1
    radius = np.linalg.norm(place, axis=1, keepdims=True)
    colors = 255 * (0.52 + 0.45 * np.cos(5 * radius + 1.2 * place[:, 1:2] + [0.2, 1.7, 3.4]))
    colors = np.concatenate([colors, np.full((len(cells), 1), 255)], axis=1).astype(np.uint8)
    voxels = svocl.Voxels(svocl.make_voxels(cells, colors), voxel_edge=2 / size)
    with svocl.Device() as device:
        return voxels.build(device).render(width, width * 3 // 4)


if __name__ == "__main__":
    pathlib.Path("gyroid.png").write_bytes(svocl.png(picture()))
