# SPDX-License-Identifier: MIT
"""Trees as .svo files and meshes from files: the same tree comes back, broken files are refused in words."""

import logging
import os

import numpy as np
import pytest
from shapes import CUBE_INDICES, CUBE_POSITIONS

import svocl

pytestmark = pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")


def write_obj(path):
    lines = [f"v {x} {y} {z}" for x, y, z in CUBE_POSITIONS]
    lines += ["f {} {} {}".format(*(triangle + 1)) for triangle in CUBE_INDICES]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("compress", [False, True])
def test_a_saved_tree_loads_again(tree, tmp_path, compress):
    path = tmp_path / "torus.svo"
    tree.save(path, compress=compress)
    for loaded in (svocl.Tree.load(path), svocl.Tree.load(str(path)), svocl.Tree.load_bytes(path.read_bytes())):
        with loaded:
            assert loaded.hash() == tree.hash() and loaded.report is None and not loaded.on_device
            assert loaded.info == tree.info
            for mine, theirs in zip(loaded.arrays, tree.arrays):
                assert (mine is None and theirs is None) or np.array_equal(mine, theirs)


def test_upper_levels_of_a_file(tree, tmp_path):
    path = tmp_path / "torus.svo"
    tree.save(path)
    with svocl.Tree.load(path, levels=3) as upper:
        inner, nodes = tree.info.level_begin[3], tree.info.level_begin[4]
        assert upper.info.depth == 3 and upper.info.leaf_count == nodes - inner
        assert np.array_equal(upper.arrays.child_mask, tree.arrays.child_mask[:inner])
        assert upper.arrays.list is None
        with svocl.Tree.load_bytes(path.read_bytes(), levels=3) as same:
            assert same.hash() == upper.hash()
    with pytest.raises(svocl.InvalidArgumentError, match="last_level 17 is not in 1 .. "):
        svocl.Tree.load(path, levels=17)


def test_a_loaded_tree_traces_after_upload(device, tree, tmp_path):
    tree.save(tmp_path / "torus.svo")
    rays = svocl.make_rays([[-3, 0.013, 0.017]], [1, 0, 0])
    with svocl.Tree.load(tmp_path / "torus.svo") as loaded:
        for use in (lambda: loaded.trace(rays), lambda: loaded.render(8, 8), loaded.prepare_rays):
            with pytest.raises(svocl.InvalidArgumentError, match="on no device; call Tree.upload first"):
                use()
        loaded.upload(device)
        loaded.upload(device)
        assert np.array_equal(loaded.trace(rays), tree.trace(rays))
        with svocl.Device() as other:
            with pytest.raises(svocl.InvalidArgumentError, match="the tree is on another device"):
                loaded.upload(other)
        assert np.array_equal(loaded.trace(rays), tree.trace(rays))


def test_broken_files(tree, tmp_path):
    path = tmp_path / "torus.svo"
    with pytest.raises(svocl.FileError, match="torus.svo: .*No such file") as caught:
        svocl.Tree.load(path)
    assert isinstance(caught.value, OSError) and caught.value.status == svocl.Status.FILE_ERROR
    tree.save(path)
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    with pytest.raises(svocl.FileDamagedError, match="^late: "):
        svocl.Tree.load_bytes(content, "late")
    with pytest.raises(svocl.FileDamagedError):
        svocl.Tree.load_bytes(b"")
    with pytest.raises(svocl.FileError, match="no/such/folder"):
        tree.save(tmp_path / "no/such/folder/t.svo")
    with pytest.raises(ValueError, match="null byte"):
        svocl.Tree.load("a\0b")
    with pytest.raises(TypeError):
        svocl.Tree.load(3)


def test_a_mesh_file(device, cube, tmp_path):
    mesh = svocl.read_mesh(write_obj(tmp_path / "cube.obj"))
    assert mesh.triangle_count == 12 and mesh.positions.dtype == np.float32
    assert not mesh.positions.flags.writeable
    with device.build(mesh, 4, need=svocl.Need.NONE) as read, device.build(cube, 4, need=svocl.Need.NONE) as made:
        assert read.hash() == made.hash()


