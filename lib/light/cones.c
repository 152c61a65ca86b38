/* SPDX-License-Identifier: MIT */
/*
 * Gathering: options and checks; batches of points, by cones, which rays/batch.c launches, and by rays; and the kernels
 * that shade surfaces of a lit tree (kernels/light/surface.clh), along rays and in pictures.
 */
#include "light/cones.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/struct_size.h"
#include "core/submit.h"
#include "light/programs.h"
#include "rays/batch.h"
#include "rays/camera.h"
#include "rays/picture.h"
#include "rays/rays.h"
#include "rays/target.h"
#include "svocl/plan.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_cones[];

#define CONES_DEFAULT 16u
#define PATHS_MIN     16u
#define PATHS_MAX     65536u
#define PATHS_DEFAULT 64u
#define BOUNCES_MAX   64u
/* Paths of a launch, so that none takes long enough for a driver to end it. */
#define BAND_PATHS   1048576u
#define STEP_DEFAULT 0.5F
#define STEP_MIN     0.25F
#define STEP_MAX     1.0F

/* Rays of a work-item: SVO_SHADE_RAYS of the kernel. */
#define ITEM_RAYS 64u

/* svo_render_view and kernels/light/picture.cl number the views of light in the same order. */
#define AHEAD ((uint32_t)SVO_VIEW_AO - SVO_LIT_VIEW_AO)
_Static_assert((uint32_t)SVO_VIEW_DIRECT == AHEAD + SVO_LIT_VIEW_DIRECT &&
                   (uint32_t)SVO_VIEW_INDIRECT == AHEAD + SVO_LIT_VIEW_INDIRECT &&
                   (uint32_t)SVO_VIEW_SPECULAR == AHEAD + SVO_LIT_VIEW_SPECULAR,
               "views of light follow each other");

#define TILE_EDGE SVO_LIGHT_BAND_ROWS
/* Camera rays of a pixel. */
#define SAMPLES 4u
/* Tiles of a launch, so that none takes long enough for a driver to end it. */
#define BAND_TILES 256u

/* ---- options ---- */

static bool is_set_of_cones(uint32_t cones)
{
    return cones == 1 || cones == 5 || cones == 6 || cones == 16 || cones == 64;
}

static svo_status check_cones(const svo_light *light, const char *function, const char *argument,
                              const svo_gather_options *options)
{
    return options->cones == 0 || is_set_of_cones(options->cones)
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s.cones %u is not 1, 5, 6, 16 or 64",
                                   function, argument, options->cones);
}

static svo_status check_lengths(const svo_light *light, const char *function, const char *argument,
                                const svo_gather_options *options)
{
    const bool step = options->step >= STEP_MIN && options->step <= STEP_MAX;
    if (!step && options->step != 0.0F) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s.step %g is not in %g .. %g", function,
                                 argument, (double)options->step, (double)STEP_MIN, (double)STEP_MAX);
    }
    if (!(options->range >= 0.0F) || !isfinite(options->range)) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s.range %g is negative or not finite",
                                 function, argument, (double)options->range);
    }
    return options->falloff >= 0.0F && isfinite(options->falloff)
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s.falloff %g is negative or not finite",
                                   function, argument, (double)options->falloff);
}

static svo_status check_paths(const svo_light *light, const char *function, const char *argument,
                              const svo_gather_options *options)
{
    const bool is_power = (options->paths & (options->paths - 1)) == 0;
    if (options->paths != 0 && (!is_power || options->paths < PATHS_MIN || options->paths > PATHS_MAX)) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s.paths %u is no power of two in %u .. %u",
                                 function, argument, options->paths, PATHS_MIN, PATHS_MAX);
    }
    if (options->bounces > BOUNCES_MAX) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s.bounces %u is above %u", function,
                                 argument, options->bounces, BOUNCES_MAX);
    }
    return options->error >= 0.0F && isfinite(options->error)
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s.error %g is negative or not finite",
                                   function, argument, (double)options->error);
}

