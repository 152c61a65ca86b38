/* SPDX-License-Identifier: MIT */
/* Options of gathering, and the kernels that shade surfaces of a lit tree (kernels/light/surface.clh). */
#include "light/shader.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/struct_size.h"
#include "rays/rays.h"
#include "rays/target.h"

#define CONES_DEFAULT 16u
#define STEP_DEFAULT  0.5F
#define STEP_MIN      0.25F
#define STEP_MAX      1.0F
#define PATHS_MIN     16u
#define PATHS_MAX     65536u
/* By default: of a point, and of 2 x 2 pixels. */
#define PATHS           64u
#define PICTURE_PATHS   16u
#define PICTURE_BOUNCES 3u
#define BOUNCES_MAX     64u

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

/* Cones need what they read. */
static svo_status check_has_cones(const svo_light *light, const char *function, const char *argument,
                                  svo_gather_method method)
{
    return method != SVO_GATHER_CONES || light->options.no_cones == 0
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                   "%s: %s.method is cones; the light was made with no_cones", function, argument);
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

svo_status svo_i_light_read_gather(const svo_light *light, const char *function, const char *argument,
                                   const svo_gather_options *options, svo_gather_method by_default, bool for_picture,
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
    SVO_I_TRY(check_has_cones(light, function, argument, method));
    *params = (svo_gather_params){.cones = asked.cones != 0 ? asked.cones : CONES_DEFAULT,
                                  .step = asked.step > 0.0F ? asked.step : STEP_DEFAULT,
                                  .range = asked.range,
                                  .falloff = asked.falloff,
                                  .with_light = asked.no_light == 0};
    if (method == SVO_GATHER_RAYS) {
        params->paths = asked.paths != 0 ? asked.paths : for_picture ? PICTURE_PATHS : PATHS;
        params->bounces = asked.bounces != 0 ? asked.bounces : for_picture ? PICTURE_BOUNCES : 1;
        params->goal = asked.error;
    }
    return SVO_OK;
}

const char *svo_i_light_options(const svo_light *light)
{
    static const char *const plain[SVO_LIGHT_FORM_COUNT] = {SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_FACES",
                                                            SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_BRICKS",
                                                            SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_VOXELS"};
    static const char *const mapped[SVO_LIGHT_FORM_COUNT] = {SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_FACES -DSVO_SKY_MAP",
                                                             SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_BRICKS -DSVO_SKY_MAP",
                                                             SVO_I_KERNEL_OPTIONS " -DSVO_LIGHT_VOXELS -DSVO_SKY_MAP"};
    return (light->sky_map != NULL ? mapped : plain)[light->info.form];
}

const char *svo_i_light_form_defines(const svo_light *light)
{
    return svo_i_light_options(light) + strlen(SVO_I_KERNEL_OPTIONS);
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
    (void)snprintf(defines, sizeof defines, "%s%s%s%s%s", svo_i_light_form_defines(light), own_defines,
                   svo_i_rays_of_triangles(&tree->info) ? " -DSVO_PICTURE_TRIANGLES" : "",
                   light->mesh.triangles != NULL ? " -DSVO_LIT_MESH" : "",
                   light->mesh.bends != NULL ? " -DSVO_NORMAL_MAPS" : "");
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

svo_status svo_i_light_shader_begin(svo_i_device_work *work, const svo_light *light, const svo_i_program *program,
                                    const char *kernel_name, const char *defines, svo_i_light_shader *out)
{
    const svo_i_light_setup *setup = &light->setup;
    *out = (svo_i_light_shader){.light = light, .work = work};
    SVO_I_TRY(upload(work, "sources", setup->sources, setup->source_count * sizeof *setup->sources, &out->sources));
    SVO_I_TRY(upload(work, "finishes", setup->finishes, setup->finish_count * sizeof *setup->finishes, &out->finishes));
    return make_kernel(out, program, kernel_name, defines);
}

svo_status svo_i_light_shader_also(const svo_i_light_shader *first, const svo_i_program *program,
                                   const char *kernel_name, const char *defines, svo_i_light_shader *out)
{
    *out = *first;
    out->kernel = NULL;
    return make_kernel(out, program, kernel_name, defines);
}

svo_status svo_i_light_shader_set(const svo_i_light_shader *shader, const svo_gather_params *gather,
                                  const svo_lit_picture_params *params, const svo_i_argument *own, cl_uint own_count)
{
    const svo_light *light = shader->light;
    const char *function = shader->work->function;
    svo_tree *tree = light->tree;
    const svo_i_argument shared[] = {SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                     SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]),
                                     SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_LIT]),
                                     SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_RADIANCE]),
                                     SVO_I_ARGUMENT(light->sky_map),
                                     SVO_I_ARGUMENT(light->params),
                                     SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]),
                                     SVO_I_ARGUMENT(tree->buffers[SVO_TREE_NORMALS]),
                                     SVO_I_ARGUMENT(tree->buffers[SVO_TREE_MATERIALS]),
                                     SVO_I_ARGUMENT(shader->finishes),
                                     SVO_I_ARGUMENT(shader->sources),
                                     SVO_I_ARGUMENT(light->emitters),
                                     SVO_I_ARGUMENT(light->mesh.triangles),
                                     SVO_I_ARGUMENT(light->mesh.materials),
                                     SVO_I_ARGUMENT(light->mesh.texels),
                                     SVO_I_ARGUMENT(light->mesh.bends),
                                     {sizeof *gather, gather, false},
                                     {sizeof *params, params, false}};
    const cl_uint shared_count = sizeof shared / sizeof shared[0];
    SVO_I_TRY(svo_i_rays_set_tree(tree, function, shader->kernel, 0));
    SVO_I_TRY(svo_i_kernel_set_from(light->device, function, shader->kernel, SVO_TREE_ARGUMENTS, shared, shared_count));
    return svo_i_kernel_set_from(light->device, function, shader->kernel, SVO_TREE_ARGUMENTS + shared_count, own,
                                 own_count);
}

svo_status svo_i_light_shader_launch(const svo_i_light_shader *shader, size_t first_group, size_t groups)
{
    const size_t local = SVO_GROUP_ITEMS;
    const size_t offset = first_group * local;
    const size_t global = groups * local;
    svo_i_device_work *work = shader->work;
    cl_event event = NULL;
    const cl_int error =
        clEnqueueNDRangeKernel(work->queue, shader->kernel, 1, &offset, &global, &local, work->last != NULL ? 1 : 0,
                               work->last != NULL ? &work->last : NULL, &event);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(work->device, work->function, "clEnqueueNDRangeKernel", error);
    }
    svo_i_work_follow(work, event);
    return SVO_OK;
}

void svo_i_light_shader_end(svo_i_light_shader *shader)
{
    if (shader->kernel != NULL) {
        clReleaseKernel(shader->kernel);
        shader->kernel = NULL;
    }
}

svo_lit_picture_params svo_i_light_shader_params(const svo_light *light, uint32_t view)
{
    return (svo_lit_picture_params){.view = view,
                                    .exposure = 1.0F,
                                    .source_count = (uint32_t)light->setup.source_count,
                                    .finish_count = (uint32_t)light->setup.finish_count,
                                    .emitter_count = light->emitter_count,
                                    .mesh_flags = light->mesh.flags};
}
