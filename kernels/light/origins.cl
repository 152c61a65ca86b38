/* SPDX-License-Identifier: MIT */
/*
 * Inner nodes of a changed tree that have in the tree before what they have in this one: below them and, for bricks,
 * around them no leaf can have changed. What was made for such a node is copied, whatever its number is now.
 *
 *   svo_k_light_origins  per inner node of a level, top-down: the origins of its inner children, and that of the root
 *   svo_k_light_keep     per inner node with an origin: copies what the light before has of it
 *
 * The children of a node with an origin follow each other as those of the origin do. So only nodes that boxes touch
 * look at their children's cells, and only what lies beside the boxes is looked for in the tree before.
 *
 * Launch: one work-item per node, rounded up to whole groups. No atomics, no local memory.
 */
#include "light/changed.clh"
#include "shared/nodes.clh"

/* Whether what a box may have changed is seen by a node of a level above the leaves. Samples of a brick depend on
   leaves half a node away at most: each level below adds half of what the one above it does. */
static bool svo_sees_change(const uint *cell, uint level, __global const int *boxes, uint box_count, uint depth)
{
    const int width = 1 << (int)(depth - level); /* leaves */
    const int3 low = (int3)((int)cell[0], (int)cell[1], (int)cell[2]) * width;
#ifdef SVO_LIGHT_BRICKS
    const int beside = width / 2;
#else
    const int beside = 0;
#endif
    return svo_is_changed(low - beside, low + (width - 1 + beside), boxes, box_count);
}

/* The node of a code in the tree before, or SVO_NO_NODE where it may have changed. */
static uint svo_find_origin(__global const uchar *old_mask, __global const uint *old_child, ulong code, uint level,
                            __global const int *boxes, uint box_count, uint depth)
{
    uint cell[3];
    svo_node node;
    svo_deinterleave(code, cell);
    if (svo_sees_change(cell, level, boxes, box_count, depth)) {
        return SVO_NO_NODE;
    }
    svo_walk_down(old_mask, old_child, level, cell, &node);
    return node.level == level ? node.index : SVO_NO_NODE;
}

/* old_mask, old_child: of the tree before. codes: Morton codes of nodes without an origin and of their children. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_origins(__global const uchar *child_mask, __global const uint *first_child, __global const uchar *old_mask,
                    __global const uint *old_child, __global const int *boxes, __global ulong *codes,
                    __global uint *origins, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    const uint node = params.first + item;
    const uint mask = child_mask[node];
    const ulong code = node == 0u ? 0ul : codes[node];
    uint origin = node == 0u ? svo_find_origin(old_mask, old_child, 0ul, 0u, boxes, params.box_count, params.depth)
                             : origins[node];
    /* Trees that differ outside the boxes are the caller's mistake; no index may leave the tree before. */
    origin = origin != SVO_NO_NODE && old_mask[origin] == mask ? origin : SVO_NO_NODE;
    origins[node] = origin;
    if (params.level + 1u == params.depth) {
        return;
    }
    uint child = first_child[node];
    uint old = origin != SVO_NO_NODE ? old_child[origin] : SVO_NO_NODE;
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((mask >> octant & 1u) == 0u) {
            continue;
        }
        if (origin != SVO_NO_NODE) {
            origins[child] = old++;
        } else {
            codes[child] = code << 3 | octant;
            origins[child] = svo_find_origin(old_mask, old_child, code << 3 | octant, params.level + 1u, boxes,
                                             params.box_count, params.depth);
        }
        ++child;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_keep(__global const uint *origins, __global const ushort *from, __global ushort *to, svo_light_step params)
{
    const uint node = (uint)get_global_id(0);
    const uint origin = node < params.count ? origins[node] : SVO_NO_NODE;
    for (uint k = 0; k < params.elements && origin != SVO_NO_NODE; ++k) {
        to[params.elements * (size_t)node + k] = from[params.elements * (size_t)origin + k];
    }
}
