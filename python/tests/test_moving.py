# SPDX-License-Identifier: MIT
"""Scenes that move: their trees are those of full builds, trees end with updates, and light follows."""

import gc
import weakref

import numpy as np
import pytest

import svocl

GRID = {"origin": (-2, -2, -2), "edge": 4.0}
DEPTH = 4
LAMP = svocl.LightSource(svocl.SourceKind.POINT, (4, 2, 1), (0, 1.8, 0))


def placed(x, y, z, scale=0.5):
    """A 4 x 4 matrix."""
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = x, y, z
    return matrix


@pytest.fixture
def moving(device, torus):
    with svocl.Moving(device, torus, DEPTH, need=svocl.Need.RAYS, **GRID) as made:
        yield made


@pytest.fixture
def box(cube):
    """A cube in double, as the torus is."""
    return svocl.Mesh(cube.positions.astype(np.float64), cube.indices)


def built_hash(device, moving):
    """Of a full build of the scene's mesh."""
    info = moving.info
    with device.build(moving.mesh(), DEPTH, need=info.need, weight_log2=info.weight_log2, **GRID) as tree:
        return tree.hash()


def test_updates_make_the_trees_of_full_builds(device, torus, box):
    static = svocl.Mesh(torus.positions, torus.indices, normals=torus.positions)
    box = svocl.Mesh(box.positions, box.indices, normals=np.ones((8, 3)))
    hashes = []
    with svocl.Moving(device, static, DEPTH, **GRID) as moving:
        assert moving.info.need == svocl.Need.NORMAL and moving.tree.hash() == built_hash(device, moving)

        def check(changed):
            report = moving.update(report=True)
            assert report.changed_objects == changed and report.fragments == moving.info.fragments > 0
            assert report.total_ms >= report.voxelize_ms + report.nodes_ms > 0
            hashes.append(moving.tree.hash())
            assert hashes[-1] == built_hash(device, moving)

        first, second = moving.add(box), moving.add(box, placed(-1, 0, 0))
        assert (first, second) == (0, 1) and moving.info.object_count == 2
        check(2)
        moving.set_transform(first, placed(0.5, 1, 0)[:3])
        check(1)
        moving.show(second, False)
        check(1)
        assert not moving.object_info(second).visible and moving.object_info(second).fragments == 0
        moving.set_vertices(first, svocl.Mesh(box.positions * 0.7, box.indices, normals=-box.normals))
        check(1)
        assert moving.object_info(first).visible and moving.object_info(first).triangles == 12
        assert moving.object_info(first).first_triangle == static.triangle_count
        moving.show(second)
        moving.remove(first)
        check(2)
        assert moving.info.object_count == 1 and moving.add(box) == first
        assert len(set(hashes)) == len(hashes)
        assert repr(moving) == f"<svocl.Moving: 2 objects, {moving.info.fragments} fragments>"


def test_areas_follow_whether_the_mesh_is_closed(device, cube):
    with svocl.Moving(device, cube, DEPTH, need=svocl.Need.PROJECTED_AREA, **GRID) as moving:
        face = moving.add(svocl.Mesh(cube.positions, cube.indices[:2]), placed(0, 0, 0))
        for is_open in (False, True, False):
            moving.show(face, is_open)
            moving.update()
            areas = moving.tree.arrays.areas
            assert np.array_equal(areas[:, ::2], areas[:, 1::2]) == is_open
            info = moving.info
            options = {"need": info.need, "weight_log2": info.weight_log2, **GRID}
            with device.build(moving.mesh(), DEPTH, **options) as tree:
                assert np.array_equal(tree.arrays.areas, areas)


def test_the_mesh_is_a_copy(moving, torus, box):
    number = moving.add(box, placed(1, 0, 0))
    mesh = moving.mesh()
    assert mesh.positions.dtype == np.float64 and np.array_equal(mesh.positions[: torus.vertex_count], torus.positions)
    assert np.array_equal(mesh.positions[torus.vertex_count :], box.positions * 0.5 + [1, 0, 0])
    assert np.array_equal(mesh.indices[torus.triangle_count :], box.indices + torus.vertex_count)
    copy = mesh.positions.copy()
    moving.set_transform(number, placed(0, 1, 0))
    assert not np.array_equal(moving.mesh().positions, copy) and np.array_equal(mesh.positions, copy)


