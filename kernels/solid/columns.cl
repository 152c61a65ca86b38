/* SPDX-License-Identifier: MIT */
/*
 * Counts the columns of voxels whose crossings do not cancel: there the surface is open or torn. A column belongs to its
 * last leaf with a sum other than 0, so each is counted once.
 *
 * Launch: one work-item per leaf, rounded up to whole groups. Reads the tree, codes, crossings and carries; adds to a
 * counter for each axis. No local memory. Atomics: sums of counts, which do not depend on their order.
 */
#include "shared/layout.h"

#include "solid/column.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_columns(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                    __global const uchar *carries, __global const uint *crossings, volatile __global uint *counters,
                    svo_solid_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.count) {
        return;
    }
    const svo_solid_tree tree = {child_mask,   first_child,       carries,          crossings,
                                 params.depth, params.leaf_begin, params.leaf_count};
    uint voxel[3];
    svo_deinterleave(codes[params.leaf_begin + leaf], voxel);
    for (uint axis = 0; axis < 3u; ++axis) {
        const bool crossed = crossings[axis * (size_t)params.leaf_count + leaf] != 0u;
        if (crossed && svo_column_sum(&tree, voxel, axis, voxel[axis] + 1u, 1u) == 0u &&
            svo_column_sum(&tree, voxel, axis, 0u, 0u) != 0u) {
            atomic_inc(counters + SVO_SOLID_OPEN_X + axis);
        }
    }
}