/* Whether the options are those of the method. */
static svo_status check_method(const svo_light *light, const char *function, const char *argument,
                               const svo_gather_options *options)
{
    const bool has_rays = options->paths != 0 || options->bounces != 0 || options->error != 0.0F;
    const bool has_cones = options->cones != 0 || options->step != 0.0F;
    if ((unsigned)options->method >= SVO_GATHER_METHOD_COUNT) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s.method %d is not in 0 .. %d", function,
                                 argument, (int)options->method, SVO_GATHER_METHOD_COUNT - 1);
    }
    if (options->method == SVO_GATHER_CONES ? has_rays
                                            : has_cones && (has_rays || options->method == SVO_GATHER_RAYS)) {
        return svo_i_device_fail(
            light->device, SVO_INVALID_ARGUMENT,
            "%s: %s names both cones (cones %u, step %g) and rays (paths %u, bounces %u, error %g)", function, argument,
            options->cones, (double)options->step, options->paths, options->bounces, (double)options->error);
    }
    return SVO_OK;
}

/* The options, checked, with the defaults for 0. by_default: the method of SVO_GATHER_AUTO without a number of cones. */
static svo_status read_gather(const svo_light *light, const char *function, const char *argument,
                              const svo_gather_options *options, svo_gather_method by_default,
                              svo_gather_params *params)
{
    svo_gather_options asked;
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(light->device), function, argument, options, &asked,
                                SVO_I_STRUCT_SIZES(svo_gather_options, no_light)));
    SVO_I_TRY(check_cones(light, function, argument, &asked));
    SVO_I_TRY(check_lengths(light, function, argument, &asked));
    SVO_I_TRY(check_paths(light, function, argument, &asked));
    SVO_I_TRY(check_method(light, function, argument, &asked));
    const bool has_cones = asked.cones != 0 || asked.step != 0.0F;
    const svo_gather_method method = asked.method != SVO_GATHER_AUTO ? asked.method
                                     : has_cones                     ? SVO_GATHER_CONES
                                                                     : by_default;
    *params = (svo_gather_params){.cones = asked.cones != 0 ? asked.cones : CONES_DEFAULT,
                                  .step = asked.step > 0.0F ? asked.step : STEP_DEFAULT,
                                  .range = asked.range,
                                  .falloff = asked.falloff,
                                  .with_light = asked.no_light == 0};
    if (method == SVO_GATHER_RAYS) {
        params->paths = asked.paths != 0 ? asked.paths : PATHS_DEFAULT;
        params->bounces = asked.bounces != 0 ? asked.bounces : 1;
        params->goal = asked.error;
    }
    return SVO_OK;
}

/* The define of the kernels that read the light's form. Static string. */
static const char *form_defines(const svo_light *light)
{
    static const char *const defines[SVO_LIGHT_FORM_COUNT] = {" -DSVO_LIGHT_FACES", " -DSVO_LIGHT_BRICKS",
                                                              " -DSVO_LIGHT_VOXELS"};
    return defines[light->info.form];
}

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
                                                           SVO_I_ARGUMENT(grid),
                                                           SVO_I_ARGUMENT(light->params)};
    return svo_i_kernel_set_from(light->device, function, kernel, first_index, arguments, SVO_LIGHT_ARGUMENTS);
}

/* ---- batches of points: kernels/light/gather.cl ---- */

/* The checks of a batch need no more than a light. */
static svo_status check_target(void *of, const char *function)
{
    const svo_light *light = of;
    return svo_i_tree_check(light->tree, function);
}

static svo_status set_target(void *of, const char *function, cl_kernel kernel, cl_uint first_index)
{
    return set_light(of, function, kernel, first_index);
}

/* Cones that read the light alone. */
static svo_status gather_cones(svo_light *light, const svo_gather_params *params, const svo_array *points,
                               const svo_array *results, size_t point_count, const svo_submit *submit)
{
    const svo_i_batch asked = {.device = light->device,
                               .function = "svo_gather",
                               .target = {light, SVO_LIGHT_ARGUMENTS, check_target, set_target},
                               .program = &svo_i_program_gather,
                               .kernel_name = "svo_k_gather",
                               .defines = form_defines(light),
                               .input_name = "points",
                               .output_name = "results",
                               .input_bytes = sizeof(svo_gather_point),
                               .output_bytes = sizeof(svo_gather_result),
                               .count = point_count,
                               .per_item = 1,
                               .last_argument = {sizeof *params, params, false}};
    return svo_i_batch_run(&asked, points, results, submit);
}

/* ---- kernels that shade ---- */

