# SPDX-License-Identifier: MIT
"""Meshes from numpy arrays: what is used as it is, what is converted, and what is refused with which words."""

import numpy as np
import pytest
from shapes import CUBE_INDICES, CUBE_POSITIONS

import svocl

TRIANGLE = np.zeros((3, 3), np.float32)


def test_matching_arrays_are_not_copied():
    for dtype in (np.float32, np.float64):
        positions = CUBE_POSITIONS.astype(dtype)
        mesh = svocl.Mesh(positions, CUBE_INDICES)
        assert mesh.positions is positions or np.shares_memory(mesh.positions, positions)
        assert mesh.positions.dtype == dtype
        assert np.shares_memory(mesh.indices, CUBE_INDICES)


def test_other_layouts_are_copied():
    columns = np.asfortranarray(CUBE_POSITIONS)
    reversed_rows = CUBE_INDICES[::-1]
    mesh = svocl.Mesh(columns, reversed_rows)
    assert mesh.positions.flags.c_contiguous and np.array_equal(mesh.positions, CUBE_POSITIONS)
    assert mesh.indices.flags.c_contiguous and np.array_equal(mesh.indices, CUBE_INDICES[::-1])
    big_endian = svocl.Mesh(CUBE_POSITIONS.astype(">f4"), CUBE_INDICES.astype(">u4"))
    assert big_endian.positions.dtype == np.float32 and np.array_equal(big_endian.positions, CUBE_POSITIONS)
    assert np.array_equal(big_endian.indices, CUBE_INDICES)


def test_lists_and_other_integers_are_converted():
    mesh = svocl.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], colors=[[255, 0, 0, 255]] * 3)
    assert mesh.positions.dtype == np.float64 and mesh.indices.dtype == np.uint32 and mesh.colors.dtype == np.uint8
    for dtype in (np.int64, np.int32, np.uint16, np.uint8):
        assert np.array_equal(svocl.Mesh(CUBE_POSITIONS, CUBE_INDICES.astype(dtype)).indices, CUBE_INDICES)


def test_without_indices_three_vertices_are_a_triangle():
    assert svocl.Mesh(np.zeros((6, 3), np.float32)).triangle_count == 2
    with pytest.raises(ValueError, match=r"positions: shape \(8, 3\), expected \(3 \* triangle_count, 3\)"):
        svocl.Mesh(CUBE_POSITIONS)


@pytest.mark.parametrize(
    ("arguments", "kind", "words"),
    [
        (
            {"positions": np.zeros((4, 2), np.float32)},
            ValueError,
            "positions: shape (4, 2), expected (vertex_count, 3)",
        ),
        ({"positions": np.zeros(12, np.float32)}, ValueError, "positions: shape (12,), expected (vertex_count, 3)"),
        (
            {"positions": np.zeros((3, 3), np.int32)},
            TypeError,
            "positions: dtype int32, expected float32 or float64, of shape (vertex_count, 3)",
        ),
        ({"positions": np.zeros((3, 3), np.complex64)}, TypeError, "positions: dtype complex64"),
        ({"positions": "cube"}, TypeError, "positions: str is no array of float64"),
        ({"positions": [[0, 0, 0], [1, 0]]}, TypeError, "positions: list is no array of float64"),
        (
            {"indices": np.zeros((1, 3), np.float32)},
            TypeError,
            "indices: dtype float32, expected uint32, of shape (triangle_count, 3)",
        ),
        ({"indices": [[0.5, 1, 2]]}, TypeError, "indices: list is no array of uint32"),
        ({"indices": np.zeros((2, 4), np.uint32)}, ValueError, "indices: shape (2, 4), expected (triangle_count, 3)"),
        ({"indices": np.array([[0, 1, -1]])}, ValueError, "indices: -1 is not in 0 .. 4294967295"),
        ({"indices": np.array([[0, 1, 2**32]])}, ValueError, "indices: 4294967296 is not in 0 .. 4294967295"),
        ({"normals": np.zeros((2, 3), np.float32)}, ValueError, "normals: shape (2, 3), expected (3, 3)"),
        ({"colors": np.zeros((3, 3), np.uint8)}, ValueError, "colors: shape (3, 3), expected (3, 4)"),
        ({"colors": np.zeros((3, 4), np.float32)}, TypeError, "colors: dtype float32, expected uint8, of shape (3, 4)"),
        ({"colors": np.full((3, 4), 256)}, ValueError, "colors: 256 is not in 0 .. 255"),
        ({"uvs": np.zeros((3, 3), np.float32)}, ValueError, "uvs: shape (3, 3), expected (3, 2)"),
        (
            {"triangle_materials": np.zeros(2, np.uint16)},
            ValueError,
            "triangle_materials: shape (2,), expected (1,)",
        ),
        (
            {"textures": [svocl.Texture(np.zeros((2, 2, 3), np.uint8))]},
            ValueError,
            "textures[0].rgba: shape (2, 2, 3), expected (height, width, 4)",
        ),
    ],
)
def test_wrong_arrays_are_named_with_what_is_expected(arguments, kind, words):
    with pytest.raises(kind) as caught:
        svocl.Mesh(**{"positions": TRIANGLE, **arguments})
    assert words in str(caught.value)


