/* SPDX-License-Identifier: MIT */
/*
 * Which empty children of inner nodes are inside. No surface passes through an empty cell, so the center of one of its
 * voxels decides for all: its middle one, or the one after the middle. Along each of the three columns through that
 * voxel, the next crossed leaf in direction +axis has its winding number, 0 without one; two of three decide. Where
 * they differ, the surface is open or torn, and the cell is counted as ambiguous.
 *
 * svo_k_solid_lines writes the winding numbers along +z alone, for what the host decides with them
 * (lib/solid/winding.c).
 *
 * Launch: one work-item per inner node of a level, rounded up to whole groups. Reads the tree, codes, carries,
 * crossings and windings; writes inside_mask, bit o for the child in octant o, or eight numbers, those of empty
 * children. No local memory. Atomics: sums of counts, which do not depend on their order.
 */
#include "shared/nodes.clh"
#include "solid/column.clh"

/* The empty octants of a node that the lines along an axis say are inside. Two that lie behind each other share a line.
   corner: the voxel of the child in octant 0 that decides. start: a walk in that child. */
static uint svo_inside_along(const svo_solid_tree *tree, __global const uint *windings, const svo_column_walk *start,
                             const uint *corner, uint axis, uint empty, uint rule)
{
    const uint step = 1u << axis;
    uint inside = 0;
    for (uint octant = 8u; octant-- > 0u;) {
        if ((empty >> octant & 1u) == 0u) {
            continue;
        }
        if ((octant & step) == 0u && (empty >> (octant | step) & 1u) != 0u) {
            inside |= (inside >> (octant | step) & 1u) << octant;
            continue;
        }
        svo_column_walk walk = *start;
        for (uint k = 0; k < 3u; ++k) {
            walk.at[k] = corner[k] + ((octant >> k & 1u) << walk.shift);
        }
        const uint leaf = svo_walk_on(tree, axis, &walk);
        const uint winding = leaf != SVO_SOLID_NO_LEAF ? windings[axis * (size_t)tree->leaf_count + leaf] : 0u;
        inside |= (svo_sum_is_inside(winding, rule) ? 1u : 0u) << octant;
    }
    return inside;
}

/* The voxel that decides for the child in octant 0 of a node, and a walk in that child. */
static void svo_begin_in_child(const svo_solid_tree *tree, ulong code, uint child_log2, uint *corner,
                               svo_column_walk *start)
{
    svo_deinterleave(code << 3, corner);
    for (uint axis = 0; axis < 3u; ++axis) {
        corner[axis] = (corner[axis] << child_log2) + (1u << child_log2 >> 1);
    }
    svo_walk_begin(tree, corner, child_log2, start);
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
    const uint empty = ~(uint)child_mask[node] & 255u;
    const uint child_log2 = params.depth - params.level - 1u; /* width of the children in voxels */
    uint corner[3];
    uint said[3];
    svo_column_walk start;
    svo_begin_in_child(&tree, codes[node], child_log2, corner, &start);
    for (uint axis = 0; axis < 3u; ++axis) {
        said[axis] = svo_inside_along(&tree, windings, &start, corner, axis, empty, params.rule);
    }
    const uint inside = (said[0] & said[1]) | (said[1] & said[2]) | (said[2] & said[0]);
    const uint ambiguous = popcount((said[0] | said[1] | said[2]) & ~(said[0] & said[1] & said[2]));
    inside_mask[node] = (uchar)inside;
    if (inside != 0u) {
        atomic_add(counters + SVO_SOLID_INSIDE, popcount(inside));
    }
    if (ambiguous != 0u) {
        atomic_add(counters + SVO_SOLID_AMBIGUOUS, ambiguous);
    }
    if (empty != 0u) {
        atomic_add(counters + SVO_SOLID_TESTS, popcount(empty));
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_lines(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                  __global const uchar *carries, __global const uint *crossings, __global const uint *windings,
                  __global uint *lines, svo_solid_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const svo_solid_tree tree = {child_mask,   first_child,       carries,          crossings,
                                 params.depth, params.leaf_begin, params.leaf_count};
    const uint node = params.first + item;
    const uint empty = ~(uint)child_mask[node] & 255u;
    uint corner[3];
    svo_column_walk start;
    svo_begin_in_child(&tree, codes[node], params.depth - params.level - 1u, corner, &start);
    for (uint octant = 8u; octant-- > 0u;) {
        uint winding = 0;
        if ((empty >> octant & 1u) != 0u) {
            svo_column_walk walk = start;
            for (uint k = 0; k < 3u; ++k) {
                walk.at[k] = corner[k] + ((octant >> k & 1u) << walk.shift);
            }
            const uint leaf = svo_walk_on(&tree, 2u, &walk);
            winding = leaf != SVO_SOLID_NO_LEAF ? windings[2u * (size_t)tree.leaf_count + leaf] : 0u;
        }
        lines[8u * (size_t)item + octant] = winding;
    }
}
