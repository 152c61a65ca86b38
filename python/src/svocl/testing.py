# SPDX-License-Identifier: MIT
"""For tests of programs that make trees: comparison with the first difference in words.

    from svocl.testing import assert_trees_equal

    def test_part(svocl_device):                        # pytest_plugins = ["svocl.pytest_plugin"] in conftest.py
        with svocl_device.build(svocl.read_mesh("part.obj"), 7) as tree:
            assert_trees_equal("golden/part.svo", tree)
"""

import contextlib
import os
from collections.abc import Iterator
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from ._generated import Need, TreeInfo
from ._mesh import Path
from ._tree import Tree, TreeArrays

__all__ = ["assert_trees_equal", "describe_difference"]

_FIELDS = ("colors", "normals", "materials", "fills", "areas")


class _Side(NamedTuple):
    tree: Tree
    info: TreeInfo
    arrays: TreeArrays


def assert_trees_equal(a: Union[Tree, Path], b: Union[Tree, Path]) -> None:
    """Fails unless two trees have one hash: grid, nodes, payload and leaf lists.

    Args:
        a, b: trees, or paths of .svo files.

    Raises:
        AssertionError: they differ; the message is that of describe_difference.
    """
    difference = describe_difference(a, b)
    if difference is not None:
        raise AssertionError(difference)


def describe_difference(a: Union[Tree, Path], b: Union[Tree, Path]) -> Optional[str]:
    """Where two trees differ, in lines: what describes them, counts of voxels and of values, and the first voxel in
    Morton order that differs; where voxels are equal, the first node above them.

    Args:
        a, b: trees, or paths of .svo files.

    Returns:
        None where the hashes are equal.
    """
    with contextlib.ExitStack() as opened:
        trees = [one if isinstance(one, Tree) else opened.enter_context(Tree.load(one)) for one in (a, b)]
        names = [one if isinstance(one, (str, os.PathLike)) else repr(one) for one in (a, b)]
        hashes = [tree.hash() for tree in trees]
        if hashes[0] == hashes[1]:
            return None
        sides = [_Side(tree, tree.info, tree.arrays) for tree in trees]
        head = f"trees differ: A {names[0]} is {hashes[0]}, B {names[1]} is {hashes[1]}"
        return "\n".join([head, *_options(*sides), *_voxels(*sides)])


def _rounding(info: TreeInfo) -> int:
    return 0 if info.is_exact else info.snap_bits


def _options(a: _Side, b: _Side) -> Iterator[str]:
    rows: list[tuple[str, Any, Any]] = [
        (name, getattr(a.info, name), getattr(b.info, name))
        for name in ("depth", "coverage", "origin", "edge", "need", "payload_level", "leaf_count", "node_count")
    ]
    rows.append(("rounding", _rounding(a.info), _rounding(b.info)))
    return (f"{name}: {of_a} in A, {of_b} in B" for name, of_a, of_b in rows if repr(of_a) != repr(of_b))


