# SPDX-License-Identifier: MIT
"""Baked light beside closed forms: floors under a sky and a sun, closed rooms; normals; texels of charts; seams; and
vertices of files found again."""

import numpy as np
import pytest
import shapes

import svocl

NEED = svocl.Need.NORMAL | svocl.Need.COLOR | svocl.Need.RAYS
FLOOR = svocl.Mesh(
    np.array([[0, 0.5, 0], [1, 0.5, 0], [1, 0.5, 1], [0, 0.5, 1]], np.float32),
    np.array([[0, 2, 1], [0, 3, 2]], np.uint32),
    uvs=np.array([[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]], np.float32),
)
SUN = svocl.LightSource(svocl.SourceKind.DIRECTIONAL, (4, 2, 1), direction=(0, -3, 4))


@pytest.fixture(scope="module")
def floor(device):
    """A light of a square of edge 1 across the middle of the grid."""
    with device.build(FLOOR, 5, need=NEED, origin=(0, 0, 0), edge=1.01) as tree, svocl.Light(tree) as light:
        yield light


def test_floors_see_the_sky(floor):
    """An irradiance of pi times the sky's radiance; open; texels outside charts are marked."""
    floor.set_sources(sky=(1, 0.5, 0))
    baked = svocl.bake_vertices(floor, FLOOR)
    assert baked.irradiance.shape == (4, 3) and baked.openness.shape == (4,)
    assert np.allclose(baked.irradiance, np.pi * np.array([1, 0.5, 0]), rtol=1e-3)
    assert np.array_equal(baked.openness, np.ones(4, np.float32))
    map = svocl.bake_lightmap(floor, FLOOR, 16, 16, dilate=0)
    inside = np.zeros((16, 16), bool)
    inside[4:12, 4:12] = True
    assert np.array_equal(map.coverage, inside.astype(np.uint8)) and np.array_equal(map.triangles >= 0, inside)
    assert np.allclose(map.irradiance[inside], np.pi * np.array([1, 0.5, 0]), rtol=1e-3)
    assert not map.irradiance[~inside].any() and not map.openness[~inside].any()
    assert set(map.triangles[inside]) == {0, 1}


def test_suns_are_part_of_it(floor):
    """Irradiance times the cosine, 3/5."""
    floor.set_sources([SUN])
    baked = svocl.bake_vertices(floor, FLOOR, bounces=1)
    assert np.allclose(baked.irradiance, 0.6 * np.array([4, 2, 1]), rtol=1e-4)
    below = svocl.bake_vertices(floor, FLOOR, normals=-svocl.vertex_normals(FLOOR))
    assert not below.irradiance.any()


def test_seams_are_dilated(floor):
    floor.set_sources(sky=(1, 1, 1))
    map = svocl.bake_lightmap(floor, FLOOR, 16, 16, dilate=2)
    counts = [(map.coverage == kind).sum() for kind in range(3)]
    assert counts == [256 - 144, 64, 144 - 64]
    assert np.allclose(map.irradiance[map.coverage > 0], np.pi, rtol=1e-3)
    assert not map.irradiance[map.coverage == 0].any() and (map.triangles[map.coverage == 2] == -1).all()


def test_closed_rooms_are_dark(device, cube):
    """From inside, under a bright sky: at texels and at vertices that are drawn inwards."""
    uvs = cube.positions[:, :2] * 0.9 + 0.05 + 0.02 * cube.positions[:, 2:]
    inwards = svocl.Mesh(cube.positions, cube.indices[:, ::-1], uvs=uvs)
    with device.build(inwards, 6, need=NEED) as tree, svocl.Light(tree) as light:
        light.set_sources(sky=(1, 1, 1))
        map = svocl.bake_lightmap(light, inwards, 32, 32)
        assert (map.coverage == 1).sum() > 700
        assert map.openness.max() < 0.02 and map.irradiance.max() < 0.02 * np.pi


def test_texels_lie_on_their_triangles(torus):
    """Places, normals and triangles of a torus whose chart is the square."""
    around, across = 24, 12
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    uvs = np.stack([u / around, v / across], axis=-1).reshape(-1, 2)
    wraps = np.ptp(uvs[torus.indices], axis=1).max(axis=1) > 0.5  # triangles across the chart's end
    mesh = svocl.Mesh(torus.positions, torus.indices[~wraps], uvs=uvs)
    texels = svocl.lightmap_texels(mesh, 96, 48)
    assert len(texels.rows) > 0.85 * 96 * 48
    assert np.allclose(np.linalg.norm(texels.normals, axis=1), 1)
    ring = texels.positions.copy()
    ring[:, 2] = 0
    ring /= np.linalg.norm(ring, axis=1, keepdims=True)
    out = texels.positions - ring
    assert (np.abs(np.linalg.norm(out, axis=1) - 0.4) < 0.03).all()
    assert ((out / np.linalg.norm(out, axis=1, keepdims=True) * texels.normals).sum(axis=1) > 0.94).all()
    corners = mesh.positions[mesh.indices[texels.triangles]]
    plane = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.abs(((texels.positions - corners[:, 0]) * plane).sum(axis=1)).max() < 1e-12


