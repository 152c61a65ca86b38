/* SPDX-License-Identifier: MIT */
/* The host side of kernels/light/opacity.cl. */
#include "light/opacity.h"

#include "light/kept_nodes.h"

svo_status svo_i_light_leaves(svo_i_device_work *work, const svo_light *light, cl_mem opacities, cl_uint first)
{
    const cl_mem areas = svo_i_light_areas(light);
    svo_light_step params = svo_i_light_step(light, light->params.depth);
    params.first = first;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_COLORS]), SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(opacities), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_leaves", SVO_I_ARGUMENTS(arguments), params.count);
}

/* A level above the leaves. */
static svo_status filter_level(svo_i_device_work *work, const svo_light *light, uint32_t level)
{
    const cl_mem origins = svo_i_light_origins(light);
    const svo_light_step params = svo_i_light_step(light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(origins), SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_voxels", SVO_I_ARGUMENTS(arguments), params.count);
}

svo_status svo_i_light_voxels(svo_i_device_work *work, svo_light *light)
{
    const cl_uint leaf_begin = (cl_uint)light->tree->info.inner_count;
    double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_OPACITY));
    SVO_I_TRY(svo_i_keep_opacity(work, light, 1));
    SVO_I_TRY(svo_i_light_leaves(work, light, light->buffers[SVO_LIGHT_OPACITY], leaf_begin));
    SVO_I_TRY(svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY, start));
    start = svo_i_now_ms();
    for (uint32_t level = light->params.depth; level-- > 0;) {
        SVO_I_TRY(filter_level(work, light, level));
    }
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY_FILTER, start);
}
