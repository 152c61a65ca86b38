/* SPDX-License-Identifier: MIT */
/*
 * The leaves of a BVH, in the order of the items.
 *
 *   svo_k_bvh_leaf_units   per item: units of 16 bytes of the leaf that begins there; scan.cl turns them into places
 *   svo_k_bvh_leaves       per item: writes the leaf that begins there, and its box
 *
 * Launch: as above, one dimension, rounded up to whole groups. No atomics, no local memory.
 */
#include "bvh/leaf.clh"

__kernel void svo_k_bvh_leaf_units(__global const uint *item_counts, __global uint *units, uint has_doubles,
                                   uint item_count)
{
    const uint first = (uint)get_global_id(0);
    if (first < item_count) {
        const uint count = item_counts[first];
        units[first] = count != 0u ? svo_bvh_leaf_units(count, has_doubles != 0u) : 0u;
    }
}

/* places: units before a leaf's, beside the empty leaf and leaf_begin units of other BVHs. The last work-item writes
   the empty leaf, which is the first, and the words that follow the last. */
__kernel void svo_k_bvh_leaves(SVO_BVH_MESH_PARAMETERS, __global const uint *floats, __global const ulong *doubles,
                               __global const uint *order, __global const uint *item_counts,
                               __global const uint *places, __global uint *leaves, __global float8 *boxes,
                               uint item_count, uint snap_bits, uint has_doubles, uint leaf_begin)
{
    const uint first = (uint)get_global_id(0);
    if (first > item_count) {
        return;
    }
    if (first == item_count) {
        vstore8((uint8)(0u), 0, leaves);
        vstore8((uint8)(0u), 0, leaves + SVO_RAY_LEAF_HEAD_WORDS + 4 * ((size_t)leaf_begin + places[item_count]));
        return;
    }
    const uint count = item_counts[first];
    if (count != 0u) {
        SVO_BVH_MESH_MAKE(mesh);
        const svo_bvh_corners corners = {floats, doubles, has_doubles != 0u};
        __global uint *record = leaves + SVO_RAY_LEAF_HEAD_WORDS + 4 * ((size_t)leaf_begin + places[first]);
        boxes[first] = svo_bvh_write_leaf(&mesh, &corners, order + first, count, snap_bits, record);
    }
}
