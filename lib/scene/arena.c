/* SPDX-License-Identifier: MIT */
/* Copies what rays and pictures read of each tree into common buffers, so that one kernel can enter any of them. */
#include "scene/arena.h"

#include "scene/bounds.h"
#include "shared/bvh_layout.h"

/* ---- layout ---- */

/* The units in which svo_scene_tree counts: elements of the arrays; of the BVH's leaves 16 bytes. Nodes of compact
   trees begin with a whole ulong (kernels/rays/read_implied.clh). */
typedef struct array_layout {
    svo_i_scene_buffer buffer;
    uint32_t unit_bytes, alignment_bytes;
} array_layout;

static array_layout layout_of_nodes(const svo_i_scene_source *source, int k)
{
    const bool is_built = source->form[0] == '\0';
    const uint32_t unit = is_built && k == 0 ? 1 : 4;
    return (array_layout){(svo_i_scene_buffer)(SVO_I_SCENE_NODES_0 + k), unit, is_built || k > 0 ? unit : 8};
}

static const array_layout layout_of_colors = {SVO_I_SCENE_COLORS, 4, 4};
static const array_layout layout_of_normals = {SVO_I_SCENE_NORMALS, 6, 6};
static const array_layout layout_of_ray_nodes = {SVO_I_SCENE_RAY_NODES, sizeof(svo_ray_node), sizeof(svo_ray_node)};
static const array_layout layout_of_ray_leaves = {SVO_I_SCENE_RAY_LEAVES, 16, 16};

/* Lays an array out behind those of the trees before. */
static svo_status append(svo_i_arena *arena, svo_device *device, const char *function, array_layout layout,
                         svo_i_source_array array, SVO_U32 *begin)
{
    const uint64_t at = arena->bytes[layout.buffer] / layout.unit_bytes;
    if (array.buffer == NULL) {
        return SVO_OK;
    }
    if (at > UINT32_MAX || array.bytes / layout.unit_bytes > UINT32_MAX) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, "%s: the trees have more than %u nodes together", function,
                                 UINT32_MAX);
    }
    *begin = (uint32_t)at;
    arena->bytes[layout.buffer] +=
        (array.bytes + layout.alignment_bytes - 1) / layout.alignment_bytes * layout.alignment_bytes;
    return SVO_OK;
}

static svo_status place_tree(svo_i_arena *arena, svo_device *device, const char *function, uint32_t index)
{
    const svo_i_scene_source *source = &arena->sources[index];
    svo_scene_tree *place = &arena->places[index];
    arena->params[index] = source->params;
    for (int k = 0; k < 3; ++k) {
        SVO_I_TRY(append(arena, device, function, layout_of_nodes(source, k), source->nodes[k], &place->begin[k]));
    }
    place->flags = (source->colors.buffer != NULL ? SVO_SCENE_TREE_COLORS : 0) |
                   (source->one_color ? SVO_SCENE_TREE_ONE_COLOR : 0) |
                   (source->normals.buffer != NULL ? SVO_SCENE_TREE_NORMALS : 0) |
                   (source->one_normal ? SVO_SCENE_TREE_ONE_NORMAL : 0);
    SVO_I_TRY(append(arena, device, function, layout_of_colors, source->colors, &place->color_begin));
    SVO_I_TRY(append(arena, device, function, layout_of_normals, source->normals, &place->normal_begin));
    SVO_I_TRY(append(arena, device, function, layout_of_ray_nodes, source->ray_nodes, &place->node_begin));
    return append(arena, device, function, layout_of_ray_leaves, source->ray_leaves, &place->leaf_begin);
}

