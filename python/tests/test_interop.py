# SPDX-License-Identifier: MIT
"""Arrays from and to other packages, meshes of trimesh, grids of pyvista."""

import sys
import types

import numpy as np
import pytest
from shapes import CUBE_INDICES, CUBE_POSITIONS

import svocl

LOOKS = svocl.Need.COLOR | svocl.Need.NORMAL


class Lent:
    """An array that DLPack alone gives."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self, **arguments):
        return self.array.__dlpack__(**arguments)

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


class Far(Lent):
    """An array that is in no host memory."""

    def __dlpack__(self, **_):
        raise BufferError("in the memory of a device")


class Interface:
    """An array that __array_interface__ alone gives."""

    def __init__(self, array):
        self.kept, self.__array_interface__ = array, array.__array_interface__


@pytest.mark.parametrize("kind", [Lent, Interface])
def test_arrays_come_in_without_a_copy(device, kind):
    for dtype in (np.float32, np.float64):
        positions = CUBE_POSITIONS.astype(dtype)
        mesh = svocl.Mesh(kind(positions), kind(CUBE_INDICES))
        assert np.shares_memory(mesh.positions, positions) and mesh.positions.dtype == dtype
        assert np.shares_memory(mesh.indices, CUBE_INDICES)
    rays = svocl.make_rays(kind(np.full((2, 3), 0.5)), kind(np.array([0.0, 0.0, 1.0])))
    numbers = rays.view(np.float32).reshape(2, 8)
    with device.build(mesh, 3, need=svocl.Need.RAYS) as tree:
        assert tree.trace(kind(numbers))["t"].tolist() == [0.5, 0.5]
        assert tree.nearest(kind(np.full((1, 3), 0.25)))["distance"] == 0.25
    voxels = svocl.make_voxels(kind(np.array([[1, 2, 3]])), kind(np.array([9, 8, 7, 6])))
    assert voxels["rgba"].tolist() == [[9, 8, 7, 6]] and voxels[["x", "y", "z"]].tolist() == [(1, 2, 3)]


def test_arrays_elsewhere_are_refused():
    with pytest.raises(TypeError, match="positions: Far is no array in the host's memory: in the memory of a device"):
        svocl.Mesh(Far(CUBE_POSITIONS), CUBE_INDICES)


def arrays_in(value):
    """The arrays of a result, of its tuples and of its properties."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for part in value:
            yield from arrays_in(part)
    elif isinstance(value, svocl.Mesh):
        for name in ("positions", "indices", "normals", "colors", "uvs"):
            yield from arrays_in(getattr(value, name))


def lent_by_dlpack(array):
    """Another look at the array's memory by DLPack; records go by their fields. Before DLPack 1.0, which comes with
    numpy 2.1, it cannot say that an array is read-only."""
    fields = [array[name] for name in array.dtype.names] if array.dtype.names else [array]
    for field in fields:
        assert field.__dlpack_device__() == (1, 0)
        interface = field.__array_interface__
        assert interface["shape"] == field.shape and interface["data"][1] == (not field.flags.writeable)
        if not field.flags.writeable and np.lib.NumpyVersion(np.__version__) < "2.1.0":
            with pytest.raises(BufferError):
                np.from_dlpack(field)
            continue
        lent = np.from_dlpack(field)
        assert lent.dtype == field.dtype and np.array_equal(lent, field, equal_nan=field.dtype.kind == "f")
        assert field.size == 0 or np.shares_memory(lent, array)
        assert lent.flags.writeable == field.flags.writeable


def test_arrays_go_out_by_dlpack(device, cube):
    """All that the package returns is numpy's: what is written to by svocl alone comes read-only."""
    need = svocl.Need.RAYS | svocl.Need.COLOR | svocl.Need.NORMAL | svocl.Need.PROJECTED_AREA
    rays = svocl.make_rays([[0.5, 0.5, -2], [9, 9, 9]], [0, 0, 1])
    points = svocl.make_gather_points([[0.5, 0.5, -0.1]], (0, 0, -1))
    voxels = svocl.make_voxels([[1, 2, 3], [4, 5, 6]], [9, 8, 7, 255])
    cloud = svocl.make_points([[0.0, 0, 0], [1, 2, 3]], [[1, 2, 3], [4, 5, 6]])
    colors = np.tile(np.array([9, 8, 7, 255], np.uint8), (len(cube.positions), 1))
    mesh = svocl.Mesh(cube.positions, cube.indices, colors=colors)
    with device.build(mesh, 4, need=need, origin=(-0.5, -0.5, -0.5), edge=2.0) as tree:
        field = svocl.sdf(tree)
        results = {
            "records": (rays, points, voxels, cloud, svocl.make_instances([0], np.eye(3, 4)[None])),
            "mesh": mesh,
            "tree": (tree.arrays, tree.voxels(), tree.centers()),
            "rays": (tree.trace(rays), tree.trace_voxels(rays), tree.nearest(np.full((3, 3), 0.25))),
            "picture": tree.render(16, 8),
            "field": (field, svocl.surface(field, colors=tree)),
            "normals": svocl.vertex_normals(mesh),
        }
        with svocl.Compact(tree, svocl.Form.SHARED) as compact:
            results["compact"] = (compact.arrays, compact.trace(rays))
        with svocl.Scene([tree], svocl.make_instances([0], np.eye(3, 4)[None])) as scene:
            results["scene"] = (scene.trace(rays), scene.render(16, 8))
        with svocl.Light(tree) as light:
            light.set_sources(sky=(1, 1, 1))
            results["light"] = (light.gather(points), light.render(16, 8))
        with svocl.Voxels.of_points(cloud, 3) as made:
            results["list"] = (made.records, made.counts)
        assert not tree.arrays.child_mask.flags.writeable and not results["list"][0].flags.writeable
    for name, value in results.items():
        arrays = list(arrays_in(value))
        print(name, len(arrays))
        assert arrays
        for array in arrays:
            lent_by_dlpack(array)