def test_vertices_of_a_mesh_file_are_welded(tmp_path):
    path = tmp_path / "cracked.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1e-7 0 0\nv 0 0 1\nf 1 2 3\nf 2 4 5\n")
    assert svocl.read_mesh(path).import_info.welded_vertices == 0
    mesh = svocl.read_mesh(path, weld=1e-6)
    assert mesh.import_info.welded_vertices == 1
    assert len(np.unique(mesh.positions, axis=0)) == 4 and mesh.triangle_count == 2
    with pytest.raises(svocl.InvalidArgumentError, match="options.weld -1 is not a finite number of at least 0"):
        svocl.read_mesh(path, weld=-1)


def test_a_name_that_is_not_utf8(tmp_path):
    path = os.fsencode(tmp_path) + b"/\xff.obj"
    write_obj(tmp_path / "cube.obj").rename(os.fsdecode(path))
    assert svocl.read_mesh(path).triangle_count == 12
    with pytest.raises(svocl.FileError, match=r"\\xfe\.obj"):
        svocl.read_mesh(path.replace(b"\xff", b"\xfe"))


def test_mesh_files_that_cannot_be_read(tmp_path):
    with pytest.raises(svocl.FileError, match=r"none\.obj: .*No such file"):
        svocl.read_mesh(tmp_path / "none.obj")
    (tmp_path / "empty.obj").write_text("v 0 0 0\n")
    with pytest.raises(svocl.ImportFailedError, match=r"empty\.obj"):
        svocl.read_mesh(tmp_path / "empty.obj")
    with pytest.raises(ValueError, match=r"time_limit_seconds: -1 is not in 0 \.\. 4294967295"):
        svocl.read_mesh(tmp_path / "empty.obj", time_limit_seconds=-1)


def obj_without_its_texture(folder):
    (folder / "paint.mtl").write_text("newmtl paint\nmap_Kd missing.png\n")
    path = folder / "triangle.obj"
    path.write_text(
        "mtllib paint.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    )
    return path


def test_warnings_are_logged(tmp_path, caplog):
    with caplog.at_level(logging.WARNING, logger="svocl"):
        svocl.read_mesh(obj_without_its_texture(tmp_path))
    assert any("missing.png" in record.getMessage() for record in caplog.records)
    assert {record.levelno for record in caplog.records} == {logging.WARNING}


def test_what_a_file_holds_is_compared_with_what_was_read(tmp_path):
    path = tmp_path / "part.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\nl 1 2\n")
    info = svocl.read_mesh(path).import_info
    assert info == svocl.ImportInfo("obj", 4, 3, 1, 1, 1, 2, 0)
    with pytest.raises(svocl.ImportFailedError, match="left out|belong to no face"):
        svocl.read_mesh(path, strict=True)
    whole = tmp_path / "whole.obj"
    whole.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert svocl.read_mesh(whole, strict=True).import_info.warnings == 0
    assert svocl.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]]).import_info is None


def test_an_exception_in_a_callback_comes_out_of_the_call(tmp_path, monkeypatch):
    """And the mesh, which the call has read nevertheless, is freed."""
    from svocl import _mesh

    class Stop(Exception):
        pass

    class Counting:
        freed = 0

        def __getattr__(self, name):
            self.freed += name == "svo_import_destroy"
            return getattr(library, name)

    def refuse(record):
        raise Stop(record.getMessage())

    library, counting = _mesh.lib, Counting()
    path = obj_without_its_texture(tmp_path)
    logger = logging.getLogger("svocl")
    logger.addFilter(refuse)
    monkeypatch.setattr(_mesh, "lib", counting)
    try:
        with pytest.raises(Stop, match=r"missing\.png"):
            svocl.read_mesh(path)
    finally:
        logger.removeFilter(refuse)
    assert counting.freed == 1
    assert svocl.read_mesh(path).triangle_count == 1
