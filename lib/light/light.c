/* SPDX-License-Identifier: MIT */
/* The handle of a light: creation, description, hash, and its side of kernels. */
#include "light/light.h"

#include <math.h>
#include <stdio.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/opencl.h"
#include "core/struct_size.h"
#include "light/bricks.h"
#include "light/faces.h"
#include "light/kept_nodes.h"
#include "light/kept_photons.h"
#include "light/opacity.h"
#include "light/plan.h"
#include "light/setup.h"
#include "svocl/plan.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_cones[];

/* ---- names ---- */

const char *svo_light_form_name(svo_light_form form)
{
    static const char *const names[SVO_LIGHT_FORM_COUNT] = {"faces", "bricks", "voxels"};
    return (unsigned)form < SVO_LIGHT_FORM_COUNT ? names[form] : "unknown form";
}

const char *svo_light_buffer_name(svo_light_buffer buffer)
{
    static const char *const names[SVO_LIGHT_BUFFER_COUNT] = {"opacity", "cover", "lit", "radiance", "flux"};
    return (unsigned)buffer < SVO_LIGHT_BUFFER_COUNT ? names[buffer] : "unknown buffer";
}

const char *svo_light_stage_name(svo_light_stage stage)
{
    static const char *const names[SVO_LIGHT_STAGE_COUNT] = {"opacity", "opacity filter", "light view",
                                                             "photons", "exchange",       "radiance filter"};
    return (unsigned)stage < SVO_LIGHT_STAGE_COUNT ? names[stage] : "unknown stage";
}

/* ---- creation ---- */

static svo_status make_opacity(svo_i_device_work *work, svo_light *light)
{
    SVO_I_TRY(svo_i_work_use(work, SVO_I_PROGRAM_LIGHT, svo_i_light_defines(light)));
    switch (light->info.form) {
    case SVO_LIGHT_BRICKS:
        return svo_i_light_bricks(work, light);
    case SVO_LIGHT_VOXELS:
        return svo_i_light_voxels(work, light);
    default:
        return svo_i_light_faces(work, light);
    }
}

static svo_status make(svo_light *light, const char *function, cl_command_queue queue)
{
    svo_i_device_work work;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_begin(light->device, function, queue, &work));
    if (light->before != NULL && light->before->light->setup.asked.updatable != 0) {
        SVO_I_TRY_CLEANUP(svo_i_kept_nodes_begin(&work, light));
        SVO_I_TRY_CLEANUP(svo_i_work_use(&work, SVO_I_PROGRAM_LIGHT, svo_i_light_defines(light)));
        SVO_I_TRY_CLEANUP(svo_i_find_origins(&work, light));
    }
    SVO_I_TRY_CLEANUP(make_opacity(&work, light));

cleanup:
    svo_i_work_end(&work);
    return status;
}

/* SVO_LIGHT_FLAG_*, by what the tree holds. */
static uint32_t find_flags(const svo_tree_info *tree)
{
    const bool normals = (tree->need & SVO_NEED_NORMAL) != 0;
    const bool colors = (tree->need & SVO_NEED_COLOR) != 0;
    return (normals ? SVO_LIGHT_FLAG_NORMALS : 0) |
           (svo_i_tree_is_constant(tree, SVO_TREE_NORMALS) ? SVO_LIGHT_FLAG_ONE_NORMAL : 0) |
           (colors ? SVO_LIGHT_FLAG_COLORS : 0) |
           (svo_i_tree_is_constant(tree, SVO_TREE_COLORS) ? SVO_LIGHT_FLAG_ONE_COLOR : 0);
}

svo_status svo_i_light_create(svo_tree *tree, const char *function, const svo_light_options *options,
                              svo_i_light_before *before, cl_command_queue queue, svo_light **out)
{
    svo_light_options asked;
    svo_light_info info;
    SVO_I_TRY(svo_i_light_plan(tree, function, options, &asked, &info));
    if (tree->device == NULL) {
        return SVO_NOT_ON_DEVICE;
    }
    svo_light *light = svo_i_alloc_zeroed(&tree->device->memory, 1, sizeof *light);
    if (light == NULL) {
        return svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a light", function);
    }
    light->tree = tree;
    light->device = tree->device;
    light->before = before;
    light->info = info;
    light->options = asked;
    light->options.struct_size = sizeof light->options;
    light->params = (svo_light_params){
        .depth = tree->info.depth,
        .flags = find_flags(&tree->info),
        .voxel_edge = (float)ldexp(1.0 / tree->info.scale, (int)(tree->info.snap_bits - tree->info.depth))};
    const svo_status status = make(light, function, queue);
    if (status != SVO_OK) {
        svo_light_destroy(&light);
        return status;
    }
    *out = light;
    return SVO_OK;
}