# --- trimesh --------------------------------------------------------------------------------------------------------


@pytest.fixture
def trimesh():
    return pytest.importorskip("trimesh")


def test_colors_of_vertices(device, trimesh):
    colors = np.concatenate([255 * CUBE_POSITIONS, np.full((8, 1), 255)], axis=1).astype(np.uint8)
    given = trimesh.Trimesh(CUBE_POSITIONS, CUBE_INDICES, vertex_colors=colors, process=False)
    mesh = svocl.from_trimesh(given)
    expected = svocl.Mesh(CUBE_POSITIONS.astype(np.float64), CUBE_INDICES, colors=colors)
    assert device.build(mesh, 4, need=LOOKS).hash() == device.build(expected, 4, need=LOOKS).hash()
    assert np.array_equal(mesh.colors, colors) and np.array_equal(mesh.indices, CUBE_INDICES)
    assert mesh.materials == () and mesh.normals is None and mesh.uvs is None
    back = expected.to_trimesh()
    assert np.array_equal(back.faces, CUBE_INDICES) and np.array_equal(back.visual.vertex_colors, colors)


def test_colors_of_faces(device, trimesh):
    colors = np.array([[255, 0, 0, 255]] * 4 + [[0, 0, 255, 255]] * 8, np.uint8)
    given = trimesh.Trimesh(CUBE_POSITIONS, CUBE_INDICES, face_colors=colors, process=False)
    mesh = svocl.Mesh.from_trimesh(given)
    assert mesh.vertex_count == 36 and np.array_equal(mesh.colors, np.repeat(colors, 3, axis=0))
    plain = device.build(svocl.Mesh(CUBE_POSITIONS.astype(np.float64), CUBE_INDICES), 4)
    with device.build(mesh, 4, need=svocl.Need.COLOR) as tree:
        assert tree.hash(nodes_only=True) == plain.hash(nodes_only=True)
        leaves = tree.arrays.colors[tree.info.level_begin[4] :]
        assert {tuple(color) for color in leaves.tolist()} >= {(255, 0, 0, 255), (0, 0, 255, 255)}


def painted(trimesh, side, image=None, **look):
    visual = trimesh.visual
    box = trimesh.creation.box((side,) * 3)
    uv = box.vertices[:, :2] / side + 0.5
    material = visual.material.PBRMaterial(baseColorTexture=image, **look)
    box.visual = visual.TextureVisuals(uv=uv, material=material)
    return box


