"""Step 5: motion. The bowl moves over its plate in one tree; an update voxelizes what moved alone, and gives the tree
of a full build."""

import pathlib

import numpy as np
from model import bowl, plate

import svocl


def picture(depth=7, width=320, frames=3):
    need = svocl.Need.COLOR | svocl.Need.NORMAL
    parts = []
    with svocl.Device() as device:
        with svocl.Moving(device, plate(), depth, origin=(-1.7, -1.0, -1.7), edge=3.4, need=need) as moving:
            thrown = moving.add(bowl(), np.eye(3, 4))
            for frame in range(frames):
                angle = 0.45 * frame
                matrix = np.eye(3, 4)
                matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
                matrix[1, 3] = 0.45 * frame
                moving.set_transform(thrown, matrix)
                moving.update()
                print(f"frame {frame}: {moving.tree.info.leaf_count} voxels")
                camera = svocl.Camera((0.9, 3.4, 6.6), (0, 0.45, 0), (0, 1, 0), 0.62)
                parts.append(moving.tree.render(width // frames, width * 3 // 8, camera=camera))
    return np.concatenate(parts, axis=1)


if __name__ == "__main__":
    pathlib.Path("motion.png").write_bytes(svocl.png(picture()))
