/* SPDX-License-Identifier: MIT */
/*
 * The masks of a solid: its children are those of the built tree and the empty ones that are inside; of them, the
 * latter and those of level depth are leaves.
 *
 * Launch: one work-item per inner node, rounded up to whole groups. Reads child_mask and inside_mask; writes valid,
 * leaf and counts: 1 for the root, then the number of children of each node, whose sums are the places of the
 * children. No atomics, no local memory.
 */
#include "shared/solid_layout.h"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_masks(__global const uchar *child_mask, __global const uchar *inside_mask, __global uchar *valid,
                  __global uchar *leaf, __global uint *counts, svo_solid_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node >= params.count) {
        return;
    }
    const uint surface = child_mask[node];
    const uint inside = inside_mask[node];
    valid[node] = (uchar)(surface | inside);
    leaf[node] = (uchar)(inside | (node >= params.first ? surface : 0u));
    counts[node + 1u] = popcount(surface | inside);
    if (node == 0u) {
        counts[0] = 1u;
    }
}
