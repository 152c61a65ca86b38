# SPDX-License-Identifier: MIT
"""svocl.testing: equal trees pass, and of others the message says where."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest

import svocl
from svocl.testing import assert_trees_equal, describe_difference

PLACES = np.array([[0, 0, 0], [3, 1, 2], [7, 7, 7]])
SAMPLE = pathlib.Path(__file__).parents[2] / "samples" / "16_ci"


def a_tree(device, places=PLACES, colors=(9, 8, 7, 255), materials=0, **options):
    with svocl.Voxels(svocl.make_voxels(places, colors, materials)) as voxels:
        return voxels.build(device, **options)


def test_equal_trees_pass(device, tree, tmp_path):
    with a_tree(device) as a, a_tree(device) as b:
        assert_trees_equal(a, b)
        assert describe_difference(a, b) is None
    assert_trees_equal(tree, tree)
    if svocl.has_io:
        tree.save(tmp_path / "a.svo")
        assert_trees_equal(tmp_path / "a.svo", tree)
        assert_trees_equal(str(tmp_path / "a.svo"), tmp_path / "a.svo")


def test_a_moved_voxel_is_named(device):
    moved = PLACES.copy()
    moved[1] = 3, 2, 2
    with a_tree(device) as a, a_tree(device, moved) as b:
        with pytest.raises(AssertionError) as failure:
            assert_trees_equal(a, b)
        text = str(failure.value)
        assert a.hash() in text and b.hash() in text
        assert "voxels of level 3: 1 only in A, 1 only in B, 2 in both" in text
        assert "first: voxel 3, 1, 2 of level 3 at [3.5, 1.5, 2.5], only in A" in text
        assert "only in B" in describe_difference(b, a).splitlines()[-1]


def test_payload_is_named_with_both_values(device):
    colors = np.array([[9, 8, 7, 255], [9, 8, 7, 255], [9, 8, 17, 255]])
    with a_tree(device) as a, a_tree(device, colors=colors) as b, a_tree(device, materials=[0, 4, 0]) as c:
        text = describe_difference(a, b)
        assert "colors: 1 voxels differ, by at most 10" in text
        assert "first: voxel 7, 7, 7 of level 3" in text
        assert "colors [9, 8, 7, 255] in A, [9, 8, 17, 255] in B" in text
        text = describe_difference(a, c)
        assert "materials: 1 voxels differ\n" in text and "materials 0 in A, 4 in B" in text


def test_options_are_named(device, cube):
    with a_tree(device) as a, a_tree(device, depth=4) as deeper, a_tree(device, need=svocl.Need.COLOR) as fewer:
        assert "depth: 3 in A, 4 in B" in describe_difference(a, deeper)
        assert "need: " in describe_difference(a, fewer)
    with device.build(cube, 3) as a, device.build(cube, 3, origin=(-1, 0, 0), edge=2.5) as b:
        assert "edge: " in describe_difference(a, b)


def test_lists_and_nodes_above_are_named(device, cube):
    """The same voxels and other lists; payload that differs above the voxels alone is that of a cut of levels."""
    indices = cube.indices.copy()
    indices[[0, 1]] = indices[[1, 0]]
    with device.build(cube, 2, need=svocl.Need.RAYS) as a:
        with device.build(svocl.Mesh(cube.positions, indices), 2, need=svocl.Need.RAYS) as b:
            text = describe_difference(a, b)
            assert "only in A, 0 only in B" in text and "list: " in text and "list [" in text.splitlines()[-1]


def test_the_fixture_and_the_sample(tmp_path):
    (tmp_path / "conftest.py").write_text('pytest_plugins = ["svocl.pytest_plugin"]\n')
    (tmp_path / "test_it.py").write_text("def test_it(svocl_device):\n    assert not svocl_device.closed\n")
    paths = [tmp_path] + ([SAMPLE] if svocl.has_io and SAMPLE.is_dir() else [])
    for path in paths:
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(path)]
        done = subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout
