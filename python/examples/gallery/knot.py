"""A mesh from numpy arrays, with a color at each vertex, as an octree of 512 voxels along a side."""

import pathlib

import numpy as np

import svocl


def knot(around=480, across=32):
    """A knotted tube."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    angle, turn = (2 * np.pi * u / around)[..., None], (2 * np.pi * v / across)[..., None]
    curve = lambda t: np.concatenate([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], -1)
    tangent = curve(angle + 1e-4) - curve(angle - 1e-4)
    side = np.cross(tangent, curve(angle))
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    up = np.cross(side, tangent)
    up /= np.linalg.norm(up, axis=-1, keepdims=True)
    positions = curve(angle) + 0.45 * (np.cos(turn) * side + np.sin(turn) * up)
    corner = [(u + i) % around * across + (v + j) % across for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    indices = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1).reshape(-1, 3)
    hue = 150 + 100 * np.cos(angle + np.array([0, 2, 4]))
    colors = np.concatenate([hue, np.full_like(angle, 255)], axis=-1).astype(np.uint8)
    return svocl.Mesh(positions.reshape(-1, 3), indices, colors=colors.reshape(-1, 4))


def picture(depth=9, width=480):
    with svocl.Device() as device:
        tree = device.build(knot(), depth, need=svocl.Need.COLOR | svocl.Need.NORMAL)
        return tree.render(width, width * 3 // 4)


if __name__ == "__main__":
    pathlib.Path("knot.png").write_bytes(svocl.png(picture()))
