/* SPDX-License-Identifier: MIT */
/* Light at batches of points, by cones, which rays/batch.c launches, and by rays; radiance along rays. */
#include "light/gather.h"

#include "core/struct_size.h"
#include "core/submit.h"
#include "light/emitters.h"
#include "light/programs.h"
#include "light/shader.h"
#include "rays/batch.h"
#include "rays/rays.h"

/* Rays that are no camera's. Source files have no defines of their own before what they include. */
#define LEAVES " -DSVO_LIT_LEAVES"
/* Rays of a work-item: SVO_SHADE_RAYS of the kernel. */
#define ITEM_RAYS 64u
/* Rays of a point, and of what a ray meets, to a source that has a size. */
#define POINT_SOURCE_RAYS_LOG2 6
#define SHADE_SOURCE_RAYS_LOG2 2

/* ---- batches of points: kernels/light/gather.cl ---- */

/* Sets the arguments that SVO_LIGHT_PARAMETERS of kernels/light/field.clh declares, from first_index on. */
static svo_status set_light(const svo_light *light, const char *function, cl_kernel kernel, cl_uint first_index)
{
    const svo_tree *tree = light->tree;
    svo_ray_params grid = {.depth = 0};
    SVO_I_TRY(svo_i_rays_tree_params(tree, function, &grid));
    const svo_i_argument arguments[SVO_LIGHT_ARGUMENTS] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                                           SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                                           SVO_I_ARGUMENT(tree->buffers[SVO_TREE_NORMALS]),
                                                           SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                                           SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]),
                                                           SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_LIT]),
                                                           SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_RADIANCE]),
                                                           SVO_I_ARGUMENT(light->sky_map),
                                                           SVO_I_ARGUMENT(grid),
                                                           SVO_I_ARGUMENT(light->params)};
    return svo_i_kernel_set_from(light->device, function, kernel, first_index, arguments, SVO_LIGHT_ARGUMENTS);
}

/* The checks of a batch need no more than a light. */
static svo_status check_target(void *of, const char *function)
{
    const svo_light *light = of;
    return svo_i_tree_check(light->tree, function);
}

svo_status svo_i_light_set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    const svo_light *light = of;
    if (light->options.no_cones != 0) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: the light was made with no_cones", function);
    }
    return set_light(of, function, kernel, first_index);
}

/* Cones that read the light alone. */
static svo_status gather_cones(svo_light *light, const svo_gather_params *params, const svo_array *points,
                               const svo_array *results, size_t point_count, const svo_submit *submit)
{
    const svo_i_batch asked = {.device = light->device,
                               .function = "svo_gather",
                               .target = {light, SVO_LIGHT_ARGUMENTS, check_target, svo_i_light_set_target},
                               .program = &svo_i_program_gather,
                               .kernel_name = "svo_k_gather",
                               .defines = svo_i_light_form_defines(light),
                               .input_name = "points",
                               .output_name = "results",
                               .input_bytes = sizeof(svo_gather_point),
                               .output_bytes = sizeof(svo_gather_result),
                               .count = point_count,
                               .last_argument = {sizeof *params, params, false}};
    return svo_i_batch_run(&asked, points, results, submit);
}

/* ---- points, with rays: kernels/light/gather_rays.cl ---- */

/* of_cones: what points by cones take. */
static const char *points_defines(const svo_light *light, const svo_gather_params *gather, const char *of_cones)
{
    const bool aims = light->emitters != NULL;
    if (gather->paths == 0) {
        return of_cones;
    }
    return light->aims_at_sky ? (aims ? LEAVES " -DSVO_EMITTERS -DSVO_SKY_AIMS" : LEAVES " -DSVO_SKY_AIMS")
                              : (aims ? LEAVES " -DSVO_EMITTERS" : LEAVES);
}

svo_status svo_i_light_points_begin(svo_i_device_work *work, const svo_light *light, const svo_gather_params *gather,
                                    svo_i_light_shader *out)
{
    return svo_i_light_shader_begin(work, light, &svo_i_program_gather_rays, "svo_k_gather_rays",
                                    points_defines(light, gather, LEAVES " -DSVO_GATHER_CONES"), out);
}

svo_status svo_i_light_points_also(const svo_i_light_shader *first, const svo_gather_params *gather,
                                   svo_i_light_shader *out)
{
    return svo_i_light_shader_also(first, &svo_i_program_gather_rays, "svo_k_gather_rays",
                                   points_defines(first->light, gather, LEAVES " -DSVO_GATHER_ERRORS"), out);
}

svo_status svo_i_light_points_set(const svo_i_light_shader *shader, const svo_gather_params *gather,
                                  uint32_t source_rays_log2, cl_mem points, cl_mem results, uint32_t point_count)
{
    const svo_i_argument own[] = {SVO_I_ARGUMENT(points), SVO_I_ARGUMENT(results)};
    svo_lit_picture_params params = svo_i_light_shader_params(shader->light, SVO_LIT_VIEW_MATTE);
    params.width = point_count;
    params.source_rays_log2 = source_rays_log2;
    return svo_i_light_shader_set(shader, gather, &params, SVO_I_ARGUMENTS(own));
}

