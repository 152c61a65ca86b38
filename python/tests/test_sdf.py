# SPDX-License-Identifier: MIT
"""Signed distance fields: those of a torus, a closed form, and of a mesh that is refused."""

import numpy as np
import pytest
import svocl


@pytest.fixture(scope="module")
def roomy(device, torus):
    """A torus in a grid with room around it."""
    with device.build(torus, 5, need=svocl.Need.RAYS, origin=(-2.0, -2.0, -2.0), edge=4.0) as made:
        yield made


def test_a_dense_field_is_that_of_the_torus(roomy):
    field = svocl.sdf(roomy, 0)
    assert field.distances.shape == (32, 32, 32) and field.distances.dtype == np.float32 and field.voxels is None
    assert field.spacing == 0.125 and field.first.tolist() == [-1.9375] * 3
    assert field.info.voxel_count == 32**3 and field.info.open_columns == (0, 0, 0)
    unsigned = svocl.sdf(roomy, 0, sign=False)
    assert np.array_equal(unsigned.distances, np.abs(field.distances)) and unsigned.info.is_unsigned
    centers = field.first + field.spacing * np.indices((32, 32, 32)).transpose(1, 2, 3, 0)
    points = np.zeros(32**3, svocl.query_dtype)
    points["position"] = centers.reshape(-1, 3)
    points["max_distance"] = np.inf
    nearest = roomy.nearest(points)["distance"].reshape(32, 32, 32)
    assert np.allclose(unsigned.distances, nearest, rtol=1e-6, atol=1e-7)


def test_a_band_is_a_part_of_the_dense_field(roomy):
    dense, band = svocl.sdf(roomy, 0).distances, svocl.sdf(roomy, 2)
    assert band.voxels.dtype == np.uint16 and band.voxels.shape == (len(band.distances), 3)
    assert np.array_equal(dense[tuple(band.voxels.T)], band.distances)
    assert (np.abs(dense) < 2 * band.spacing).sum() == len(band.distances) == band.info.voxel_count
    assert (band.distances < 0).any() and (band.distances > 0).any()


def test_arguments(device, torus, roomy):
    with pytest.raises(svocl.InvalidArgumentError, match="band"):
        svocl.sdf(roomy, -1)
    with pytest.raises(ValueError):
        svocl.sdf(roomy, rule=7)
    with pytest.raises(TypeError):
        svocl.sdf(None)
    with device.build(torus, 4) as bare, pytest.raises(svocl.InvalidArgumentError, match="leaf lists"):
        svocl.sdf(bare)