def test_normals_of_vertices(cube, torus):
    """By angles a cube's corners have diagonals, however its faces are cut; by areas they do not."""
    diagonal = (cube.positions - 0.5) / np.sqrt(0.75)
    assert np.allclose(svocl.vertex_normals(cube), diagonal, atol=1e-6)
    assert not np.allclose(svocl.vertex_normals(cube, "area"), diagonal, atol=0.1)
    split = svocl.Mesh(cube.positions[cube.indices].reshape(-1, 3))
    assert np.allclose(svocl.vertex_normals(split), diagonal[cube.indices].reshape(-1, 3), atol=1e-6)
    hard = svocl.vertex_normals(split, join=False)
    assert np.allclose(np.sort(np.abs(hard), axis=1), [0, 0, 1])
    ring = torus.positions * [1, 1, 0]
    out = torus.positions - ring / np.linalg.norm(ring, axis=1, keepdims=True)
    for weights in ("angle", "area"):
        assert ((svocl.vertex_normals(torus, weights) * out).sum(axis=1) > 0.4 * 0.98).all()
    lonely = svocl.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5], [2, 0, 0]], [[0, 1, 2], [0, 1, 4]])
    assert np.array_equal(svocl.vertex_normals(lonely), [[0, 0, 1]] * 3 + [[0, 0, 0]] * 2)


def test_charts_that_overlap_and_leave_the_map():
    """The first triangle wins; what is outside, not finite or without area has no texels."""
    uvs = np.array([[-1, -1], [3, -1], [-1, 3], [0, 0], [1, 0], [np.nan, 1]], np.float32)
    mesh = svocl.Mesh(np.eye(6, 3), [[3, 4, 5], [3, 4, 4], [0, 1, 2], [1, 0, 2]], uvs=uvs)
    texels = svocl.lightmap_texels(mesh, 5, 3)
    assert len(texels.rows) == 15 and (texels.triangles == 2).all()
    assert (len(svocl.lightmap_texels(mesh, 3, 3, uvs=uvs + 10).rows)) == 0


def test_large_maps_are_made_piece_by_piece(monkeypatch):
    whole = svocl.lightmap_texels(FLOOR, 40, 30)
    monkeypatch.setattr("svocl._bake._PAIRS", 100)
    pieces = svocl.lightmap_texels(FLOOR, 40, 30)
    assert len(whole.rows) > 250 and all(np.array_equal(a, b) for a, b in zip(whole, pieces))


def test_wrong_arguments(floor):
    with pytest.raises(ValueError, match="uvs: the mesh has none"):
        svocl.lightmap_texels(svocl.Mesh(FLOOR.positions, FLOOR.indices), 4, 4)
    with pytest.raises(ValueError, match="0 x 4"):
        svocl.lightmap_texels(FLOOR, 0, 4)
    with pytest.raises(ValueError, match="weights"):
        svocl.vertex_normals(FLOOR, "length")
    with pytest.raises(ValueError, match="normals"):
        svocl.bake_vertices(floor, FLOOR, normals=np.zeros((3, 3)))
    with pytest.raises(ValueError, match="index 9"):
        svocl.vertex_normals(svocl.Mesh(FLOOR.positions, [[0, 1, 9]]))
    with pytest.raises(svocl.InvalidArgumentError):
        svocl.bake_vertices(floor, FLOOR, paths=17)


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_vertices_of_files_are_found_again(tmp_path):
    positions = [[0, 0, 0], [1, 1, 0], [2, 4, 0], [3, 9, 0], [0, 0, 0]]
    lines = [f"v {x} {y} {z}" for x, y, z in positions] + ["f 1 2 4", "f 5 4 2"]
    (tmp_path / "map.obj").write_text("\n".join(lines))
    mesh = svocl.read_mesh(tmp_path / "map.obj")
    found = mesh.file_vertices
    assert mesh.vertex_count == 3 and found.tolist().index(svocl.NO_VERTEX) == 2
    used = np.delete(np.arange(5), 2)
    assert np.array_equal(mesh.positions[found[used]], np.array(positions, np.float32)[used])
    assert svocl.Mesh(*shapes.torus()).file_vertices is None
