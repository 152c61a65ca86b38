# SPDX-License-Identifier: MIT
"""A folder of parts as a tree, of any number of nodes, without stitching."""

import os
from typing import Any

from . import _arrays, _generated, _structs
from ._callbacks import call
from ._errors import error, text
from ._handle import Guard, Handle, Native
from ._mesh import Path, encode, need_io, to_path
from ._native import ffi, lib
from ._tree import Tree


class PartsTree(Handle):
    """A folder whose parts are all built, as a tree: it may have more nodes than a .svo file, and nothing is stitched.
    Parts are read where they lie, and an array's checksum is compared before its first byte is used.

    A region is what lies under one node, down to a level: a tree of its own, whose grid is the node. Regions that
    leave out anything have nodes and payload alone.

    Args:
        folder: of Parts.create, or the path of the file "plan" in it.

    Raises:
        FileError: the folder cannot be read, or a part is missing.
        FileDamagedError: the plan or a part is damaged, or of another plan.
        UnavailableError: the folder was planned anew meanwhile.
    """

    def __init__(self, folder: Path) -> None:
        need_io("PartsTree")
        self.folder: str = os.fsdecode(folder)
        out = ffi.new("svo_parts_tree **")
        message = ffi.new("svo_message *")
        arguments = (encode(folder), out, message)
        status = call(lib.svo_parts_tree_open, *arguments, undo=lambda: lib.svo_parts_tree_close(out))
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        self._open(Native(out[0], _close, Guard(), None))

    @property
    def info(self) -> _generated.PartsTreeInfo:
        """What the tree holds."""
        struct = _structs.new("svo_parts_tree_info")
        self._ask(lib.svo_parts_tree_get_info, struct)
        return _structs.read_parts_tree_info(struct)

    def hash(self, *, nodes_only: bool = False) -> str:
        """32 hexadecimal digits, those of the stitched tree; every part is read once.

        Args:
            nodes_only: leave leaf lists and payload out.
        """
        digits = ffi.new("char[]", lib.SVO_HASH_TEXT_BYTES)
        self._ask(lib.svo_parts_tree_hash, lib.SVO_HASH_NODES if nodes_only else lib.SVO_HASH_ALL, digits)
        return text(digits)

    def check(self, count: int = 0, seed: int = 0) -> int:
        """Reads every byte of parts that are spread evenly over the tree.

        Args:
            count: of parts; 0: all.
            seed: which ones.

        Returns:
            How many were checked.
        """
        out = ffi.new("uint64_t *")
        self._ask(lib.svo_parts_tree_check, _arrays.integer("count", count, 64), _arrays.integer("seed", seed, 64), out)
        return int(out[0])

    def load(self, level: int = 0, code: int = 0, *, levels: int = 0) -> Tree:
        """Loads a region into host memory.

        Args:
            level: of the node that is the region's root; 0: the whole grid.
            code: the node's Morton code.
            levels: down to this level of the whole tree; 0: the deepest.

        Raises:
            CapacityExceededError: more than 2^32 - 2 nodes or list entries.
            InvalidArgumentError: no node is there.
        """
        out = ffi.new("svo_tree **")
        self._ask(lib.svo_parts_tree_load, _region(level, code, levels), out, undo=lambda: lib.svo_tree_destroy(out))
        return Tree(out[0], None, None)

    def save(self, path: Path, level: int = 0, code: int = 0, *, levels: int = 0) -> _generated.TreeInfo:
        """Writes a region as a .svo file, in blocks, so that memory does not grow with it. Of the whole tree it is the
        file of Parts.finish.

        Args:
            path: of the file, which appears whole or not at all.
            level, code, levels: see load.

        Returns:
            What the file holds.
        """
        sink, _kept = to_path(path)
        info = _structs.new("svo_tree_info")
        self._ask(lib.svo_parts_tree_save, _region(level, code, levels), sink, info)
        return _structs.read_tree_info(info)

    def _ask(self, function: Any, *arguments: Any, undo: Any = None) -> None:
        """Calls function(pointer, *arguments, message); raises the status."""
        message = ffi.new("svo_message *")
        with self._use() as pointer:
            status = call(function, pointer, *arguments, message, undo=undo)
        if status != lib.SVO_OK:
            raise error(status, text(message.text))

    def __repr__(self) -> str:
        if self.closed:
            return "<svocl.PartsTree: closed>"
        info = self.info
        return f"<svocl.PartsTree: depth {info.tree.depth}, {info.node_count} nodes in {info.part_count} parts>"


def _region(level: int, code: int, levels: int) -> Any:
    region = _structs.new("svo_parts_region")
    region.level = _arrays.integer("level", level)
    region.code = _arrays.integer("code", code, 64)
    region.last_level = _arrays.integer("levels", levels)
    return region


def _close(pointer: Any) -> None:
    lib.svo_parts_tree_close(ffi.new("svo_parts_tree **", pointer))
