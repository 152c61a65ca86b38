/* SPDX-License-Identifier: MIT */
/*
 * The hierarchy's nodes from the sorted codes: a binary radix tree, every node on its own (Karras, "Maximizing
 * Parallelism in the Construction of BVHs, Octrees, and k-d Trees", 2012). Node i has an end of its range at place i of
 * the list; the direction, the other end and the split follow from the lengths of common prefixes. Equal codes are
 * told apart by their places, which are in the order of the instances.
 *
 * Launch: one work-item per node, of which there is one less than instances, one dimension, rounded up to whole groups.
 * Reads the sorted list (with SVO_CODE48); writes each node's children, and the parents of those. No atomics: each
 * node and each instance has one parent. No local memory.
 */
#include "shared/fragment.clh"
#include "shared/scene_layout.h"

/* The length of the common prefix of two places; -1 beyond the ends of the list. */
static int svo_scene_prefix(__global const uint *list, uint count, uint i, long j)
{
    if (j < 0 || j >= (long)count) {
        return -1;
    }
    const ulong difference = (ulong)svo_fragment_code(list, i) ^ (ulong)svo_fragment_code(list, (size_t)j);
    return difference != 0UL ? (int)clz(difference) : 64 + (int)clz(i ^ (uint)j);
}

/* The place where a range divides: the last one whose prefix with the first is longer than that of the whole range. */
static uint svo_scene_split(__global const uint *list, uint count, uint first, uint last)
{
    const int common = svo_scene_prefix(list, count, first, (long)last);
    uint split = first;
    uint stride = last - first;
    do {
        stride = (stride + 1u) / 2u;
        if (split + stride < last && svo_scene_prefix(list, count, first, (long)split + stride) > common) {
            split += stride;
        }
    } while (stride > 1u);
    return split;
}

/* The other end of node i's range. */
static uint svo_scene_range_end(__global const uint *list, uint count, uint i)
{
    const long at = (long)i;
    const int direction = svo_scene_prefix(list, count, i, at + 1) > svo_scene_prefix(list, count, i, at - 1) ? 1 : -1;
    const int outside = svo_scene_prefix(list, count, i, at - direction);
    long reach = 2;
    while (svo_scene_prefix(list, count, i, at + reach * direction) > outside) {
        reach *= 2;
    }
    long length = 0;
    for (long stride = reach / 2; stride >= 1; stride /= 2) {
        if (svo_scene_prefix(list, count, i, at + (length + stride) * direction) > outside) {
            length += stride;
        }
    }
    return (uint)(at + length * direction);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scene_link(__global const uint *list, __global svo_scene_node *nodes, __global uint *parents,
                 svo_scene_params params)
{
    const uint i = (uint)get_global_id(0);
    if (i + 1u >= params.instance_count) {
        return;
    }
    const uint end = svo_scene_range_end(list, params.instance_count, i);
    const uint first = min(i, end);
    const uint last = max(i, end);
    const uint split = svo_scene_split(list, params.instance_count, first, last);
    for (uint side = 0; side < 2u; ++side) {
        const uint place = split + side;
        const bool is_instance = place == (side == 0u ? first : last);
        if (is_instance) {
            const uint instance = svo_fragment_triangle(list, place);
            nodes[i].child[side] = SVO_SCENE_LEAF | instance;
            parents[instance] = 2u * i + side;
        } else {
            nodes[i].child[side] = place;
            nodes[place].parent = 2u * i + side;
        }
    }
    nodes[i].reserved = 0u;
    if (i == 0u) {
        nodes[i].parent = SVO_NO_NODE;
    }
}