def test_a_scene_looks_as_its_file(device, trimesh, tmp_path):
    """Materials, a texture, emission and transforms of a scene give the tree that svocl reads from its glTF file."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.zeros((4, 4, 3), np.uint8)
    pixels[:2, :, 0], pixels[2:, :, 1] = 255, 200  # above red, below green
    scene = trimesh.Scene()
    scene.add_geometry(painted(trimesh, 1, image.fromarray(pixels)), node_name="textured")
    moved = trimesh.transformations.translation_matrix([2, 0.5, 0])
    glowing = painted(trimesh, 0.5, baseColorFactor=[64, 128, 255, 255], emissiveFactor=[1.0, 0.5, 0.0])
    scene.add_geometry(glowing, node_name="glowing", transform=moved)
    scene.export(tmp_path / "scene.glb")
    mesh = svocl.from_trimesh(scene)
    assert (mesh.triangle_count, len(mesh.textures), len(mesh.materials)) == (24, 1, 2)
    assert sorted(finish.emission for finish in mesh.finishes) == [(0, 0, 0), (1, 0.5, 0)]
    need = svocl.Need.COLOR
    grid = {"origin": (-1, -1, -1), "edge": 4}
    with device.build(mesh, 5, need=need, **grid) as tree:
        colors = tree.arrays.colors[tree.info.level_begin[5] :].astype(int)
        x, y, _ = tree.centers().T
        high, low = ((x < 1) & (np.abs(y - middle) < 0.1) for middle in (0.25, -0.25))  # off the texture's edges
        assert high.any() and (colors[high] == [255, 0, 0, 255]).all()
        assert low.any() and (colors[low] == [0, 200, 0, 255]).all()
        if svocl.has_io:
            from_file = device.build(svocl.read_mesh(tmp_path / "scene.glb"), 5, need=need, **grid)
            assert from_file.hash(nodes_only=True) == tree.hash(nodes_only=True)
            other = from_file.arrays.colors[tree.info.level_begin[5] :].astype(int)
            assert np.abs(colors - other).max() <= 1
    back = mesh.to_trimesh()
    assert isinstance(back, trimesh.Scene) and len(back.geometry) == 2
    again = svocl.from_trimesh(back)
    assert again.triangle_count == 24 and np.array_equal(again.textures[0].rgba, mesh.textures[0].rgba)
    for material, other in zip(sorted(mesh.materials), sorted(again.materials)):
        assert np.abs(np.subtract(material.rgba, other.rgba)).max() <= 2
    assert sorted(again.finishes) == sorted(mesh.finishes)
    assert np.allclose(sorted(map(tuple, again.uvs)), sorted(map(tuple, mesh.uvs)))


def test_mirrored_instances_stay_outside_out(trimesh):
    box = trimesh.creation.box((1, 1, 1))
    scene = trimesh.Scene()
    scene.add_geometry(box, geom_name="box", node_name="plain")
    mirror = np.diag([-2.0, 1, 1, 1])
    mirror[0, 3] = 5
    scene.graph.update(frame_to="mirrored", geometry="box", matrix=mirror)
    mesh = svocl.from_trimesh(scene, normals=True)
    assert mesh.triangle_count == 24 and mesh.normals is not None
    corners = mesh.positions[mesh.indices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middles = np.where(corners.mean(axis=1)[:, :1] < 2, [0.0, 0, 0], [5.0, 0, 0])
    assert ((corners.mean(axis=1) - middles) * normals).sum(axis=1).min() > 0
    outward = mesh.positions - np.where(mesh.positions[:, :1] < 2, [0.0, 0, 0], [5.0, 0, 0])
    assert (outward * mesh.normals).sum(axis=1).min() > 0


def test_what_is_no_mesh_is_refused(trimesh):
    with pytest.raises(TypeError, match="source: list, expected trimesh.Trimesh or trimesh.Scene"):
        svocl.from_trimesh([])
    points = trimesh.Scene(trimesh.PointCloud(CUBE_POSITIONS))
    with pytest.raises(ValueError, match="source: Scene without a mesh"):
        svocl.from_trimesh(points)


def test_packages_that_are_missing_are_named(tree, monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ImportError, match=r"Mesh.to_trimesh needs trimesh: .* \(pip install trimesh\)"):
        svocl.Mesh(CUBE_POSITIONS, CUBE_INDICES).to_trimesh()
    with pytest.raises(ImportError, match=r"Tree.to_pyvista needs pyvista: .* \(pip install pyvista\)"):
        tree.to_pyvista()


# --- pyvista --------------------------------------------------------------------------------------------------------


class Grid:
    """In place of pyvista.UnstructuredGrid, which brings all of VTK: keeps what it is given."""

    def __init__(self, cells, kinds, points):
        self.cells, self.celltypes, self.points, self.cell_data = cells, kinds, points, {}


@pytest.fixture(params=["stand-in", "pyvista"])
def pyvista(request, monkeypatch):
    if request.param == "pyvista":
        return pytest.importorskip("pyvista")
    monkeypatch.setitem(sys.modules, "pyvista", types.SimpleNamespace(UnstructuredGrid=Grid))


@pytest.mark.parametrize("level", [None, 3, 0])
def test_grids_of_voxels(device, torus, pyvista, level):
    mesh = svocl.Mesh(torus.positions, torus.indices, colors=np.tile([9, 8, 7, 255], (torus.vertex_count, 1)))
    with device.build(mesh, 4, need=LOOKS, payload_level=2) as tree:
        grid = tree.to_pyvista(level)
        info, arrays, centers = tree.info, tree.arrays, tree.centers(level)
    last = info.depth if level is None else level
    cells = np.asarray(grid.cells).reshape(-1, 9)
    assert len(cells) == len(centers) and (cells[:, 0] == 8).all() and (np.asarray(grid.celltypes) == 11).all()
    corners = np.asarray(grid.points)[cells[:, 1:]]
    half = info.edge / 2**last / 2
    for octant in range(8):
        sign = np.array([octant & 1, octant >> 1 & 1, octant >> 2 & 1]) * 2 - 1
        assert np.allclose(corners[:, octant], centers + half * sign, atol=1e-12)
    assert len(np.unique(cells[:, 1:])) == len(grid.points) == len(np.unique(grid.points, axis=0))
    assert ("rgba" in grid.cell_data) == ("normal" in grid.cell_data) == (last >= 2)
    if last >= 2:
        first = info.level_begin[2]
        rows = slice(info.level_begin[last] - first, info.level_begin[last + 1] - first)
        assert np.array_equal(grid.cell_data["rgba"], arrays.colors[rows])
        assert np.allclose(grid.cell_data["normal"], arrays.normals[rows] / 32767, atol=1e-6)