def test_enqueued_updates(device, moving, box):
    cl = pytest.importorskip("pyopencl")
    context = cl.Context.from_int_ptr(device.context_int_ptr)
    queue = cl.CommandQueue(context)
    number = moving.add(box, placed(0, 0, 0))
    assert moving.update() is None  # a report has the update wait after each stage
    before, tree = moving.tree.hash(), moving.tree
    moving.set_transform(number, placed(0.3, 0.2, 0.1))
    ready = cl.UserEvent(context)
    event = cl.Event.from_int_ptr(moving.update_enqueue(queue, wait_for=[ready]).int_ptr)
    assert event.command_execution_status != cl.command_execution_status.COMPLETE
    with pytest.raises(svocl.InvalidArgumentError, match="an update is in flight"):
        moving.show(number)
    assert not tree.closed and moving.tree.hash() == before
    ready.set_status(cl.command_execution_status.COMPLETE)
    event.wait()
    report = moving.finish()
    assert report.changed_objects == 1 and report.voxelize_ms == 0 and report.total_ms > 0
    assert tree.closed and moving.tree.hash() == built_hash(device, moving) != before
    with pytest.raises(svocl.InvalidArgumentError, match="svo_moving_finish: no update is in flight"):
        moving.finish()


def test_rays_by_the_bvhs_of_objects(device, moving, box, random):
    rays = svocl.make_rays(random.uniform(-2, 2, (300, 3)), random.normal(size=(300, 3)))
    number = moving.add(box, placed(0.6, 0, 0))
    moving.update()
    report = moving.make_bvh(quality=svocl.BvhQuality.FAST)
    assert (report.kept, report.refit, report.made) == (0, 0, 2)
    moving.set_transform(number, placed(0.5, 0.4, 0.3))
    moving.update()
    report = moving.make_bvh(cost_ratio=4)
    assert (report.kept, report.refit, report.made) == (1, 1, 0) and report.total_ms > 0
    hits = moving.tree.trace(rays)
    with device.build(moving.mesh(), DEPTH, need=svocl.Need.RAYS, **GRID) as tree:
        whole = tree.trace(rays)
    assert 20 < np.isfinite(hits["t"]).sum() < 280
    assert (hits["triangle"][np.isfinite(hits["t"])] >= 576).any()
    for field in ("t", "triangle", "u", "v", "normal"):
        assert np.array_equal(hits[field], whole[field]), field


def test_a_tree_ends_with_the_next_update(moving, box):
    tree = moving.tree
    masks = tree.arrays.child_mask
    copy = masks.copy()
    assert not masks.flags.writeable
    moving.add(box)
    assert not tree.closed
    moving.update()
    assert tree.closed and "closed" in repr(tree) and np.array_equal(masks, copy)
    for use in (
        tree.hash,
        lambda: tree.trace(svocl.make_rays([0, 0, 0], [0, 0, 1])),
        lambda: svocl.Light(tree),
        lambda: svocl.Scene([tree], svocl.make_instances(0, np.eye(3, 4))),
        lambda: svocl.Compact(tree),
    ):
        with pytest.raises(ValueError, match="^Tree is closed$"):
            use()
    tree.close()
    with moving.tree as now:
        assert now.hash() == moving.tree.hash()
    assert now.closed and not moving.tree.closed


@pytest.fixture
def lit(device, box):
    """A floor with a box on it, and their light."""
    floor = svocl.Mesh(np.array([[-1.5, -1, -1.5], [0, -1, 1.5], [1.5, -1, -1.5]]), np.array([[0, 1, 2]]))
    with svocl.Moving(device, floor, DEPTH, need=svocl.Need.RAYS | svocl.Need.NORMAL, **GRID) as moving:
        moving.add(box, placed(0.5, -1, 0))
        moving.update()
        with svocl.Light(moving.tree, svocl.LightForm.VOXELS) as light:
            light.set_sources([LAMP], view_resolution=64, updatable=True)
            yield moving, light


def test_light_follows(device, lit):
    moving, light = lit
    points = svocl.make_gather_points([[0, -1, 0]], (0, 1, 0))
    before = light.hash()
    assert light.info.kept_bytes > 0
    moving.set_transform(0, placed(0.5, -1, 0, 0.4))
    moving.update()
    boxes = [[[0.5, -1, 0], [1, -0.5, 0.5]], [[0.5, -1, 0], [0.9, -0.6, 0.4]]]
    assert moving.changes.shape == (2, 2, 3) and np.allclose(moving.changes, boxes, atol=0.3)
    with pytest.raises(ValueError, match=r"Light: Moving has replaced its tree; call Light\.update first"):
        light.gather(points)
    assert "voxels" in repr(light)
    light.update(moving.tree, moving.changes)
    assert light.gather(points)["openness"] > 0
    with svocl.Light(moving.tree, svocl.LightForm.VOXELS) as fresh:
        fresh.set_sources([LAMP], view_resolution=64)
        assert light.hash() == fresh.hash() != before


def test_light_takes_another_tree(device, lit):
    """Any tree on the device will do, and the light lets go of the one before."""
    moving, light = lit
    info, before = moving.info, light.hash()
    with device.build(moving.mesh(), DEPTH, need=info.need, weight_log2=info.weight_log2, **GRID) as built:
        light.update(built, np.empty((0, 2, 3)))
    moving.close()
    assert moving._native.ended and light.hash() == before
    assert light.gather(svocl.make_gather_points([0, -1, 0], (0, 1, 0)))["openness"] > 0


