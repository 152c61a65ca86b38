# SPDX-License-Identifier: MIT
"""Light: what closed forms say of a floor under a sun and a sky, refusals, lifetimes."""

import numpy as np
import pytest

import svocl

NEED = svocl.Need.NORMAL | svocl.Need.RAYS | svocl.Need.PROJECTED_AREA
SUN = svocl.LightSource(svocl.SourceKind.DIRECTIONAL, (4, 2, 1), direction=(0, -1, 0))
FLOOR = np.array([[0, 0.5, 0], [1, 0.5, 0], [1, 0.5, 1], [0, 0.5, 1]], np.float32)


@pytest.fixture(scope="module")
def floor(device):
    """A square of edge 1 across the middle of the grid."""
    mesh = svocl.Mesh(FLOOR, np.array([[0, 2, 1], [0, 3, 2]], np.uint32))
    with device.build(mesh, 5, need=NEED, origin=(0, 0, 0), edge=1.01) as made:
        yield made


@pytest.fixture
def points(random):
    """Above the floor, looking up."""
    positions = random.uniform(0.3, 0.7, (2, 25, 3))
    positions[..., 1] = 0.5
    return svocl.make_gather_points(positions, (0, 1, 0))


@pytest.mark.parametrize("form", list(svocl.LightForm))
def test_a_bare_floor_is_open_and_sees_the_sky(floor, points, form):
    with svocl.Light(floor, form) as light:
        assert light.info.form == form and light.info.opacity == svocl.Opacity.AREA and light.info.lit_leaves == 0
        light.set_sources(sky=(1, 0.5, 0))
        results = light.gather(points)
        assert results.shape == (2, 25) and results["openness"].min() > 0.95
        assert np.allclose(results["irradiance"], np.pi * np.array([1, 0.5, 0]), rtol=0.05)
        dark = light.gather(points, with_light=False)
        assert np.array_equal(dark["openness"], results["openness"]) and not dark["irradiance"].any()


def test_a_sky_may_depend_on_direction(floor, points):
    """1 + y for a direction's height y brings pi + 2 pi / 3 to a surface that looks up; a half is red."""
    height = np.cos(np.pi * (np.arange(90) + 0.5) / 90)
    sky = np.zeros((90, 60, 3), np.float32)
    sky[:, 30:, 0] = 1
    sky[..., 1] = 1 + height[:, np.newaxis]
    with svocl.Light(floor) as light:
        light.set_sources(sky=(0, 0, 1), sky_map=sky)
        assert light.info.sky_bytes >= sky.nbytes
        for kind in ({"paths": 1024}, {"cones": 64}):
            results = light.gather(points, **kind)
            assert np.allclose(results["irradiance"], np.pi * np.array([1 / 2, 5 / 3, 1]), rtol=0.05)
        with pytest.raises(ValueError, match="sky_map: shape"):
            light.set_sources(sky_map=sky[0])
        with pytest.raises(svocl.InvalidArgumentError, match=r"sky_map\[0\] -1, of column 0 and row 0, is negative"):
            light.set_sources(sky_map=-np.ones((2, 3, 3)))
        light.set_sources()
        assert light.info.sky_bytes == 0


def test_photons_leave_what_emits_and_bounce(device):
    """Two opposite squares that glow: of the light that one gets from the other, the albedo goes back."""
    mesh = svocl.Mesh(
        np.concatenate([FLOOR, FLOOR + np.float32([0, 0.5, 0])]),
        np.array([[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]], np.uint32),
        triangle_materials=np.zeros(4, np.uint16),
        materials=[svocl.Material((188, 188, 188, 255))],
    )
    needs = svocl.Need.COLOR | svocl.Need.RAYS | svocl.Need.MATERIAL
    with device.build(mesh, 3, need=needs) as tree, svocl.Light(tree) as light:
        glow = svocl.Finish(emission=(1, 2, 4))
        flux = []
        for bounces in (1, 2, 64):
            light.set_sources(finishes=[glow], emission_photons=4096, bounces=bounces, photon_alpha=True)
            assert light.info.photons == 4096 and (light.info.sent_photons > 0) == (bounces > 1)
            flux.append(light.info.flux[2])
        assert 0 < flux[0] < flux[1] < flux[2] < 3 * flux[0]
        with pytest.raises(svocl.InvalidArgumentError, match="setup.bounces 65 is above 64"):
            light.set_sources(bounces=65)


