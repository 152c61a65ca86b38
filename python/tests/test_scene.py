# SPDX-License-Identifier: MIT
"""Scenes: an identity is the tree itself, instances move, and what does not go together is refused in words."""

import numpy as np
import pytest

import svocl

IDENTITY = np.eye(3, 4, dtype=np.float32)


def moved(*places):
    transforms = np.repeat(IDENTITY[None], len(places), axis=0)
    transforms[:, :, 3] = places
    return transforms


@pytest.fixture
def rays(random):
    return svocl.make_rays(random.uniform(-2, 2, (300, 3)), random.normal(size=(300, 3)))


def test_an_identity_is_the_tree_itself(tree, rays):
    with svocl.Scene([tree], svocl.make_instances(0, IDENTITY), need=svocl.Need.RAYS) as scene:
        hits, own = scene.trace(rays), tree.trace_voxels(rays)
        met = np.isfinite(own["t"])
        assert 20 < met.sum() < 280
        for field in ("t", "node", "level", "face", "normal"):
            assert np.array_equal(hits[field], own[field]), field
        assert np.array_equal(hits["instance"] == 0, met) and np.all(hits["instance"][~met] == svocl.NO_INSTANCE)
        triangles, closest = scene.trace_triangles(rays), tree.trace(rays)
        for field in ("t", "triangle", "u", "v", "normal"):
            assert np.array_equal(triangles[field], closest[field]), field
        assert np.array_equal(np.isfinite(scene.trace(rays, mode=svocl.SceneTrace.ANY)["t"]), met)


def test_instances_move(tree):
    """One ray along x meets the instance that is in its way, and at the distance by which it moved."""
    ray = svocl.make_rays([-9, 0.013, 0.017], [1, 0, 0])
    own = tree.trace_voxels(ray)["t"]
    with svocl.Scene([tree], svocl.make_instances(0, moved((0, 5, 0), (2, 0, 0), (4, 0, 0)))) as scene:
        assert scene.info.instance_count == 3 and scene.info.tree_count == 1
        hit = scene.trace(ray)
        assert hit["instance"] == 1 and np.isclose(hit["t"], own + 2, atol=1e-4)
        assert scene.trace(ray, mode=svocl.SceneTrace.EVERY_INSTANCE) == hit
        scene.set_transforms(moved((1, 0, 0)), 2)
        hit = scene.trace(ray)
        assert hit["instance"] == 2 and np.isclose(hit["t"], own + 1, atol=1e-4)
        scene.rebuild()
        assert scene.trace(ray) == hit
        with pytest.raises(svocl.InvalidArgumentError, match="instance 1"):
            scene.set_transforms(np.zeros((1, 3, 4)), 1)
        assert scene.trace(ray) == hit


@pytest.mark.parametrize("form", list(svocl.Form))
def test_compact_trees_are_placed_as_built_ones(device, tree, cube, rays, form):
    transforms = moved((0, 0, 0), (0.5, 1, 0))
    with device.build(cube, 3, need=svocl.Need.NONE) as box, svocl.Compact(tree, form) as a, svocl.Compact(
        box, form
    ) as b:
        instances = svocl.make_instances([0, 1], transforms)
        built, compact = svocl.Scene([tree, box], instances), svocl.Scene([a, b], instances)
    for field in ("t", "level", "face", "normal", "instance"):  # the scenes outlive their trees
        assert np.array_equal(built.trace(rays)[field], compact.trace(rays)[field]), field
    assert np.array_equal(built.render(32, 24), compact.render(32, 24))
    assert compact.info.tree_bytes < built.info.tree_bytes


def test_pictures(tree):
    with svocl.Scene([tree], svocl.make_instances(0, IDENTITY)) as scene:
        camera = scene.frame(4 / 3)
        assert camera.vertical_fov > 0
        picture = scene.render(32, 24, camera=camera)
        assert picture.shape == (24, 32, 4) and len(np.unique(picture.reshape(-1, 4), axis=0)) > 10
        dark = scene.render(32, 24, camera=camera, lights=[svocl.SceneLight((0, 0, 1), (0, 0, 0))])
        assert dark[..., :3].sum() < picture[..., :3].sum()
        with pytest.raises(svocl.InvalidArgumentError, match="direction"):
            scene.render(8, 8, lights=[svocl.SceneLight((0, 0, 0))])
        with pytest.raises(svocl.InvalidArgumentError, match="pixels"):
            scene.render(0, 8)


def test_what_is_refused(device, tree):
    one = svocl.make_instances(0, IDENTITY)
    with pytest.raises(ValueError, match="trees: none"):
        svocl.Scene([], one)
    with pytest.raises(TypeError, match="instances: ndarray|instances: dtype float32"):
        svocl.Scene([tree], IDENTITY)
    with pytest.raises(svocl.InvalidArgumentError, match="the matrix of instance 1 is flat"):
        svocl.Scene([tree], svocl.make_instances(0, [IDENTITY, IDENTITY * 0]))
    with pytest.raises(svocl.InvalidArgumentError, match="tree"):
        svocl.Scene([tree], svocl.make_instances(1, IDENTITY))
    with svocl.Compact(tree) as compact, pytest.raises(TypeError, match=r"trees: Compact, expected svocl\.Tree"):
        svocl.Scene([tree, compact], one)
    with svocl.Compact(tree) as words, svocl.Compact(tree, svocl.Form.SHARED) as shared:
        with pytest.raises(svocl.InvalidArgumentError, match="differs from the first in form"):
            svocl.Scene([words, shared], one)
    with svocl.Device() as other, other.build(svocl.Mesh(np.eye(3, dtype=np.float32)), 2) as elsewhere:
        with pytest.raises(svocl.InvalidArgumentError, match="the trees are not all on one device"):
            svocl.Scene([tree, elsewhere], one)
    with pytest.raises(ValueError, match=r"transforms: shape \(4, 3\), expected \(\.\.\., 3, 4\)"):
        svocl.make_instances(0, np.zeros((4, 3)))
    with pytest.raises(TypeError, match="trees: dtype float64, expected integers"):
        svocl.make_instances(0.5, IDENTITY)


def test_closed(tree, rays):
    scene = svocl.Scene([tree], svocl.make_instances(0, IDENTITY))
    assert repr(scene) == "<svocl.Scene: 1 instances of 1 trees>"
    scene.close()
    for use in (lambda: scene.info, lambda: scene.trace(rays), scene.rebuild, scene.frame):
        with pytest.raises(ValueError, match="Scene is closed"):
            use()
    closed = svocl.Compact(tree)
    closed.close()
    with pytest.raises(ValueError, match="Compact is closed"):
        svocl.Scene([closed], svocl.make_instances(0, IDENTITY))