def test_what_light_refuses(lit):
    moving, light = lit
    with pytest.raises(TypeError, match=r"tree: Light, expected svocl\.Tree"):
        light.update(light, moving.changes)
    with pytest.raises(ValueError, match=r"changed: shape \(1, 6\), expected \(count, 2, 3\)"):
        light.update(moving.tree, np.zeros((1, 6)))
    with pytest.raises(svocl.InvalidArgumentError, match="svo_light_update: "):
        light.update(moving.tree, np.full((1, 2, 3), np.nan))
    with svocl.Device() as other, other.build(svocl.Mesh(np.eye(3)), 2) as elsewhere:
        with pytest.raises(svocl.InvalidArgumentError, match=r"Light\.update: the tree is not on the light's device"):
            light.update(elsewhere, moving.changes)


def test_what_is_refused(device, moving, cube, box, torus):
    with pytest.raises(TypeError, match=r"mesh: ndarray, expected svocl\.Mesh"):
        svocl.Moving(device, cube.positions, DEPTH, **GRID)
    with pytest.raises(svocl.InvalidArgumentError, match="svo_moving_create: .*edge"):
        svocl.Moving(device, cube, DEPTH, origin=(0, 0, 0), edge=0)
    number = moving.add(torus)
    with pytest.raises(svocl.InvalidArgumentError, match="svo_moving_add: the transform of object 1 is flat"):
        moving.add(torus, np.zeros((3, 4)))
    with pytest.raises(ValueError, match=r"transform: shape \(3, 3\), expected \(3, 4\) or \(4, 4\)"):
        moving.set_transform(number, np.eye(3))
    with pytest.raises(ValueError, match=r"transform: the last row is \[0.0, 0.0, 0.0, 2.0\], expected \[0, 0, 0, 1\]"):
        moving.set_transform(number, np.eye(4) * [1, 1, 1, 2])
    with pytest.raises(TypeError, match="transform: dtype complex128, expected float64"):
        moving.set_transform(number, np.eye(4) * 1j)
    for use in (
        lambda: moving.set_transform(7, np.eye(4)),
        lambda: moving.set_vertices(7, torus),
        lambda: moving.show(7),
        lambda: moving.remove(7),
        lambda: moving.object_info(7),
    ):
        with pytest.raises(svocl.InvalidArgumentError, match="there is no object 7"):
            use()
    with pytest.raises(svocl.InvalidArgumentError, match="svo_moving_set_vertices: "):
        moving.set_vertices(number, box)
    with svocl.Moving(device, cube, DEPTH, fragment_capacity=400, **GRID) as small:
        before = small.tree
        small.add(cube, placed(0, 0, 0, 2))
        small.add(cube, placed(-2, -2, -2, 4))
        with pytest.raises(svocl.CapacityExceededError, match="svo_moving_update: "):
            small.update()
        assert not before.closed and before.hash() == small.tree.hash()


def test_lifetimes(cube):
    """A tree keeps its scene and device alive; when it is closed, all is destroyed."""
    device = svocl.Device()
    moving = svocl.Moving(device, cube, 3, need=svocl.Need.NONE, **GRID)
    old, tree = moving.tree, moving.tree
    natives = [weakref.ref(handle._native) for handle in (device, moving, tree)]
    device.close()
    moving.close()
    assert repr(moving) == "<svocl.Moving: closed>" and not natives[1]().ended
    for use in (lambda: moving.tree, moving.update, moving.mesh, lambda: moving.info, lambda: moving.changes):
        with pytest.raises(ValueError, match="^Moving is closed$"):
            use()
    old.close()
    assert len(tree.hash()) == 32
    tree.close()
    assert natives[0]().ended and natives[1]().ended
    del device, moving, old, tree
    gc.collect()
    assert [native() for native in natives] == [None, None, None]


def test_closing_destroys_once_whatever_was_updated(monkeypatch, cube):
    from svocl import _device, _moving

    order = []
    for module, name in ((_device, "_destroy_device"), (_moving, "_destroy")):
        destroy = getattr(module, name)
        monkeypatch.setattr(module, name, lambda *given, n=name, d=destroy: (order.append(n), d(*given)))
    device = svocl.Device()
    with svocl.Moving(device, cube, 3, need=svocl.Need.NONE, **GRID) as moving:
        old = moving.tree
        moving.add(cube, placed(0, 0, 0))
        moving.update()
    assert order == ["_destroy"]  # a tree that has ended keeps no scene
    device.close()
    assert order == ["_destroy"]
    old.close()
    assert order == ["_destroy", "_destroy_device"]
