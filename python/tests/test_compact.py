# SPDX-License-Identifier: MIT
"""Compact trees and solids: they expand to the tree, trace as it does, and hold what a closed form says."""

import numpy as np
import pytest

import svocl

FORMS = list(svocl.Form)


@pytest.fixture
def rays(random):
    return svocl.make_rays(random.uniform(-2, 2, (300, 3)), random.normal(size=(300, 3)))


@pytest.fixture(scope="module")
def shaded(device, torus):
    """The torus with normals on every level."""
    with device.build(torus, 5, need=svocl.Need.NORMAL) as made:
        yield made


@pytest.mark.parametrize("form", FORMS)
def test_a_form_expands_and_traces_as_its_tree(shaded, rays, form):
    with svocl.Compact(shaded, form) as compact:
        assert compact.info.form == form and compact.on_device
        assert compact.info.leaf_count == compact.info.voxel_count == shaded.info.leaf_count
        assert sum(compact.info.level_leaf) == shaded.info.leaf_count and len(compact.info.level_leaf) == 6
        with compact.expand() as expanded:
            assert expanded.hash(nodes_only=True) == shaded.hash(nodes_only=True)
            assert expanded.info.is_exact and compact.info.is_exact and shaded.info.is_exact
        expected, hits = shaded.trace_voxels(rays), compact.trace(rays)
        assert 20 < np.isfinite(expected["t"]).sum() < 280
        for field in ("t", "level", "face", "normal"):
            assert np.array_equal(hits[field], expected[field]), field
        camera = shaded.frame()
        assert np.array_equal(compact.render(32, 24, camera), shaded.render(32, 24, camera=camera))
        assert compact.frame() == camera and compact.frame(1.5, camera) == shaded.frame(1.5, camera)
        assert np.array_equal(compact.render(32, 24), shaded.render(32, 24))


def test_the_arrays_are_those_of_the_form(shaded):
    words, masks, shared, mirrored = (svocl.Compact(shaded, form).arrays for form in FORMS)
    assert words.nodes.dtype == np.uint32 and words.links is None and words.bases.shape == words.nodes.shape
    assert masks.nodes.dtype == np.uint8
    assert np.array_equal(masks.nodes[: shaded.info.inner_count], shaded.arrays.child_mask)
    assert masks.links[0] == 1 and len(masks.bases) == 1
    assert len(shared.links) == 2 and shared.bases is None
    assert len(mirrored.links) == shaded.info.depth + 1 and len(mirrored.nodes) < len(shared.nodes)
    for arrays in (words, masks, shared, mirrored):  # they outlive the compact trees
        assert arrays.normals.shape == (shaded.info.node_count, 3) and arrays.colors is None
        assert not arrays.nodes.flags.writeable
        assert sorted(map(tuple, arrays.normals)) == sorted(map(tuple, shaded.arrays.normals))
    assert masks.normals.tolist() == shaded.arrays.normals.tolist()


def test_packed_payload(shaded):
    with svocl.Compact(shaded, svocl.Form.SHARED) as compact, compact.pack(normal_bits=5) as packed:
        assert packed.info.packed == svocl.Need.NORMAL and packed.info.normal_bits == 5 and compact.info.packed == 0
        assert packed.info.total_bytes < compact.info.total_bytes
        assert 0 < packed.info.mean_error[1] < packed.info.largest_error[1] < 3500
        normals = packed.payload(svocl.CompactBuffer.NORMALS)
        assert np.abs(normals.astype(int) - compact.arrays.normals).max() == packed.info.largest_error[1]
        assert np.array_equal(packed.payload(svocl.CompactBuffer.NORMALS, 7, 3), normals[7:10])
        assert packed.arrays.normals is None and list(packed.arrays.packed) == ["normals"]
        assert packed.arrays.packed["normals"].nbytes == packed.info.bytes[svocl.CompactBuffer.NORMALS]
        with packed.expand() as expanded:
            camera = expanded.frame()
            assert np.array_equal(packed.render(32, 24, camera), expanded.render(32, 24, camera=camera))
        with pytest.raises(svocl.InvalidArgumentError, match="normal_bits 9"):
            compact.pack(normal_bits=9)
        with pytest.raises(ValueError, match="no payload"):
            packed.payload(svocl.CompactBuffer.NODES)