/* " -DSVO_x -DSVO_ONE_x" as far as the tree has that payload. */
static void add_define(const svo_tree *tree, svo_tree_buffer buffer, const char *held, const char *constant,
                       char *defines, size_t defines_bytes)
{
    if (tree->buffers[buffer] != NULL) {
        const size_t used = strlen(defines);
        (void)snprintf(defines + used, defines_bytes - used, "%s%s", held,
                       svo_i_tree_is_constant(&tree->info, buffer) ? constant : "");
    }
}

static svo_status make_kernel(svo_i_light_shader *shader, const svo_i_program *program, const char *kernel_name,
                              const char *own_defines)
{
    const svo_light *light = shader->light;
    const svo_tree *tree = light->tree;
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    (void)snprintf(defines, sizeof defines, "%s%s%s", form_defines(light), own_defines,
                   svo_i_rays_of_triangles(&tree->info) ? " -DSVO_PICTURE_TRIANGLES" : "");
    add_define(tree, SVO_TREE_COLORS, " -DSVO_COLOR", " -DSVO_ONE_COLOR", defines, sizeof defines);
    add_define(tree, SVO_TREE_NORMALS, " -DSVO_NORMAL", " -DSVO_ONE_NORMAL", defines, sizeof defines);
    if (light->setup.finish_count > 0) {
        add_define(tree, SVO_TREE_MATERIALS, " -DSVO_FINISHES", " -DSVO_ONE_MATERIAL", defines, sizeof defines);
    }
    SVO_I_TRY(svo_i_work_use(shader->work, program, defines));
    return svo_i_kernel_create(light->device, shader->work->function, shader->work->program, kernel_name,
                               &shader->kernel);
}

/* A buffer with a list of the setup; none for an empty list. */
static svo_status upload(svo_i_device_work *work, const char *name, const void *list, uint64_t bytes, cl_mem *out)
{
    if (bytes == 0) {
        return SVO_OK;
    }
    return svo_i_work_constants(work, name, list, bytes, out);
}

/* Makes the kernel, with more defines, and uploads what lights the tree. The work stays in use until end_shader. */
static svo_status begin_shader(svo_i_device_work *work, const svo_light *light, const svo_i_program *program,
                               const char *kernel_name, const char *defines, svo_i_light_shader *out)
{
    const svo_i_light_setup *setup = &light->setup;
    *out = (svo_i_light_shader){.light = light, .work = work};
    SVO_I_TRY(upload(work, "sources", setup->sources, setup->source_count * sizeof *setup->sources, &out->sources));
    SVO_I_TRY(upload(work, "finishes", setup->finishes, setup->finish_count * sizeof *setup->finishes, &out->finishes));
    return make_kernel(out, program, kernel_name, defines);
}

static svo_status set_arguments(const svo_i_light_shader *shader, const svo_gather_params *gather,
                                const svo_lit_picture_params *params, const svo_i_argument *own, cl_uint own_count)
{
    const svo_light *light = shader->light;
    const char *function = shader->work->function;
    svo_tree *tree = light->tree;
    const svo_i_argument shared[] = {SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                     SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]),
                                     SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_LIT]),
                                     SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_RADIANCE]),
                                     SVO_I_ARGUMENT(light->params),
                                     SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]),
                                     SVO_I_ARGUMENT(tree->buffers[SVO_TREE_NORMALS]),
                                     SVO_I_ARGUMENT(tree->buffers[SVO_TREE_MATERIALS]),
                                     SVO_I_ARGUMENT(shader->finishes),
                                     SVO_I_ARGUMENT(shader->sources),
                                     {sizeof *gather, gather, false},
                                     {sizeof *params, params, false}};
    const cl_uint shared_count = sizeof shared / sizeof shared[0];
    SVO_I_TRY(svo_i_rays_set_tree(tree, function, shader->kernel, 0));
    SVO_I_TRY(svo_i_kernel_set_from(light->device, function, shader->kernel, SVO_TREE_ARGUMENTS, shared, shared_count));
    return svo_i_kernel_set_from(light->device, function, shader->kernel, SVO_TREE_ARGUMENTS + shared_count, own,
                                 own_count);
}

