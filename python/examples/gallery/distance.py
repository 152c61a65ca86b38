"""A slice through the exact distances to a mesh: negative (blue) inside, positive (orange) outside, with contours."""

import pathlib

import numpy as np

import svocl


def flower(around=360, across=120):
    """A ring with waves."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    angle, turn = 2 * np.pi * u / around, 2 * np.pi * v / across
    radius = 1 + 0.22 * np.cos(7 * angle) + (0.45 + 0.1 * np.cos(7 * angle + 2)) * np.cos(turn)
    positions = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.4 * np.sin(turn)], axis=-1)
    corner = [(u + i) % around * across + (v + j) % across for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    indices = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1)
    return svocl.Mesh(positions.reshape(-1, 3), indices.reshape(-1, 3))


def picture(depth=7, width=480):
    with svocl.Device() as device:
        tree = device.build(flower(), depth, need=svocl.Need.RAYS)
        x, y = np.meshgrid(np.linspace(-2.6, 2.6, width), np.linspace(1.95, -1.95, width * 3 // 4))
        points = np.stack([x, y, np.full_like(x, 0.05)], axis=-1)
        distance = tree.nearest(points)["distance"]
        crossed = tree.trace(svocl.make_rays(points, (0.1, 0.2, 1)), mode=svocl.TraceMode.COUNT)["count"]
    inside = crossed % 2 == 1  # a ray out of a closed mesh leaves it once more than it enters it
    color = np.where(inside[..., None], [0.35, 0.6, 0.95], [0.98, 0.72, 0.4])
    color = color * (1 - 0.45 * np.exp(-3 * distance))[..., None]
    contour = np.abs((distance * 10) % 1 - 0.5) * 2  # a line each 0.1
    color = color * (0.82 + 0.18 * np.clip((1 - contour) * 8, 0, 1))[..., None]
    color = np.where(distance[..., None] < 7 / width, 1, color)
    return np.round(255 * color).astype(np.uint8)


if __name__ == "__main__":
    pathlib.Path("distance.png").write_bytes(svocl.png(picture()))