def _codes(side: _Side, level: int) -> npt.NDArray[np.uint64]:
    """Morton codes of a level's nodes, which ascend."""
    cells = side.tree.voxels(level).astype(np.uint64)
    codes = np.zeros(len(cells), np.uint64)
    for bit in range(level):
        for axis in range(3):
            codes |= (cells[:, axis] >> np.uint64(bit) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return codes


def _rows(side: _Side, name: str, level: int) -> Optional[npt.NDArray[Any]]:
    """A payload array from the level's first node on; None where these nodes have none."""
    array: Optional[npt.NDArray[Any]] = getattr(side.arrays, name)
    first = side.info.depth if name == "areas" else side.info.payload_level
    if array is None or level < first:
        return None
    return array[side.info.level_begin[level] - side.info.level_begin[first] :].reshape(-1, *array.shape[1:])


def _changed(a: _Side, b: _Side, level: int, at: tuple[Any, Any]) -> Iterator[tuple[str, npt.NDArray[np.bool_]]]:
    """Of the nodes of both trees, at those places of the level: which differ, by field."""
    for name in _FIELDS:
        of_a, of_b = _rows(a, name, level), _rows(b, name, level)
        if of_a is not None and of_b is not None:
            differ = of_a[at[0]] != of_b[at[1]]
            yield name, differ.reshape(len(at[0]), -1).any(axis=1)
    if level == a.info.depth == b.info.depth and (a.info.need & b.info.need & Need.RAYS):
        pairs = zip(at[0].tolist(), at[1].tolist())
        yield "list", np.array([not np.array_equal(_list(a, i), _list(b, k)) for i, k in pairs], bool)


def _list(side: _Side, leaf: int) -> npt.NDArray[np.uint32]:
    begin, entries = side.arrays.list_begin, side.arrays.list
    assert begin is not None and entries is not None
    return entries[begin[leaf] : begin[leaf + 1]]


def _value(side: _Side, name: str, level: int, place: int) -> Any:
    if name == "list":
        return _list(side, place).tolist()
    rows = _rows(side, name, level)
    return None if rows is None else rows[place].tolist()


def _place(side: _Side, level: int, place: int) -> str:
    x, y, z = side.tree.voxels(level)[place].tolist()
    return f"{x}, {y}, {z} of level {level} at {side.tree.centers(level)[place].tolist()}"


def _voxels(a: _Side, b: _Side) -> Iterator[str]:
    """Compares the voxels of the last level that both trees have, and where these are equal the nodes above them."""
    last = min(a.info.depth, b.info.depth)
    for level in range(last, -1, -1):
        what = "voxel" if level == last else "node above the voxels"
        codes = [_codes(side, level) for side in (a, b)]
        both, *at = np.intersect1d(codes[0], codes[1], assume_unique=True, return_indices=True)
        only = [np.setdiff1d(codes[i], codes[1 - i], assume_unique=True) for i in (0, 1)]
        changed = dict(_changed(a, b, level, (at[0], at[1])))
        any_field = np.logical_or.reduce(list(changed.values())) if changed else np.zeros(len(both), bool)
        if not (len(only[0]) or len(only[1]) or any_field.any()):
            continue
        yield f"{what}s of level {level}: {len(only[0])} only in A, {len(only[1])} only in B, {len(both)} in both"
        for name, differ in changed.items():
            if differ.any():
                yield f"{name}: {differ.sum()} {what}s differ{_largest(a, b, level, name, at, differ)}"
        firsts = [codes_of[0] if len(codes_of) else None for codes_of in (*only, both[any_field])]
        which, code = min(((i, int(c)) for i, c in enumerate(firsts) if c is not None), key=lambda pair: pair[1])
        side = b if which == 1 else a
        place = int(np.searchsorted(codes[1 if which == 1 else 0], np.uint64(code)))
        yield f"first: {what} {_place(side, level, place)}, " + (
            _values(a, b, level, place, int(np.searchsorted(codes[1], np.uint64(code))), changed)
            if which == 2
            else f"only in {'AB'[which]}"
        )
        return


def _largest(a: _Side, b: _Side, level: int, name: str, at: Any, differ: npt.NDArray[np.bool_]) -> str:
    of_a, of_b = (None, None) if name in ("list", "materials") else (_rows(a, name, level), _rows(b, name, level))
    if of_a is None or of_b is None:
        return ""
    most = np.abs(of_a[at[0][differ]].astype(np.int64) - of_b[at[1][differ]].astype(np.int64)).max()
    return f", by at most {most}"


def _values(a: _Side, b: _Side, level: int, place_a: int, place_b: int, names: Any) -> str:
    values = [(name, _value(a, name, level, place_a), _value(b, name, level, place_b)) for name in names]
    return ", ".join(f"{name} {of_a} in A, {of_b} in B" for name, of_a, of_b in values if of_a != of_b)
