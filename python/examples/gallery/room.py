"""Light in a room: a lamp under the ceiling, its soft shadows, and the colors that the walls hand on."""

import pathlib

import numpy as np

import svocl

WHITE, RED, GREEN = (205, 200, 190, 255), (190, 45, 35, 255), (55, 140, 60, 255)
QUADS = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]  # -x, +x, -y, +y, -z, +z


def box(center, half, turn=0.0, faces=range(6), colors=(WHITE,) * 6, inward=False):
    """Corners of triangles (n, 3) and their colors (n, 4)."""
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) * 2 - 1
    turned = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    corners = (corners * half) @ turned.T + center
    order = [0, 2, 1, 0, 3, 2] if inward else [0, 1, 2, 0, 2, 3]
    points = np.concatenate([corners[[QUADS[face][k] for k in order]] for face in faces])
    return points, np.repeat([colors[face] for face in faces], 6, axis=0)


def room():
    walls = (RED, GREEN, WHITE, WHITE, WHITE, WHITE)
    parts = [
        box((0, 1, 0), (1.32, 1, 1), faces=range(5), colors=walls, inward=True),
        box((-0.45, 0.6, -0.3), (0.3, 0.6, 0.3), turn=0.3),
        box((0.45, 0.3, 0.25), (0.3, 0.3, 0.3), turn=-0.3),
    ]
    positions, colors = (np.concatenate(part) for part in zip(*parts))
    return svocl.Mesh(positions, colors=colors)


def picture(depth=8, width=480):
    need = svocl.Need.COLOR | svocl.Need.NORMAL | svocl.Need.RAYS
    with svocl.Device() as device, device.build(room(), depth, need=need) as tree, svocl.Light(tree) as light:
        lamp = svocl.LightSource(svocl.SourceKind.POINT, (6.5, 5.9, 5.0), position=(0, 1.8, 0), radius=0.12)
        light.set_sources([lamp])
        camera = svocl.Camera((0, 1, 4.15), (0, 1, 0), (0, 1, 0), 0.6)
        return light.render(width, width * 3 // 4, camera=camera, paths=32, bounces=4)


if __name__ == "__main__":
    pathlib.Path("room.png").write_bytes(svocl.png(picture()))