static svo_status enqueue_points(const svo_light *light, const svo_gather_params *gather, cl_mem points, cl_mem results,
                                 uint32_t point_count, const svo_i_call *call)
{
    svo_i_device_work work;
    svo_i_light_shader shader = {.kernel = NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(call->device, call->function, call->queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_light_points_begin(&work, light, gather, &shader));
    SVO_I_TRY_CLEANUP(svo_i_light_points_set(&shader, gather, POINT_SOURCE_RAYS_LOG2, points, results, point_count));
    status = svo_i_call_launch(call, &(svo_i_launch){.kernel = shader.kernel,
                                                     .groups = ((size_t)point_count - 1) / SVO_GROUP_ITEMS + 1,
                                                     .group_items = SVO_GROUP_ITEMS});

cleanup:
    svo_i_light_shader_end(&shader);
    svo_i_work_leave(&work, NULL);
    return status;
}

/* Rays, or cones with direct light beside them. */
static svo_status gather_rays(const svo_light *light, const svo_gather_params *params, const svo_array *points,
                              const svo_array *results, size_t point_count, const svo_submit *submit)
{
    static const char function[] = "svo_gather";
    cl_mem from = NULL;
    cl_mem to = NULL;
    svo_i_call call;
    svo_status status = SVO_OK;
    if (point_count > SVO_TRACE_RAYS_MAX) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %zu points are above %u", function,
                                 point_count, SVO_TRACE_RAYS_MAX);
    }
    SVO_I_TRY(svo_i_call_begin(light->device, function, submit, &call));
    SVO_I_TRY_CLEANUP(svo_i_call_input(&call, "points", points, point_count * sizeof(svo_gather_point), &from));
    SVO_I_TRY_CLEANUP(svo_i_call_output(&call, "results", results, point_count * sizeof(svo_gather_result), 0,
                                        point_count * sizeof(svo_gather_result), &to));
    status = point_count > 0 ? enqueue_points(light, params, from, to, (uint32_t)point_count, &call)
                             : svo_i_call_none(&call);

cleanup:
    return svo_i_call_end(&call, status);
}

svo_status svo_gather(svo_light *light, svo_array points, svo_array results, size_t point_count,
                      const svo_gather_options *options, const svo_submit *submit)
{
    svo_gather_params params;
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_light_read_gather(light, "svo_gather", "options", options, SVO_GATHER_RAYS, false, &params));
    SVO_I_TRY(svo_i_tree_check(light->tree, "svo_gather"));
    SVO_I_TRY(svo_i_light_list_emitters(light, "svo_gather", &params, submit));
    const bool has_direct = params.with_light != 0 && light->setup.source_count > 0;
    return params.paths != 0 || has_direct ? gather_rays(light, &params, &points, &results, point_count, submit)
                                           : gather_cones(light, &params, &points, &results, point_count, submit);
}

/* ---- radiance along rays: kernels/light/shade.cl ---- */

static svo_status read_cones(const svo_light *light, const char *function, uint32_t cones, svo_gather_params *out)
{
    const svo_gather_options options = {.struct_size = sizeof options, .cones = cones};
    return svo_i_light_read_gather(light, function, "options", &options, SVO_GATHER_CONES, false, out);
}

svo_status svo_i_light_check_cones(const svo_light *light, const char *function, uint32_t cones)
{
    svo_gather_params unused;
    return read_cones(light, function, cones, &unused);
}

svo_status svo_i_light_shade_begin(svo_i_device_work *work, const svo_light *light, uint32_t cones,
                                   svo_i_light_shade *out)
{
    *out = (svo_i_light_shade){.shader = {.light = light}};
    SVO_I_TRY(read_cones(light, work->function, cones, &out->gather));
    return svo_i_light_shader_begin(work, light, &svo_i_program_light_shade, "svo_k_light_shade", LEAVES, &out->shader);
}

svo_status svo_i_light_shade_rays(const svo_i_light_shade *shade, cl_mem rays, cl_mem radiance, uint32_t ray_count)
{
    svo_lit_picture_params params = svo_i_light_shader_params(shade->shader.light, SVO_LIT_VIEW_MATTE);
    const svo_i_argument own[] = {SVO_I_ARGUMENT(rays), SVO_I_ARGUMENT(radiance)};
    const uint32_t group_rays = ITEM_RAYS * SVO_GROUP_ITEMS;
    params.width = ray_count;
    params.source_rays_log2 = SHADE_SOURCE_RAYS_LOG2;
    SVO_I_TRY(svo_i_light_shader_set(&shade->shader, &shade->gather, &params, SVO_I_ARGUMENTS(own)));
    return svo_i_light_shader_launch(&shade->shader, 0, ((size_t)ray_count + group_rays - 1) / group_rays);
}

void svo_i_light_shade_end(svo_i_light_shade *shade)
{
    svo_i_light_shader_end(&shade->shader);
}
