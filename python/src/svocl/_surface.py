# SPDX-License-Identifier: MIT
"""Closed meshes out of signed distance fields."""

from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _generated, _structs
from ._callbacks import call
from ._errors import error, text
from ._native import ffi, lib
from ._sdf import Sdf
from ._tree import Tree


class Surface(NamedTuple):
    """A closed triangle mesh: each edge belongs to two triangles, counterclockwise seen from outside."""

    vertices: npt.NDArray[np.float32]
    """(n, 3): world coordinates."""
    triangles: npt.NDArray[np.uint32]
    """(m, 3): indices into vertices."""
    normals: Optional[npt.NDArray[np.float32]]
    """(n, 3): unit normals; None: not asked for."""
    colors: Optional[npt.NDArray[np.uint8]]
    """(n, 4): RGBA; None: not asked for."""
    info: _generated.SurfaceInfo
    """What the surface consists of."""


def surface(
    field: Sdf,
    level: float = 0.0,
    *,
    normals: bool = True,
    colors: Optional[Tree] = None,
) -> Surface:
    """Finds where a field has a level, as a closed mesh.

    A band has to hold what is within level and 2.5 voxels of the mesh. Without signs only levels above 0 have an
    inside: what is nearer than that.

    Args:
        field: of svocl.sdf. A dense one may have other numbers, indexed x, y, z, of any shape, and no info.
        level: what is below it is inside; at 0, what has the sign bit.
        normals: whether vertices get the field's gradient.
        colors: a tree with Need.COLOR, whose nearest leaves give vertices their colors. It is downloaded if need be.

    Raises:
        InvalidArgumentError: the surface leaves the band, a number is not finite, or the tree has no colors or leaves.
        UnsupportedError: there are too many vertices or triangles.
        OutOfHostMemoryError
    """
    if not isinstance(field, Sdf):
        raise TypeError(f"field: {type(field).__name__}, expected svocl.Sdf")
    if colors is not None and not isinstance(colors, Tree):
        raise TypeError(f"colors: {type(colors).__name__}, expected svocl.Tree")
    options = _structs.new("svo_surface_options")
    options.level = float(level)
    options.parts = (lib.SVO_SURFACE_NORMALS if normals else 0) | (lib.SVO_SURFACE_COLORS if colors is not None else 0)
    given, kept = _describe(field)
    if colors is None:
        made = _make(given, options)
    else:
        with colors._downloaded(None) as pointer:
            options.tree = pointer
            made = _make(given, options)
    del kept
    return made


def _describe(field: Sdf) -> tuple[Any, list[Any]]:
    """The field as a struct, and the arrays that it points into."""
    struct = _structs.new("svo_surface_field")
    distances = np.asarray(field.distances, np.float32)
    kept: list[Any] = []
    if field.voxels is None:
        if distances.ndim != 3:
            raise ValueError(f"field.distances: {distances.ndim} dimensions, expected 3")
        struct.size = distances.shape
        distances = distances.ravel(order="F")
    else:
        voxels = np.asarray(field.voxels, np.uint64)
        if distances.ndim != 1 or voxels.shape != (len(distances), 3):
            raise ValueError(f"field.voxels: shape {voxels.shape}, expected ({distances.size}, 3)")
        struct.size = [1 << field.info.depth] * 3
        codes = np.zeros(len(voxels), np.uint64)
        for axis in range(3):
            codes |= _spread_bits(voxels[:, axis]) << np.uint64(axis)
        kept.append(codes)
        struct.codes = ffi.cast("uint64_t *", codes.ctypes.data)
    distances = np.ascontiguousarray(distances)
    kept.append(distances)
    struct.distances = ffi.cast("float *", distances.ctypes.data)
    struct.voxel_count = distances.size
    struct.first = [float(value) for value in field.first]
    struct.spacing = float(field.spacing)
    return struct, kept


def _make(field: Any, options: Any) -> Surface:
    out = ffi.new("svo_surface **")
    message = ffi.new("svo_message *")
    try:
        status = call(lib.svo_surface_create, field, options, out, message, undo=lambda: lib.svo_surface_destroy(out))
        if status != lib.SVO_OK:
            raise error(status, text(message.text))
        return _copy(out[0])
    finally:
        lib.svo_surface_destroy(out)


def _copy(pointer: Any) -> Surface:
    struct = _structs.new("svo_surface_info")
    lib.svo_surface_get_info(pointer, struct)
    mesh = lib.svo_surface_get_mesh(pointer)
    vertices, triangles = mesh.vertex_count, mesh.triangle_count
    return Surface(
        _array(mesh.positions, np.float32, (vertices, 3)),
        _array(mesh.indices, np.uint32, (triangles, 3)),
        _array(mesh.normals, np.float32, (vertices, 3)) if mesh.normals != ffi.NULL else None,
        _array(mesh.colors, np.uint8, (vertices, 4)) if mesh.colors != ffi.NULL else None,
        _structs.read(struct, _generated.SurfaceInfo),
    )


def _array(pointer: Any, kind: Any, shape: tuple[int, int]) -> npt.NDArray[Any]:
    copied: npt.NDArray[Any] = np.empty(shape, kind)
    if copied.size > 0:
        ffi.memmove(copied, pointer, copied.nbytes)
    return copied


def _spread_bits(numbers: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """Bit k of numbers below 2^16 becomes bit 3 k."""
    bits = numbers
    for shift, mask in ((16, 0x001F0000FF0000FF), (8, 0x100F00F00F00F00F), (4, 0x10C30C30C30C30C3)):
        bits = (bits | bits << np.uint64(shift)) & np.uint64(mask)
    return (bits | bits << np.uint64(2)) & np.uint64(0x1249249249249249)
