/* SPDX-License-Identifier: MIT */
/* Copies what rays and pictures read of each tree into common buffers, so that one kernel can enter any of them. */
#include "scene/arena.h"

#include <stdlib.h>

#include "core/tree.h"
#include "rays/bounds.h"
#include "rays/rays.h"
#include "svocl/plan.h"

/* Reads beyond a BVH's leaf stay inside its own padding; leaves are counted in units of 16 bytes. */
#define LEAF_UNIT_BYTES 16u

/* ---- layout ---- */

static uint64_t round_up(uint64_t bytes, uint64_t unit)
{
    return (bytes + unit - 1) / unit * unit;
}

static svo_status check_tree(svo_device *device, const char *function, svo_tree *tree, uint32_t index, uint32_t need)
{
    if (tree == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: trees[%u] is NULL", function, index);
    }
    const char *undefined = svo_i_tree_undefined(tree);
    if (undefined != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: trees[%u]: %s", function, index, undefined);
    }
    if (tree->device != device || tree->buffers[SVO_TREE_CHILD_MASK] == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: trees[%u] is not on the scene's device", function,
                                 index);
    }
    if ((need & SVO_NEED_RAYS) != 0 &&
        ((tree->info.need & SVO_NEED_RAYS) == 0 || tree->info.coverage == SVO_COVERAGE_THIN)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: trees[%u] has no leaf lists for SVO_NEED_RAYS, or its coverage is thin", function,
                                 index);
    }
    return SVO_OK;
}

/* Whether the scene takes this payload of the tree: pictures show nodes of all levels. */
static bool takes(const svo_i_arena *arena, const svo_tree *tree, svo_tree_buffer buffer, svo_need need)
{
    return (arena->need & (uint32_t)need) != 0 && tree->buffers[buffer] != NULL &&
           (tree->info.payload_level == 0 || svo_i_tree_is_constant(&tree->info, buffer));
}

/* Lays an array out behind those of the trees before. *begin: in units of so many bytes. */
static svo_status append(svo_i_arena *arena, svo_device *device, const char *function, svo_i_scene_buffer buffer,
                         uint64_t bytes, uint32_t unit, uint32_t *begin)
{
    const uint64_t at = arena->bytes[buffer] / unit;
    if (at > UINT32_MAX || bytes / unit > UINT32_MAX) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, "%s: the trees have more than %u nodes together", function,
                                 UINT32_MAX);
    }
    *begin = (uint32_t)at;
    arena->bytes[buffer] += round_up(bytes, unit);
    return SVO_OK;
}

static uint64_t payload_bytes(const svo_tree *tree, svo_tree_buffer buffer)
{
    return svo_i_tree_element_count(&tree->info, buffer) * svo_i_tree_element_bytes(buffer);
}

static svo_status place_payload(svo_i_arena *arena, svo_device *device, const char *function, const svo_tree *tree,
                                svo_scene_tree *place)
{
    if (takes(arena, tree, SVO_TREE_COLORS, SVO_NEED_COLOR)) {
        place->flags |= SVO_SCENE_TREE_COLORS;
        place->flags |= svo_i_tree_is_constant(&tree->info, SVO_TREE_COLORS) ? SVO_SCENE_TREE_ONE_COLOR : 0;
        SVO_I_TRY(append(arena, device, function, SVO_I_SCENE_COLORS, payload_bytes(tree, SVO_TREE_COLORS), 4,
                         &place->color_begin));
    }
    if (takes(arena, tree, SVO_TREE_NORMALS, SVO_NEED_NORMAL)) {
        place->flags |= SVO_SCENE_TREE_NORMALS;
        place->flags |= svo_i_tree_is_constant(&tree->info, SVO_TREE_NORMALS) ? SVO_SCENE_TREE_ONE_NORMAL : 0;
        SVO_I_TRY(append(arena, device, function, SVO_I_SCENE_NORMALS, payload_bytes(tree, SVO_TREE_NORMALS), 6,
                         &place->normal_begin));
    }
    return SVO_OK;
}

