/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits into a buffer: the batch interface of rays.clh. Defines: SVO_COUNT_HITS: count all hits;
 * SVO_RAY_STREAMS: for CPUs.
 *
 * On GPUs a work-item traces one ray, and other work-items hide its latency. On CPUs a work-item traces an equal share
 * of all rays, as packets (ray_packet.clh) and streams (ray_stream.clh). The hits are the same.
 *
 * Launch: one dimension, groups of SVO_TRACE_ITEMS work-items: on GPUs at least one work-item per ray, on CPUs any
 * number of them.
 * Reads the tree and the rays; writes one record per ray. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/ray_packet.clh"
#include "rays/ray_stream.clh"
#include "rays/rays.clh"

#ifdef SVO_RAY_STREAMS
#define SVO_TRACE_ITEMS 1
#else
#define SVO_TRACE_ITEMS SVO_GROUP_ITEMS
#endif

__kernel __attribute__((reqd_work_group_size(SVO_TRACE_ITEMS, 1, 1))) void
svo_k_trace(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_hit *hits, uint ray_count, uint any)
{
    SVO_TREE_MAKE(tree);
#ifdef SVO_RAY_STREAMS
    const uint items = (uint)get_global_size(0);
    const ulong per_item = ((ray_count - 1u) / SVO_PACKET_RAYS / items + 1u) * (ulong)SVO_PACKET_RAYS;
    const uint first = (uint)min(get_global_id(0) * per_item, (ulong)ray_count);
    const uint end = (uint)min(first + per_item, (ulong)ray_count);
    uint i = first;
    const uint packed = (end - first) / SVO_PACKET_RAYS * SVO_PACKET_RAYS;
    svo_stream_trace(&tree, rays + first, hits + first, packed, any != 0u);
    i += packed;
#else
    uint i = (uint)get_global_id(0);
    const uint end = min(i + 1u, ray_count);
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