svo_status svo_i_arena_plan(svo_device *device, const char *function, const svo_scene_options *options,
                            svo_i_arena *out)
{
    *out = (svo_i_arena){.tree_count = options->tree_count};
    out->sources = svo_i_alloc_zeroed(&device->memory, options->tree_count, sizeof *out->sources);
    out->places = svo_i_alloc_zeroed(&device->memory, options->tree_count, sizeof *out->places);
    out->params = svo_i_alloc_zeroed(&device->memory, options->tree_count, sizeof *out->params);
    if (out->sources == NULL || out->places == NULL || out->params == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u trees", function,
                                 options->tree_count);
    }
    for (uint32_t i = 0; i < options->tree_count; ++i) {
        SVO_I_TRY(svo_i_scene_source_of(device, function, options, i, &out->sources[i]));
        SVO_I_TRY(place_tree(out, device, function, i));
    }
    out->bytes[SVO_I_SCENE_TREE_PARAMS] = options->tree_count * sizeof *out->params;
    out->bytes[SVO_I_SCENE_TREES] = options->tree_count * sizeof *out->places;
    out->bytes[SVO_I_SCENE_BOUNDS] = options->tree_count * SVO_I_BOUNDS_BYTES;
    return SVO_OK;
}

void svo_i_arena_free(svo_i_arena *arena)
{
    svo_i_free(arena->sources);
    svo_i_free(arena->places);
    svo_i_free(arena->params);
}

/* ---- copies ---- */

static svo_status copy(const svo_scene *scene, const char *function, cl_command_queue queue, svo_i_source_array from,
                       array_layout to, uint32_t begin)
{
    if (from.buffer == NULL || from.bytes == 0) {
        return SVO_OK;
    }
    const cl_int error = clEnqueueCopyBuffer(queue, from.buffer, scene->buffers[to.buffer], 0,
                                             (size_t)begin * to.unit_bytes, (size_t)from.bytes, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clEnqueueCopyBuffer", error);
}

static svo_status copy_tree(const svo_i_scene_source *source, const svo_scene_tree *place, const svo_scene *scene,
                            const char *function, cl_command_queue queue)
{
    for (int k = 0; k < 3; ++k) {
        SVO_I_TRY(copy(scene, function, queue, source->nodes[k], layout_of_nodes(source, k), place->begin[k]));
    }
    SVO_I_TRY(copy(scene, function, queue, source->colors, layout_of_colors, place->color_begin));
    SVO_I_TRY(copy(scene, function, queue, source->normals, layout_of_normals, place->normal_begin));
    SVO_I_TRY(copy(scene, function, queue, source->ray_nodes, layout_of_ray_nodes, place->node_begin));
    return copy(scene, function, queue, source->ray_leaves, layout_of_ray_leaves, place->leaf_begin);
}

static svo_status write_array(const svo_scene *scene, const char *function, cl_command_queue queue,
                              svo_i_scene_buffer to, uint64_t bytes, const void *array)
{
    const cl_int error =
        clEnqueueWriteBuffer(queue, scene->buffers[to], CL_TRUE, 0, (size_t)bytes, array, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clEnqueueWriteBuffer", error);
}

static svo_status enqueue_copies(const svo_i_arena *arena, const svo_scene *scene, const char *function,
                                 cl_command_queue queue)
{
    for (uint32_t i = 0; i < arena->tree_count; ++i) {
        SVO_I_TRY(copy_tree(&arena->sources[i], &arena->places[i], scene, function, queue));
    }
    return SVO_OK;
}

static svo_status copy_trees(const svo_i_arena *arena, const svo_scene *scene, const char *function,
                             cl_command_queue queue)
{
    const svo_status status = enqueue_copies(arena, scene, function, queue);
    const cl_int error = clFinish(queue); /* also after a failure: buffers may be released next */
    SVO_I_TRY(status);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clFinish", error);
}

svo_status svo_i_arena_fill(const svo_i_arena *arena, svo_scene *scene, const char *function, cl_command_queue queue)
{
    SVO_I_TRY(copy_trees(arena, scene, function, queue));
    SVO_I_TRY(write_array(scene, function, queue, SVO_I_SCENE_TREE_PARAMS, arena->bytes[SVO_I_SCENE_TREE_PARAMS],
                          arena->params));
    SVO_I_TRY(write_array(scene, function, queue, SVO_I_SCENE_TREES, arena->bytes[SVO_I_SCENE_TREES], arena->places));
    return svo_i_scene_find_bounds(scene, function, queue, arena->sources);
}
