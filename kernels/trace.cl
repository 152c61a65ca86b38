/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits into a buffer: the batch side of rays.clh. Reads the tree, writes one record per ray;
 * -DSVO_COUNT_HITS counts all hits. No atomics, no local memory.
 *
 * Launch: one work-item per SVO_RAYS_PER_ITEM rays, one dimension, rounded up to whole groups.
 */
#include "svocl/layout.h"

#include "rays.clh"

#ifndef SVO_RAYS_PER_ITEM
#define SVO_RAYS_PER_ITEM 1 /* lib/rays_batch.c sets it for CPUs */
#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_trace(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_hit *hits, uint ray_count, uint any)
{
    const uint first = (uint)get_global_id(0) * SVO_RAYS_PER_ITEM;
    const uint end = min(first + SVO_RAYS_PER_ITEM, ray_count);
    SVO_TREE_MAKE(tree);
    for (uint i = first; i < end; ++i) {
        const svo_ray ray = rays[i];
        svo_hit hit;
#ifdef SVO_COUNT_HITS
        (void)any;
        svo_trace_count(&tree, &ray, &hit);
#else
        svo_trace_first(&tree, &ray, any != 0u, &hit);
#endif
        hits[i] = hit;
    }
}