/* Launches so many whole groups. own: the kernel's own arguments, own_count. */
static svo_status launch_shader(const svo_i_light_shader *shader, const svo_gather_params *gather,
                                const svo_lit_picture_params *params, const svo_i_argument *own, cl_uint own_count,
                                uint64_t groups)
{
    const size_t local = SVO_GROUP_ITEMS;
    const size_t global = (size_t)groups * local;
    svo_i_device_work *work = shader->work;
    cl_event event = NULL;
    SVO_I_TRY(set_arguments(shader, gather, params, own, own_count));
    const cl_int error =
        clEnqueueNDRangeKernel(work->queue, shader->kernel, 1, NULL, &global, &local, work->last != NULL ? 1 : 0,
                               work->last != NULL ? &work->last : NULL, &event);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(work->device, work->function, "clEnqueueNDRangeKernel", error);
    }
    svo_i_work_follow(work, event);
    return SVO_OK;
}

/* Releases the kernel, but not what the work owns. */
static void end_shader(svo_i_light_shader *shader)
{
    if (shader->kernel != NULL) {
        clReleaseKernel(shader->kernel);
        shader->kernel = NULL;
    }
}

/* What params have of a light: sky, numbers of sources and finishes. */
static svo_lit_picture_params shader_params(const svo_light *light, uint32_t view)
{
    svo_lit_picture_params params = {.view = view,
                                     .exposure = 1.0F,
                                     .source_count = (uint32_t)light->setup.source_count,
                                     .finish_count = (uint32_t)light->setup.finish_count};
    for (int channel = 0; channel < 3; ++channel) {
        params.sky[channel] = light->params.sky[channel];
    }
    return params;
}

/* ---- points, with rays: kernels/light/gather_rays.cl ---- */

/* Points of a launch: as many as have BAND_PATHS paths. */
static uint32_t points_of_band(const svo_gather_params *gather)
{
    const uint32_t points = BAND_PATHS / (gather->paths != 0 ? gather->paths : gather->cones);
    return points > SVO_GROUP_ITEMS ? points / SVO_GROUP_ITEMS * SVO_GROUP_ITEMS : SVO_GROUP_ITEMS;
}

static svo_status launch_points(const svo_i_light_shader *shader, const svo_gather_params *gather, cl_mem points,
                                cl_mem results, uint32_t point_count)
{
    const svo_i_argument own[] = {SVO_I_ARGUMENT(points), SVO_I_ARGUMENT(results)};
    const uint32_t band = points_of_band(gather);
    svo_lit_picture_params params = shader_params(shader->light, SVO_LIT_VIEW_MATTE);
    params.width = point_count;
    for (uint64_t first = 0; first < point_count; first += band) {
        const uint64_t count = point_count - first < band ? point_count - first : band;
        params.first_tile = (uint32_t)first;
        SVO_I_TRY(launch_shader(shader, gather, &params, SVO_I_ARGUMENTS(own),
                                (count + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS));
    }
    return SVO_OK;
}

static svo_status enqueue_points(const svo_light *light, const svo_gather_params *gather, cl_mem points, cl_mem results,
                                 uint32_t point_count, svo_i_call *call)
{
    svo_i_device_work work;
    svo_i_light_shader shader = {.kernel = NULL};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin_after(call->device, call->function, call->queue, call->num_wait, call->wait, &work));
    SVO_I_TRY_CLEANUP(begin_shader(&work, light, &svo_i_program_gather_rays, "svo_k_gather_rays",
                                   gather->paths == 0 ? " -DSVO_GATHER_CONES" : "", &shader));
    SVO_I_TRY_CLEANUP(launch_points(&shader, gather, points, results, point_count));

cleanup:
    end_shader(&shader);
    svo_i_work_leave(&work, status == SVO_OK ? call->event : NULL);
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
    SVO_I_TRY(svo_i_tree_check(light->tree, function));
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
    SVO_I_TRY(read_gather(light, "svo_gather", "options", options, SVO_GATHER_RAYS, &params));
    const bool has_direct = params.with_light != 0 && light->setup.source_count > 0;
    return params.paths != 0 || has_direct ? gather_rays(light, &params, &points, &results, point_count, submit)
                                           : gather_cones(light, &params, &points, &results, point_count, submit);
}

/* ---- radiance along rays: kernels/light/shade.cl ---- */

static svo_status read_cones(const svo_light *light, const char *function, uint32_t cones, svo_gather_params *out)
{
    const svo_gather_options options = {.struct_size = sizeof options, .cones = cones};
    return read_gather(light, function, "options", &options, SVO_GATHER_CONES, out);
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
    return begin_shader(work, light, &svo_i_program_light_shade, "svo_k_light_shade", "", &out->shader);
}