svo_status svo_light_create(svo_tree *tree, const svo_light_options *options, cl_command_queue queue, svo_light **out)
{
    static const char function[] = "svo_light_create";
    return tree != NULL && out != NULL ? svo_i_light_create(tree, function, options, NULL, queue, out)
                                       : svo_i_device_fail(tree != NULL ? tree->device : NULL, SVO_INVALID_ARGUMENT,
                                                           "%s: %s is NULL", function, tree == NULL ? "tree" : "out");
}

void svo_light_destroy(svo_light **light)
{
    if (light == NULL || *light == NULL) {
        return;
    }
    for (svo_light_buffer i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        svo_i_light_release(*light, i);
    }
    svo_i_light_forget_setup(*light);
    svo_i_kept_destroy(&(*light)->kept);
    svo_i_kept_nodes_destroy(&(*light)->nodes);
    svo_i_free(*light);
    *light = NULL;
}

/* ---- description ---- */

svo_status svo_light_get_info(const svo_light *light, svo_light_info *info)
{
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    return svo_i_struct_write(svo_i_device_message(light->device), "svo_light_get_info", "info", &light->info, info,
                              SVO_I_STRUCT_SIZES(svo_light_info, kept_bytes));
}

cl_mem svo_light_get_buffer(const svo_light *light, svo_light_buffer buffer)
{
    return light != NULL && (unsigned)buffer < SVO_LIGHT_BUFFER_COUNT ? light->buffers[buffer] : NULL;
}

/* ---- hash ---- */

/* Adds a buffer's length and bytes to a hash. */
static svo_status hash_buffer(const svo_light *light, const char *function, cl_command_queue queue,
                              svo_light_buffer buffer, XXH3_state_t *state)
{
    const uint64_t bytes = light->info.bytes[buffer];
    XXH3_128bits_update(state, &bytes, sizeof bytes);
    if (bytes == 0) {
        return SVO_OK;
    }
    void *copy = svo_i_alloc(&light->device->memory, (size_t)bytes);
    if (copy == NULL) {
        return svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY, "%s: %s needs %llu bytes", function,
                                 svo_light_buffer_name(buffer), (unsigned long long)bytes);
    }
    const cl_int error =
        clEnqueueReadBuffer(queue, light->buffers[buffer], CL_TRUE, 0, (size_t)bytes, copy, 0, NULL, NULL);
    if (error == CL_SUCCESS) {
        XXH3_128bits_update(state, copy, (size_t)bytes);
    }
    svo_i_free(copy);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(light->device, function, "clEnqueueReadBuffer", error);
}

svo_status svo_light_hash(const svo_light *light, cl_command_queue queue, char text[SVO_HASH_TEXT_BYTES])
{
    static const char function[] = "svo_light_hash";
    XXH3_state_t stack;
    XXH3_state_t *state = &stack;
    if (light == NULL || text == NULL) {
        return svo_i_device_fail(light != NULL ? light->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 light == NULL ? "light" : "text");
    }
    SVO_I_TRY(svo_i_device_queue(light->device, function, queue, &queue));
    XXH3_INITSTATE(state);
    XXH3_128bits_reset(state);
    const uint32_t words[3] = {(uint32_t)light->info.form, (uint32_t)light->info.opacity, light->params.depth};
    XXH3_128bits_update(state, words, sizeof words);
    XXH3_128bits_update(state, &light->params.unit, sizeof light->params.unit);
    for (svo_light_buffer i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        SVO_I_TRY(hash_buffer(light, function, queue, i, state));
    }
    const XXH128_hash_t hash = XXH3_128bits_digest(state);
    (void)snprintf(text, SVO_HASH_TEXT_BYTES, "%016llx%016llx", (unsigned long long)hash.high64,
                   (unsigned long long)hash.low64);
    return SVO_OK;
}

/* ---- kernels ---- */

const char *svo_light_kernel_source(void)
{
    return svo_i_source_cones;
}

const char *svo_light_kernel_options(const svo_light *light)
{
    static const char *const options[SVO_LIGHT_FORM_COUNT] = {
        "-cl-std=CL1.2 -DSVO_LIGHT_FACES", "-cl-std=CL1.2 -DSVO_LIGHT_BRICKS", "-cl-std=CL1.2 -DSVO_LIGHT_VOXELS"};
    return light != NULL ? options[light->info.form] : "";
}

svo_status svo_light_set_args(svo_light *light, cl_kernel kernel, cl_uint first_index)
{
    static const char function[] = "svo_light_set_args";
    if (light == NULL || kernel == NULL) {
        return svo_i_device_fail(light != NULL ? light->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 light == NULL ? "light" : "kernel");
    }
    const char *wrong = svo_i_wrong_kernel(light->device->context, kernel);
    if (wrong != NULL) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: kernel %s", function, wrong);
    }
    return svo_i_light_set_args(light, function, kernel, first_index);
}
