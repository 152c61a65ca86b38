"""Step 2: its voxels. How many there are at each depth, where they are, and a file of the tree."""

import pathlib
import sys

from model import load

import svocl


def picture(depth=6, width=320, path=None):
    mesh = load(path)
    with svocl.Device() as device:
        for levels in range(3, depth + 1):
            with device.build(mesh, levels, need=svocl.Need.COLOR | svocl.Need.NORMAL) as tree:
                edge = tree.info.edge / 2**levels
                print(f"depth {levels}: {tree.info.leaf_count} voxels, {edge:.4f} wide, hash {tree.hash()}")
                if levels == depth:
                    print("the first three:", tree.voxels()[:3].tolist(), "at", tree.centers()[:3].round(3).tolist())
                    if svocl.has_io:
                        tree.save("voxels.svo")  # svocl info voxels.svo; svocl view voxels.svo
                    return tree.render(width, width * 3 // 4)


if __name__ == "__main__":
    pathlib.Path("voxels.png").write_bytes(svocl.png(picture(path=sys.argv[1] if len(sys.argv) > 1 else None)))
