/* SPDX-License-Identifier: MIT */
/*
 * SVO_FORM_IMPLIED: the child masks of all nodes above level depth, breadth-first, and the directory of first children.
 * A scan (kernels/stages/scan.cl) of the numbers of children gives where the children of each inner node are; another
 * one, of the masks, gives the directory.
 *
 * Launch: one work-item per element, rounded up to whole groups. No atomics, no local memory.
 */
#include "shared/layout.h"

/* How many bits each mask has. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_implied_counts(__global const uchar *masks, __global uint *counts, svo_compact_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item < params.node_count) {
        counts[item] = popcount((uint)masks[item]);
    }
}

/* The masks of a node's inner children; those of leaves are 0 before. sums: of the children of the inner nodes. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_implied_masks(__global const uchar *valid, __global const uchar *leaf, __global const uint *first_inner,
                    __global const uint *sums, __global uchar *masks, svo_compact_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node >= params.node_count) {
        return;
    }
    uint inner = first_inner[node];
    uint child = 1u + sums[node];
    for (uint left = valid[node]; left != 0u; left &= left - 1u) {
        if ((leaf[node] & left & -left) == 0u) {
            masks[child] = valid[inner];
            ++inner;
        }
        ++child;
    }
    if (node == 0u) {
        masks[0] = valid[0];
    }
}

/* One entry of the directory per work-item. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_implied_directory(__global const uint *sums, __global uint *directory, uint step_log2, uint count)
{
    const uint entry = (uint)get_global_id(0);
    if (entry < count) {
        directory[entry] = 1u + sums[entry << step_log2];
    }
}

/* Where the payload of each inner node's children goes. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_implied_targets(__global const uint *sums, __global uint *targets, svo_compact_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node < params.node_count) {
        targets[node] = 1u + sums[node] - params.child_begin;
    }
}
