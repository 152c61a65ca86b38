# SPDX-License-Identifier: MIT
"""Paged trees: pictures of a file or of a folder of parts that is larger than the memory it may take."""

import os
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _arrays, _generated, _structs
from ._callbacks import call
from ._device import Device
from ._errors import error
from ._generated import View
from ._handle import Handle, Native
from ._mesh import Path, encode, need_io
from ._native import ffi, lib
from ._parts_tree import PartsTree
from ._tree import Camera, Tree, render_options


class Paged(Handle):
    """A .svo file of which so much is on a device as a budget allows. Where a part of the tree is absent, a coarser
    node stands in, so pictures have no holes. Paged.update reads what the last picture missed.

    Args:
        device: that draws.
        path: of a file that Tree.save wrote without compress, or of a folder whose parts are all built (PartsTree).
            Of that the levels are drawn that one tree can have, PartsTreeInfo.last_level.
        budget_bytes: for buffers on the device. Pictures come on top.
        page_levels: levels of a page, 2 .. 5; fewer follow the view more closely, and take more pages.
        update_bytes: an update that has read as many bytes reads no further page; 0: no limit.

    Raises:
        FileError: the file cannot be read.
        FileDamagedError: it is damaged.
        UnsupportedError: it is compressed, of an older version, or has payload not on all levels.
        CapacityExceededError: budget_bytes is too small; the message has the least number.
        OutOfDeviceMemoryError, OutOfHostMemoryError, CLError
    """

    def __init__(
        self, device: Device, path: Path, budget_bytes: int, *, page_levels: int = 3, update_bytes: int = 0
    ) -> None:
        need_io("Paged")
        self.path: str = os.fsdecode(path)
        options = _structs.new("svo_paged_options")
        options.page_levels = _arrays.integer("page_levels", page_levels)
        options.update_bytes = _arrays.integer("update_bytes", update_bytes, 64)
        budget = _arrays.integer("budget_bytes", budget_bytes, 64)
        out = ffi.new("svo_paged **")
        arguments = (encode(path), budget, options, out)
        with device._use() as pointer:
            status = call(lib.svo_paged_open, pointer, *arguments, undo=lambda: lib.svo_paged_close(out))
            if status != lib.SVO_OK:
                raise error(status, device._native.device_message())
            self._open(Native(out[0], _close, device._native.guard, device._native))

    @property
    def info(self) -> _generated.PagedInfo:
        """What was opened."""
        struct = _structs.new("svo_paged_info")
        self._call(lib.svo_paged_get_info, struct)
        return _structs.read(struct, _generated.PagedInfo)

    @property
    def counts(self) -> _generated.PagedCounts:
        """What the last picture, the last update and all of them did."""
        struct = _structs.new("svo_paged_counts")
        self._call(lib.svo_paged_get_counts, struct)
        return _structs.read(struct, _generated.PagedCounts)

    def frame(self, aspect: float = 1.0, camera: Optional[Camera] = None) -> Camera:
        """A camera that frames the occupied part of the tree, as Tree.frame, from its upper levels. Reads them from
        the file at the path.

        Args:
            aspect: width / height of the picture, above 0.
            camera: see Tree.frame.
        """
        with self._upper(min(self.info.depth, lib.SVO_FRAME_LEVEL_MAX)) as upper:
            return upper.frame(aspect, camera)

    def _upper(self, levels: int) -> Tree:
        if os.path.isdir(self.path) or os.path.basename(self.path) == "plan":
            with PartsTree(self.path) as parts:
                return parts.load(levels=levels)
        return Tree.load(self.path, levels=levels)

    def render(
        self, width: int, height: int, *, camera: Optional[Camera] = None, view: View = View.SHADED
    ) -> npt.NDArray[np.uint8]:
        """Draws a picture of what is there, and waits. If it misses nothing it is that of Tree.render.

        Args:
            width, height: pixels, 1 .. 16384.
            camera: None: Paged.frame.
            view: what to show: View.SHADED, NORMAL, DEPTH, STEPS or LEVEL.

        Returns:
            (height, width, 4) uint8: RGBA, top to bottom.
        """
        used = self.frame(width / max(height, 1)) if camera is None else camera
        options, picture = render_options(width, height, used, view)
        self._call(lib.svo_paged_render, options, ffi.from_buffer("uint8_t[]", picture))
        return picture

    def update(self) -> _generated.PagedCounts:
        """Reads the pages that the last picture missed, upper ones first, and drops those that were not used for
        longest as far as room is short.

        Returns:
            Paged.counts.

        Raises:
            FileError: the file cannot be read.
            FileDamagedError: its bytes have changed since it was opened. The update may be repeated.
        """
        self._call(lib.svo_paged_update)
        return self.counts

    def __repr__(self) -> str:
        if self.closed:
            return "<svocl.Paged: closed>"
        info, counts = self.info, self.counts
        return f"<svocl.Paged: depth {info.depth}, {counts.held_pages} of {info.page_count} pages of {self.path}>"


def _close(pointer: Any) -> None:
    lib.svo_paged_close(ffi.new("svo_paged **", pointer))
