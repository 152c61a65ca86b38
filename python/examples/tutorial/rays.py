"""Step 3: rays. They meet the triangles exactly, in batches of any shape: here one for each pixel, which gets the
distance as its brightness."""

import pathlib
import sys

import numpy as np
from model import load

import svocl


def eye_rays(camera, width, height):
    """A ray through the center of each pixel: (height, width) records of ray_dtype."""
    forward = np.subtract(camera.target, camera.eye)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    pixel = 2 * np.tan(camera.vertical_fov / 2) / height
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - 0.5 - np.arange(height))
    return svocl.make_rays(
        camera.eye, forward + pixel * (x[..., None] * right + y[..., None] * np.cross(right, forward))
    )


def picture(depth=7, width=320, path=None):
    height = width * 3 // 4
    with svocl.Device() as device, device.build(load(path), depth, need=svocl.Need.RAYS) as tree:
        hits = tree.trace(eye_rays(tree.frame(width / height), width, height))
        nearest = tree.nearest([[0.0, 2.0, 0.0]])[0]
        print(f"nearest to (0, 2, 0) is triangle {nearest['triangle']}, {nearest['distance']:.3f} away")
    met = np.isfinite(hits["t"])
    print(f"{met.sum()} of {met.size} rays meet a triangle")
    shown = np.zeros((height, width, 4), np.uint8)
    far, near = hits["t"][met].max(), hits["t"][met].min()
    shown[met, :3] = (40 + 215 * (far - hits["t"][met]) / (far - near))[:, None]
    shown[..., 3] = 255
    return shown


if __name__ == "__main__":
    pathlib.Path("rays.png").write_bytes(svocl.png(picture(path=sys.argv[1] if len(sys.argv) > 1 else None)))
