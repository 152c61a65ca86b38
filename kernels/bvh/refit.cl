/* SPDX-License-Identifier: MIT */
/*
 * Writes the nodes of a BVH from the boxes of their children, upwards; after leaves.cl, whatever has changed of the
 * geometry but the number of triangles. Bounds are rounded outwards to 16 bits (after Mahovsky and Wyvill,
 * "Memory-Conserving Bounding Volume Hierarchies with Coherent Raytracing", 2006).
 *
 *   svo_k_bvh_refit    per node of a level, the lowest level first: reads the boxes of leaves, by their first items,
 *                      and of the nodes below; writes the node and its box
 *   svo_k_bvh_extent   once they are written: how costly rays through the nodes are
 *
 * Launch: refit: one dimension, rounded up to whole groups; extent: one group of SVO_GROUP_ITEMS. No atomics. Local
 * memory is an argument.
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

/* node_begin, leaf_begin: the BVH's first node among those of others, and units of leaves before its own. */
__kernel void svo_k_bvh_refit(__global const svo_bvh_children *children, __global const uint *places,
                              __global const float8 *leaf_boxes, __global float8 *node_boxes,
                              __global svo_ray_node *nodes, uint level_begin, uint level_end, uint box_log2,
                              uint node_begin, uint leaf_begin)
{
    const uint node = level_begin + (uint)get_global_id(0);
    if (node >= level_end) {
        return;
    }
    __global const svo_bvh_children *of = children + node;
    svo_ray_node made;
    float8 sum = SVO_BVH_EMPTY_BOX;
    for (uint i = 0; i < 12u; ++i) {
        made.low[i] = 0u;
        made.high[i] = 0u;
    }
    for (uint i = 0; i < 8u; ++i) {
        const bool is_there = of->count[i] != 0u;
        const bool is_node = of->node[i] != 0u;
        const uint place = SVO_RAY_LEAF_HEAD_WORDS / 4u + leaf_begin + places[of->first[i]];
        made.child[i] = is_node ? node_begin + of->node[i] : SVO_RAY_LEAF | (is_there ? place : 0u);
        uint4 low = (uint4)(0xffffu);
        uint4 high = (uint4)(0u);
        if (is_there) {
            const float8 box = is_node ? node_boxes[of->node[i]] : leaf_boxes[of->first[i]];
            low = svo_bvh_steps(box.lo, box_log2);
            high = svo_bvh_steps(-box.hi, box_log2);
            sum = min(sum, box);
        }
        svo_bvh_set_bounds(made.low, i, low);
        svo_bvh_set_bounds(made.high, i, high);
    }
    nodes[node_begin + node] = made;
    node_boxes[node] = sum;
}

/* A work-item's share of so many numbers. */
static uint2 svo_bvh_strip(uint item, uint count)
{
    const uint length = (count + SVO_GROUP_ITEMS - 1u) / SVO_GROUP_ITEMS;
    const uint begin = min(item * length, count);
    return (uint2)(begin, min(begin + length, count));
}

/* In lane 3 of the root's box the areas of all nodes and leaves: over the root's, those that a random ray through it
   visits (Lauterbach, Yoon, Tuft and Manocha, "RT-DEFORM", 2006, watch a refit hierarchy by areas). Strips and their
   order are fixed, and so is the sum. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bvh_extent(__global float8 *node_boxes, __global const float8 *leaf_boxes, __global const uint *item_counts,
                 uint node_count, uint item_count, __local float *sums)
{
    const uint item = (uint)get_local_id(0);
    const uint2 nodes = svo_bvh_strip(item, node_count);
    const uint2 items = svo_bvh_strip(item, item_count);
    float sum = 0.0f;
    for (uint node = nodes.x; node < nodes.y; ++node) {
        sum += svo_bvh_half_area(node_boxes[node]);
    }
    for (uint first = items.x; first < items.y; ++first) {
        if (item_counts[first] != 0u) {
            sum += svo_bvh_half_area(leaf_boxes[first]);
        }
    }
    sums[item] = sum;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item == 0u) {
        for (uint i = 1; i < SVO_GROUP_ITEMS; ++i) {
            sum += sums[i];
        }
        node_boxes[0].s3 = sum;
    }
}
