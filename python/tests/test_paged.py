# SPDX-License-Identifier: MIT
"""Paged trees: a picture that misses nothing is that of the whole tree, and files that change are noticed."""

import re

import numpy as np
import pytest

import svocl

pytestmark = pytest.mark.skipif(not svocl.has_io, reason="built without svocl::io")

PLENTY = 1 << 20  # for all pages, though not for all of the tree as upper levels
SIZE = (96, 64)


@pytest.fixture(scope="module")
def whole(device, torus, tmp_path_factory):
    """A tree, its file, and its picture."""
    path = tmp_path_factory.mktemp("paged") / "torus.svo"
    with device.build(torus, 7, need=svocl.Need.NORMAL) as tree:
        tree.save(path)
        tree.save(path.with_name("compressed.svo"), compress=True)
        yield tree, path, tree.render(*SIZE)


def refine(paged, **options):
    """The last of the pictures that follow each other."""
    picture = paged.render(*SIZE, **options)
    while paged.counts.missed_pages > 0 and paged.update().read_pages > 0:
        picture = paged.render(*SIZE, **options)
    return picture


def test_the_last_picture_is_that_of_the_whole_tree(device, whole):
    tree, path, picture = whole
    with svocl.Paged(device, path, PLENTY) as paged:
        info = paged.info
        assert info.depth == 7 and info.need == svocl.Need.NORMAL and info.page_count > 10
        assert info.file_bytes == path.stat().st_size and info.least_bytes < info.device_bytes == info.whole_bytes
        assert paged.frame(1.5) == tree.frame(1.5)
        first = paged.render(*SIZE)
        assert paged.counts.missed_pages > 0 and paged.counts.held_pages == 0
        assert not np.array_equal(first, picture)
        assert np.array_equal(refine(paged), picture)
        counts = paged.counts
        assert counts.missed_pages == 0 and counts.pictures > 2
        assert counts.all_read_pages == counts.held_pages <= info.page_count and counts.all_evicted_pages == 0
        assert f"{counts.held_pages} of {info.page_count} pages" in repr(paged)
        depths = refine(paged, view=svocl.View.DEPTH)
        assert np.array_equal(depths, tree.render(*SIZE, view=svocl.View.DEPTH))


def test_a_folder_of_parts_is_a_tree(device, torus, whole, tmp_path):
    tree, path, picture = whole
    place = tmp_path / "parts"
    with svocl.Parts.create(device, torus, 7, place, max_bytes=1 << 18, need=svocl.Need.NORMAL) as parts:
        with pytest.raises(svocl.FileError, match="part"):
            svocl.PartsTree(place)
        for index in range(len(parts)):
            parts.build(index, device)
    with svocl.PartsTree(place) as folder:
        info = folder.info
        assert info.part_count > 1 and info.last_level == info.tree.depth == 7
        assert info.node_count == tree.info.node_count == sum(info.level_nodes)
        assert info.inner_count + info.leaf_count == info.node_count
        assert folder.hash() == tree.hash() and folder.hash(nodes_only=True) == tree.hash(nodes_only=True)
        assert folder.check() == info.part_count and folder.check(1, seed=5) == 1
        assert folder.save(tmp_path / "again.svo").node_count == info.node_count
        assert (tmp_path / "again.svo").read_bytes() == path.read_bytes()
        with folder.load(levels=5) as coarse, svocl.Tree.load(path, levels=5) as expected:
            assert coarse.hash() == expected.hash()
        codes = [code for code in range(8) if tree.arrays.child_mask[0] >> code & 1]
        with folder.load(1, codes[0]) as corner:
            assert corner.info.depth == 6 and corner.info.edge == tree.info.edge / 2
        with pytest.raises(svocl.InvalidArgumentError, match="level"):
            folder.load(8)
        assert f"in {info.part_count} parts" in repr(folder)
    assert repr(folder) == "<svocl.PartsTree: closed>"
    with svocl.Paged(device, place, PLENTY) as paged:
        assert np.array_equal(refine(paged), picture)
        assert paged.frame(1.5) == tree.frame(1.5)


def test_little_room(device, whole):
    """As much is drawn as fits, and what an update reads has a limit."""
    tree, path, picture = whole
    budget = path.stat().st_size // 2
    with svocl.Paged(device, path, budget, page_levels=2, update_bytes=1) as paged:
        assert paged.info.device_bytes <= budget and paged.info.page_levels == 2
        paged.render(*SIZE)
        counts = paged.update()
        assert counts.read_pages == 1 and counts.waiting_pages > 0 and counts.read_bytes == counts.all_read_bytes > 0
    with pytest.raises(svocl.CapacityExceededError) as caught:
        svocl.Paged(device, path, 1)
    least = int(re.search(r"is below (\d+)", str(caught.value))[1])
    with pytest.raises(svocl.CapacityExceededError, match=str(least)):
        svocl.Paged(device, path, least - 1)
    with svocl.Paged(device, path, least) as paged:
        coarse = refine(paged)
        assert paged.counts.missed_pages > 0 and paged.info.device_bytes <= least
        assert not np.array_equal(coarse, picture)


def test_a_file_that_changes(device, whole, tmp_path):
    content = whole[1].read_bytes()
    path = tmp_path / "changes.svo"
    path.write_bytes(content)
    with svocl.Paged(device, path, PLENTY) as paged:
        camera = paged.frame(SIZE[0] / SIZE[1])
        paged.render(*SIZE, camera=camera)
        path.write_bytes(bytes(byte ^ 255 for byte in content))
        with pytest.raises(svocl.FileDamagedError, match=r"changes\.svo"):
            paged.update()
        assert paged.counts.held_pages == 0
        path.write_bytes(content)
        assert np.array_equal(refine(paged, camera=camera), whole[2])


def test_what_is_refused(device, whole, tmp_path):
    path = whole[1]
    with pytest.raises(svocl.FileError, match=r"none\.svo"):
        svocl.Paged(device, tmp_path / "none.svo", PLENTY)
    with pytest.raises(svocl.UnsupportedError, match="compressed"):
        svocl.Paged(device, path.with_name("compressed.svo"), PLENTY)
    with pytest.raises(svocl.InvalidArgumentError, match="page_levels"):
        svocl.Paged(device, path, PLENTY, page_levels=6)
    with pytest.raises(ValueError, match="budget_bytes: -1"):
        svocl.Paged(device, path, -1)
    paged = svocl.Paged(device, path, PLENTY)
    with pytest.raises(svocl.Error, match="options.view 5 is none of a paged tree"):
        paged.render(*SIZE, view=svocl.View.TRIANGLES)
    paged.close()
    assert repr(paged) == "<svocl.Paged: closed>"
    with pytest.raises(ValueError, match="Paged is closed"):
        paged.update()
