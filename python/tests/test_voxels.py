# SPDX-License-Identifier: MIT
"""Given voxels: lists, the trees of them, and files, there and back."""

import struct

import numpy as np
import pytest

import svocl


def some_voxels(random, count=200):
    """Different places, colors and materials."""
    places = np.unique(random.integers(-9, 9, (count, 3)), axis=0)
    colors = random.integers(0, 256, (len(places), 4))
    colors[:, 3] = 255
    return svocl.make_voxels(places, colors, random.integers(0, 5, len(places)))


def as_set(records):
    return {(int(v["x"]), int(v["y"]), int(v["z"]), tuple(v["rgba"]), int(v["material"])) for v in records}


def test_a_list_holds_each_place_once(random):
    given = some_voxels(random)
    again = given[:7].copy()
    again["rgba"] = 1, 2, 3, 4
    with svocl.Voxels(np.concatenate([given, again])) as voxels:
        info, records = voxels.info, voxels.records
        assert info.voxel_count == len(given) == len(records) and info.given_count == len(given) + 7
        assert as_set(records) == as_set(given[7:]) | as_set(again)
        places = np.stack([given[axis] for axis in "xyz"], axis=1)
        assert info.low == tuple(places.min(axis=0)) and info.high == tuple(places.max(axis=0) + 1)
        assert info.depth == 5 and info.material_count == given["material"].max() + 1
        assert not records.flags.writeable and voxels.file_info is None
    assert len(as_set(records)) == len(given)  # the records outlive the list


def test_properties_and_the_grid(random):
    properties = {3: {"type": "glass", "ior": "1.5"}, 0: {"type": ""}}
    with svocl.Voxels(some_voxels(random), properties=properties, origin=(1, 2, 3), voxel_edge=0.5) as voxels:
        assert voxels.properties == properties
        assert voxels.info.origin == (1, 2, 3) and voxels.info.voxel_edge == 0.5 and voxels.info.property_count == 3


def test_a_tree_of_a_list_has_its_voxels(device, random):
    given = some_voxels(random)
    with svocl.Voxels(given) as voxels, voxels.build(device) as tree:
        assert tree.info.depth == voxels.info.depth and tree.info.leaf_count == len(given)
        assert tree.info.need == svocl.Need.COLOR | svocl.Need.MATERIAL
        places = tree.voxels() + np.array(voxels.info.low)
        assert {tuple(place) for place in places} == {tuple(int(v[axis]) for axis in "xyz") for v in given}
        with svocl.Voxels.of_tree(tree) as back:
            assert np.array_equal(back.records, voxels.records)
        with voxels.plan(device, 6, need=svocl.Need.NONE) as plan:
            assert plan.info.depth == 6 and plan.info.need == 0
        stages = set()
        voxels.build(device, progress=lambda stage, _: stages.add(stage)).close()
        assert stages


