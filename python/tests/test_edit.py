# SPDX-License-Identifier: MIT
"""Edits of voxels: steps, versions, and the lists and trees of them."""

import numpy as np
import pytest

import svocl
from svocl import Box, Capsule, EditVerb, Sphere


def places(edit):
    with edit.voxels() as voxels:
        return {tuple(int(v[axis]) for axis in "xyz") for v in voxels.records}


def inside(radius):
    axis = np.arange(-20, 20) + 0.5
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    found = np.argwhere(x**2 + y**2 + z**2 <= radius**2) - 20
    return {tuple(int(part) for part in place) for place in found}


def test_steps_and_versions():
    with svocl.Edit(undo_count=3) as edit:
        edit.apply(EditVerb.SET, Sphere((0, 0, 0), 7.5), color=(9, 8, 7, 255), material=2)
        sphere = inside(7.5)
        assert places(edit) == sphere and edit.info.voxel_count == len(sphere)
        assert tuple(edit.find((0, -1, 3))["rgba"]) == (9, 8, 7, 255) and edit.find((0, 0, 9)) is None
        edit.apply(EditVerb.CLEAR, Box((-20, -20, 0), (20, 20, 20)))
        half = {place for place in sphere if place[2] < 0}
        assert places(edit) == half
        edit.copy(Box((0, -20, -20), (20, 20, 20)), (10, 0, 1))
        assert places(edit) == half | {(x + 10, y, z + 1) for x, y, z in half if x >= 0}
        edit.apply(EditVerb.KEEP, Capsule((0, 0, -5), (0, 0, -5), 0.0))  # no center is that near
        assert places(edit) == set() and edit.info.undo_count == 3 and edit.info.redo_count == 0
        for _ in range(3):
            edit.undo()
        assert places(edit) == sphere
        with pytest.raises(IndexError):
            edit.undo()
        edit.redo()
        edit.collect()
        assert places(edit) == half and edit.info.collections == 1
        edit.forget()
        assert edit.info.undo_count == 0 and edit.info.redo_count == 0
        with pytest.raises(svocl.InvalidArgumentError, match="radius -1 is not at least 0"):
            edit.apply(EditVerb.SET, Sphere((0, 0, 0), -1))
        with pytest.raises(TypeError):
            edit.apply(EditVerb.SET, (0, 0, 0))
    assert edit.closed and repr(edit) == "<svocl.Edit: closed>"


def test_other_edits_are_combined(device):
    with svocl.Edit() as ball, svocl.Edit() as edit:
        ball.apply(EditVerb.SET, Sphere((0, 0, 0), 4), color=(1, 2, 3, 255))
        edit.apply(EditVerb.SET, Box((0, 0, 0), (8, 8, 8)))
        box = places(edit)
        moved = {(x + 8, y + 8, z) for x, y, z in inside(4)}
        edit.combine(EditVerb.CLEAR, ball, (8, 8, 0))
        assert places(edit) == box - moved
        edit.combine(EditVerb.ADD, ball, (8, 8, 0))
        assert places(edit) == box | moved and tuple(edit.find((7, 7, 0))["rgba"]) == (1, 2, 3, 255)
        edit.combine(EditVerb.KEEP, edit, (4, 0, 0))
        assert places(edit) == {place for place in box | moved if (place[0] - 4, *place[1:]) in box | moved}
        with edit.build(device) as tree, edit.voxels() as voxels, svocl.Edit(voxels) as again:
            assert tree.info.leaf_count == edit.info.voxel_count
            with again.build(device) as same:
                assert same.hash() == tree.hash()
            with edit.compact(device, 6, svocl.Form.SHARED) as compact, edit.build(device, 6) as deeper:
                with svocl.Compact(deeper, svocl.Form.SHARED) as same:
                    assert compact.hash() == same.hash()
            with pytest.raises(svocl.InvalidArgumentError, match="svo_edit_commit_compact: depth 1 is not in"):
                edit.compact(device, 1)


def test_normals_follow(device):
    records = svocl.make_voxels([(2, 0, 0), (0, 0, 0), (1, 0, 0)])
    given = np.array([(0, 0, 100), (-32767, 0, 0), (0, 0, 0)], np.int16)
    with svocl.Voxels(records, normals=given) as voxels, svocl.Edit(voxels) as edit:
        assert voxels.normals.tolist() == [[-32767, 0, 0], [0, 0, 0], [0, 0, 100]]
        edit.apply(EditVerb.SET, Box((1, 0, 0), (5, 3, 3)))
        with edit.voxels() as found, edit.build(device) as tree, found.build(device) as same:
            normals = {tuple(int(v[axis]) for axis in "xyz"): n for v, n in zip(found.records, found.normals.tolist())}
            assert tree.hash() == same.hash() and tree.info.need & svocl.Need.NORMAL
        assert normals[0, 0, 0] == [-32767, 0, 0] and normals[2, 1, 1] == [0, 0, 0]
        assert normals[1, 1, 1] == [-32767, 0, 0] and normals[3, 2, 2] == [0, 23170, 23170]
    with svocl.Voxels(records) as voxels:
        assert voxels.normals is None
    with pytest.raises(ValueError, match="normals: 40000 is not in -32768"):
        svocl.Voxels(records, normals=[[40000, 0, 0]] * 3)


def test_a_budget_that_is_too_small(random):
    with svocl.Edit(max_bytes=1 << 21, undo_count=1) as edit:
        with pytest.raises(svocl.CapacityExceededError, match="max_bytes"):
            for _ in range(10000):
                center = random.uniform(-200, 200, 3)
                before = edit.info.voxel_count
                edit.apply(EditVerb.SET, Sphere(center, 9), color=(*random.integers(0, 256, 3), 255))
        assert edit.info.voxel_count == before and edit.info.peak_bytes <= 1 << 21


def test_progress_stops_a_step():
    told = []

    def stop_at_once(fraction):
        told.append(fraction)
        return len(told) > 3

    with svocl.Edit(progress=stop_at_once) as edit:
        with pytest.raises(svocl.CanceledError):
            edit.apply(EditVerb.SET, Sphere((0, 0, 0), 200))
        assert edit.info.voxel_count == 0 and told == sorted(told) and told[0] == 0
