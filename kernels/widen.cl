/* SPDX-License-Identifier: MIT */
/*
 * What rays.clh reads of a tree, laid out for it.
 *
 * Wide nodes: two levels of the octree in one record, 64 bits of occupancy in Morton order and the position
 * of the first child on the level below, among wide nodes or leaves. Since nodes lie in Morton order on their level, the
 * grandchildren of a node follow each other, and a child's position is the first one's plus the bits before its own.
 *
 * Launch: one work-item per node of one level, one dimension, rounded up to whole groups. Reads child_mask and first_child,
 * writes one record each.
 *
 * Triangles: the corners of all leaf lists, each where its entry is, so that what a leaf reads lies together. Launch: one
 * work-item per entry.
 *
 * No atomics, no local memory.
 */
#include "svocl/layout.h"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void svo_k_widen(__global const uchar *child_mask,
                                                                                       __global const uint *first_child,
                                                                                       __global uint4 *wide,
                                                                                       svo_widen_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    const uint node = params.node_begin + item;
    const uint mask = child_mask[node];
    ulong occupied = 0ul;
    uint below = first_child[node];
    if (params.lone_root != 0u) {
        occupied = mask;
    } else {
        uint child = below;
        below = mask != 0u ? first_child[child] : params.child_begin;
        for (uint octant = 0u; octant < 8u; ++octant) {
            if ((mask >> octant & 1u) != 0u) {
                occupied |= (ulong)child_mask[child] << (8u * octant);
                ++child;
            }
        }
    }
    wide[params.wide_begin + item] =
        (uint4)((uint)occupied, (uint)(occupied >> 32), below - params.child_begin + params.wide_child_begin, 0u);
}

/* A coordinate of a triangle's corner. */
static int svo_corner(__global const int *vertices, __global const uint *indices, uint triangle, uint corner, uint axis)
{
    return vertices[3u * (size_t)indices[3u * (size_t)triangle + corner] + axis];
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_spread(__global const uint *list, __global const int *vertices, __global const uint *indices,
             __global const uint *triangle_ids, __global int4 *triangles, uint list_count)
{
    const uint item = (uint)get_global_id(0);
    if (item >= list_count) {
        return;
    }
    const uint triangle = list[item];
    for (uint axis = 0u; axis < 3u; ++axis) {
        triangles[3u * (size_t)item + axis] =
            (int4)(svo_corner(vertices, indices, triangle, 0u, axis), svo_corner(vertices, indices, triangle, 1u, axis),
                   svo_corner(vertices, indices, triangle, 2u, axis), (int)triangle_ids[triangle]);
    }
}
