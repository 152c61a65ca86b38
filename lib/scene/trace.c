/* SPDX-License-Identifier: MIT */
/* Batches of rays against the voxels or the triangles of a scene: launches kernels/scene/trace.cl. */
#include <math.h>

#include "rays/batch.h"
#include "scene/state.h"
#include "svocl/plan.h"

_Static_assert(SVO_SCENE_ANY == 1 && SVO_SCENE_EVERY_INSTANCE == 2,
               "svo_scene_flags and kernels/scene/scene.clh number the flags alike");

/* What a batch launches. */
typedef struct scene_batch {
    const svo_scene *scene;
    const char *defines; /* of the program */
    svo_scene_params params;
} scene_batch;

static svo_status make_kernel(const svo_i_batch *asked, cl_mem input, cl_mem output, cl_kernel *out)
{
    const scene_batch *of = asked->user;
    cl_program program = NULL;
    SVO_I_TRY(
        svo_i_program_get(asked->device, asked->function, SVO_I_PROGRAM_SCENE_TRACE, of->defines, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(asked->device, asked->function, program, "svo_k_scene_trace", out));
    const svo_i_argument others[] = {SVO_I_ARGUMENT(input), SVO_I_ARGUMENT(output)};
    return svo_i_scene_set_args(of->scene, asked->function, *out, &of->params, SVO_I_ARGUMENTS(others));
}

/* Checks the arguments and describes the batch; *of and *out live as long as it. */
static svo_status prepare(const svo_scene *scene, const svo_i_batch *asked, float footprint, uint32_t flags,
                          scene_batch *of)
{
    SVO_I_TRY(svo_i_scene_check(scene, asked->function));
    if (flags > (SVO_SCENE_ANY | SVO_SCENE_EVERY_INSTANCE)) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT, "%s: flags %u is not in 0 .. %u", asked->function,
                                 flags, (unsigned)(SVO_SCENE_ANY | SVO_SCENE_EVERY_INSTANCE));
    }
    if (!(footprint >= 0.0F) || !isfinite(footprint)) {
        return svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT, "%s: footprint %g is not finite, or below 0",
                                 asked->function, (double)footprint);
    }
    of->scene = scene;
    of->params = scene->params;
    of->params.footprint = footprint;
    of->params.ray_count = (cl_uint)asked->count;
    of->params.flags = flags;
    return SVO_OK;
}

/* ---- voxels ---- */

static svo_i_batch voxel_batch(const svo_scene *scene, const char *function, size_t ray_count, scene_batch *of)
{
    of->defines = "";
    return (svo_i_batch){.function = function,
                         .device = scene->device,
                         .input_name = "rays",
                         .output_name = "hits",
                         .input_bytes = sizeof(svo_ray),
                         .output_bytes = sizeof(svo_scene_hit),
                         .count = ray_count,
                         .per_item = 1,
                         .make_kernel = make_kernel,
                         .user = of};
}

svo_status svo_scene_trace_enqueue(svo_scene *scene, cl_mem rays, cl_mem hits, size_t ray_count, float footprint,
                                   uint32_t flags, cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                   cl_event *event)
{
    scene_batch of;
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = voxel_batch(scene, "svo_scene_trace_enqueue", ray_count, &of);
    SVO_I_TRY(svo_i_batch_check(&asked, rays, hits));
    SVO_I_TRY(prepare(scene, &asked, footprint, flags, &of));
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_scene_trace(svo_scene *scene, const svo_ray *rays, svo_scene_hit *hits, size_t ray_count,
                           float footprint, uint32_t flags, cl_command_queue queue)
{
    scene_batch of;
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = voxel_batch(scene, "svo_scene_trace", ray_count, &of);
    SVO_I_TRY(svo_i_batch_check(&asked, rays, hits));
    SVO_I_TRY(prepare(scene, &asked, footprint, flags, &of));
    return svo_i_batch_run(&asked, rays, hits, queue);
}

/* ---- triangles ---- */

static svo_i_batch triangle_batch(const svo_scene *scene, const char *function, size_t ray_count, scene_batch *of)
{
    svo_i_batch batch = voxel_batch(scene, function, ray_count, of);
    batch.output_bytes = sizeof(svo_scene_triangle_hit);
    of->defines = " -DSVO_SCENE_TRIANGLES";
    return batch;
}

static svo_status check_triangles(const svo_scene *scene, const char *function)
{
    return (scene->info.need & SVO_NEED_RAYS) != 0
               ? SVO_OK
               : svo_i_device_fail(scene->device, SVO_INVALID_ARGUMENT,
                                   "%s: the scene holds no triangles; create it with SVO_NEED_RAYS", function);
}

svo_status svo_scene_trace_triangles_enqueue(svo_scene *scene, cl_mem rays, cl_mem hits, size_t ray_count,
                                             uint32_t flags, cl_command_queue queue, cl_uint num_wait,
                                             const cl_event *wait, cl_event *event)
{
    scene_batch of;
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = triangle_batch(scene, "svo_scene_trace_triangles_enqueue", ray_count, &of);
    SVO_I_TRY(svo_i_batch_check(&asked, rays, hits));
    SVO_I_TRY(check_triangles(scene, asked.function));
    SVO_I_TRY(prepare(scene, &asked, 0.0F, flags, &of));
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_scene_trace_triangles(svo_scene *scene, const svo_ray *rays, svo_scene_triangle_hit *hits,
                                     size_t ray_count, uint32_t flags, cl_command_queue queue)
{
    scene_batch of;
    if (scene == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = triangle_batch(scene, "svo_scene_trace_triangles", ray_count, &of);
    SVO_I_TRY(svo_i_batch_check(&asked, rays, hits));
    SVO_I_TRY(check_triangles(scene, asked.function));
    SVO_I_TRY(prepare(scene, &asked, 0.0F, flags, &of));
    return svo_i_batch_run(&asked, rays, hits, queue);
}