def test_options(shaded):
    with svocl.Compact(shaded, svocl.Form.IMPLIED, directory_step=16, leave_out=svocl.Need.NORMAL) as compact:
        assert compact.info.directory_step_log2 == 4 and compact.info.need == 0 and compact.arrays.normals is None
    with svocl.Compact(shaded, minimize=True, leave_out=svocl.Need.NORMAL) as compact, compact.expand() as expanded:
        assert compact.info.minimized and compact.info.leaf_count < compact.info.voxel_count == shaded.info.leaf_count
        assert expanded.hash(nodes_only=True) == shaded.hash(nodes_only=True)
    with pytest.raises(ValueError, match="directory_step: 8 is not 16, 32 or 64"):
        svocl.Compact(shaded, svocl.Form.IMPLIED, directory_step=8)
    with pytest.raises(svocl.InvalidArgumentError, match="color_tolerance"):
        svocl.Compact(shaded, minimize=True, color_tolerance=(0, 0, 0, 256))
    with pytest.raises(ValueError, match=r"color_tolerance: shape \(3,\), expected \(4,\)"):
        svocl.Compact(shaded, color_tolerance=(0, 0, 0))
    with pytest.raises(TypeError, match=r"tree: Device, expected svocl\.Tree"):
        svocl.Compact(svocl.Device())
    with pytest.raises(ValueError):
        svocl.Compact(shaded, 7)


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
@pytest.mark.parametrize("form", FORMS)
def test_files(device, tree, rays, form, tmp_path):
    path = tmp_path / "torus.svc"
    with svocl.Compact(tree, form) as compact:
        compact.save(path, compress=True)
        for loaded in (svocl.Compact.load(path), svocl.Compact.load_bytes(path.read_bytes())):
            assert loaded.hash() == compact.hash() and loaded.info == compact.info and not loaded.on_device
            with pytest.raises(svocl.InvalidArgumentError, match=r"on no device; call Compact\.upload first"):
                loaded.trace(rays)
            loaded.upload(device)
            assert np.array_equal(loaded.trace(rays), compact.trace(rays))
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    with pytest.raises(svocl.FileDamagedError, match="^late: "):
        svocl.Compact.load_bytes(content, "late")
    with pytest.raises(svocl.FileError, match="No such file"):
        svocl.Compact.load(tmp_path / "none.svc")
    with pytest.raises(svocl.FileError):
        compact = svocl.Compact(tree, form)
        compact.save(tmp_path / "no/such/folder/t.svc")


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_a_tree_on_the_host_needs_a_device(device, tree, tmp_path):
    tree.save(tmp_path / "torus.svo")
    with svocl.Tree.load(tmp_path / "torus.svo") as loaded, svocl.Device() as other:
        with pytest.raises(svocl.InvalidArgumentError, match="Compact: the tree is on no device"):
            svocl.Compact(loaded)
        with svocl.Compact(loaded, device=device) as made, svocl.Compact(tree, device=device) as expected:
            assert made.hash() == expected.hash()
        with pytest.raises(svocl.InvalidArgumentError, match="Compact: the tree is on another device"):
            svocl.Compact(tree, device=other)


def test_closed(tree, rays):
    compact = svocl.Compact(tree)
    nodes = compact.arrays.nodes
    before = nodes.copy()
    compact.close()
    assert repr(compact) == "<svocl.Compact: closed>" and np.array_equal(nodes, before)
    for use in (lambda: compact.info, lambda: compact.trace(rays), compact.expand, compact.hash):
        with pytest.raises(ValueError, match="Compact is closed"):
            use()


def test_a_solid_cube_is_full(device, cube):
    """The cube fills its fitted grid: 16^3 voxels, of which the inner 14^3 touch no surface."""
    with device.build(cube, 4, need=svocl.Need.RAYS) as hull, svocl.Solid(hull) as solid:
        assert solid.solid_info.surface_voxels == hull.info.leaf_count == 16**3 - 14**3
        assert solid.solid_info.inside_voxels == 14**3 and solid.info.voxel_count == 16**3
        assert solid.solid_info.open_columns == (0, 0, 0) and solid.solid_info.ambiguous_cells == 0
        with solid.expand() as expanded:
            assert expanded.info.leaf_count == 16**3
        assert repr(solid).startswith("<svocl.Solid: descriptor, depth 4")
        with svocl.Solid(hull, svocl.SolidRule.PARITY) as parity:
            assert parity.hash() == solid.hash()


def test_a_cube_with_a_hole_says_so(device, cube):
    open_cube = svocl.Mesh(cube.positions, cube.indices[:-2])
    with device.build(open_cube, 4, need=svocl.Need.RAYS) as hull, svocl.Solid(hull) as solid:
        assert max(solid.solid_info.open_columns) > 0 and solid.solid_info.inside_voxels == 14 * 14 * 15
        with svocl.Solid(hull, svocl.SolidRule.GENERALIZED) as lid:
            assert lid.solid_info.boundary_edges == 4
            assert 0 < lid.solid_info.inside_voxels <= 14 * 14 * 15


def test_progress_stops_a_solid(device, cube):
    told = []

    def stop_at_second(fraction):
        told.append(fraction)
        return len(told) == 2

    with device.build(cube, 4, need=svocl.Need.RAYS) as hull:
        with svocl.Solid(hull, progress=told.append) as solid:
            assert told == sorted(told) and told[0] == 0 and told[-1] == 1
            made = solid.hash()
        told.clear()
        with pytest.raises(svocl.CanceledError, match="the progress callback stopped the call"):
            svocl.Solid(hull, progress=stop_at_second)
        assert len(told) == 2
        with svocl.Solid(hull) as again:
            assert again.hash() == made


def test_what_is_no_solid(device, cube):
    with device.build(cube, 4) as bare, pytest.raises(svocl.InvalidArgumentError, match="holds no leaf lists"):
        svocl.Solid(bare)
    with device.build(cube, 4, need=svocl.Need.RAYS) as hull:
        with pytest.raises(ValueError, match="color"):
            svocl.Solid(hull, color=(0, 0, 0))
        with pytest.raises(ValueError, match=r"material: 65536 is not in 0 \.\. 65535"):
            svocl.Solid(hull, material=65536)