svo_status svo_i_light_shade_rays(const svo_i_light_shade *shade, cl_mem rays, cl_mem radiance, uint32_t ray_count)
{
    svo_lit_picture_params params = shader_params(shade->shader.light, SVO_LIT_VIEW_MATTE);
    const svo_i_argument own[] = {SVO_I_ARGUMENT(rays), SVO_I_ARGUMENT(radiance)};
    const uint32_t group_rays = ITEM_RAYS * SVO_GROUP_ITEMS;
    params.width = ray_count;
    return launch_shader(&shade->shader, &shade->gather, &params, SVO_I_ARGUMENTS(own),
                         ((uint64_t)ray_count + group_rays - 1) / group_rays);
}

void svo_i_light_shade_end(svo_i_light_shade *shade)
{
    end_shader(&shade->shader);
}

/* ---- pictures: kernels/light/picture.cl ---- */

static svo_status check_band(const svo_light *light, const char *function, const svo_render_options *options)
{
    if (options->first_row >= options->height || options->first_row % TILE_EDGE != 0) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: options.first_row %u is not a multiple of %u below height %u", function,
                                 options->first_row, TILE_EDGE, options->height);
    }
    return options->row_count % TILE_EDGE == 0 ? SVO_OK
                                               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                                                   "%s: options.row_count %u is not a multiple of %u",
                                                                   function, options->row_count, TILE_EDGE);
}

static svo_status check_exposure(const svo_light *light, const char *function, const svo_render_options *options)
{
    return options->exposure >= 0.0F && isfinite(options->exposure)
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                   "%s: options.exposure %g is negative or not finite", function,
                                   (double)options->exposure);
}

static svo_status fill_params(const svo_light *light, const char *function, const svo_render_options *options,
                              svo_lit_picture_params *params, svo_i_pixel_output *output)
{
    svo_i_pinhole hole;
    SVO_I_TRY(svo_i_pixel_output_of(light->device, function, &options->output, SAMPLES, SVO_I_CURVE_SRGB, output));
    SVO_I_TRY(
        svo_i_pinhole_from_camera(light->device, function, &options->camera, options->width, options->height, &hole));
    *params = shader_params(light, options->view == SVO_VIEW_SHADED ? SVO_LIT_VIEW_FULL : options->view - AHEAD);
    memcpy(params->clip, options->clip, sizeof params->clip);
    params->width = options->width;
    params->height = options->height;
    params->exposure = options->exposure > 0.0F ? options->exposure : 1.0F;
    params->samples = output->samples;
    params->pixel_flags = output->flags;
    for (int axis = 0; axis < 3; ++axis) {
        params->eye[axis] = options->camera.eye[axis];
        params->corner[axis] = hole.corner[axis];
        params->across[axis] = hole.across[axis];
        params->down[axis] = hole.down[axis];
        params->background[axis] = output->background[axis];
    }
    return SVO_OK;
}

/* The caller's options for what the view shows of them. */
static svo_status fill_gather(const svo_light *light, const char *function, const svo_render_options *options,
                              svo_gather_params *gather)
{
    SVO_I_TRY(read_gather(light, function, "options.gather", options->gather, SVO_GATHER_CONES, gather));
    if (gather->paths != 0) {
        return svo_i_device_fail(light->device, SVO_UNSUPPORTED, "%s: options.gather.method: pictures have cones alone",
                                 function);
    }
    if (options->view == SVO_VIEW_AO) {
        gather->with_light = 0;
    }
    return SVO_OK;
}

/* Rows of the picture's band. */
static uint32_t rows_of_band(const svo_render_options *options)
{
    const uint32_t below = options->height - options->first_row;
    return options->row_count == 0 || options->row_count > below ? below : options->row_count;
}

/* A picture that is about to be drawn. */
typedef struct drawing {
    const svo_light *light;
    svo_render_options asked;
    svo_lit_picture_params params;
    svo_gather_params gather;
    svo_i_pixel_output output;
} drawing;

