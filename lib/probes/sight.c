/* SPDX-License-Identifier: MIT */
/* The public batches of rays, one for each kind of what probes see. */
#include "probes/sight.h"

#include <math.h>

#include "rays/rays.h"
#include "scene/state.h"
#include "svocl/plan.h"
#include "svocl/trace.h"

static bool has_triangles(const svo_i_sight *sight)
{
    return sight->tree != NULL ? svo_i_rays_of_triangles(&sight->tree->info)
                               : (sight->scene->info.need & SVO_NEED_RAYS) != 0;
}

svo_device *svo_i_sight_device(const svo_i_sight *sight)
{
    return sight->tree != NULL ? sight->tree->device : sight->scene->device;
}

svo_status svo_i_sight_check(const svo_i_sight *sight, const char *function)
{
    svo_ray_params unused;
    if (sight->scene != NULL) {
        return svo_i_scene_check(sight->scene, function);
    }
    SVO_I_TRY(svo_i_tree_check(sight->tree, function));
    return svo_i_rays_tree_params(sight->tree, function, &unused);
}

void svo_i_sight_get_box(const svo_i_sight *sight, svo_i_sight_box *box)
{
    if (sight->scene != NULL) {
        box->leaf_edge = svo_i_scene_leaf_edge(sight->scene);
        for (int axis = 0; axis < 3; ++axis) {
            box->low[axis] = sight->scene->info.low[axis];
            box->high[axis] = sight->scene->info.high[axis];
        }
        return;
    }
    const svo_tree_info *tree = &sight->tree->info;
    const double width = ldexp(1.0 / tree->scale, (int)tree->snap_bits);
    box->leaf_edge = ldexp(width, -(int)tree->depth);
    for (int axis = 0; axis < 3; ++axis) {
        box->low[axis] = tree->origin[axis];
        box->high[axis] = tree->origin[axis] + width;
    }
}

uint32_t svo_i_sight_hit_words(const svo_i_sight *sight)
{
    const size_t bytes = sight->tree != NULL    ? sizeof(svo_hit)
                         : has_triangles(sight) ? sizeof(svo_scene_triangle_hit)
                                                : sizeof(svo_scene_hit);
    return (uint32_t)(bytes / sizeof(cl_uint));
}

_Static_assert(sizeof(svo_hit) == sizeof(svo_voxel_hit) && offsetof(svo_hit, normal) == 4 * sizeof(cl_uint) &&
                   offsetof(svo_voxel_hit, normal) == 4 * sizeof(cl_uint) &&
                   offsetof(svo_scene_hit, normal) == 4 * sizeof(cl_uint) &&
                   offsetof(svo_scene_triangle_hit, normal) == 4 * sizeof(cl_uint),
               "hits have their normals in words 4 .. 6");

static svo_status trace(svo_probes *probes, cl_command_queue queue, cl_mem rays, cl_mem hits, size_t ray_count,
                        const cl_event *last, cl_event *done)
{
    const svo_i_sight sight = {probes->tree, probes->scene};
    const cl_uint num_wait = *last != NULL ? 1 : 0;
    const cl_event *wait = *last != NULL ? last : NULL;
    if (probes->tree != NULL) {
        return has_triangles(&sight) ? svo_tree_trace_enqueue(probes->tree, rays, hits, ray_count, SVO_TRACE_CLOSEST,
                                                              queue, num_wait, wait, done)
                                     : svo_tree_trace_voxels_enqueue(probes->tree, rays, hits, ray_count, 0.0F, queue,
                                                                     num_wait, wait, done);
    }
    return has_triangles(&sight) ? svo_scene_trace_triangles_enqueue(probes->scene, rays, hits, ray_count,
                                                                     SVO_SCENE_CLOSEST, queue, num_wait, wait, done)
                                 : svo_scene_trace_enqueue(probes->scene, rays, hits, ray_count, 0.0F,
                                                           SVO_SCENE_CLOSEST, queue, num_wait, wait, done);
}

svo_status svo_i_sight_trace(svo_probes *probes, svo_i_device_work *work, cl_mem rays, cl_mem hits, size_t ray_count)
{
    cl_event done = NULL;
    const svo_status status = trace(probes, work->queue, rays, hits, ray_count, &work->last, &done);
    if (status != SVO_OK) {
        svo_i_message_rename(svo_i_device_message(work->device), work->function);
        return status;
    }
    svo_i_work_follow(work, done);
    return SVO_OK;
}
