"""Step 1: your model. Any mesh file, or numpy arrays: here a bowl on a plate, with a color at each vertex."""

import pathlib
import sys

import numpy as np

import svocl


def turned(profile, colors, around=128):
    """A closed outline of points (radius, height), turned round the y axis."""
    steps = np.linspace(0, 1, len(profile) * 12, endpoint=False) * len(profile)
    radius, height = (np.interp(steps, range(len(profile) + 1), [*part, part[0]]) for part in np.array(profile).T)
    angle = 2 * np.pi * np.arange(around) / around
    positions = np.stack(
        [
            np.outer(np.cos(angle), radius),
            np.broadcast_to(height, (around, len(height))),
            np.outer(np.sin(angle), radius),
        ],
        axis=-1,
    )
    u, v = np.meshgrid(np.arange(around), np.arange(len(steps)), indexing="ij")
    corner = [(u + i) % around * len(steps) + (v + j) % len(steps) for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))]
    indices = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1).reshape(-1, 3)
    stripe = (np.sin(40 * height) > 0)[None, :, None]
    rgba = np.where(stripe, *(np.array(color, np.uint8) for color in colors)) + np.zeros((around, 1, 1), np.uint8)
    return svocl.Mesh(positions.reshape(-1, 3), indices, colors=rgba.reshape(-1, 4))


def bowl():
    return turned(
        [(0.25, 0.0), (0.35, 0.0), (1.0, 0.8), (0.95, 0.83), (0.3, 0.08), (0.02, 0.05), (0.02, 0.03)],
        [(205, 120, 60, 255), (235, 205, 160, 255)],
    )


def plate():
    return turned(
        [(0.02, -0.06), (1.5, -0.06), (1.55, 0.0), (1.45, 0.0), (0.02, -0.02)],
        [(90, 120, 140, 255), (100, 130, 150, 255)],
    )


def load(path=None):
    """The mesh of a file, or the bowl and its plate as one."""
    if path is not None:
        return svocl.read_mesh(path)
    one, other = bowl(), plate()
    return svocl.Mesh(
        np.concatenate([one.positions, other.positions]),
        np.concatenate([one.indices, other.indices + one.vertex_count]),
        colors=np.concatenate([one.colors, other.colors]),
    )


def picture(depth=9, width=320, path=None):
    mesh = load(path)
    print(f"{mesh.vertex_count} vertices, {mesh.triangle_count} triangles")
    with svocl.Device() as device:
        tree = device.build(mesh, depth, need=svocl.Need.COLOR | svocl.Need.NORMAL)
        return tree.render(width, width * 3 // 4)


if __name__ == "__main__":
    pathlib.Path("model.png").write_bytes(svocl.png(picture(path=sys.argv[1] if len(sys.argv) > 1 else None)))
