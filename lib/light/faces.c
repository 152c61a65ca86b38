/* SPDX-License-Identifier: MIT */
/* The host side of kernels/light/faces.cl. Opacities are filtered where the extinctions lie at last. */
#include "light/faces.h"

static svo_status make_leaves(svo_i_device_work *work, const svo_light *light)
{
    const cl_mem areas = svo_i_light_areas(light);
    const svo_light_step params = svo_i_light_step(light, light->params.depth);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_COLORS]), SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_leaves", SVO_I_ARGUMENTS(arguments), params.count);
}

/* A level above the leaves. */
static svo_status filter_level(svo_i_device_work *work, const svo_light *light, uint32_t level)
{
    const svo_light_step params = svo_i_light_step(light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_level", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status take_logarithms(svo_i_device_work *work, const svo_light *light)
{
    svo_light_step params = svo_i_light_step(light, 0);
    params.count = (cl_uint)light->tree->info.node_count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_extinctions", SVO_I_ARGUMENTS(arguments),
                             6 * light->tree->info.node_count);
}

svo_status svo_i_light_faces(svo_i_device_work *work, svo_light *light)
{
    double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_OPACITY));
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_COVER));
    SVO_I_TRY(make_leaves(work, light));
    SVO_I_TRY(svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY, start));
    start = svo_i_now_ms();
    for (uint32_t level = light->params.depth; level-- > 0;) {
        SVO_I_TRY(filter_level(work, light, level));
    }
    SVO_I_TRY(take_logarithms(work, light));
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY_FILTER, start);
}
