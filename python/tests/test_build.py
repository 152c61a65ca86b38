# SPDX-License-Identifier: MIT
"""Plans and builds: known counts, every array and its shape, what a plan lists, the library's words in exceptions."""

import pickle

import numpy as np
import pytest
from shapes import CUBE_INDICES, CUBE_POSITIONS

import svocl


def test_counts_and_hash_of_the_cube(device, cube):
    """The figures of README.md; float64 positions and the builder change nothing."""
    with device.build(cube, 7) as tree:
        assert (tree.info.leaf_count, tree.info.node_count) == (96776, 128073)
        nodes = tree.hash(nodes_only=True)
        assert len(nodes) == 32
    double = svocl.Mesh(CUBE_POSITIONS.astype(np.float64), CUBE_INDICES.astype(np.int64))
    with device.build(double, 7, need=svocl.Need.NONE) as tree:
        assert tree.hash(nodes_only=True) == nodes
    with device.build(cube, 7, need=svocl.Need.NONE, builder=svocl.Builder.SORTED) as tree:
        assert tree.hash(nodes_only=True) == nodes and tree.report.builder == "sorted"


def test_float64_positions_keep_their_precision(device):
    """A triangle far from the origin, whose corners are one point in float32."""
    positions = np.array([[0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0]]) + 1e6
    with device.plan(svocl.Mesh(positions), 3) as plan:
        assert plan.info.edge == pytest.approx(1e-3, rel=1e-3)
    with device.plan(svocl.Mesh(positions.astype(np.float32)), 3) as plan:
        assert plan.info.edge != pytest.approx(1e-3, rel=1e-3)


def test_plan_lists_bytes_and_what_it_leaves_out(device, torus):
    with device.plan(torus, 5, need=svocl.Need.COLOR) as plan:
        info = plan.info
        assert (info.depth, info.need, info.coverage) == (5, svocl.Need.COLOR, svocl.Coverage.HALF_OPEN)
        assert info.triangles == 576 and info.refused_triangles == 0 and info.fragments == 0
        reasons = {entry.what: entry.reason for entry in plan.left_out}
        assert reasons["normal"] == "it is not requested"
        assert {kernels.name for kernels in plan.kernels} >= {"voxelize", "subdivide"}
        assert 1 <= plan.info.ray_depth <= 12
        text = str(plan)
        for buffer in plan.buffers:
            assert buffer.name in text and f"{buffer.bytes:,} bytes" in text
        assert "without normal: it is not requested" in text
        counted = plan.count()
        assert counted == plan.info.fragments > 0
        with plan.build() as tree:
            assert tree.info.fragments == tree.report.fragments
            assert 0 <= counted - tree.info.fragments <= tree.report.undecided
            assert sum(buffer.bytes for buffer in plan.buffers if buffer.persistent) == plan.info.tree_bytes
            assert all(buffer.certainty == svocl.Certainty.EXACT for buffer in plan.buffers)
            assert plan.info.peak_bytes >= plan.info.tree_bytes > 0
            assert {"grid", "compile", "voxelize", "subdivide"} <= set(tree.report.stages)
            assert all(stage.ms >= 0 and stage.clock in ("wall", "cl-event") for stage in tree.report.stages.values())


def test_pairs_below_an_alpha_are_left_out(device):
    """A square whose alpha grows from its left side to its right one, built, and as a scene that moves."""
    positions = np.array([[0, 0, 0.51], [1, 0, 0.51], [1, 1, 0.51], [0, 1, 0.51]], np.float32)
    colors = np.array([[255, 255, 255, alpha] for alpha in (0, 255, 255, 0)], np.uint8)
    mesh = svocl.Mesh(positions, np.array([[0, 1, 2], [0, 2, 3]]), colors=colors)
    grid = {"origin": (0, 0, 0), "edge": 1.0}
    with device.build(mesh, 5, **grid) as whole, device.build(mesh, 5, drop_alpha=0.75, **grid) as tree:
        assert whole.info.leaf_count == 1024 and whole.report.dropped == 0
        assert tree.info.leaf_count == 256 and tree.voxels()[:, 0].min() == 24
        assert tree.report.dropped + tree.report.fragments == whole.report.fragments
        assert tree.report.stages["drop"].ms >= 0 and "drop" not in whole.report.stages
    with device.plan(mesh, 5, drop_alpha=0.5) as plan, device.plan(mesh, 5) as other:
        assert plan.info.drops_pairs and not other.info.drops_pairs
    with svocl.Moving(device, mesh, 5, drop_alpha=0.75, **grid) as moving:
        assert moving.tree.info.leaf_count == 256
    with pytest.raises(svocl.InvalidArgumentError, match="drop_alpha 2 is not in 0 .. 1"):
        device.plan(mesh, 5, drop_alpha=2.0)


