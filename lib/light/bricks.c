/* SPDX-License-Identifier: MIT */
/* The host side of kernels/light/bricks.cl. */
#include "light/bricks.h"

#include "light/kept_nodes.h"
#include "light/opacity.h"

svo_status svo_i_light_place(svo_i_device_work *work, const svo_light *light, cl_mem codes)
{
    for (uint32_t level = 0; level < light->params.depth; ++level) {
        const svo_light_step params = svo_i_light_step(light, level);
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                            SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                            SVO_I_ARGUMENT(codes), SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(work, "svo_k_light_place", SVO_I_ARGUMENTS(arguments), params.count));
    }
    return SVO_OK;
}

/* The bricks of the nodes above the leaves. */
static svo_status make_deepest(svo_i_device_work *work, const svo_light *light, cl_mem codes, cl_mem leaves)
{
    const cl_mem origins = svo_i_light_origins(light);
    const svo_light_step params = svo_i_light_step(light, light->params.depth - 1);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(codes),
                                        SVO_I_ARGUMENT(leaves),
                                        SVO_I_ARGUMENT(origins),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_brick_leaves", SVO_I_ARGUMENTS(arguments), params.count);
}

/* A level above. */
static svo_status filter_level(svo_i_device_work *work, const svo_light *light, cl_mem codes, uint32_t level)
{
    const cl_mem origins = svo_i_light_origins(light);
    const svo_light_step params = svo_i_light_step(light, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(codes),
                                        SVO_I_ARGUMENT(origins),
                                        SVO_I_ARGUMENT(light->buffers[SVO_LIGHT_OPACITY]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_brick_level", SVO_I_ARGUMENTS(arguments), params.count);
}

svo_status svo_i_light_bricks(svo_i_device_work *work, svo_light *light)
{
    const svo_tree_info *tree = &light->tree->info;
    cl_mem codes = NULL;
    cl_mem leaves = NULL;
    double start = svo_i_now_ms();
    SVO_I_TRY(svo_i_light_buffer(work, light, SVO_LIGHT_OPACITY));
    SVO_I_TRY(svo_i_work_alloc(work, "light_codes", tree->inner_count * sizeof(cl_ulong), &codes));
    SVO_I_TRY(svo_i_work_alloc(work, "light_leaves", tree->leaf_count * sizeof(cl_ushort), &leaves));
    SVO_I_TRY(svo_i_keep_opacity(work, light, SVO_BRICK_SAMPLES));
    SVO_I_TRY(svo_i_light_place(work, light, codes));
    SVO_I_TRY(svo_i_light_leaves(work, light, leaves, 0));
    SVO_I_TRY(make_deepest(work, light, codes, leaves));
    SVO_I_TRY(svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY, start));
    start = svo_i_now_ms();
    for (uint32_t level = tree->depth - 1; level-- > 0;) {
        SVO_I_TRY(filter_level(work, light, codes, level));
    }
    return svo_i_light_took(work, light, SVO_LIGHT_STAGE_OPACITY_FILTER, start);
}
