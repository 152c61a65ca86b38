/* SPDX-License-Identifier: MIT */
/*
 * Morton codes of the nodes, top-down: codes[i] has three bits for each level above node i.
 *
 * Launch: one work-item per inner node of a level, rounded up to whole groups; levels in order. Reads the tree and the
 * codes of the level, writes those of the next. No atomics, no local memory.
 */
#include "shared/place.clh"
#include "shared/solid_layout.h"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_place(__global const uchar *child_mask, __global const uint *first_child, __global ulong *codes,
                  svo_solid_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    svo_place_children(child_mask, first_child, params.first + item, SVO_ALL_NODES, codes);
}
