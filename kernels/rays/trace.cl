/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits into a buffer: the batch interface of rays.clh. Defines: SVO_COUNT_HITS: count all hits;
 * SVO_RAY_STREAMS: for CPUs.
 *
 * On GPUs a work-item traces one ray, and other work-items hide its latency. On CPUs a work-item traces all rays of its
 * group, as packets (ray_packet.clh) and streams (ray_stream.clh). The hits are the same.
 *
 * Launch: one group per SVO_GROUP_ITEMS rays, one dimension, of SVO_GROUP_ITEMS / SVO_RAYS_PER_ITEM work-items.
 * Reads the tree and the rays; writes one record per ray. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/ray_packet.clh"
#include "rays/ray_stream.clh"
#include "rays/rays.clh"

#ifdef SVO_RAY_STREAMS
#define SVO_RAYS_PER_ITEM SVO_GROUP_ITEMS
#else
#define SVO_RAYS_PER_ITEM 1
#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS / SVO_RAYS_PER_ITEM, 1, 1))) void
svo_k_trace(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_hit *hits, uint ray_count, uint any)
{
    const uint first = (uint)get_global_id(0) * SVO_RAYS_PER_ITEM;
    const uint end = min(first + SVO_RAYS_PER_ITEM, ray_count);
    uint i = first;
    SVO_TREE_MAKE(tree);
#ifdef SVO_RAY_STREAMS
    const uint packed = (end - first) / SVO_PACKET_RAYS * SVO_PACKET_RAYS;
    svo_stream_trace(&tree, rays + first, hits + first, packed, any != 0u);
    i += packed;
#endif
    for (; i < end; ++i) {
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