static svo_status launch(const drawing *drawn, const svo_i_light_shader *shader, cl_mem pixels)
{
    const svo_render_options *options = &drawn->asked;
    const svo_i_argument own[] = {SVO_I_ARGUMENT(pixels)};
    const uint64_t across = (options->width + TILE_EDGE - 1) / TILE_EDGE;
    const uint64_t begin = across * (options->first_row / TILE_EDGE);
    const uint64_t end = begin + across * ((rows_of_band(options) + TILE_EDGE - 1) / TILE_EDGE);
    svo_lit_picture_params params = drawn->params;
    for (uint64_t first = begin; first < end; first += BAND_TILES) {
        params.first_tile = (uint32_t)first;
        SVO_I_TRY(launch_shader(shader, &drawn->gather, &params, SVO_I_ARGUMENTS(own),
                                end - first < BAND_TILES ? end - first : BAND_TILES));
    }
    return SVO_OK;
}

static svo_status enqueue(const drawing *drawn, const svo_array *to, svo_i_call *call)
{
    const svo_render_options *options = &drawn->asked;
    const size_t row_bytes = (size_t)options->width * drawn->output.pixel_bytes;
    svo_i_device_work work;
    svo_i_light_shader shader = {.kernel = NULL};
    cl_mem pixels = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_call_output(call, "pixels", to, row_bytes * options->height, row_bytes * options->first_row,
                                row_bytes * rows_of_band(options), &pixels));
    SVO_I_TRY(svo_i_work_begin_after(call->device, call->function, call->queue, call->num_wait, call->wait, &work));
    SVO_I_TRY_CLEANUP(
        begin_shader(&work, drawn->light, &svo_i_program_light_picture, "svo_k_light_picture", "", &shader));
    SVO_I_TRY_CLEANUP(launch(drawn, &shader, pixels));

cleanup:
    end_shader(&shader);
    svo_i_work_leave(&work, status == SVO_OK ? call->event : NULL);
    return status;
}

static svo_status render(void *of, const svo_render_options *options, const svo_array *pixels, const svo_submit *submit)
{
    static const char function[] = "svo_render";
    static const svo_i_picture_kind kind = {.name = "light",
                                            .views = 1u << SVO_VIEW_SHADED | 1u << SVO_VIEW_AO | 1u << SVO_VIEW_DIRECT |
                                                     1u << SVO_VIEW_INDIRECT | 1u << SVO_VIEW_SPECULAR,
                                            .view_names = "SVO_VIEW_SHADED, AO, DIRECT, INDIRECT and SPECULAR",
                                            .gathers = true};
    const svo_light *light = of;
    drawing drawn = {.light = light};
    svo_i_call call;
    SVO_I_TRY(svo_i_picture_options(light->device, function, &kind, options, &drawn.asked));
    SVO_I_TRY(svo_i_tree_check(light->tree, function));
    SVO_I_TRY(check_exposure(light, function, &drawn.asked));
    SVO_I_TRY(check_band(light, function, &drawn.asked));
    SVO_I_TRY(fill_params(light, function, &drawn.asked, &drawn.params, &drawn.output));
    SVO_I_TRY(fill_gather(light, function, &drawn.asked, &drawn.gather));
    SVO_I_TRY(svo_i_call_begin(light->device, function, submit, &call));
    return svo_i_call_end(&call, enqueue(&drawn, pixels, &call));
}

/* ---- the class ---- */

static svo_device *device_of(const void *light)
{
    return ((const svo_light *)light)->device;
}

static svo_status fit_camera(const void *light, float aspect, svo_camera *camera)
{
    return svo_i_tree_fit_camera(((const svo_light *)light)->tree, aspect, camera);
}

static const char *kernel_source(void)
{
    return svo_i_source_cones;
}

static const char *kernel_options(const void *of)
{
    static const char *const options[SVO_LIGHT_FORM_COUNT] = {SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_FACES",
                                                              SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_BRICKS",
                                                              SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_VOXELS"};
    const svo_light *light = of;
    return light != NULL ? options[light->info.form] : NULL;
}

static const struct svo_target_class light_class = {.name = "light",
                                                    .device = device_of,
                                                    .render = render,
                                                    .fit_camera = fit_camera,
                                                    .kernel_source = kernel_source,
                                                    .kernel_options = kernel_options,
                                                    .set_kernel_arguments = set_target};

svo_target svo_light_target(svo_light *light)
{
    return (svo_target){&light_class, light};
}
