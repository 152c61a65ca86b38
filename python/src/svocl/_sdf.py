# SPDX-License-Identifier: MIT
"""Signed distance fields: how far voxels are from a mesh, negative inside."""

from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _generated, _opencl, _structs
from ._callbacks import call
from ._compact import _on
from ._errors import error
from ._generated import SolidRule
from ._native import ffi, lib
from ._tree import Tree


class Sdf(NamedTuple):
    """A signed distance field on the host."""

    distances: npt.NDArray[np.float32]
    """Dense: (n, n, n), indexed x, y, z. Of a band (count,): of its voxels. World units, negative inside."""
    voxels: Optional[npt.NDArray[np.uint16]]
    """Of a band (count, 3): x, y, z, in Morton order. Dense: None."""
    first: npt.NDArray[np.float64]
    """(3,): center of voxel 0, 0, 0, world coordinates. That of others is first + spacing * voxel."""
    spacing: float
    """Width of a voxel, world units."""
    info: _generated.SdfInfo
    """What the field consists of."""


def sdf(
    tree: Tree,
    band: float = 3.0,
    *,
    sign: bool = True,
    rule: SolidRule = SolidRule.WINDING,
    queue: Any = None,
) -> Sdf:
    """Finds how far the centers of voxels are from the mesh of a tree, within an ulp.

    The field has the voxels of the tree's grid. A fitted grid ends at the mesh; give Device.build a grid with room
    for the band.

    Args:
        tree: on a device, with Need.RAYS, coverage half-open or closed, and the whole mesh in its grid.
        band: only voxels whose distance is less than so many voxels' widths; 0: all voxels.
        sign: whether distances of voxels inside are negative.
        rule: which sums of crossings mean inside.
        queue: a pyopencl.CommandQueue on the device's context, or its int_ptr; None: the device's own.

    Raises:
        InvalidArgumentError: the tree has no leaf lists or leaves, is thin, on no device, or not of the whole mesh; or
            band is out of its range.
        UnsupportedError: the device has no doubles, or there are too many voxels.
        OutOfDeviceMemoryError, OutOfHostMemoryError, CompileError, CLError
    """
    options = _structs.new("svo_sdf_options")
    options.band = float(band)
    options.is_unsigned = 0 if sign else 1
    options.rule = SolidRule(rule)
    cl_queue = _opencl.pointer("cl_command_queue", queue, "queue")
    out = ffi.new("svo_sdf **")
    with _on("sdf", tree, None) as (native, pointer):
        try:
            status = call(lib.svo_sdf_create, pointer, options, cl_queue, out, undo=lambda: lib.svo_sdf_destroy(out))
            if status == lib.SVO_OK:
                status = call(lib.svo_sdf_download, out[0], cl_queue)
            if status != lib.SVO_OK:
                raise error(status, native.device_message())
            return _copy(out[0])
        finally:
            lib.svo_sdf_destroy(out)


def _copy(pointer: Any) -> Sdf:
    struct = _structs.new("svo_sdf_info")
    arrays = _structs.new("svo_sdf_arrays")
    lib.svo_sdf_get_info(pointer, struct)
    lib.svo_sdf_get_arrays(pointer, arrays)
    info = _structs.read(struct, _generated.SdfInfo)
    count = info.voxel_count
    distances: npt.NDArray[np.float32] = np.empty(count, np.float32)
    if count > 0:
        ffi.memmove(distances, arrays.distances, distances.nbytes)
    voxels = None
    if info.band > 0:
        codes = np.empty(count, np.uint64)
        if count > 0:
            ffi.memmove(codes, arrays.codes, codes.nbytes)
        voxels = np.stack([_gather_bits(codes >> np.uint64(axis)) for axis in range(3)], axis=-1)
    else:
        distances = distances.reshape((1 << info.depth,) * 3).transpose()
    return Sdf(distances, voxels, np.array(info.first), info.spacing, info)


def _gather_bits(codes: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint16]:
    """Bit 3 k of Morton codes becomes bit k."""
    bits = codes & np.uint64(0x1249249249249249)
    for shift, mask in ((2, 0x10C30C30C30C30C3), (4, 0x100F00F00F00F00F), (8, 0x001F0000FF0000FF), (16, 0xFFFF)):
        bits = (bits | bits >> np.uint64(shift)) & np.uint64(mask)
    return bits.astype(np.uint16)
