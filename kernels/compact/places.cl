/* SPDX-License-Identifier: MIT */
/*
 * SVO_FORM_DESCRIPTOR, second stage: where the word of each inner node is, and where the group of its inner children
 * begins. Top-down, one level a launch; the host sets those of the root.
 *
 * Launch: one work-item per inner node of the level, rounded up to whole groups. Reads the nodes, sizes, far, and
 * groups of the level; writes places and groups of the level below. No atomics, no local memory.
 */
#include "compact/group.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_compact_places(__global const uchar *valid, __global const uchar *leaf, __global const uint *first_inner,
                     __global const uint *sizes, __global const uchar *far, __global uint *places,
                     __global uint *groups, svo_compact_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    const uint node = params.first_node + item;
    const svo_siblings siblings = svo_find_siblings(valid, leaf, first_inner, node);
    const uint first_word = groups[node];
    uint begin = first_word + siblings.count + popcount((uint)far[node]);
    for (uint rank = 0; rank < siblings.count; ++rank) {
        const uint member = siblings.first + rank;
        places[member] = first_word + rank;
        groups[member] = begin;
        begin += sizes[member];
    }
}
