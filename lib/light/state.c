/* SPDX-License-Identifier: MIT */
/* The buffers of a light, the arguments of its kernels and the times of its stages. */
#include "light/state.h"

#include "rays/rays.h"

const char *svo_i_light_defines(const svo_light *light)
{
    static const char *const area[SVO_LIGHT_FORM_COUNT] = {" -DSVO_SORT -DSVO_LIGHT_FACES -DSVO_LIGHT_AREA",
                                                           " -DSVO_SORT -DSVO_LIGHT_BRICKS -DSVO_LIGHT_AREA",
                                                           " -DSVO_SORT -DSVO_LIGHT_VOXELS -DSVO_LIGHT_AREA"};
    static const char *const full[SVO_LIGHT_FORM_COUNT] = {
        " -DSVO_SORT -DSVO_LIGHT_FACES", " -DSVO_SORT -DSVO_LIGHT_BRICKS", " -DSVO_SORT -DSVO_LIGHT_VOXELS"};
    return light->info.opacity == SVO_OPACITY_AREA ? area[light->info.form] : full[light->info.form];
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
    return svo_i_work_result(work, svo_light_buffer_name(buffer), light->info.bytes[buffer], &light->buffers[buffer]);
}

void svo_i_light_release(svo_light *light, svo_light_buffer buffer)
{
    svo_i_buffer_release(&light->buffers[buffer]);
    light->info.total_bytes -= light->info.bytes[buffer];
    light->info.bytes[buffer] = 0;
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

svo_status svo_i_light_set_args(const svo_light *light, const char *function, cl_kernel kernel, cl_uint first_index)
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
