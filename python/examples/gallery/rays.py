"""Rays meet the triangles of the mesh exactly, however coarse the tree: on the left its voxels, on the right the hits
of one ray for each pixel, with a shadow ray from each."""

import pathlib

import numpy as np

import svocl


def rings(around=192, across=64):
    """Two linked rings."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    angle, turn = 2 * np.pi * u / around, 2 * np.pi * v / across
    radius = 1 + 0.3 * np.cos(turn)
    one = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.3 * np.sin(turn)], axis=-1).reshape(-1, 3)
    corner = [(u + i) % around * across + (v + j) % across for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    indices = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1).reshape(-1, 3)
    other = one[:, [0, 2, 1]] * [1, 1, -1] + [1, 0, 0]
    return svocl.Mesh(np.concatenate([one, other]), np.concatenate([indices, indices + len(one)]))


def picture(depth=5, width=480):
    height, sun = width * 3 // 4, np.array([0.5, 0.8, 0.35])
    with svocl.Device() as device, device.build(rings(), depth, need=svocl.Need.RAYS | svocl.Need.NORMAL) as tree:
        camera = tree.frame(width / height)
        shown = tree.render(width, height, camera=camera)
        eye = np.array(camera.eye)
        forward = (camera.target - eye) / np.linalg.norm(camera.target - eye)
        right = np.cross(forward, camera.up) / np.linalg.norm(np.cross(forward, camera.up))
        x, y = np.meshgrid(np.arange(width // 2, width) + 0.5 - width / 2, height / 2 - 0.5 - np.arange(height))
        pixel = np.tan(camera.vertical_fov / 2) * 2 / height
        seen = forward + pixel * (x[..., None] * right + y[..., None] * np.cross(right, forward))
        hits = tree.trace(svocl.make_rays(eye, seen))
        met, normals = np.isfinite(hits["t"]), hits["normal"]
        points = eye + np.where(met, hits["t"], 0)[..., None] * seen
        shadows = tree.trace(svocl.make_rays(points + 1e-3 * normals, sun), mode=svocl.TraceMode.ANY)
    light = 0.25 + 0.1 * normals[..., 1] + 0.65 * np.isinf(shadows["t"]) * np.clip(normals @ sun, 0, 1)
    half = shown[:, width // 2 :]
    half[:] = shown[:, :1]  # what is behind
    half[met, :3] = np.round(255 * (light[met, None] * [1.0, 0.72, 0.42]).clip(0, 1) ** (1 / 2.2))
    return shown


if __name__ == "__main__":
    pathlib.Path("rays.png").write_bytes(svocl.png(picture()))
