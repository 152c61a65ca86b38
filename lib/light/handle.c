/* SPDX-License-Identifier: MIT */
/* The handle of a light: names, buffers, levels, description, hash. */
#include "light/handle.h"

#include <stdio.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/struct_size.h"

/* ---- names ---- */

/* ---- buffers and levels ---- */

const char *svo_i_light_defines(const svo_light *light)
{
    static const char *const area[] = {" -DSVO_SORT -DSVO_LIGHT_FACES -DSVO_LIGHT_AREA",
                                       " -DSVO_SORT -DSVO_LIGHT_BRICKS -DSVO_LIGHT_AREA",
                                       " -DSVO_SORT -DSVO_LIGHT_VOXELS -DSVO_LIGHT_AREA",
                                       " -DSVO_SORT -DSVO_LIGHT_BRICKS -DSVO_LIGHT_AREA -DSVO_ONE_WORKER"};
    static const char *const full[] = {" -DSVO_SORT -DSVO_LIGHT_FACES", " -DSVO_SORT -DSVO_LIGHT_BRICKS",
                                       " -DSVO_SORT -DSVO_LIGHT_VOXELS",
                                       " -DSVO_SORT -DSVO_LIGHT_BRICKS -DSVO_ONE_WORKER"};
    const bool one_worker = light->info.form == SVO_LIGHT_BRICKS && light->device->cpu_path;
    const size_t form = one_worker ? SVO_LIGHT_FORM_COUNT : (size_t)light->info.form;
    return light->info.opacity == SVO_OPACITY_AREA ? area[form] : full[form];
}

svo_status svo_i_light_launch_bricks(svo_i_device_work *work, const char *name, const svo_i_argument *arguments,
                                     cl_uint argument_count, uint32_t bricks)
{
    return work->device->cpu_path
               ? svo_i_work_launch(work, name, arguments, argument_count - 1, bricks)
               : svo_i_work_launch(work, name, arguments, argument_count, (uint64_t)bricks * SVO_GROUP_ITEMS);
}

cl_mem svo_i_light_areas(const svo_light *light)
{
    return light->info.opacity == SVO_OPACITY_AREA ? light->tree->buffers[SVO_TREE_AREAS] : NULL;
}

svo_status svo_i_light_buffer(svo_i_device_work *work, svo_light *light, svo_light_buffer buffer)
{
    light->info.total_bytes = 0;
    for (svo_light_buffer i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        light->info.total_bytes += light->info.bytes[i];
    }
    return svo_i_work_result(work, svo_name(SVO_NAME_LIGHT_BUFFER, buffer), light->info.bytes[buffer],
                             &light->buffers[buffer]);
}

void svo_i_light_release(svo_light *light, svo_light_buffer buffer)
{
    svo_i_buffer_release(&light->buffers[buffer]);
    light->info.total_bytes -= light->info.bytes[buffer];
    light->info.bytes[buffer] = 0;
}

void svo_i_light_darken(svo_light *light)
{
    svo_i_light_release(light, SVO_LIGHT_LIT);
    svo_i_light_release(light, SVO_LIGHT_RADIANCE);
    light->params.flags &= ~(cl_uint)SVO_LIGHT_FLAG_LIT;
    light->params.unit = 0;
    light->info.lit_nodes = 0;
}

svo_light_step svo_i_light_step(const svo_light *light, uint32_t level)
{
    const svo_tree_info *tree = &light->tree->info;
    return (svo_light_step){.depth = tree->depth,
                            .leaf_begin = (cl_uint)tree->inner_count,
                            .first = tree->level_begin[level],
                            .count = tree->level_begin[level + 1] - tree->level_begin[level],
                            .level = level,
                            .flags = light->params.flags};
}

svo_status svo_i_light_took(svo_i_device_work *work, svo_light *light, svo_light_stage stage, double start_ms)
{
    SVO_I_TRY(svo_i_work_wait(work));
    light->info.stage_ms[stage] = svo_i_now_ms() - start_ms;
    return SVO_OK;
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
                                 svo_name(SVO_NAME_LIGHT_BUFFER, buffer), (unsigned long long)bytes);
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
