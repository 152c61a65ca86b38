/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer through a scene, hits into a buffer. With -DSVO_SCENE_TRIANGLES the hits are of triangles, else of
 * voxels. The options of read.clh select how nodes are read.
 *
 * Launch: one work-item per ray, one dimension, rounded up to whole groups. Reads the scene and the rays; writes one
 * record per ray. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "scene/scene.clh"

#ifdef SVO_SCENE_TRIANGLES
#define SVO_SCENE_RECORD svo_scene_triangle_hit

static svo_scene_triangle_hit svo_scene_record(const svo_scene *scene, const svo_scene_search *search)
{
    const bool met = search->instance != SVO_NO_INSTANCE;
    svo_scene_triangle_hit hit;
    hit.t = search->t;
    hit.instance = search->instance;
    hit.triangle = met ? search->triangle.triangle : SVO_NO_TRIANGLE;
    hit.u = met ? search->triangle.u : 0.0f;
    hit.v = met ? search->triangle.v : 0.0f;
    const float3 normal =
        met ? svo_scene_normal(scene->instances + search->instance, vload3(0, search->triangle.normal))
            : (float3)(0.0f);
    vstore3(normal, 0, hit.normal);
    return hit;
}

#else
#define SVO_SCENE_RECORD svo_scene_hit

static svo_scene_hit svo_scene_record(const svo_scene *scene, const svo_scene_search *search)
{
    const bool met = search->instance != SVO_NO_INSTANCE;
    svo_scene_hit hit;
    hit.t = search->t;
    hit.instance = search->instance;
    hit.node = met ? search->voxel.node : SVO_NO_NODE;
    hit.level = met ? search->voxel.level : 0u;
    hit.face = met ? search->voxel.face : SVO_FACE_NONE;
    hit.steps = met ? search->voxel.steps : 0u;
    const float3 normal =
        met ? svo_scene_face_normal(scene->instances + search->instance, search->voxel.face) : (float3)(0.0f);
    vstore3(normal, 0, hit.normal);
    return hit;
}

#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scene_trace(SVO_SCENE_PARAMETERS, __global const svo_ray *rays, __global SVO_SCENE_RECORD *hits, uint ray_count)
{
    const uint i = (uint)get_global_id(0);
    if (i >= ray_count) {
        return;
    }
    SVO_SCENE_MAKE(scene);
    const svo_ray ray = rays[i];
    svo_scene_search search;
    svo_scene_search_ray(&scene, &ray, scene.params.footprint, scene.params.flags, &search);
    hits[i] = svo_scene_record(&scene, &search);
}