static svo_status place_tree(svo_i_arena *arena, svo_device *device, const char *function, uint32_t index)
{
    svo_tree *tree = arena->trees[index];
    svo_scene_tree *place = &arena->places[index];
    uint32_t same = 0; /* entries of first_child begin where those of child_mask do */
    SVO_I_TRY(check_tree(device, function, tree, index, arena->need));
    if ((arena->need & SVO_NEED_RAYS) != 0) {
        SVO_I_TRY(svo_i_rays_prepare(tree, function, NULL));
        const svo_i_ray_buffers bvh = svo_i_rays_buffers(tree);
        SVO_I_TRY(append(arena, device, function, SVO_I_SCENE_RAY_NODES, bvh.node_bytes, sizeof(svo_ray_node),
                         &place->node_begin));
        SVO_I_TRY(append(arena, device, function, SVO_I_SCENE_RAY_LEAVES, bvh.leaf_bytes, LEAF_UNIT_BYTES,
                         &place->leaf_begin));
    }
    SVO_I_TRY(svo_i_rays_params(tree, function, &arena->params[index]));
    SVO_I_TRY(append(arena, device, function, SVO_I_SCENE_CHILD_MASK, tree->info.inner_count, 1, &place->inner_begin));
    SVO_I_TRY(append(arena, device, function, SVO_I_SCENE_FIRST_CHILD, tree->info.inner_count * 4, 4, &same));
    return place_payload(arena, device, function, tree, place);
}

svo_status svo_i_arena_plan(svo_device *device, const char *function, const svo_scene_options *options,
                            svo_i_arena *out)
{
    *out = (svo_i_arena){.trees = options->trees, .tree_count = options->tree_count, .need = options->need};
    out->places = calloc(options->tree_count, sizeof *out->places);
    out->params = calloc(options->tree_count, sizeof *out->params);
    if (out->places == NULL || out->params == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u trees", function,
                                 options->tree_count);
    }
    for (uint32_t i = 0; i < options->tree_count; ++i) {
        SVO_I_TRY(place_tree(out, device, function, i));
    }
    out->bytes[SVO_I_SCENE_TREE_PARAMS] = options->tree_count * sizeof *out->params;
    out->bytes[SVO_I_SCENE_TREES] = options->tree_count * sizeof *out->places;
    return SVO_OK;
}

void svo_i_arena_free(svo_i_arena *arena)
{
    free(arena->places);
    free(arena->params);
}

/* ---- copies ---- */

static svo_status copy(const svo_scene *scene, const char *function, cl_command_queue queue, cl_mem from,
                       svo_i_scene_buffer to, uint64_t offset, uint64_t bytes)
{
    const cl_int error = bytes > 0 ? clEnqueueCopyBuffer(queue, from, scene->buffers[to], 0, (size_t)offset,
                                                         (size_t)bytes, 0, NULL, NULL)
                                   : CL_SUCCESS;
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clEnqueueCopyBuffer", error);
}

static svo_status copy_tree(const svo_i_arena *arena, const svo_scene *scene, const char *function,
                            cl_command_queue queue, uint32_t index)
{
    const svo_tree *tree = arena->trees[index];
    const svo_scene_tree *place = &arena->places[index];
    const uint64_t inner = tree->info.inner_count;
    SVO_I_TRY(copy(scene, function, queue, tree->buffers[SVO_TREE_CHILD_MASK], SVO_I_SCENE_CHILD_MASK,
                   place->inner_begin, inner));
    SVO_I_TRY(copy(scene, function, queue, tree->buffers[SVO_TREE_FIRST_CHILD], SVO_I_SCENE_FIRST_CHILD,
                   (uint64_t)place->inner_begin * 4, inner * 4));
    if ((arena->need & SVO_NEED_RAYS) != 0) {
        const svo_i_ray_buffers bvh = svo_i_rays_buffers(tree);
        SVO_I_TRY(copy(scene, function, queue, bvh.nodes, SVO_I_SCENE_RAY_NODES,
                       place->node_begin * (uint64_t)sizeof(svo_ray_node), bvh.node_bytes));
        SVO_I_TRY(copy(scene, function, queue, bvh.leaves, SVO_I_SCENE_RAY_LEAVES,
                       (uint64_t)place->leaf_begin * LEAF_UNIT_BYTES, bvh.leaf_bytes));
    }
    if ((place->flags & SVO_SCENE_TREE_COLORS) != 0) {
        SVO_I_TRY(copy(scene, function, queue, tree->buffers[SVO_TREE_COLORS], SVO_I_SCENE_COLORS,
                       (uint64_t)place->color_begin * 4, payload_bytes(tree, SVO_TREE_COLORS)));
    }
    return (place->flags & SVO_SCENE_TREE_NORMALS) != 0
               ? copy(scene, function, queue, tree->buffers[SVO_TREE_NORMALS], SVO_I_SCENE_NORMALS,
                      (uint64_t)place->normal_begin * 6, payload_bytes(tree, SVO_TREE_NORMALS))
               : SVO_OK;
}

