/* SPDX-License-Identifier: MIT */
/*
 * Winding numbers in front of the crossed leaves, along each axis: the sum of a leaf and of all behind it in its
 * column. Sums wrap around. There are fewer than 2^32 triangles, so one is 0 or odd exactly if the true sum is.
 *
 * Launch: one work-item per leaf, rounded up to whole groups. svo_k_solid_chain finds the next crossed leaf along each
 * axis, and sets that leaf's bit of the axis in follows: it is not the first of its column. svo_k_solid_sum follows
 * each chain from its first leaf, twice: for the sum of the column, and to give each leaf what is left of it there. So
 * its work is linear in the leaves. It counts the columns whose sum is not 0: there the surface is open or torn. Leaves
 * that are not crossed have entries without meaning. No local memory. Atomics: bits that are set, and counts, neither
 * of which depend on their order.
 */
#include "shared/nodes.clh"
#include "solid/column.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_chain(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                  __global const uchar *carries, __global const uint *crossings, __global uint *next_leaf,
                  volatile __global uint *follows, svo_solid_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.count) {
        return;
    }
    const svo_solid_tree tree = {child_mask,   first_child,       carries,          crossings,
                                 params.depth, params.leaf_begin, params.leaf_count};
    uint voxel[3];
    svo_column_walk start;
    svo_deinterleave(codes[params.leaf_begin + leaf], voxel);
    svo_walk_begin(&tree, voxel, 0u, &start);
    for (uint axis = 0; axis < 3u; ++axis) {
        const size_t row = axis * (size_t)params.leaf_count;
        if (crossings[row + leaf] != 0u) {
            svo_column_walk walk = start;
            const uint next = svo_walk_on(&tree, axis, &walk);
            next_leaf[row + leaf] = next;
            if (next != SVO_SOLID_NO_LEAF) {
                atomic_or(follows + next, 1u << axis);
            }
        }
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_sum(__global const uint *crossings, __global const uint *next_leaf, __global const uint *follows,
                __global uint *windings, volatile __global uint *counters, svo_solid_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.count) {
        return;
    }
    for (uint axis = 0; axis < 3u; ++axis) {
        const size_t row = axis * (size_t)params.leaf_count;
        if (crossings[row + leaf] == 0u || (follows[leaf] >> axis & 1u) != 0u) {
            continue;
        }
        uint rest = 0;
        for (uint at = leaf; at != SVO_SOLID_NO_LEAF; at = next_leaf[row + at]) {
            rest += crossings[row + at];
        }
        if (rest != 0u) {
            atomic_inc(counters + SVO_SOLID_OPEN_X + axis);
        }
        for (uint at = leaf; at != SVO_SOLID_NO_LEAF; at = next_leaf[row + at]) {
            windings[row + at] = rest;
            rest -= crossings[row + at];
        }
    }
}
