/* SPDX-License-Identifier: MIT */
/*
 * Where the levels of what remains of a minimized tree begin, so that the host reads all of them at once.
 *
 * Launch: one work-item per level and one for their end, rounded up to whole groups. No atomics, no local memory.
 */
#include "shared/layout.h"

/* level_begin: the first inner node of each level before minimizing, and their number. inner_sums, child_sums:
   exclusive sums over these nodes, with the totals. levels: of each level its two sums. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_minimize_levels(__global const uint *level_begin, __global const uint *inner_sums,
                      __global const uint *child_sums, __global uint2 *levels, svo_compact_params params)
{
    const uint level = (uint)get_global_id(0);
    if (level >= params.node_count) {
        return;
    }
    const uint node = level_begin[level];
    levels[level] = (uint2)(inner_sums[node], child_sums[node]);
}
