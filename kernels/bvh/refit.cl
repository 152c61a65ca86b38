/* SPDX-License-Identifier: MIT */
/*
 * Writes the nodes of a BVH from the boxes of their children, upwards; after leaves.cl, whatever has changed of the
 * geometry but the number of triangles. Bounds are rounded outwards to 16 bits (after Mahovsky and Wyvill,
 * "Memory-Conserving Bounding Volume Hierarchies with Coherent Raytracing", 2006).
 *
 * Launch: a work-item per node of a level, the lowest level first. Reads the boxes of leaves, by their first items, and
 * of the nodes below; writes the level's nodes and their boxes. No atomics, no local memory.
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

__kernel void svo_k_bvh_refit(__global const svo_bvh_children *children, __global const uint *places,
                              __global const float8 *leaf_boxes, __global float8 *node_boxes,
                              __global svo_ray_node *nodes, uint level_begin, uint level_end, uint box_log2)
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
        const uint place = SVO_RAY_LEAF_HEAD_WORDS / 4u + places[of->first[i]];
        made.child[i] = is_node ? of->node[i] : SVO_RAY_LEAF | (is_there ? place : 0u);
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
    nodes[node] = made;
    node_boxes[node] = sum;
}
