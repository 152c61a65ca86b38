/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits into a buffer: the batch side of rays.clh. One work-item per ray, one dimension, rounded up to
 * whole groups. Reads the tree, writes one record per ray; -DSVO_COUNT_HITS counts all hits. No atomics, no local memory.
 */
#include "svocl/layout.h"

#include "rays.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_trace(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_hit *hits, uint ray_count, uint any)
{
    const uint item = (uint)get_global_id(0);
    if (item >= ray_count) {
        return;
    }
    SVO_TREE_MAKE(tree);
    const svo_ray ray = rays[item];
    svo_hit hit;
#ifdef SVO_COUNT_HITS
    svo_trace_count(&tree, &ray, &hit);
#else
    svo_trace_first(&tree, &ray, any != 0u, &hit);
#endif
    hits[item] = hit;
}
