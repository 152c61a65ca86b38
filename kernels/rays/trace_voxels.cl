/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits of voxels into a buffer: svo_trace_voxel of rays.clh in batches, for built trees and, with a
 * define of read.clh, for compact ones. On CPUs, with SVO_RAY_STREAMS, a work-item traces an equal share of all rays,
 * eight at a time (voxel_lanes.clh). The hits are the same.
 *
 * Launch: one dimension, groups of SVO_TRACE_ITEMS work-items: on GPUs at least one work-item per ray, on CPUs any
 * number of them. Reads the tree and the rays; writes one record per ray. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/rays.clh"
#include "rays/share.clh"
#include "rays/voxel_lanes.clh"

__kernel __attribute__((reqd_work_group_size(SVO_TRACE_ITEMS, 1, 1))) void
svo_k_trace_voxels(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_voxel_hit *hits, uint ray_count,
                   float footprint)
{
    uint first;
    uint end;
    svo_trace_share(ray_count, &first, &end);
    SVO_TREE_MAKE(tree);
#ifdef SVO_RAY_STREAMS
    svo_trace_voxels(&tree, rays + first, hits + first, end - first, footprint);
#else
    for (uint i = first; i < end; ++i) {
        const svo_ray ray = rays[i];
        svo_voxel_hit hit;
        svo_trace_voxel(&tree, &ray, footprint, &hit);
        hits[i] = hit;
    }
#endif
}