def test_no_voxels(device):
    with svocl.Voxels(svocl.make_voxels(np.empty((0, 3), int))) as voxels:
        assert voxels.info.voxel_count == 0 and len(voxels.records) == 0 and voxels.properties == {}


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
@pytest.mark.parametrize("suffix", ["vox", "svx", "binvox"])
def test_files(random, suffix, tmp_path):
    path = tmp_path / f"some.{suffix}"
    with svocl.Voxels(some_voxels(random)) as voxels:
        written = voxels.save(path)
        assert written.format == suffix and written.bytes == path.stat().st_size
        for loaded in (svocl.Voxels.load(path), svocl.Voxels.load_bytes(path.read_bytes())):
            assert loaded.file_info.format == suffix and loaded.info.voxel_count == voxels.info.voxel_count
            if suffix == "vox":
                assert loaded.file_info.version in (150, 200)
                assert loaded.file_info.instance_voxels == len(voxels.records)
                places = [{tuple(int(v[axis]) for axis in "xyz") for v in some.records} for some in (loaded, voxels)]
                assert places[0] == places[1]
                kept = svocl.Voxels.load(path, axes=svocl.Axes.KEEP)
                turned = {(int(v["x"]), int(v["z"]), -1 - int(v["y"])) for v in kept.records}
                assert turned == places[0]
                kept.save(tmp_path / "kept.vox")
                assert (tmp_path / "kept.vox").read_bytes() == path.read_bytes()
                kept.set_axes(svocl.Axes.AUTO)
                kept.save(tmp_path / "kept.vox")
                assert (tmp_path / "kept.vox").read_bytes() != path.read_bytes()


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_files_that_are_only_written_or_broken(random, tmp_path):
    with svocl.Voxels(some_voxels(random)) as voxels:
        assert voxels.save(tmp_path / "some.obj").faces > 0
        assert voxels.save(tmp_path / "some.ply").format == "ply"
        with pytest.raises(svocl.InvalidArgumentError, match="some.txt"):
            voxels.save(tmp_path / "some.txt")
        with pytest.raises(svocl.FileError):
            voxels.save(tmp_path / "no/such/folder/some.vox")
        voxels.save(tmp_path / "some.vox")
    content = (tmp_path / "some.vox").read_bytes()
    with pytest.raises(svocl.FileDamagedError, match="^half: "):
        svocl.Voxels.load_bytes(content[: len(content) // 2], "half")
    with pytest.raises(svocl.InvalidArgumentError):
        svocl.Voxels.load_bytes(content, voxels_max=3)
    with pytest.raises(svocl.FileError, match="No such file"):
        svocl.Voxels.load(tmp_path / "none.vox")


def vox_chunk(kind, content, children=b""):
    return kind + struct.pack("<II", len(content), len(children)) + content + children


def vox_dict(**values):
    content = struct.pack("<I", len(values))
    for key, value in values.items():
        content += struct.pack("<I", len(key)) + key.encode() + struct.pack("<I", len(value)) + value.encode()
    return content


def vox_scene():
    """Two models in three places: the first one twice, once turned by a quarter about z; and a third one nowhere."""
    models = [((3, 4, 2), [(0, 0, 0, 1), (2, 3, 1, 2)]), ((5, 1, 7), [(4, 0, 6, 9)]), ((1, 1, 1), [(0, 0, 0, 1)])]
    places = [(0, "4", "0 0 0"), (1, "4", "20 -3 5"), (0, "17", "-9 30 2")]
    chunks = b""
    for size, voxels in models:
        chunks += vox_chunk(b"SIZE", struct.pack("<3I", *size))
        chunks += vox_chunk(b"XYZI", struct.pack("<I", len(voxels)) + bytes(byte for voxel in voxels for byte in voxel))
    chunks += vox_chunk(b"nTRN", struct.pack("<I", 0) + vox_dict() + struct.pack("<IiiI", 1, -1, -1, 1) + vox_dict())
    children = [2 + 2 * i for i in range(len(places))]
    chunks += vox_chunk(b"nGRP", struct.pack("<I", 1) + vox_dict() + struct.pack("<4I", 3, *children))
    for child, (model, rotation, moved) in zip(children, places):
        frame = struct.pack("<IiiI", child + 1, -1, 0, 1) + vox_dict(_r=rotation, _t=moved)
        chunks += vox_chunk(b"nTRN", struct.pack("<I", child) + vox_dict() + frame)
        shape = struct.pack("<I", child + 1) + vox_dict() + struct.pack("<II", 1, model) + vox_dict()
        chunks += vox_chunk(b"nSHP", shape)
    return b"VOX " + struct.pack("<I", 200) + vox_chunk(b"MAIN", b"", chunks)


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_parts_of_a_scene_are_its_list(device, tmp_path):
    path = tmp_path / "scene.vox"
    path.write_bytes(vox_scene())
    for axes in (svocl.Axes.AUTO, svocl.Axes.KEEP):
        parts = svocl.Voxels.load_parts(path, axes=axes)
        assert [part.model for part in parts] == [0, 1]
        assert [part.transforms.shape for part in parts] == [(2, 3, 4), (1, 3, 4)]
        assert [part.voxels.info.voxel_count for part in parts] == [2, 1]
        placed = set()
        for part in parts:
            records = part.voxels.records
            centers = np.stack([records[axis] + 0.5 for axis in "xyz"] + [np.ones(len(records))])
            for matrix in part.transforms:
                moved = records.copy()
                moved["x"], moved["y"], moved["z"] = np.floor(matrix @ centers)
                placed |= as_set(moved)
        with svocl.Voxels.load(path, axes=axes) as voxels:
            assert placed == as_set(voxels.records) and len(placed) == 5
            assert all(part.voxels.file_info == voxels.file_info for part in parts)
    again = svocl.Voxels.load_parts_bytes(path.read_bytes())
    trees = [part.voxels.build(device) for part in again]
    rows = [svocl.make_instances(tree, part.transforms) for tree, part in enumerate(again)]
    with svocl.Scene(trees, np.concatenate(rows)) as scene:
        assert scene.info.instance_count == 3 and scene.info.tree_count == 2


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_parts_that_are_refused(random, tmp_path, monkeypatch):
    path = tmp_path / "scene.vox"
    path.write_bytes(vox_scene())
    with pytest.raises(svocl.InvalidArgumentError):
        svocl.Voxels.load_parts(path, voxels_max=1)
    with pytest.raises(svocl.FileDamagedError, match="^half: "):
        svocl.Voxels.load_parts_bytes(path.read_bytes()[:-20], "half")
    with svocl.Voxels(some_voxels(random)) as voxels:
        voxels.save(tmp_path / "some.binvox")
    with pytest.raises(svocl.UnsupportedError):
        svocl.Voxels.load_parts(tmp_path / "some.binvox")

    def fail(_self, _axes):
        raise KeyError("in the callback")

    monkeypatch.setattr(svocl.Voxels, "set_axes", fail)  # what the callback raises comes out, and ends the reading
    with pytest.raises(KeyError, match="in the callback"):
        svocl.Voxels.load_parts(path)


def test_wrong_arguments(device):
    with pytest.raises(TypeError, match=r"voxels: list, expected an array of svocl\.voxel_dtype"):
        svocl.Voxels([])
    with pytest.raises(TypeError, match="voxels: dtype float64"):
        svocl.Voxels(np.zeros((3, 3)))
    with pytest.raises(ValueError, match=r"positions: shape \(3,\), expected \(voxel_count, 3\)"):
        svocl.make_voxels([1, 2, 3])
    with pytest.raises(TypeError, match="positions: dtype float64, expected integers"):
        svocl.make_voxels([[0.5, 1, 2]])
    with pytest.raises(ValueError, match=r"colors: not all in 0 \.\. 255"):
        svocl.make_voxels([[0, 1, 2]], [[0, 0, 0, 256]])
    with pytest.raises(ValueError, match="voxel_edge: 0 is not above 0"):
        svocl.Voxels(svocl.make_voxels([[0, 0, 0]]), voxel_edge=0)
    with pytest.raises(svocl.InvalidArgumentError, match="origin"):
        svocl.Voxels(svocl.make_voxels([[0, 0, 0]]), origin=(np.nan, 0, 0))
    far = svocl.Voxels(svocl.make_voxels([[0, 0, 0], [100, 0, 0]]))
    with pytest.raises(svocl.InvalidArgumentError, match="depth"):
        far.build(device, 3)
    far.close()
    with pytest.raises(ValueError, match="Voxels is closed"):
        far.info  # noqa: B018


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_vox_files_are_copied(random, tmp_path):
    first, second = tmp_path / "first.vox", tmp_path / "second.vox"
    with svocl.Voxels(some_voxels(random)) as voxels:
        voxels.save(first)
        assert voxels.left_out == ""
    info = svocl.Voxels.copy_vox(first, second)
    assert info.format == "vox" and info.models == 1 and info.groups == 1
    assert first.read_bytes() == second.read_bytes()
    with svocl.Voxels.load(first) as loaded:
        assert loaded.left_out.startswith("1 group, ") and loaded.left_out.endswith(" colors that no voxel has")
    first.write_bytes(b"TDCZ")
    with pytest.raises(svocl.UnsupportedError, match="Teardown"):
        svocl.Voxels.copy_vox(first, second)


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_faces_are_read_back(device, random, tmp_path):
    """A list, its faces, the mesh of them, a tree on the grid of that mesh, and its leaves."""
    path = tmp_path / "faces.ply"
    places = np.unique(random.integers(-3, 3, (60, 3)), axis=0)
    with svocl.Voxels(svocl.make_voxels(places, (200, 100, 50, 255))) as voxels:
        written = voxels.save_faces(path)
    assert 6 < written.faces < written.voxel_faces < 6 * len(places)
    mesh = svocl.read_mesh(path)
    origin, edge, depth = mesh.voxel_grid(1)
    assert edge == 8 and depth == 3
    with device.build(mesh, depth, origin=origin, edge=edge) as tree:
        found = {tuple(place) for place in (tree.voxels() + np.array(origin, int)).tolist()}
    assert found <= {tuple(place) for place in places.tolist()}
    steps = [(axis, step) for axis in range(3) for step in (-1, 1)]
    shown = [p for p in places.tolist() if any(beside(p, *step) not in places.tolist() for step in steps)]
    assert found >= {tuple(place) for place in shown}
    with pytest.raises(svocl.InvalidArgumentError, match="above the limit of 65536"):
        mesh.voxel_grid(1e-6)


def beside(place, axis, step):
    return [coordinate + (step if i == axis else 0) for i, coordinate in enumerate(place)]


@pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")
def test_points(device, random, tmp_path):
    at, colors = random.integers(-50, 50, (4000, 3)) / 8.0, random.integers(0, 65536, (4000, 3))
    points = svocl.make_points(at, colors)
    with svocl.Voxels.of_points(points, voxel_edge=1.0, counts=True) as voxels:
        places, inverse, counts = np.unique(np.floor(at), axis=0, return_inverse=True, return_counts=True)
        low = places.min(axis=0)
        assert voxels.points_info.format == "auto" and voxels.points_info.taken_count == len(points)
        assert voxels.info.origin == tuple(low) and voxels.info.voxel_edge == 1.0
        found = {(int(v["x"]), int(v["y"]), int(v["z"])): i for i, v in enumerate(voxels.records)}
        assert len(found) == len(places)
        sums = np.stack([np.bincount(inverse.reshape(-1), colors[:, c]) for c in range(3)], axis=1).astype(np.int64)
        means = (2 * 255 * sums + counts[:, None] * 65535) // (2 * counts[:, None] * 65535)
        for place, count, mean in zip(places - low, counts, means):
            index = found[tuple(place.astype(int))]
            assert voxels.counts[index] == count == voxels.records[index]["material"]
            assert tuple(voxels.records[index]["rgba"]) == (*mean, 255)
        with voxels.build(device) as tree:
            assert tree.info.leaf_count == len(places)
        voxels.save(tmp_path / "map.bt")
        with svocl.Voxels.load(tmp_path / "map.bt") as back:
            assert back.info.voxel_count == len(places) and back.counts is None
    path = tmp_path / "cloud.ply"
    head = f"ply\nformat ascii 1.0\nelement vertex {len(at)}\n" + "".join(f"property double {c}\n" for c in "xyz")
    path.write_text(head + "end_header\n" + "\n".join(" ".join(map(str, row)) for row in at.tolist()))
    with svocl.Voxels.load_points(path, origin=(0, 0, 0), edge=4, depth=2) as voxels:
        inside = np.all((at >= 0) & (at < 4), axis=1)
        assert voxels.points_info.outside_count == len(at) - inside.sum() and voxels.counts.sum() == inside.sum()
        assert not voxels.counts.flags.writeable
    with pytest.raises(svocl.OutOfHostMemoryError, match="memory_bytes"):
        svocl.Voxels.of_points(svocl.make_points(random.random((50000, 3))), 16, memory_bytes=4 << 20)
    with pytest.raises(ValueError, match="colors: not all in 0 .. 65535"):
        svocl.make_points(at, 65536)
