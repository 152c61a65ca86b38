/* SPDX-License-Identifier: MIT */
/*
 * What walks along columns may pass by: carries[i] has a bit for each axis along which a column is crossed below inner
 * node i, bottom-up.
 *
 * Launch: one work-item per inner node of a level, rounded up to whole groups; levels in reverse order. Reads the tree,
 * the leaves' crossings or the bits of the next level; writes those of the level. No atomics, no local memory.
 */
#include "shared/solid_layout.h"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_carry(__global const uchar *child_mask, __global const uint *first_child, __global const uint *crossings,
                  __global uchar *carries, svo_solid_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)child_mask[node]);
    uint bits = 0;
    for (uint child = begin; child < end; ++child) {
        if (child < params.leaf_begin) {
            bits |= carries[child];
            continue;
        }
        for (uint axis = 0; axis < 3u; ++axis) {
            bits |= (uint)(crossings[axis * (size_t)params.leaf_count + child - params.leaf_begin] != 0u) << axis;
        }
    }
    carries[node] = (uchar)bits;
}