def test_callers_grid(device, cube):
    with device.build(cube, 3, origin=(-1.0, -1.0, -1.0), edge=4.0) as tree:
        assert (tree.info.origin, tree.info.edge) == ((-1.0, -1.0, -1.0), 4.0)
        voxels = tree.voxels()
        assert voxels.min() == 2 and voxels.max() == 4  # 0 .. 1 in voxels of 0.5, half-open
    for arguments in ({"origin": (0, 0, 0)}, {"edge": 1.0}):
        with pytest.raises(ValueError, match="origin and edge: give both or neither"):
            device.plan(cube, 3, **arguments)
    with pytest.raises(ValueError, match=r"origin: shape \(2,\), expected \(3,\)"):
        device.plan(cube, 3, origin=(0, 0), edge=1.0)
    with pytest.raises(ValueError, match="edge: 0.0 is not above 0"):
        device.plan(cube, 3, origin=(0, 0, 0), edge=0.0)


def test_arrays_are_views_of_the_right_shape(device, torus):
    need = svocl.Need.COLOR | svocl.Need.NORMAL | svocl.Need.RAYS | svocl.Need.MATERIAL
    tree = device.build(torus, 4, need=need | svocl.Need.FILL | svocl.Need.PROJECTED_AREA)
    info, arrays = tree.info, tree.download()
    assert info.node_count == info.inner_count + info.leaf_count == info.level_begin[-1]
    assert len(info.level_begin) == info.depth + 2
    shapes = {
        "child_mask": ((info.inner_count,), np.uint8),
        "first_child": ((info.inner_count,), np.uint32),
        "colors": ((info.node_count, 4), np.uint8),
        "normals": ((info.node_count, 3), np.int16),
        "list_begin": ((info.leaf_count + 1,), np.uint32),
        "list": ((info.list_count,), np.uint32),
        "vertices": ((info.vertex_count, 3), np.int32),
        "indices": ((info.list_triangle_count, 3), np.uint32),
        "triangle_ids": ((info.list_triangle_count,), np.uint32),
        "materials": ((info.node_count,), np.uint16),
        "fills": ((info.node_count,), np.uint16),
        "areas": ((info.leaf_count, 6), np.uint16),
        "positions_double": ((info.vertex_count, 3), np.float64),
    }
    assert set(shapes) | {"positions"} == set(svocl.TreeArrays._fields)
    assert info.positions == svocl.Positions.DOUBLE
    assert arrays.positions is None
    assert np.array_equal(arrays.positions_double, torus.positions)
    again = tree.arrays
    for name, (shape, dtype) in shapes.items():
        array = getattr(arrays, name)
        assert (array.shape, array.dtype) == (shape, dtype), name
        assert not array.flags.writeable, name
        assert array.__array_interface__["data"] == getattr(again, name).__array_interface__["data"], name
    assert arrays.list_begin[-1] == info.list_count
    assert np.unpackbits(arrays.child_mask).sum() == info.node_count - 1
    positions = arrays.vertices / info.scale + np.array(info.origin)
    assert np.abs(positions - torus.positions).max() <= (1 + 1e-9) / info.scale
    tree.close()


def test_payload_of_the_lower_levels_alone(device, torus):
    with device.build(torus, 4, need=svocl.Need.FILL, payload_level=4) as tree:
        assert tree.arrays.fills.shape == (tree.info.leaf_count,) and tree.arrays.colors is None


def test_opposite_rays_see_as_much_of_a_closed_mesh(device, torus):
    need = svocl.Need.PROJECTED_AREA
    with device.build(torus, 4, need=need, weights=svocl.Weights.UNIFORM) as tree:
        seen = tree.arrays.areas.sum(axis=0, dtype=np.int64)
        assert seen.min() > 0 and np.abs(seen[0::2] - seen[1::2]).max() <= tree.info.leaf_count


def test_voxels_hold_the_surface(device, torus):
    """Samples of the triangles lie in leaves; each leaf has a parent; centers lie half a voxel inside."""
    with device.build(torus, 5, need=svocl.Need.NONE) as tree:
        info = tree.info
        leaves = set(map(tuple, tree.voxels().tolist()))
        assert len(leaves) == info.leaf_count
        weights = np.array([[0.2, 0.3, 0.5], [0.6, 0.1, 0.3], [1 / 3, 1 / 3, 1 / 3]])
        samples = np.einsum("wk,tkx->twx", weights, torus.positions[torus.indices]).reshape(-1, 3)
        places = (samples - np.array(info.origin)) / info.edge * 2**5
        near_a_face = np.abs(places - np.round(places)).min(axis=1) < 1e-3  # rounded differently here
        found = [tuple(place) in leaves for place in np.floor(places[~near_a_face]).astype(int).tolist()]
        assert len(found) > 1000 and all(found)
        assert set(map(tuple, (tree.voxels() >> 1).tolist())) == set(map(tuple, tree.voxels(4).tolist()))
        assert np.array_equal(tree.voxels(0), [[0, 0, 0]])
        first = np.array(info.origin) + (tree.voxels()[0] + 0.5) * info.edge / 32
        assert np.allclose(tree.centers()[0], first)
        with pytest.raises(ValueError, match=r"level: 6 is not in 0 \.\. 5"):
            tree.voxels(6)


