/* SPDX-License-Identifier: MIT */
/*
 * The boxes of the hierarchy, from the instances upwards (Karras 2012, as link.cl). Each work-item carries the box of
 * an instance to its parent and goes on from there if it is the second to arrive; the first one stops. So the union is
 * of complete boxes, and least and greatest bounds are the same whoever comes second.
 *
 * Launch: one work-item per instance, one dimension, rounded up to whole groups. Reads the instances' boxes and the
 * parents; writes the nodes' boxes. Atomics: a counter per node, zero before and afterwards, says who is second. The
 * boxes themselves are exchanged and read as atomics too, so that the second one sees what the first one wrote from
 * another group. No local memory.
 */
#include "shared/layout.h"

typedef struct svo_scene_bounds {
    float3 low, high;
} svo_scene_bounds;

static void svo_scene_store(__global svo_scene_node *node, uint side, svo_scene_bounds bounds)
{
    volatile __global uint *words = (volatile __global uint *)(node->box + 6u * side);
    atomic_xchg(words, as_uint(bounds.low.x));
    atomic_xchg(words + 1, as_uint(bounds.low.y));
    atomic_xchg(words + 2, as_uint(bounds.low.z));
    atomic_xchg(words + 3, as_uint(bounds.high.x));
    atomic_xchg(words + 4, as_uint(bounds.high.y));
    atomic_xchg(words + 5, as_uint(bounds.high.z));
}

static svo_scene_bounds svo_scene_load(__global svo_scene_node *node, uint side)
{
    volatile __global uint *words = (volatile __global uint *)(node->box + 6u * side);
    svo_scene_bounds bounds;
    bounds.low.x = as_float(atomic_or(words, 0u));
    bounds.low.y = as_float(atomic_or(words + 1, 0u));
    bounds.low.z = as_float(atomic_or(words + 2, 0u));
    bounds.high.x = as_float(atomic_or(words + 3, 0u));
    bounds.high.y = as_float(atomic_or(words + 4, 0u));
    bounds.high.z = as_float(atomic_or(words + 5, 0u));
    return bounds;
}

/* The first child's box comes first, whoever arrived second: 0 and -0 are equal, and which one remains must not depend
   on the order. */
static svo_scene_bounds svo_scene_union(svo_scene_bounds first, svo_scene_bounds second)
{
    svo_scene_bounds both;
    both.low = select(first.low, second.low, second.low < first.low);
    both.high = select(first.high, second.high, second.high > first.high);
    return both;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scene_refit(__global const svo_scene_instance *instances, __global const uint *parents,
                  __global svo_scene_node *nodes, __global uint *arrivals, svo_scene_params params)
{
    const uint i = (uint)get_global_id(0);
    if (i >= params.instance_count || params.instance_count < 2u) {
        return;
    }
    svo_scene_bounds bounds;
    bounds.low = vload3(0, instances[i].low);
    bounds.high = vload3(0, instances[i].high);
    uint at = parents[i];
    while (at != SVO_NO_NODE) {
        __global svo_scene_node *node = nodes + (at >> 1);
        const uint side = at & 1u;
        svo_scene_store(node, side, bounds);
        mem_fence(CLK_GLOBAL_MEM_FENCE);
        if (atomic_inc((volatile __global uint *)arrivals + (at >> 1)) == 0u) {
            return;
        }
        mem_fence(CLK_GLOBAL_MEM_FENCE);
        atomic_xchg((volatile __global uint *)arrivals + (at >> 1), 0u);
        const svo_scene_bounds other = svo_scene_load(node, 1u - side);
        bounds = side == 0u ? svo_scene_union(bounds, other) : svo_scene_union(other, bounds);
        at = node->parent;
    }
}