static svo_status write_array(const svo_scene *scene, const char *function, cl_command_queue queue,
                              svo_i_scene_buffer to, uint64_t bytes, const void *array)
{
    const cl_int error =
        clEnqueueWriteBuffer(queue, scene->buffers[to], CL_TRUE, 0, (size_t)bytes, array, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clEnqueueWriteBuffer", error);
}

/* ---- boxes ---- */

static svo_status read_nodes(const svo_tree *tree, const char *function, cl_command_queue queue, uint64_t count,
                             uint8_t *masks, uint32_t *first)
{
    cl_int error =
        clEnqueueReadBuffer(queue, tree->buffers[SVO_TREE_CHILD_MASK], CL_TRUE, 0, (size_t)count, masks, 0, NULL, NULL);
    if (error == CL_SUCCESS) {
        error = clEnqueueReadBuffer(queue, tree->buffers[SVO_TREE_FIRST_CHILD], CL_TRUE, 0, (size_t)count * 4, first, 0,
                                    NULL, NULL);
    }
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(tree->device, function, "clEnqueueReadBuffer", error);
}

/* The occupied part as the upper levels show it, enlarged by what the traversal of the tree may round. */
static void make_box(const svo_tree_info *info, const uint8_t *masks, const uint32_t *first, svo_i_scene_box *out)
{
    svo_i_cell_bounds bounds;
    svo_i_occupied_cells(info, masks, first, &bounds);
    const double width = (double)(UINT64_C(1) << info->snap_bits) / info->scale;
    const double margin = width * 0x1p-20;
    for (int axis = 0; axis < 3; ++axis) {
        out->low[axis] = info->origin[axis] + width * bounds.low[axis] / bounds.cells - margin;
        out->high[axis] = info->origin[axis] + width * bounds.high[axis] / bounds.cells + margin;
    }
}

static svo_status find_box(const svo_tree *tree, const char *function, cl_command_queue queue, svo_i_scene_box *out)
{
    const uint64_t count = svo_i_bounds_nodes(&tree->info);
    svo_status status = SVO_OK;
    uint8_t *masks = calloc((size_t)count + 1, sizeof *masks);
    uint32_t *first = calloc((size_t)count + 1, sizeof *first);
    if (masks == NULL || first == NULL) {
        status = svo_i_device_fail(tree->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu nodes", function,
                                   (unsigned long long)count);
        goto cleanup;
    }
    if (count > 0 && tree->info.leaf_count > 0) {
        SVO_I_TRY_CLEANUP(read_nodes(tree, function, queue, count, masks, first));
    }
    make_box(&tree->info, masks, first, out);

cleanup:
    free(masks);
    free(first);
    return status;
}

svo_status svo_i_arena_fill(const svo_i_arena *arena, svo_scene *scene, const char *function, cl_command_queue queue)
{
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < arena->tree_count && status == SVO_OK; ++i) {
        status = copy_tree(arena, scene, function, queue, i);
    }
    /* Also after a failure, since the trees are the caller's. */
    const cl_int error = clFinish(queue);
    SVO_I_TRY(status);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(scene->device, function, "clFinish", error);
    }
    for (uint32_t i = 0; i < arena->tree_count; ++i) {
        SVO_I_TRY(find_box(arena->trees[i], function, queue, &scene->tree_boxes[i]));
    }
    SVO_I_TRY(write_array(scene, function, queue, SVO_I_SCENE_TREE_PARAMS, arena->bytes[SVO_I_SCENE_TREE_PARAMS],
                          arena->params));
    return write_array(scene, function, queue, SVO_I_SCENE_TREES, arena->bytes[SVO_I_SCENE_TREES], arena->places);
}
