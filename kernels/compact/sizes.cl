/* SPDX-License-Identifier: MIT */
/*
 * SVO_FORM_DESCRIPTOR, first stage: how many words the descendants of each inner node take, and which of its inner
 * children need a far word. Bottom-up, one level a launch.
 *
 * Launch: one work-item per inner node of the level, rounded up to whole groups. Reads valid, leaf, first_inner, and
 * sizes of the level below; writes sizes and far of the level. No atomics, no local memory.
 */
#include "compact/group.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_compact_sizes(__global const uchar *valid, __global const uchar *leaf, __global const uint *first_inner,
                    __global uint *sizes, __global uchar *far, svo_compact_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    const uint node = params.first_node + item;
    const svo_siblings group = svo_find_siblings(valid, leaf, first_inner, node);
    const uint flags = svo_find_far(group, sizes);
    uint size = group.count + popcount(flags);
    for (uint rank = 0; rank < group.count; ++rank) {
        size += sizes[group.first + rank];
    }
    sizes[node] = size;
    far[node] = (uchar)flags;
}
