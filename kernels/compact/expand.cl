/* SPDX-License-Identifier: MIT */
/*
 * From a compact tree back to a built one, top-down, one level at a time. Each node of a level has a reference, what
 * stands for it in the form (read.clh), and the place of its payload. The nodes inside a leaf have none of their own:
 * they are full, and have the leaf's place.
 *
 * Launch: one work-item per node of the level, rounded up to whole groups. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/read.clh"

/* A node and how it was reached. */
typedef struct svo_expanded {
    svo_cast_node node;
    uint place; /* of its payload */
    uint inside; /* not 0: inside a leaf, or one */
} svo_expanded;

/* The nodes' masks, and how many children each has. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_expand_masks(SVO_NODES_PARAMETERS, __global svo_expanded *level, __global uchar *child_mask,
                   __global uint *counts, svo_compact_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    SVO_NODES_MAKE(nodes);
    const uint node = params.first_node + item;
    uint mask = level[item].inside != 0u ? 255u : svo_cast_mask(&nodes, level[item].node);
    if (mask == 0u && node != 0u) {
        level[item].inside = 1u; /* SVO_CHILD_SELF */
        mask = 255u;
    }
    child_mask[node] = (uchar)mask;
    counts[item] = popcount(mask);
}

/* first_child, from the exclusive sums of the counts, and the nodes of the next level. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_expand_children(SVO_NODES_PARAMETERS, __global const svo_expanded *level, __global const uchar *child_mask,
                      __global const uint *sums, __global uint *first_child, __global svo_expanded *below,
                      svo_compact_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    SVO_NODES_MAKE(nodes);
    const svo_expanded own = level[item];
    const uint mask = child_mask[params.first_node + item];
    uint child = sums[item];
    first_child[params.first_node + item] = params.child_begin + child;
    for (uint octant = 0; params.keep_below != 0u && octant < 8u; ++octant) {
        if ((mask >> octant & 1u) != 0u) {
            svo_expanded next = own;
            if (own.inside == 0u) {
                next.inside = svo_cast_open(&nodes, own.node, octant, &next.node) == SVO_CHILD_LEAF ? 1u : 0u;
                next.place = svo_cast_place(&nodes, own.node, octant);
            }
            below[child] = next;
            ++child;
        }
    }
}

/* Copies one payload array of a level; from and to in units of two bytes, to from the level's first payload on. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_expand_payload(__global const svo_expanded *level, __global const ushort *from, __global ushort *to,
                     svo_compact_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    const size_t source = (size_t)level[item].place * params.element_halves;
    const size_t target = (size_t)(params.payload_begin + item) * params.element_halves;
    for (uint k = 0; k < params.element_halves; ++k) {
        to[target + k] = from[source + k];
    }
}
