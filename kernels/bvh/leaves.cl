/* SPDX-License-Identifier: MIT */
/*
 * The leaves of a BVH, in the order of the items.
 *
 *   svo_k_bvh_leaf_units   per item: units of 16 bytes of the leaf that begins there; scan.cl turns them into places
 *   svo_k_bvh_leaves       per item of all members: writes the leaf that begins there, and its box
 *
 * Launch: one dimension; leaf_units rounded up to whole groups, leaves a group for each tile. Atomics: whether a member
 * reaches outside the grid, which no order changes. No local memory.
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

/* places: units before a leaf's, beside the empty leaf and leaf_begin units of other BVHs. A member has an item more,
   whose work-item writes the words that follow the last leaf, and for the first member the empty leaf, which comes
   before all others. extents: zero at first. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bvh_leaves(SVO_BVH_MESH_PARAMETERS, __global const uint *floats, __global const ulong *doubles,
                 __global const uint *order, __global const uint *item_counts, __global const uint *places,
                 __global uint *leaves, __global float8 *boxes, __global const svo_bvh_member *members,
                 __global const svo_bvh_tile *tiles, volatile __global svo_bvh_extent *extents, uint snap_bits,
                 uint has_doubles)
{
    const svo_bvh_tile tile = tiles[get_group_id(0)];
    const uint item = tile.begin + (uint)get_local_id(0);
    if (item >= tile.end) {
        return;
    }
    const svo_bvh_member of = members[tile.member];
    const size_t first = (size_t)of.item_begin + item;
    __global uint *record = leaves + SVO_RAY_LEAF_HEAD_WORDS + 4 * ((size_t)of.leaf_begin + places[first]);
    if (item == of.item_count) {
        vstore8((uint8)(0u), 0, record);
        if (tile.member == 0u) {
            vstore8((uint8)(0u), 0, leaves);
        }
        return;
    }
    const uint count = item_counts[first];
    if (count != 0u) {
        SVO_BVH_MESH_MAKE(mesh, of.first_triangle);
        const svo_bvh_corners corners = {floats, doubles, has_doubles != 0u};
        bool outside;
        boxes[first] = svo_bvh_write_leaf(&mesh, &corners, order + first, count, snap_bits, record, &outside);
        if (outside) {
            atomic_or(&extents[tile.member].outside, 1u);
        }
    }
}
