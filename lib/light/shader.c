/* SPDX-License-Identifier: MIT */
/* The host side of kernels/light/surface.clh. */
#include "light/shader.h"

#include <stdio.h>
#include <string.h>

#include "light/gather.h"
#include "rays/rays.h"
#include "svocl/plan.h"

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

static svo_status make_kernel(svo_i_light_shader *shader, const svo_i_program *program, const char *kernel_name)
{
    const svo_light *light = shader->light;
    const svo_tree *tree = light->tree;
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    (void)snprintf(defines, sizeof defines, "%s%s", svo_i_gather_defines(light),
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

static uint64_t source_bytes(const svo_i_light_setup *setup)
{
    return setup->source_count * sizeof *setup->sources;
}

static uint64_t finish_bytes(const svo_i_light_setup *setup)
{
    return setup->finish_count * sizeof *setup->finishes;
}

uint64_t svo_i_light_shader_bytes(const svo_light *light)
{
    return source_bytes(&light->setup) + finish_bytes(&light->setup);
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
                                    const char *kernel_name, svo_i_light_shader *out)
{
    const svo_i_light_setup *setup = &light->setup;
    *out = (svo_i_light_shader){.light = light, .work = work};
    SVO_I_TRY(upload(work, "sources", setup->sources, source_bytes(setup), &out->sources));
    SVO_I_TRY(upload(work, "finishes", setup->finishes, finish_bytes(setup), &out->finishes));
    return make_kernel(out, program, kernel_name);
}

static svo_status set_arguments(const svo_i_light_shader *shader, const svo_gather_params *gather,
                                const svo_lit_picture_params *params, const svo_i_argument *own, cl_uint own_count)
{
    const svo_light *light = shader->light;
    const char *function = shader->work->function;
    svo_tree *tree = light->tree;
    const cl_uint first = SVO_TREE_ARGUMENTS + SVO_LIGHT_ARGUMENTS;
    const svo_i_argument shared[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]),
                                     SVO_I_ARGUMENT(tree->buffers[SVO_TREE_NORMALS]),
                                     SVO_I_ARGUMENT(tree->buffers[SVO_TREE_MATERIALS]),
                                     SVO_I_ARGUMENT(shader->finishes),
                                     SVO_I_ARGUMENT(shader->sources),
                                     {sizeof *gather, gather, false},
                                     {sizeof *params, params, false}};
    const cl_uint shared_count = sizeof shared / sizeof shared[0];
    SVO_I_TRY(svo_i_rays_set_tree(tree, function, shader->kernel, 0));
    SVO_I_TRY(svo_i_light_set_args(light, function, shader->kernel, SVO_TREE_ARGUMENTS));
    SVO_I_TRY(svo_i_kernel_set_from(light->device, function, shader->kernel, first, shared, shared_count));
    return svo_i_kernel_set_from(light->device, function, shader->kernel, first + shared_count, own, own_count);
}

svo_status svo_i_light_shader_launch(const svo_i_light_shader *shader, const svo_gather_params *gather,
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

void svo_i_light_shader_end(svo_i_light_shader *shader)
{
    if (shader->kernel != NULL) {
        clReleaseKernel(shader->kernel);
        shader->kernel = NULL;
    }
}

svo_lit_picture_params svo_i_light_shader_params(const svo_light *light, uint32_t view)
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
