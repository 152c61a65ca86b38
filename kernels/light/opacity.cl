/* SPDX-License-Identifier: MIT */
/*
 * One opacity for each node, without direction.
 *
 *   svo_k_light_place    per inner node of a level, top-down: the Morton codes of its children
 *   svo_k_light_leaves   per leaf: its opacity
 *   svo_k_light_voxels   per inner node of a level, from the deepest level upwards: the mean over its eight cells, of
 *                        which absent ones count as 0
 *
 * Launch: one work-item per node, rounded up to whole groups. No atomics, no local memory.
 */
#include "light/nodes.clh"
#include "light/opacity.clh"
#include "shared/place.clh"

#ifdef SVO_LIGHT_BRICKS

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_place(__global const uchar *child_mask, __global const uint *first_child, __global ulong *codes,
                  svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    svo_place_children(child_mask, first_child, params.first + item, params.leaf_begin, codes);
}

#endif

#if defined(SVO_LIGHT_BRICKS) || defined(SVO_LIGHT_VOXELS)

/* opacities: from the first leaf on if params.first is 0, else from the root on. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_leaves(__global const uchar *colors, __global const ushort *areas, __global ushort *opacities,
                   svo_light_step params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf < params.count) {
        opacities[params.first + leaf] = (ushort)svo_leaf_opacity_any(colors, areas, leaf, params);
    }
}

#endif

#ifdef SVO_LIGHT_VOXELS

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_voxels(__global const uchar *child_mask, __global const uint *first_child, __global const uint *origins,
                   __global ushort *opacities, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    const uint node = params.first + item;
    if (item >= params.count || svo_light_is_kept(origins, node)) {
        return;
    }
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)child_mask[node]);
    uint sum = 4u;
    for (uint child = begin; child < end; ++child) {
        sum += opacities[child];
    }
    opacities[node] = (ushort)(sum / 8u);
}

#endif
