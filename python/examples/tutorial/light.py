"""Step 4: light. A sun and a sky, soft shadows, and what surfaces hand on to each other, by paths of rays."""

import pathlib
import sys

from model import load

import svocl


def picture(depth=7, width=320, path=None, paths=32):
    need = svocl.Need.COLOR | svocl.Need.NORMAL | svocl.Need.RAYS
    with svocl.Device() as device, device.build(load(path), depth, need=need) as tree, svocl.Light(tree) as light:
        sun = svocl.LightSource(svocl.SourceKind.DIRECTIONAL, (2.6, 2.4, 2.0), direction=(-0.5, -1, -0.3))
        light.set_sources([sun], sky=(0.5, 0.6, 0.8))
        return light.render(width, width * 3 // 4, paths=paths, bounces=3)


if __name__ == "__main__":
    pathlib.Path("light.png").write_bytes(svocl.png(picture(path=sys.argv[1] if len(sys.argv) > 1 else None)))
