/* SPDX-License-Identifier: MIT */
/* The host side of kernels/light/origins.cl, and copies of a tree's nodes. */
#include "light/kept_nodes.h"

#include "light/changes.h"

/* ---- what is kept ---- */

static svo_status copy_buffer(svo_i_device_work *work, const char *name, cl_mem from, uint64_t bytes, cl_mem *out)
{
    SVO_I_TRY(svo_i_work_result(work, name, bytes, out));
    return svo_i_work_copy(work, from, 0, *out, 0, bytes);
}

svo_status svo_i_kept_nodes_begin(svo_i_device_work *work, svo_light *light)
{
    const svo_tree *tree = light->tree;
    const uint64_t count = tree->info.inner_count;
    light->nodes = svo_i_alloc_zeroed(&light->device->memory, 1, sizeof *light->nodes);
    if (light->nodes == NULL) {
        return svo_i_device_fail(light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for kept nodes", work->function);
    }
    SVO_I_TRY(svo_i_kept_tree_read(work, tree, &light->nodes->tree));
    SVO_I_TRY(copy_buffer(work, "kept_masks", tree->buffers[SVO_TREE_CHILD_MASK], count, &light->nodes->masks));
    return copy_buffer(work, "kept_children", tree->buffers[SVO_TREE_FIRST_CHILD], count * sizeof(cl_uint),
                       &light->nodes->children);
}

uint64_t svo_i_kept_nodes_bytes(const svo_i_kept_nodes *nodes)
{
    return nodes == NULL ? 0
                         : svo_i_kept_buffer_bytes(nodes->masks) + svo_i_kept_buffer_bytes(nodes->children) +
                               svo_i_kept_buffer_bytes(nodes->opacities);
}

void svo_i_kept_nodes_destroy(svo_i_kept_nodes **nodes)
{
    if (*nodes != NULL) {
        svo_i_buffer_release(&(*nodes)->masks);
        svo_i_buffer_release(&(*nodes)->children);
        svo_i_buffer_release(&(*nodes)->opacities);
        svo_i_free(*nodes);
        *nodes = NULL;
    }
}

/* ---- origins ---- */

static svo_status find_level(svo_i_device_work *work, const svo_light *light, cl_mem boxes, cl_mem codes,
                             uint32_t level)
{
    const svo_i_light_before *before = light->before;
    const svo_i_kept_nodes *old = before->light->nodes;
    const svo_light_step params = svo_i_light_step(light, level);
    const cl_uint box_count = (cl_uint)before->changes.count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(light->tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        SVO_I_ARGUMENT(old->masks),
                                        SVO_I_ARGUMENT(old->children),
                                        SVO_I_ARGUMENT(boxes),
                                        SVO_I_ARGUMENT(box_count),
                                        SVO_I_ARGUMENT(codes),
                                        SVO_I_ARGUMENT(before->origins),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_origins", SVO_I_ARGUMENTS(arguments), params.count);
}

svo_status svo_i_find_origins(svo_i_device_work *work, svo_light *light)
{
    svo_i_light_before *before = light->before;
    const uint64_t count = light->tree->info.inner_count;
    cl_mem boxes = NULL;
    cl_mem codes = NULL;
    if (before->light->nodes == NULL || !svo_i_kept_tree_is_same(&before->light->nodes->tree, &light->nodes->tree)) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(work, "light_origins", count * sizeof(cl_uint), &before->origins));
    SVO_I_TRY(svo_i_work_alloc(work, "light_origin_codes", count * sizeof(cl_ulong), &codes));
    SVO_I_TRY(svo_i_changes_upload(work, light->tree, &before->changes, &boxes));
    for (uint32_t level = 0; level < light->params.depth; ++level) {
        SVO_I_TRY(find_level(work, light, boxes, codes, level));
    }
    svo_i_work_free(work, &codes);
    svo_i_work_free(work, &boxes);
    return SVO_OK;
}

cl_mem svo_i_light_origins(const svo_light *light)
{
    return light->before != NULL ? light->before->origins : NULL;
}

svo_status svo_i_keep_nodes(svo_i_device_work *work, const svo_light *light, cl_mem from, cl_mem to, cl_uint elements)
{
    const cl_mem origins = svo_i_light_origins(light);
    svo_light_step params = svo_i_light_step(light, 0);
    if (origins == NULL) {
        return SVO_OK;
    }
    params.count = (cl_uint)light->tree->info.inner_count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(origins), SVO_I_ARGUMENT(from), SVO_I_ARGUMENT(to),
                                        SVO_I_ARGUMENT(elements), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_light_keep", SVO_I_ARGUMENTS(arguments), params.count);
}

svo_status svo_i_keep_opacity(svo_i_device_work *work, const svo_light *light, cl_uint elements)
{
    const cl_mem from = svo_i_light_origins(light) != NULL ? light->before->light->buffers[SVO_LIGHT_OPACITY] : NULL;
    return svo_i_keep_nodes(work, light, from, light->buffers[SVO_LIGHT_OPACITY], elements);
}
