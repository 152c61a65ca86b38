# SPDX-License-Identifier: MIT
"""Closed meshes: of a torus, of numbers of one's own, and what is refused."""

import numpy as np
import pytest
import svocl


@pytest.fixture(scope="module")
def roomy(device, torus):
    """A torus in a grid with room around it."""
    with device.build(torus, 5, need=svocl.Need.RAYS | svocl.Need.COLOR, origin=(-2.0, -2.0, -2.0), edge=4.0) as made:
        yield made


def euler(surface):
    """Vertices - edges + triangles; each edge in both directions once."""
    sides = np.concatenate([surface.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    assert len(np.unique(sides, axis=0)) == len(sides)
    assert np.array_equal(np.unique(sides, axis=0), np.unique(sides[:, ::-1], axis=0))
    return len(surface.vertices) - len(sides) // 2 + len(surface.triangles)


def test_the_surface_of_a_torus(roomy):
    dense, band = svocl.surface(svocl.sdf(roomy, 0), colors=roomy), svocl.surface(svocl.sdf(roomy), colors=roomy)
    assert euler(band) == 0
    for name in ("vertices", "triangles", "normals", "colors"):
        assert np.array_equal(getattr(dense, name), getattr(band, name)), name
    assert np.allclose(np.linalg.norm(band.normals, axis=1), 1, atol=1e-5)
    assert band.info.vertex_count == len(band.vertices) and band.info.end_triangles == 0
    points = np.zeros(len(band.vertices), svocl.query_dtype)
    points["position"] = band.vertices
    points["max_distance"] = np.inf
    assert roomy.nearest(points)["distance"].max() < 0.25 * svocl.sdf(roomy).spacing
    plain = svocl.surface(svocl.sdf(roomy), normals=False)
    assert plain.normals is None and plain.colors is None
    assert np.array_equal(plain.vertices, band.vertices)


def test_levels_and_numbers_of_ones_own(roomy):
    unsigned = svocl.sdf(roomy, 4, sign=False)
    assert len(svocl.surface(unsigned).triangles) == 0
    assert euler(svocl.surface(unsigned, 1.5 * unsigned.spacing)) == 0
    x, y, z = np.indices((20, 24, 18))
    numbers = np.sqrt((x - 9.2) ** 2 + (y - 11.3) ** 2 + (z - 8.7) ** 2) - 6
    ball = svocl.surface(svocl.Sdf(numbers, None, np.zeros(3), 1.0, None))
    assert euler(ball) == 2
    assert np.allclose(np.linalg.norm(ball.vertices - (9.2, 11.3, 8.7), axis=1), 6, atol=0.0625)


def test_arguments(device, torus, roomy):
    with pytest.raises(svocl.InvalidArgumentError, match="band does not hold"):
        svocl.surface(svocl.sdf(roomy, 1))
    with pytest.raises(svocl.InvalidArgumentError, match="not finite"):
        svocl.surface(svocl.sdf(roomy), np.inf)
    with pytest.raises(TypeError):
        svocl.surface(roomy)
    with pytest.raises(TypeError):
        svocl.surface(svocl.sdf(roomy), colors=1)
    with pytest.raises(ValueError):
        svocl.surface(svocl.Sdf(np.zeros((3, 3)), None, np.zeros(3), 1.0, None))
    with device.build(torus, 5, need=svocl.Need.RAYS, origin=(-2.0, -2.0, -2.0), edge=4.0) as bare:
        with pytest.raises(svocl.InvalidArgumentError, match="no colors"):
            svocl.surface(svocl.sdf(bare), colors=bare)
