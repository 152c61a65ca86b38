/* SPDX-License-Identifier: MIT */
/*
 * The boxes of the hierarchy, from the instances upwards (Karras 2012, as link.cl). A box is six numbers, and each goes
 * its own way: a work-item carries one bound of an instance to its parent and goes on from there if it is the second to
 * arrive; the first one stops. So the union is of both children's bounds, and it is the same whoever comes second.
 *
 * Work-groups see each other's stores only through atomics, and not in any order from one address to another. So a
 * bound and the news of its arrival are one word: whoever comes exchanges its own for what is there, and that is the
 * sibling's or nothing yet.
 *
 * Launch: six work-items per instance, one dimension, rounded up to whole groups. Reads the instances' boxes and the
 * parents; writes the nodes' boxes. Atomics: six words per node in arrivals, zero before and afterwards. No local
 * memory.
 */
#include "shared/scene_layout.h"

/* A bound as it waits in arrivals: never zero, since no bound is a NaN. */
static uint svo_scene_pack(float bound)
{
    return ~as_uint(bound);
}

static float svo_scene_unpack(uint word)
{
    return as_float(~word);
}

/* The lower of low bounds, the higher of high ones. The first child's comes first, whoever arrived second: 0 and -0 are
   equal, and which one remains must not depend on the order. */
static float svo_scene_union(bool is_low, float first, float second)
{
    return (is_low ? second < first : second > first) ? second : first;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scene_refit(__global const svo_scene_instance *instances, __global const uint *parents,
                  __global svo_scene_node *nodes, volatile __global uint *arrivals, svo_scene_params params)
{
    const uint i = (uint)get_global_id(0) / SVO_SCENE_BOUNDS;
    const uint which = (uint)get_global_id(0) % SVO_SCENE_BOUNDS; /* low x, y, z, high x, y, z */
    if (i >= params.instance_count || params.instance_count < 2u) {
        return;
    }
    float bound = which < 3u ? instances[i].low[which] : instances[i].high[which - 3u];
    uint at = parents[i];
    while (at != SVO_NO_NODE) {
        __global svo_scene_node *node = nodes + (at >> 1);
        volatile __global uint *meeting = arrivals + SVO_SCENE_BOUNDS * (size_t)(at >> 1) + which;
        const bool is_first_child = (at & 1u) == 0u;
        node->box[SVO_SCENE_BOUNDS * (at & 1u) + which] = bound;
        const uint sibling = atomic_xchg(meeting, svo_scene_pack(bound));
        if (sibling == 0u) {
            return;
        }
        *meeting = 0u; /* nobody else comes */
        const float other = svo_scene_unpack(sibling);
        bound = svo_scene_union(which < 3u, is_first_child ? bound : other, is_first_child ? other : bound);
        at = node->parent;
    }
}
