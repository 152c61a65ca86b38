/* SPDX-License-Identifier: MIT */
/*
 * Writes the nodes of BVHs from the boxes of their children, upwards; after leaves.cl, whatever has changed of the
 * geometry but the number of triangles. BVHs that share their buffers (svo_bvh_member) are written together. Bounds
 * are rounded outwards to 16 bits (after Mahovsky and Wyvill, "Memory-Conserving Bounding Volume Hierarchies with
 * Coherent Raytracing", 2006).
 *
 *   svo_k_bvh_refit    per node of a level of all members, the lowest level first: reads the boxes of leaves, by their
 *                      first items, and of the nodes below; writes the node and its box, of a root also the extent
 *
 * Lane 3 of a node's box has the areas of all nodes and leaves from the node down. The root's, over the area of its own
 * box, is how many of them a random ray through it visits (Lauterbach, Yoon, Tuft and Manocha, "RT-DEFORM", 2006, watch
 * a refit hierarchy by areas).
 *
 * Launch: one dimension, a group for each tile. No atomics, no local memory.
 */
#include "bvh/boxes.clh"

/* Both bounds are rounded down: a box ends where the step after its high bound begins. */
static uint4 svo_bvh_steps(float4 bounds, uint box_log2)
{
    return min(convert_uint4(bounds) >> box_log2, (uint4)(0xffffu));
}

static void svo_bvh_set_bounds(uint *words, uint child, uint4 value)
{
    const uint shift = 16u * (child % 2u);
    words[child / 2u] |= value.x << shift;
    words[4u + child / 2u] |= value.y << shift;
    words[8u + child / 2u] |= value.z << shift;
}

/* children, node_boxes: of the nodes of all members; places, leaf_boxes: of their items. first_tile: of the level. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bvh_refit(__global const svo_bvh_children *children, __global const uint *places,
                __global const float8 *leaf_boxes, __global float8 *node_boxes, __global svo_ray_node *nodes,
                __global const svo_bvh_member *members, __global const svo_bvh_tile *tiles,
                __global svo_bvh_extent *extents, uint first_tile, uint box_log2)
{
    const svo_bvh_tile tile = tiles[first_tile + (uint)get_group_id(0)];
    const uint node = tile.begin + (uint)get_local_id(0);
    if (node >= tile.end) {
        return;
    }
    const svo_bvh_member member = members[tile.member];
    __global const svo_bvh_children *of = children + member.child_begin + node;
    leaf_boxes += member.item_begin;
    places += member.item_begin;
    node_boxes += member.child_begin;
    svo_ray_node made;
    float8 sum = SVO_BVH_EMPTY_BOX;
    float area = 0.0f;
    for (uint i = 0; i < 12u; ++i) {
        made.low[i] = 0u;
        made.high[i] = 0u;
    }
    for (uint i = 0; i < 8u; ++i) {
        const bool is_there = of->count[i] != 0u;
        const bool is_node = of->node[i] != 0u;
        const uint place = SVO_RAY_LEAF_HEAD_WORDS / 4u + member.leaf_begin + places[of->first[i]];
        made.child[i] = is_node ? member.node_begin + of->node[i] : SVO_RAY_LEAF | (is_there ? place : 0u);
        uint4 low = (uint4)(0xffffu);
        uint4 high = (uint4)(0u);
        if (is_there) {
            const float8 box = is_node ? node_boxes[of->node[i]] : leaf_boxes[of->first[i]];
            low = svo_bvh_steps(box.lo, box_log2);
            high = svo_bvh_steps(-box.hi, box_log2);
            sum = min(sum, box);
            area += is_node ? box.s3 : svo_bvh_half_area(box);
        }
        svo_bvh_set_bounds(made.low, i, low);
        svo_bvh_set_bounds(made.high, i, high);
    }
    nodes[member.node_begin + node] = made;
    sum.s3 = area + svo_bvh_half_area(sum);
    node_boxes[node] = sum;
    if (node == 0u) {
        __global svo_bvh_extent *to = extents + tile.member;
        vstore3(sum.s012, 0, to->low);
        vstore3(sum.s456, 0, to->high);
        to->area = sum.s3;
    }
}
