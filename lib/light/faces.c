/* SPDX-License-Identifier: MIT */
/* The host side of kernels/light/faces.cl. Opacities are filtered where the extinctions lie at last; of a changed tree,
   beside them. */
#include "light/faces.h"

#include "light/kept_nodes.h"

/* ---- from nothing ---- */

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

/* The opacities of inner nodes, for the next update. */
static svo_status keep_opacities(svo_i_device_work *work, const svo_light *light)
{
    const uint64_t bytes = light->tree->info.inner_count * 6 * sizeof(cl_ushort);
    return light->nodes != NULL
               ? svo_i_work_copy(work, light->buffers[SVO_LIGHT_OPACITY], 0, light->nodes->opacities, 0, bytes)
               : SVO_OK;
}

static svo_status filter_all(svo_i_device_work *work, const svo_light *light)
{
    for (uint32_t level = light->params.depth; level-- > 0;) {
        SVO_I_TRY(filter_level(work, light, level));
    }
    SVO_I_TRY(keep_opacities(work, light));
    return take_logarithms(work, light);
}

/* ---- of a changed tree ---- */

static svo_status make_leaves_again(svo_i_device_work *work, const svo_light *light)
{
    const cl_mem areas = svo_i_light_areas(light);
    const cl_mem origins = svo_i_light_origins(light);
    const svo_light *old = light->before->light;
    const svo_light_step params = svo_i_light_step(light, light->params.depth - 1);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(origins),
                                        SVO_I_ARGUMENT(old->nodes->children),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(old->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(old->buffers[SVO_LIGHT_COVER]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_leaves_again", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status filter_level_again(svo_i_device_work *work, const svo_light *light, uint32_t level)
{
    const cl_mem areas = svo_i_light_areas(light);
    const cl_mem origins = svo_i_light_origins(light);
    const svo_light_step params = svo_i_light_step(light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(origins),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_COLORS]),
                                        SVO_I_ARGUMENT(areas),
                                        SVO_I_ARGUMENT(light->nodes->opacities),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_COVER]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_face_level_again", SVO_I_ARGUMENTS(arguments), params.count);
}

static svo_status filter_all_again(svo_i_device_work *work, const svo_light *light)
{
    const svo_light *old = light->before->light;
    SVO_I_TRY(svo_i_keep_opacity(work, light, 6));
    SVO_I_TRY(svo_i_keep_nodes(work, light, old->buffers[SVO_LIGHT_COVER], light->buffers[SVO_LIGHT_COVER], 6));
    SVO_I_TRY(svo_i_keep_nodes(work, light, old->nodes->opacities, light->nodes->opacities, 6));
    for (uint32_t level = light->params.depth; level-- > 0;) {
        SVO_I_TRY(filter_level_again(work, light, level));
    }
    return SVO_OK;
}

/* ---- both ---- */

static svo_status make_buffers(svo_i_device_work *work, svo_light *light)
{
    const uint64_t bytes = light->tree->info.inner_count * 6 * sizeof(cl_ushort);
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_OPACITY));
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_COVER));
    return light->nodes != NULL ? svo_i_work_result(work, "kept_opacities", bytes, &light->nodes->opacities) : SVO_OK;
}

svo_status svo_i_light_faces(svo_i_device_work *work, svo_light *light)
{
    const bool again = svo_i_light_origins(light) != NULL;
    double start = svo_i_now_ms();
    SVO_I_TRY(make_buffers(work, light));
    SVO_I_TRY(again ? make_leaves_again(work, light) : make_leaves(work, light));
    SVO_I_TRY(svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY, start));
    start = svo_i_now_ms();
    SVO_I_TRY(again ? filter_all_again(work, light) : filter_all(work, light));
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY_FILTER, start);
}
