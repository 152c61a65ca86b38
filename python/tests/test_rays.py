# SPDX-License-Identifier: MIT
"""Rays and nearest points in batches, compared with loops over all triangles in numpy."""

import numpy as np
import pytest
import shapes

import svocl


def test_closest_hits(tree, torus, random):
    origins = random.uniform(-2, 2, (200, 3)).astype(np.float32)
    directions = random.normal(size=(200, 3)).astype(np.float32)
    hits = tree.trace(svocl.make_rays(origins, directions))
    expected = np.array([shapes.trace(torus.positions, torus.indices, *ray) for ray in zip(origins, directions)])
    assert 20 < np.isfinite(expected).sum() < 180
    assert np.array_equal(np.isfinite(hits["t"]), np.isfinite(expected))
    met = np.isfinite(expected)
    assert np.allclose(hits["t"][met], expected[met], rtol=1e-4, atol=1e-5)
    assert np.all(hits["triangle"][~met] == svocl.NO_TRIANGLE)
    corners = torus.positions[torus.indices[hits["triangle"][met]]]
    u, v = hits["u"][met], hits["v"][met]
    on_triangle = np.einsum("ij,ijx->ix", np.stack([1 - u - v, u, v], axis=1), corners)
    on_ray = origins[met] + hits["t"][met, None] * directions[met]
    assert np.allclose(on_triangle, on_ray, atol=1e-4)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert np.allclose(hits["normal"][met], normals, atol=1e-3)


def test_modes(tree):
    """Through the middle of a closed torus along x: four triangles; t_max ends before the first."""
    rays = svocl.make_rays([-3, 0.013, 0.017], [1, 0, 0], t_max=[np.inf, 1.0])
    assert tree.trace(rays, mode=svocl.TraceMode.COUNT)["count"].tolist() == [4, 0]
    assert np.isfinite(tree.trace(rays, mode=svocl.TraceMode.ANY)["t"]).tolist() == [True, False]


def test_shapes_and_layouts(tree):
    directions = np.stack([*np.meshgrid(np.linspace(-1, 1, 4), np.linspace(-1, 1, 3)), np.ones((3, 4))], axis=-1)
    rays = svocl.make_rays([0, 0, -3], directions)
    assert rays.shape == (3, 4) and rays.dtype == svocl.ray_dtype
    hits = tree.trace(rays)
    assert hits.shape == (3, 4) and hits.dtype == svocl.hit_dtype
    numbers = np.ascontiguousarray(rays).view(np.float32).reshape(3, 4, 8)
    assert np.array_equal(tree.trace(numbers), hits)
    assert np.array_equal(tree.trace(rays.T), hits.T)
    assert tree.trace(rays[0, 0]).shape == ()
    assert tree.trace(rays[:0]).shape == (0, 4)
    out = np.zeros((3, 4), svocl.hit_dtype)
    assert tree.trace(rays, out=out) is out and np.array_equal(out, hits)


@pytest.mark.parametrize(
    ("arguments", "kind", "words"),
    [
        ({"rays": [[0, 0, 0, 0, 0, 1, 0, 9]]}, TypeError, "rays: list, expected an array of svocl.ray_dtype"),
        (
            {"rays": np.zeros((5, 6), np.float32)},
            ValueError,
            "rays: shape (5, 6), expected (..., 8) for float32",
        ),
        (
            {"rays": np.zeros((5, 8))},
            TypeError,
            "rays: dtype float64, expected svocl.ray_dtype, or float32 of shape (..., 8)",
        ),
        ({"out": np.zeros(3, svocl.hit_dtype)}, ValueError, "out: shape (3,), expected (2,)"),
        ({"out": np.zeros(2, np.float32)}, TypeError, "out: float32, expected an array of"),
        ({"out": np.zeros(4, svocl.hit_dtype)[::2]}, ValueError, "out: not C-contiguous and writable"),
        ({"mode": 3}, ValueError, "3 is not a valid TraceMode"),
        ({"queue": "default"}, TypeError, "queue: str, expected pyopencl.CommandQueue or its int_ptr"),
    ],
)
def test_wrong_batches(tree, arguments, kind, words):
    rays = svocl.make_rays([[0, 0, 0]] * 2, [0, 0, 1])
    with pytest.raises(kind) as caught:
        tree.trace(**{"rays": rays, **arguments})
    assert words in str(caught.value)


def test_make_rays_refuses_wrong_shapes():
    with pytest.raises(ValueError, match=r"directions: shape \(2,\), expected \(\.\.\., 3\)"):
        svocl.make_rays([0, 0, 0], [1, 0])
    with pytest.raises(TypeError, match="origins: dtype bool"):
        svocl.make_rays([True, True, True], [1, 0, 0])
    with pytest.raises(ValueError, match="broadcast"):
        svocl.make_rays(np.zeros((2, 3)), np.ones((3, 3)))


def test_nearest_points(tree, torus, random):
    points = random.uniform(-1.5, 1.5, (40, 3))
    found = tree.nearest(points)
    assert found.dtype == svocl.nearest_dtype and found.shape == (40,)
    sampled = shapes.distances(torus.positions, torus.indices, points)
    assert np.all(found["distance"] <= sampled + 1e-5) and np.all(found["distance"] >= sampled - 0.01)
    assert np.allclose(np.linalg.norm(found["position"] - points, axis=1), found["distance"], atol=1e-5)
    assert found["triangle"].max() < torus.triangle_count
    out = np.empty(40, svocl.nearest_dtype)
    assert tree.nearest(points.astype(np.float32), out=out) is out


def test_nearest_within_a_distance(tree):
    points = np.zeros(2, svocl.query_dtype)  # the middle of the hole is 0.6 away from the surface
    points["max_distance"] = [0.5, np.inf]
    found = tree.nearest(points)
    assert found["triangle"][0] == svocl.NO_TRIANGLE and np.isinf(found["distance"][0])
    assert found["distance"][1] == pytest.approx(0.6, abs=0.03)
    assert np.array_equal(tree.nearest(np.zeros((2, 3)), max_distance=[0.5, np.inf]), found)
    with pytest.raises(ValueError, match=r"points: shape \(2, 2\), expected \(\.\.\., 3\)"):
        tree.nearest(np.zeros((2, 2)))
    with pytest.raises(TypeError, match="points: dtype complex128"):
        tree.nearest(np.zeros((2, 3), complex))


def test_rays_need_lists(device, cube):
    with device.build(cube, 3, need=svocl.Need.NONE) as tree:
        with pytest.raises(svocl.InvalidArgumentError, match="svo_trace_triangles: .*SVO_NEED_RAYS"):
            tree.trace(svocl.make_rays([0, 0, 0], [0, 0, 1]))


def test_the_bvh_can_be_made_beforehand(device, torus):
    with device.build(torus, 4, need=svocl.Need.RAYS) as tree:
        assert tree.info.ray_bytes == 0
        tree.prepare_rays()
        assert tree.info.ray_bytes > 0
