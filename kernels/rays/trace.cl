/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits into a buffer: the batch interface of rays.clh. Defines: SVO_COUNT_HITS: count all hits;
 * SVO_RAY_STREAMS: for CPUs; SVO_RAY_FIELDS: rays and hits by field (ray_records.clh).
 *
 * On GPUs a work-item traces one ray, and other work-items hide its latency. On CPUs a work-item traces an equal share
 * of all rays (ray_batch.clh). The hits are the same.
 *
 * Launch: one dimension, groups of SVO_TRACE_ITEMS work-items: on GPUs at least one work-item per ray, on CPUs any
 * number of them.
 * Reads the tree and the rays; writes one record per ray. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/ray_batch.clh"
#include "rays/rays.clh"
#include "rays/share.clh"

/* Traces an array of rays into an array of hits. */
static void svo_trace_part(const svo_tree *tree, svo_ray_array rays, svo_hit_array hits, uint ray_count, uint any)
{
#ifdef SVO_COUNT_HITS
    (void)any;
    for (uint i = 0u; i < ray_count; ++i) {
        const svo_ray ray = svo_ray_at(rays, i);
        svo_hit hit;
        svo_trace_count(tree, &ray, &hit);
        svo_put_hit(hits, i, &hit);
    }
#else
    svo_trace_rays(tree, rays, hits, ray_count, any != 0u);
#endif
}

__kernel __attribute__((reqd_work_group_size(SVO_TRACE_ITEMS, 1, 1))) void
svo_k_trace(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_hit *hits, uint ray_count, uint any)
{
    uint first;
    uint end;
    svo_trace_share(ray_count, &first, &end);
    SVO_TREE_MAKE(tree);
#ifdef SVO_RAY_FIELDS
    int8 block[SVO_BLOCK_RAYS];
    for (; first < end; first += SVO_BLOCK_RAYS) {
        const uint count = min(end - first, SVO_BLOCK_RAYS);
        svo_trace_part(&tree, svo_rays_from(rays, first, ray_count), block, count, any);
        svo_write_block(block, count, hits, first, ray_count);
    }
#else
    svo_trace_part(&tree, rays + first, hits + first, end - first, any);
#endif
}
