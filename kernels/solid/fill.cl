/* SPDX-License-Identifier: MIT */
/*
 * Which empty children of inner nodes are inside. No surface passes through an empty cell, so the center of one of its
 * voxels decides for all: its middle one, or the one after the middle. Along each of the three columns through that
 * voxel, the next crossed leaf in direction +axis has its winding number, 0 without one; two of three decide. Where
 * they differ, the surface is open or torn, and the cell is counted as ambiguous.
 *
 * Launch: one work-item per inner node of a level, rounded up to whole groups. Reads the tree, codes, carries,
 * crossings and windings; writes inside_mask, bit o for the child in octant o. No local memory. Atomics: sums of
 * counts, which do not depend on their order.
 */
#include "shared/nodes.clh"
#include "solid/column.clh"

/* For how many of the axes the voxel is inside. */
static uint svo_inside_votes(const svo_solid_tree *tree, __global const uint *windings, const uint *voxel, uint parity)
{
    uint votes = 0;
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint leaf = svo_next_crossed(tree, voxel, axis);
        const uint winding = leaf != SVO_SOLID_NO_LEAF ? windings[axis * (size_t)tree->leaf_count + leaf] : 0u;
        votes += parity != 0u ? winding & 1u : (uint)(winding != 0u);
    }
    return votes;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_fill(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                 __global const uchar *carries, __global const uint *crossings, __global const uint *windings,
                 __global uchar *inside_mask, volatile __global uint *counters, svo_solid_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const svo_solid_tree tree = {child_mask,   first_child,       carries,          crossings,
                                 params.depth, params.leaf_begin, params.leaf_count};
    const uint node = params.first + item;
    const uint mask = child_mask[node];
    const uint child_log2 = params.depth - params.level - 1u; /* width of the children in voxels */
    const uint middle = 1u << child_log2 >> 1;
    uint inside = 0;
    uint ambiguous = 0;
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((mask >> octant & 1u) != 0u) {
            continue;
        }
        uint voxel[3];
        svo_deinterleave(codes[node] << 3 | octant, voxel);
        for (uint axis = 0; axis < 3u; ++axis) {
            voxel[axis] = (voxel[axis] << child_log2) + middle;
        }
        const uint votes = svo_inside_votes(&tree, windings, voxel, params.parity);
        inside |= (uint)(votes >= 2u) << octant;
        ambiguous += (uint)(votes == 1u || votes == 2u);
    }
    inside_mask[node] = (uchar)inside;
    if (inside != 0u) {
        atomic_add(counters + SVO_SOLID_INSIDE, popcount(inside));
    }
    if (ambiguous != 0u) {
        atomic_add(counters + SVO_SOLID_AMBIGUOUS, ambiguous);
    }
    if (mask != 255u) {
        atomic_add(counters + SVO_SOLID_TESTS, 8u - popcount(mask));
    }
}