def test_pictures_show_the_mesh(device):
    """A floor of one voxel's width with a texel of red and one of green, under a sun that makes it send its albedo."""
    texels = np.array([[[255, 0, 0, 255], [0, 255, 0, 255]]], np.uint8)
    mesh = svocl.Mesh(
        FLOOR,
        np.array([[0, 2, 1], [0, 3, 2]], np.uint32),
        uvs=FLOOR[:, [0, 2]],
        materials=[svocl.Material((255, 255, 255, 255), 0)],
        textures=[svocl.Texture(texels, svocl.Wrap.CLAMP, svocl.Wrap.CLAMP)],
    )
    sun = svocl.LightSource(svocl.SourceKind.DIRECTIONAL, (np.pi,) * 3, direction=(0, -1, 0))
    with device.build(mesh, 1, need=svocl.Need.COLOR | svocl.Need.RAYS, origin=(0, 0, 0), edge=4) as tree:
        with svocl.Light(tree) as light:
            light.set_sources([sun])
            light.set_mesh(mesh)
            assert light.info.mesh_bytes > 0
            for x, channel in ((0.2, 0), (0.8, 1)):
                camera = svocl.Camera(eye=(x, 2, 0.4), target=(x, 0, 0.4), up=(0, 0, 1), vertical_fov=1e-3)
                picture = light.render(2, 2, camera=camera, view=svocl.View.DIRECT)
                assert (picture[..., channel] > 200).all() and (picture[..., 1 - channel] < 5).all()
            with pytest.raises(svocl.InvalidArgumentError, match="mesh has 1 triangles; that of the tree has 2"):
                light.set_mesh(svocl.Mesh(FLOOR[:3]))
            with pytest.raises(TypeError, match="mesh: int, expected svocl.Mesh"):
                light.set_mesh(7)
            assert light.info.mesh_bytes == 0
            light.set_mesh(None)