def test_a_mesh_without_triangles(device):
    empty = svocl.Mesh(np.empty((0, 3), np.float32), np.empty((0, 3), np.uint32))
    with device.build(empty, 3, need=svocl.Need.NONE) as tree:
        assert tree.info.leaf_count == 0 and tree.voxels().shape == (0, 3)
        assert tree.arrays.child_mask.tolist() == [0]


def test_exceptions_have_the_words_and_the_status_of_the_library(device, cube):
    with pytest.raises(svocl.InvalidArgumentError, match=r"svo_plan_create: depth 17 is not in 1 \.\. 16") as caught:
        device.plan(cube, 17)
    assert caught.value.status == svocl.Status.INVALID_ARGUMENT
    assert isinstance(caught.value, (svocl.Error, ValueError)) and isinstance(caught.value, ValueError)
    copy = pickle.loads(pickle.dumps(caught.value))
    assert (type(copy), str(copy), copy.status) == (type(caught.value), str(caught.value), caught.value.status)
    with pytest.raises(svocl.NoDeviceError, match="no such device here"):
        svocl.Device("no such device here")
    with pytest.raises(svocl.InvalidArgumentError):
        device.plan(cube, 3, need=svocl.Need.FILL, weights=svocl.Weights.UNIFORM)


@pytest.mark.parametrize(
    ("arguments", "kind", "words"),
    [
        ({"depth": -1}, ValueError, "depth: -1 is not in 0 .. 4294967295"),
        ({"depth": 2.5}, TypeError, "float"),
        ({"coverage": 3}, ValueError, "3 is not a valid Coverage"),
        ({"fragment_capacity": -1}, ValueError, "fragment_capacity: -1 is not in 0 .. 18446744073709551615"),
        ({"mesh": CUBE_POSITIONS}, TypeError, "mesh: ndarray, expected svocl.Mesh"),
    ],
)
def test_wrong_arguments_of_a_plan(device, cube, arguments, kind, words):
    with pytest.raises(kind) as caught:
        device.plan(**{"mesh": cube, "depth": 3, **arguments})
    assert words in str(caught.value)


def test_every_status_has_a_class_of_its_own():
    from svocl import _errors

    classes = {type(_errors.error(status)) for status in svocl.Status if status != svocl.Status.OK}
    assert len(classes) == len(svocl.Status) - 1
    assert all(issubclass(kind, svocl.Error) and getattr(svocl, kind.__name__) is kind for kind in classes)
    assert str(_errors.error(svocl.Status.NO_DEVICE)) == "no OpenCL platform or device fits"


def test_a_trusted_driver_gives_the_same_tree(device, cube):
    with svocl.Device(trust_driver=True) as trusted:
        assert trusted.build(cube, 4).hash() == device.build(cube, 4).hash()
    assert issubclass(svocl.DeviceUnreliableError, svocl.Error)


def test_a_picture(device, cube):
    with device.build(cube, 4) as tree:
        camera = tree.frame(4 / 3)
        picture = tree.render(64, 48)
        assert (picture.shape, picture.dtype) == ((48, 64, 4), np.uint8)
        assert np.array_equal(picture, tree.render(64, 48, camera=camera))
        background, middle = picture[0, 0], picture[24, 32]
        assert not np.array_equal(background, middle)
        turned = tree.frame(4 / 3, svocl.Camera((0, 0, 0), (0, 0, 0), (0, 0, 2), 1.0))
        assert turned.up == (0, 0, 2) and turned.vertical_fov == 1.0 and turned.eye != camera.eye
        assert turned.eye[2] > turned.target[2] and turned.eye[1] < turned.target[1]
        with pytest.raises(svocl.InvalidArgumentError, match="has no frame"):
            tree.frame(1.0, svocl.Camera((0, 1, 0), (0, 0, 0), (0, 1, 0), 1.0))
        away = camera._replace(target=tuple(2 * e - t for e, t in zip(camera.eye, camera.target)))
        assert np.all(tree.render(64, 48, camera=away)[:, :, 3] == background[3])
        assert not np.array_equal(tree.render(64, 48, camera=away)[24, 32], middle)
        with pytest.raises(svocl.InvalidArgumentError, match="svo_render: 0 x 48 pixels"):
            tree.render(0, 48)
        with pytest.raises(svocl.InvalidArgumentError, match="svo_render: 20000 x 20000 pixels"):
            tree.render(20000, 20000)
