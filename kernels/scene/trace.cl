/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer through a scene, hits into a buffer. With -DSVO_SCENE_TRIANGLES the hits are of triangles, else of
 * voxels. The options of read.clh select how nodes are read.
 *
 * On GPUs a work-item traces one ray. On CPUs, with SVO_RAY_STREAMS, it traces an equal share of all rays, sixteen at a
 * time (voxel_stream.clh, triangle_stream.clh). The hits are the same.
 *
 * Launch: one dimension, groups of SVO_TRACE_ITEMS work-items: on GPUs at least one work-item per ray, on CPUs any
 * number of them. Reads the scene and the rays; writes one record per ray. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "rays/share.clh"
#include "scene/record.clh"
#include "scene/triangle_stream.clh"
#include "scene/voxel_stream.clh"
#include "scene/walk.clh"

__kernel __attribute__((reqd_work_group_size(SVO_TRACE_ITEMS, 1, 1))) void
svo_k_scene_trace(SVO_SCENE_PARAMETERS, __global const svo_ray *rays, __global SVO_SCENE_RECORD *hits, uint ray_count)
{
    uint first;
    uint end;
    svo_trace_share(ray_count, &first, &end);
    SVO_SCENE_MAKE(scene);
#ifdef SVO_SCENE_STREAMS
    if ((scene.params.flags & SVO_SCENE_FLAG_EVERY) == 0u) {
        svo_scene_stream(&scene, rays + first, hits + first, end - first);
        return;
    }
#endif
    for (uint i = first; i < end; ++i) {
        const svo_ray ray = rays[i];
        svo_scene_search search;
        svo_scene_search_ray(&scene, &ray, scene.params.footprint, scene.params.flags, &search);
        hits[i] = svo_scene_record(&scene, &search);
    }
}
