# SPDX-License-Identifier: MIT
"""Trees as grids of pyvista, which is imported when one is made."""

from typing import Any, Optional

import numpy as np

from ._errors import optional

_VTK_VOXEL = 11


def to_pyvista(tree: Any, level: Optional[int]) -> Any:
    """See Tree.to_pyvista."""
    pyvista = optional("pyvista", "Tree.to_pyvista", "pyvista")
    info, arrays = tree.info, tree.arrays
    last = info.depth if level is None else level
    voxels = tree.voxels(last).astype(np.int64)
    octants = np.arange(8)
    corners = voxels[:, None] + np.stack([octants & 1, octants >> 1 & 1, octants >> 2 & 1], axis=1)  # VTK's order too
    side = 2**last + 1
    keys = (corners[..., 2] * side + corners[..., 1]) * side + corners[..., 0]
    used, places = np.unique(keys, return_inverse=True)
    points = np.stack([used % side, used // side % side, used // side**2], axis=1)
    cells = np.concatenate([np.full((len(voxels), 1), 8), places.reshape(-1, 8)], axis=1)
    world = points * (info.edge / 2**last) + np.array(info.origin)
    grid = pyvista.UnstructuredGrid(cells.reshape(-1), np.full(len(voxels), _VTK_VOXEL, np.uint8), world)
    first = info.level_begin[info.payload_level]
    rows = slice(info.level_begin[last] - first, info.level_begin[last + 1] - first)
    if rows.start >= 0:
        if arrays.colors is not None:
            grid.cell_data["rgba"] = arrays.colors[rows]
        if arrays.normals is not None:
            grid.cell_data["normal"] = arrays.normals[rows] / np.float32(32767)
        if arrays.materials is not None:
            grid.cell_data["material"] = arrays.materials[rows]
    return grid
