"""What is inside of a closed mesh, by its signed distance field: cut open, with a color by depth."""

import pathlib

import numpy as np

import svocl


def trefoil(around=300, across=60):
    """A thick knotted tube."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    angle, turn = (2 * np.pi * u / around)[..., None], (2 * np.pi * v / across)[..., None]
    curve = lambda t: np.concatenate([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], -1)
    tangent = curve(angle + 1e-4) - curve(angle - 1e-4)
    side = np.cross(tangent, curve(angle))
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    up = np.cross(side, tangent)
    up /= np.linalg.norm(up, axis=-1, keepdims=True)
    positions = curve(angle) + 0.62 * (np.cos(turn) * side + np.sin(turn) * up)
    corner = [(u + i) % around * across + (v + j) % across for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    indices = np.stack([corner[k] for k in (0, 1, 2, 0, 2, 3)], axis=-1)
    return svocl.Mesh(positions.reshape(-1, 3), indices.reshape(-1, 3))


def picture(depth=7, width=480):
    with svocl.Device() as device:
        tree = device.build(trefoil(), depth, need=svocl.Need.RAYS)
        field = svocl.sdf(tree, band=0)
        cells = np.argwhere(field.distances < 0)
        centers = field.first + field.spacing * cells
        kept = cells[centers[:, 2] < 0.25 + 0.12 * centers[:, 0]]
        depths = -field.distances[tuple(kept.T)] / 0.62  # 0 at the surface, 1 in the middle of the tube
        stops = np.array([[245, 240, 225], [250, 190, 90], [215, 80, 60], [90, 25, 80]])
        colors = np.stack([np.interp(depths, [0.02, 0.3, 0.65, 1], stop) for stop in stops.T], axis=-1)
        colors = np.concatenate([colors, np.full((len(kept), 1), 255)], axis=-1).astype(np.uint8)
        voxels = svocl.Voxels(svocl.make_voxels(kept, colors)).build(device)
        return voxels.render(width, width * 3 // 4)


if __name__ == "__main__":
    pathlib.Path("inside.png").write_bytes(svocl.png(picture()))
