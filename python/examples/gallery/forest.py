"""A scene: 1,500 instances of two small models on a hill, each turned and scaled by its own matrix."""

import pathlib

import numpy as np

import svocl

RANDOM = np.random.default_rng(5)


def voxels(cells, color):
    """Voxels of cells, in shades of a color."""
    colors = np.array(color) + RANDOM.integers(-14, 15, (len(cells), 1))
    return svocl.make_voxels(cells.astype(int), np.concatenate([colors, np.full((len(cells), 1), 255)], axis=1))


def tree_of(crown, bark, leaves):
    """A trunk and a crown on 32 x 32 x 32 cells, 1 / 16 wide."""
    x, y, z = np.meshgrid(*[np.arange(32) + 0.5] * 3, indexing="ij")
    x, y, z = x / 16 - 1, y / 16, z / 16 - 1
    trunk = voxels(np.argwhere((x * x + z * z < 0.015) & (y < 0.8)), bark)
    records = np.concatenate([trunk, voxels(np.argwhere(crown(x, y, z)), leaves)])
    return svocl.Voxels(records, origin=(-1, 0, -1), voxel_edge=1 / 16)


def hill(x, z):
    return 2.2 * np.exp(-((x - 3) ** 2 + (z + 4) ** 2) / 40) + 0.35 * np.sin(0.5 * x) * np.cos(0.4 * z)


def picture(depth=8, width=480, count=1500):
    size, step = 2**depth, 32 / 2**depth
    x, z = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    tops = np.floor((hill(step * x - 16, step * z - 16) + 1.5) / step)
    ground = np.concatenate([np.stack([x, tops - k, z], axis=-1).reshape(-1, 3) for k in range(2)])
    soil = svocl.Voxels(voxels(ground, (150, 158, 96)), origin=(-16, -1.5, -16), voxel_edge=step)
    pine = lambda x, y, z: (x * x + z * z < ((2 - y) * (0.55 - 0.3 * (y * 2.2 % 1))) ** 2) & (y > 0.35)
    oak = lambda x, y, z: x * x + 1.3 * (y - 1.2) ** 2 + z * z < 0.5 + 0.12 * np.sin(9 * x) * np.sin(8 * y + 7 * z)
    models = [soil, tree_of(pine, (96, 66, 42), (44, 96, 58)), tree_of(oak, (110, 80, 54), (122, 140, 52))]
    place, turn = RANDOM.uniform(-15.5, 15.5, (2, count)), RANDOM.uniform(0, 2 * np.pi, count)
    matrices = np.zeros((count, 3, 4))
    matrices[:, 0, 0], matrices[:, 0, 2] = np.cos(turn), np.sin(turn)
    matrices[:, 2, 0], matrices[:, 2, 2] = -np.sin(turn), np.cos(turn)
    matrices[:, 1, 1] = 1.15
    matrices[:, :, :3] *= RANDOM.uniform(0.3, 0.62, (count, 1, 1))
    matrices[:, :, 3] = np.stack([place[0], hill(*place), place[1]], axis=1)
    kinds = 1 + (hill(*place) + RANDOM.normal(0, 0.4, count) < 0.7)  # oaks grow below
    instances = svocl.make_instances([0, *kinds], np.concatenate([np.eye(3, 4)[None], matrices]))
    with svocl.Device() as device:
        scene = svocl.Scene([model.build(device) for model in models], instances)
        camera = svocl.Camera((-6, 7.5, 17), (0.5, 0.2, -1), (0, 1, 0), 0.62)
        sun = svocl.SceneLight((-0.7, 0.75, 0.3), (1.0, 0.93, 0.8))
        return scene.render(width, width * 3 // 4, camera=camera, lights=[sun])


if __name__ == "__main__":
    pathlib.Path("forest.png").write_bytes(svocl.png(picture()))