def test_finishes_are_one_for_each_material():
    finish = svocl.Finish((2, 0, 0.5), (0.25, 0.25, 0.25), 16)
    mesh = svocl.Mesh(TRIANGLE, materials=[svocl.Material()], finishes=[finish])
    assert mesh.finishes == (finish,)
    with pytest.raises(ValueError) as caught:
        svocl.Mesh(TRIANGLE, finishes=[finish])
    assert "finishes: 1, expected 0, one for each material" in str(caught.value)


def test_normal_maps_are_one_for_each_material():
    map = svocl.NormalMap(0, 0.5)
    mesh = svocl.Mesh(TRIANGLE, materials=[svocl.Material()], normal_maps=[map])
    assert mesh.normal_maps == (map,)
    with pytest.raises(ValueError, match="normal_maps: 1, expected 0, one for each material"):
        svocl.Mesh(TRIANGLE, normal_maps=[map])


def test_every_array_reaches_the_tree(device):
    """Two triangles side by side: one red by its vertices, one half as bright by its material and green texture."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [4, 0, 0], [5, 0, 0], [4, 1, 0]], np.float32)
    white, red = [255, 255, 255, 255], [255, 0, 0, 255]
    texture = svocl.Texture(np.tile(np.array([0, 255, 0, 255], np.uint8), (2, 2, 1)), svocl.Wrap.CLAMP)
    mesh = svocl.Mesh(
        positions,
        normals=np.tile(np.array([0, 1, 0], np.float64), (6, 1)),
        colors=np.array([red] * 3 + [white] * 3, np.uint8),
        uvs=np.full((6, 2), 0.5, np.float32),
        triangle_materials=np.array([0, 1], np.uint16),
        materials=[svocl.Material(), svocl.Material((128, 128, 128, 255), 0)],
        textures=[texture],
        finishes=[svocl.Finish(), svocl.Finish((1, 2, 3))],
    )
    need = svocl.Need.COLOR | svocl.Need.NORMAL | svocl.Need.MATERIAL
    with device.build(mesh, 4, need=need) as tree:
        info, arrays, centers = tree.info, tree.arrays, tree.centers()
    leaves = slice(info.level_begin[info.depth], None)
    left = centers[:, 0] < 2.5
    assert left.any() and not left.all()
    assert np.all(arrays.colors[leaves][left] == red)
    assert np.all(arrays.colors[leaves][~left] == [0, 128, 0, 255])
    assert np.array_equal(arrays.materials[leaves], np.where(left, 0, 1))
    assert np.all(arrays.normals[leaves] == [0, 32767, 0])


def test_objects_with_vertices_and_faces(device):
    """What trimesh and Open3D have: vertices and faces, or triangles, as arrays or as what makes arrays."""
    positions, indices = np.asarray(CUBE_POSITIONS, np.float64), np.asarray(CUBE_INDICES, np.int64)
    expected = device.build(svocl.Mesh(positions, indices), 4).hash()

    class Trimesh:
        vertices, faces = positions, indices

    class Open3D:
        vertices, triangles = list(map(tuple, positions)), indices.tolist()

    class Both(Trimesh):
        @property
        def triangles(self):
            raise AssertionError("not needed")

    assert device.build(Trimesh(), 4).hash() == expected
    assert device.build(Open3D(), 4).hash() == expected
    assert device.build(Both(), 4).hash() == expected
    with svocl.Moving(device, Trimesh(), 4, origin=(-2, -2, -2), edge=4, need=svocl.Need.RAYS) as moving:
        assert moving.add(Open3D()) == 0
    with pytest.raises(TypeError, match="mesh: object, expected svocl.Mesh or an object with vertices and faces"):
        device.build(object(), 4)
    with pytest.raises(ValueError, match="indices: 8589934599 is not in 0 .. 4294967295"):
        svocl.Mesh(positions, indices + 2**33)
