/* SPDX-License-Identifier: MIT */
/*
 * Wide nodes for rays.clh: two levels of the octree in one record, 64 bits of occupancy in Morton order and the position
 * of the first child on the level below, among wide nodes or leaves. Since nodes lie in Morton order on their level, the
 * grandchildren of a node follow each other, and a child's position is the first one's plus the bits before its own.
 *
 * Launch: one work-item per node of one level, one dimension, rounded up to whole groups. Reads child_mask and first_child,
 * writes one record each. No atomics, no local memory.
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