def test_normal_maps_bend_normals(device):
    """A floor whose map leans it towards u: a sun from that side lights it by the cosine of both."""
    floor = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 0, 0], [4, 4, 0], [0, 4, 0]], np.float32)
    texel = svocl.Texture(np.array([[[229, 128, 204, 255]]], np.uint8))
    bent = svocl.Mesh(
        floor,
        uvs=floor[:, :2] / 4,
        materials=[svocl.Material()],
        textures=[texel],
        normal_maps=[svocl.NormalMap(0)],
    )
    with device.build(bent, 3, need=svocl.Need.COLOR | svocl.Need.RAYS) as tree:
        with svocl.Light(tree) as light:
            sun = svocl.LightSource(svocl.SourceKind.DIRECTIONAL, (1, 1, 1), direction=(-0.6, 0, -0.8))
            light.set_sources([sun])
            light.set_mesh(bent)
            camera = svocl.Camera(eye=(2, 2, 9), target=(2, 2, 0), up=(0, 1, 0), vertical_fov=1e-3)
            shown = light.render(2, 2, camera=camera, view=svocl.View.DIRECT)
    normal = 2 * np.array([229, 128, 204]) / 255 - 1
    radiance = normal @ (0.6, 0, 0.8) / np.linalg.norm(normal) / np.pi
    coded = 255 * (1.055 * radiance ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(shown[..., 0], coded, atol=1)


def test_a_ceiling_reflects_the_floor(device, random):
    """Between two large sheets a ceiling gets what the floor reflects: albedo times the sun's irradiance."""
    low, high = FLOOR.copy(), FLOOR.copy()
    low[:, 1], high[:, 1] = 0.3, 0.4
    high[:, [0, 2]] = high[:, [0, 2]] * 0.2 + 0.4
    mesh = svocl.Mesh(np.concatenate([low, high]), np.array([[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]], np.uint32))
    point = svocl.make_gather_points([[0.52, 0.4, 0.4]], (0, -1, 0))
    with device.build(mesh, 6, need=NEED, origin=(0, 0, 0), edge=1.01) as tree, svocl.Light(tree) as light:
        light.set_sources([SUN])
        irradiance = light.gather(point, cones=64)["irradiance"][0]
        assert 0.2 * 0.6 * 4 < irradiance[0] < 0.6 * 4
        assert np.allclose(irradiance / irradiance[0], [1, 0.5, 0.25], rtol=0.02)


def test_lights_are_saved_and_loaded(device, floor, cube, points, tmp_path):
    with svocl.Light(floor, one_side=True) as light:
        light.set_sources([SUN], sky=(0, 0, 1))
        light.save(tmp_path / "floor.svl", compress=True)
        with svocl.Light.load(floor, tmp_path / "floor.svl") as loaded:
            assert loaded.hash() == light.hash()
            assert np.array_equal(loaded.gather(points), light.gather(points))
    with device.build(cube, 4, need=NEED) as other:
        with pytest.raises(svocl.InvalidArgumentError, match="of a tree of hash"):
            svocl.Light.load(other, tmp_path / "floor.svl")
    with pytest.raises(svocl.FileError):
        svocl.Light.load(floor, tmp_path / "none.svl")


def test_rays_need_nothing_stored(floor, points):
    with svocl.Light(floor) as light, svocl.Light(floor, no_cones=True) as bare:
        for one in (light, bare):
            one.set_sources([SUN], sky=(0, 0, 1))
        assert bare.info.total_bytes == 0 and light.info.total_bytes > 0
        assert np.array_equal(bare.gather(points), light.gather(points))
        with pytest.raises(svocl.InvalidArgumentError, match="no_cones"):
            bare.gather(points, cones=16)


def test_sources_make_the_light_of_each_call(floor, points):
    with svocl.Light(floor) as light:
        dark = light.hash()
        light.set_sources([SUN], view_resolution=100, diagnose=True)
        lit, info = light.hash(), light.info
        assert info.lit_leaves == 32 * 32 and info.missed_leaves == 0
        assert 0.95 * info.photons < info.photon_hits <= info.photons <= 100 * 100
        assert info.lit_nodes > info.lit_leaves
        assert np.allclose(info.flux, [4, 2, 1], rtol=0.02) and info.lost_flux == 0
        assert info.stage_ms["photons"] > 0 and sum(info.bytes) == info.total_bytes
        light.set_sources()
        assert light.hash() == dark and light.buffer_int_ptr(svocl.LightBuffer.RADIANCE) is None
        light.set_sources([SUN], view_resolution=100)
        assert light.hash() == lit
        light.set_sources([SUN._replace(radius=0.1)], view_resolution=100)
        assert light.hash() == lit  # photons leave its middle
        with pytest.raises(svocl.InvalidArgumentError, match="radius 2 is not below pi / 2"):
            light.set_sources([SUN._replace(radius=2)])
        light.set_sources([SUN], view_resolution=100, photons=False)
        assert light.hash() == dark


def test_pictures(floor):
    with svocl.Light(floor) as light:
        light.set_sources([SUN])
        open_floor = light.render(32, 24, view=svocl.View.AO, cones=5)
        assert open_floor.shape == (24, 32, 4) and open_floor.dtype == np.uint8
        direct = light.render(32, 24, view=svocl.View.DIRECT)
        assert direct[12, 16, 0] > direct[12, 16, 2] > 0 and not direct[0, 0, :3].any()
        camera = svocl.Camera((0.5, 3, 0.5), (0.5, 0.5, 0.5), (0, 0, 1), 0.2)
        above = light.render(8, 8, camera=camera, view=svocl.View.DIRECT, exposure=0.1)
        # 0.1 times albedo 0.6 / pi times the irradiance 4, by the sRGB curve
        share = 0.1 * 0.6 / np.pi * 4
        assert abs(int(above[4, 4, 0]) - 255 * (1.055 * share ** (1 / 2.4) - 0.055)) <= 2


def test_wrong_arguments(floor, points):
    with pytest.raises(TypeError, match=r"tree: Light, expected svocl\.Tree"):
        svocl.Light(svocl.Light(floor))
    with svocl.Light(floor) as light:
        with pytest.raises(svocl.InvalidArgumentError, match=r"setup\.sources\[0\]\.direction is zero"):
            light.set_sources([svocl.LightSource(svocl.SourceKind.DIRECTIONAL, (1, 1, 1))])
        with pytest.raises(svocl.InvalidArgumentError, match=r"setup\.sky\[1\] -1 is negative"):
            light.set_sources(sky=(0, -1, 0))
        with pytest.raises(svocl.InvalidArgumentError, match="cones 7"):
            light.gather(points, cones=7)
        with pytest.raises(TypeError, match=r"points: dtype float64, expected svocl\.gather_point_dtype"):
            light.gather(np.zeros((3, 12)))
        with pytest.raises(ValueError, match="positions: shape"):
            svocl.make_gather_points([0, 0], (0, 1, 0))


def test_a_light_keeps_its_tree(device, cube, points):
    tree = device.build(cube, 4, need=svocl.Need.NONE)
    light = svocl.Light(tree, svocl.LightForm.VOXELS)
    tree.close()
    light.set_sources(sky=(1, 1, 1))
    assert light.gather(points).shape == points.shape
    assert light.render(4, 4).shape == (4, 4, 4)
    assert "voxels" in repr(light)
    light.close()
    assert "closed" in repr(light)
    with pytest.raises(ValueError, match="^Light is closed$"):
        light.hash()


def test_trees_without_a_device(tmp_path, floor, device):
    if not svocl.has_io:
        pytest.skip("no files")
    floor.save(tmp_path / "floor.svo")
    loaded = svocl.Tree.load(tmp_path / "floor.svo")
    with pytest.raises(svocl.InvalidArgumentError, match=r"Light: the tree is on no device; call Tree\.upload"):
        svocl.Light(loaded)
    loaded.upload(device)
    with svocl.Light(loaded) as again, svocl.Light(floor) as light:
        assert again.hash() == light.hash()
