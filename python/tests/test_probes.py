# SPDX-License-Identifier: MIT
"""Light field probes: what they hold, rays through them, and diffuse light."""

import numpy as np
import pytest
import shapes

import svocl


@pytest.fixture(scope="module")
def room(device):
    """A box seen from inside, with all that light needs."""
    positions = np.asarray(shapes.CUBE_POSITIONS, np.float32)
    inside = np.asarray(shapes.CUBE_INDICES, np.uint32)[:, ::-1]
    need = svocl.Need.NORMAL | svocl.Need.RAYS | svocl.Need.PROJECTED_AREA
    with device.build(svocl.Mesh(positions, inside), 5, need=need) as tree:
        yield tree


def test_rays_through_probes(room, random):
    with svocl.Probes(room, (2, 2, 2), resolution=64) as probes:
        info = probes.info
        assert info.counts == (2, 2, 2) and info.probe_count == 8 and info.resolution == 64
        assert info.total_bytes == sum(info.bytes) > 0 and list(info.stage_ms)[:2] == ["placing", "texels"]
        assert len(probes.hash()) == 32 and repr(probes) == "<svocl.Probes: 2 x 2 x 2, 64 texels a side>"
        low, high = np.asarray(room.info.origin), np.asarray(room.info.origin) + room.info.edge
        rays = svocl.make_rays((low + high) / 2, random.normal(size=(200, 3)))
        hits, exact = probes.trace(rays), room.trace(rays)
        known = hits["state"] == 1
        assert known.mean() > 0.9
        assert np.allclose(hits["t"][known], exact["t"][known], atol=3 * room.info.edge / 2**5)
        assert probes.buffer_int_ptr(svocl.ProbeBuffer.TEXELS) and not probes.buffer_int_ptr(
            svocl.ProbeBuffer.IRRADIANCE
        )
    assert probes.closed


def test_diffuse_light(room):
    with svocl.Light(room) as light:
        light.set_sources(sky=(1.0, 1.0, 1.0))
        with svocl.Probes(room, (1, 1, 1), resolution=64, light=light, diffuse=True) as probes:
            middle = np.asarray(room.info.origin) + room.info.edge / 2
            points = svocl.make_gather_points(middle, [[0, 0, 1], [0, 1, 0]])
            assert probes.irradiance(points)["weight"].shape == (2,)
            probes.relight()
            assert probes.info.bytes[svocl.ProbeBuffer.IRRADIANCE] > 0


def test_wrong_arguments(room):
    with pytest.raises(TypeError, match="subject: int, expected svocl.Tree or svocl.Scene"):
        svocl.Probes(3)
    with pytest.raises(ValueError, match="counts: 2 numbers, expected 3"):
        svocl.Probes(room, (1, 2))
    with pytest.raises(svocl.InvalidArgumentError, match="resolution"):
        svocl.Probes(room, (1, 1, 1), resolution=65)
    with svocl.Probes(room, (1, 1, 1), resolution=64) as probes:
        with pytest.raises(ValueError, match="thickness: 0 is not above 0"):
            probes.trace(svocl.make_rays([0, 0, 0], [1, 0, 0]), thickness=0)
