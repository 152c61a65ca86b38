/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, hits of voxels into a buffer: svo_trace_voxel of rays.clh in batches, for built trees and, with a
 * define of read.clh, for compact ones.
 *
 * Launch: one work-item per ray, rounded up to whole groups. Reads the tree and the rays; writes one record per ray. No
 * atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/rays.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_trace_voxels(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_voxel_hit *hits, uint ray_count,
                   float footprint)
{
    const uint i = (uint)get_global_id(0);
    if (i >= ray_count) {
        return;
    }
    SVO_TREE_MAKE(tree);
    const svo_ray ray = rays[i];
    svo_voxel_hit hit;
    svo_trace_voxel(&tree, &ray, footprint, &hit);
    hits[i] = hit;
}
