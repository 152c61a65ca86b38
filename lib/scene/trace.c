/* SPDX-License-Identifier: MIT */
/* Batches of rays against the voxels or the triangles of a scene: launches kernels/scene/trace.cl. */
#include <math.h>
#include <stdio.h>

#include "rays/batch.h"
#include "scene/programs.h"
#include "scene/state.h"
#include "svocl/plan.h"

#define FLAGS_MAX ((uint32_t)SVO_SCENE_ANY | (uint32_t)SVO_SCENE_EVERY_INSTANCE)
_Static_assert((uint32_t)SVO_SCENE_ANY == 1 && (uint32_t)SVO_SCENE_EVERY_INSTANCE == 2,
               "svo_scene_flags and kernels/scene/scene.clh number the flags alike");

/* What a batch is traced against. */
typedef struct scene_target {
    const svo_scene *scene;
    svo_scene_params params;
    bool triangles;
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
} scene_target;

static svo_status check_target(void *of, const char *function)
{
    const scene_target *target = of;
    svo_device *device = target->scene->device;
    SVO_I_TRY(svo_i_scene_check(target->scene, function));
    if (target->triangles && (target->scene->info.need & SVO_NEED_RAYS) == 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: the scene holds no triangles; create it with SVO_NEED_RAYS", function);
    }
    if (target->params.flags > FLAGS_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: flags %u is not in 0 .. %u", function,
                                 target->params.flags, FLAGS_MAX);
    }
    if (!(target->params.footprint >= 0.0F) || !isfinite(target->params.footprint)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: footprint %g is negative or not finite", function,
                                 (double)target->params.footprint);
    }
    return SVO_OK;
}

static svo_status set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    const scene_target *target = of;
    return svo_i_scene_set_args(target->scene, function, kernel, first_index, &target->params);
}

/* *of lives as long as the batch. */
static svo_i_batch describe(const svo_scene *scene, const char *function, size_t ray_count, float footprint,
                            uint32_t flags, scene_target *of)
{
    of->scene = scene;
    of->params = scene->params;
    of->params.footprint = footprint;
    of->params.flags = flags;
    (void)snprintf(of->defines, sizeof of->defines, "%s%s", scene->form, of->triangles ? " -DSVO_SCENE_TRIANGLES" : "");
    return (svo_i_batch){.device = scene->device,
                         .function = function,
                         .target = {of, svo_i_scene_arguments(scene), check_target, set_target},
                         .program = &svo_i_program_scene_trace,
                         .kernel_name = "svo_k_scene_trace",
                         .defines = of->defines,
                         .input_name = "rays",
                         .output_name = "hits",
                         .input_bytes = sizeof(svo_ray),
                         .output_bytes = of->triangles ? sizeof(svo_scene_triangle_hit) : sizeof(svo_scene_hit),
                         .count = ray_count,
                         .per_item = 1};
}

/* ---- voxels ---- */

svo_status svo_scene_trace_enqueue(svo_scene *scene, cl_mem rays, cl_mem hits, size_t ray_count, float footprint,
                                   uint32_t flags, cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                   cl_event *event)
{
    scene_target of = {.triangles = false};
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = describe(scene, "svo_scene_trace_enqueue", ray_count, footprint, flags, &of);
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_scene_trace(svo_scene *scene, const svo_ray *rays, svo_scene_hit *hits, size_t ray_count,
                           float footprint, uint32_t flags, cl_command_queue queue)
{
    scene_target of = {.triangles = false};
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = describe(scene, "svo_scene_trace", ray_count, footprint, flags, &of);
    return svo_i_batch_run(&asked, rays, hits, queue);
}

/* ---- triangles ---- */

svo_status svo_scene_trace_triangles_enqueue(svo_scene *scene, cl_mem rays, cl_mem hits, size_t ray_count,
                                             uint32_t flags, cl_command_queue queue, cl_uint num_wait,
                                             const cl_event *wait, cl_event *event)
{
    scene_target of = {.triangles = true};
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = describe(scene, "svo_scene_trace_triangles_enqueue", ray_count, 0.0F, flags, &of);
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_scene_trace_triangles(svo_scene *scene, const svo_ray *rays, svo_scene_triangle_hit *hits,
                                     size_t ray_count, uint32_t flags, cl_command_queue queue)
{
    scene_target of = {.triangles = true};
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = describe(scene, "svo_scene_trace_triangles", ray_count, 0.0F, flags, &of);
    return svo_i_batch_run(&asked, rays, hits, queue);
}
