/* SPDX-License-Identifier: MIT */
/*
 * Checks the trees of a scene and finds their arrays; copies what rays and pictures read of each into common buffers,
 * so that one kernel can enter any of them; finds the boxes of what they occupy by kernels/scene/bounds.cl.
 */
#include "scene/trees.h"

#include <limits.h>
#include <string.h>

#include "compact/form.h"
#include "core/compact.h"
#include "core/packed.h"
#include "core/staging.h"
#include "core/tree.h"
#include "rays/rays.h"
#include "scene/programs.h"
#include "shared/bvh_layout.h"
#include "svocl/plan.h"

/* The deepest level whose cells are looked at. */
#define BOUNDS_LEVEL_MAX 6u
/* Bounds of a tree, on the device. */
#define BOUNDS_BYTES (6 * sizeof(cl_int))

static double grid_width(uint32_t snap_bits, double scale)
{
    return (double)(UINT64_C(1) << snap_bits) / scale;
}

/* ---- built trees ---- */

static svo_status check_tree(svo_device *device, const char *function, const svo_tree *tree, uint32_t index,
                             uint32_t need)
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
    if ((need & SVO_NEED_RAYS) != 0 && !svo_i_rays_of_triangles(&tree->info)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: trees[%u] has no leaf lists for SVO_NEED_RAYS, or its coverage is thin", function,
                                 index);
    }
    return SVO_OK;
}

static svo_i_source_array array_of(const svo_tree *tree, svo_tree_buffer buffer)
{
    return (svo_i_source_array){tree->buffers[buffer],
                                svo_i_tree_element_count(&tree->info, buffer) * svo_i_tree_element_bytes(buffer)};
}

/* Payload that the scene takes: pictures show nodes of all levels. */
static svo_i_source_array payload_of(const svo_tree *tree, svo_tree_buffer buffer, uint32_t wanted)
{
    const bool shown = wanted != 0 && tree->buffers[buffer] != NULL &&
                       (tree->info.payload_level == 0 || svo_i_tree_is_constant(&tree->info, buffer));
    return shown ? array_of(tree, buffer) : (svo_i_source_array){.buffer = NULL};
}

static svo_status describe_tree(svo_device *device, const char *function, const svo_scene_options *options,
                                uint32_t index, svo_i_scene_source *out)
{
    svo_tree *tree = options->trees[index];
    SVO_I_TRY(check_tree(device, function, tree, index, options->need));
    *out = (svo_i_scene_source){.form = "",
                                .nodes = {array_of(tree, SVO_TREE_CHILD_MASK), array_of(tree, SVO_TREE_FIRST_CHILD)},
                                .colors = payload_of(tree, SVO_TREE_COLORS, options->need & SVO_NEED_COLOR),
                                .normals = payload_of(tree, SVO_TREE_NORMALS, options->need & SVO_NEED_NORMAL),
                                .one_color = svo_i_tree_is_constant(&tree->info, SVO_TREE_COLORS),
                                .one_normal = svo_i_tree_is_constant(&tree->info, SVO_TREE_NORMALS),
                                .empty = tree->info.leaf_count == 0,
                                .origin = {tree->info.origin[0], tree->info.origin[1], tree->info.origin[2]},
                                .width = grid_width(tree->info.snap_bits, tree->info.scale)};
    if ((options->need & SVO_NEED_RAYS) != 0) {
        SVO_I_TRY(svo_i_rays_prepare(tree, function, NULL));
        const svo_i_ray_buffers bvh = svo_i_rays_buffers(tree);
        out->ray_nodes = (svo_i_source_array){bvh.nodes, bvh.node_bytes};
        out->ray_leaves = (svo_i_source_array){bvh.leaves, bvh.leaf_bytes};
    }
    return svo_i_rays_tree_params(tree, function, &out->params);
}

/* ---- compact trees ---- */

static svo_status check_compact(svo_device *device, const char *function, const svo_scene_options *options,
                                uint32_t index)
{
    const svo_compact *compact = options->compacts[index];
    if (compact == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: compacts[%u] is NULL", function, index);
    }
    if (compact->device != device || compact->buffers[SVO_COMPACT_NODES] == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: compacts[%u] is not on the scene's device",
                                 function, index);
    }
    if ((options->need & SVO_NEED_RAYS) != 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: compacts[%u] has no triangles for SVO_NEED_RAYS",
                                 function, index);
    }
    /* The options select the kernels of the whole scene. */
    const svo_compact *first = options->compacts[0];
    return strcmp(svo_i_form_defines(&compact->info), svo_i_form_defines(&first->info)) == 0
               ? SVO_OK
               : svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                   "%s: compacts[%u] differs from the first in form, directory_step_log2, or in "
                                   "whether payload has places",
                                   function, index);
}

static svo_i_source_array compact_array(const svo_compact *compact, svo_compact_buffer buffer)
{
    return (svo_i_source_array){compact->buffers[buffer],
                                compact->buffers[buffer] != NULL ? compact->info.bytes[buffer] : 0};
}

static svo_i_source_array compact_payload(const svo_compact *compact, svo_compact_buffer buffer, uint32_t wanted)
{
    const bool shown =
        wanted != 0 && (compact->info.payload_level == 0 || svo_i_compact_is_constant(&compact->info, buffer));
    return shown ? compact_array(compact, buffer) : (svo_i_source_array){.buffer = NULL};
}

static svo_status describe_compact(svo_device *device, const char *function, const svo_scene_options *options,
                                   uint32_t index, svo_i_scene_source *out)
{
    SVO_I_TRY(check_compact(device, function, options, index));
    const svo_compact *compact = options->compacts[index];
    const svo_compact_info *info = &compact->info;
    const svo_grid grid = {.depth = info->depth,
                           .snap_bits = info->snap_bits,
                           .origin = {info->origin[0], info->origin[1], info->origin[2]},
                           .scale = info->scale,
                           .edge = info->edge};
    *out = (svo_i_scene_source){
        .form = svo_i_form_defines(info),
        .nodes = {compact_array(compact, SVO_COMPACT_NODES), compact_array(compact, SVO_COMPACT_LINKS),
                  compact_array(compact, SVO_COMPACT_BASES)},
        .colors = compact_payload(compact, SVO_COMPACT_COLORS, options->need & SVO_NEED_COLOR),
        .normals = compact_payload(compact, SVO_COMPACT_NORMALS, options->need & SVO_NEED_NORMAL),
        .one_color = svo_i_compact_is_constant(info, SVO_COMPACT_COLORS),
        .one_normal = svo_i_compact_is_constant(info, SVO_COMPACT_NORMALS),
        .packed_colors = svo_i_compact_is_packed(info, SVO_COMPACT_COLORS),
        .packed_normals = svo_i_compact_is_packed(info, SVO_COMPACT_NORMALS),
        .empty = info->leaf_count == 0,
        .origin = {info->origin[0], info->origin[1], info->origin[2]},
        .width = grid_width(info->snap_bits, info->scale)};
    return svo_i_rays_params(device, function, &grid, info->edge, &out->params);
}

/* Checks and describes a tree of the options. With SVO_NEED_RAYS its BVH is made. */
static svo_status source_of(svo_device *device, const char *function, const svo_scene_options *options, uint32_t index,
                            svo_i_scene_source *out)
{
    return options->compacts != NULL ? describe_compact(device, function, options, index, out)
                                     : describe_tree(device, function, options, index, out);
}

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
/* Packed ones begin with a whole word. */
static array_layout layout_of_normals(const svo_i_scene_source *source)
{
    return (array_layout){SVO_I_SCENE_NORMALS, 6, source->packed_normals ? 12 : 6};
}

static const array_layout layout_of_ray_nodes = {SVO_I_SCENE_RAY_NODES, sizeof(svo_ray_node), sizeof(svo_ray_node)};
static const array_layout layout_of_ray_leaves = {SVO_I_SCENE_RAY_LEAVES, 16, 16};

static uint64_t round_up(uint64_t bytes, uint32_t to)
{
    return (bytes + to - 1) / to * to;
}

/* Lays an array out behind those of the trees before. */
static svo_status append(svo_i_arena *arena, svo_device *device, const char *function, array_layout layout,
                         svo_i_source_array array, SVO_U32 *begin)
{
    const uint64_t begin_bytes = round_up(arena->bytes[layout.buffer], layout.alignment_bytes);
    const uint64_t at = begin_bytes / layout.unit_bytes;
    if (array.buffer == NULL) {
        return SVO_OK;
    }
    if (at > UINT32_MAX || array.bytes / layout.unit_bytes > UINT32_MAX) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, "%s: the trees have more than %u nodes together", function,
                                 UINT32_MAX);
    }
    *begin = (uint32_t)at;
    arena->bytes[layout.buffer] = begin_bytes + round_up(array.bytes, layout.alignment_bytes);
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
                   (source->one_normal ? SVO_SCENE_TREE_ONE_NORMAL : 0) |
                   (source->colors.buffer != NULL && source->packed_colors ? SVO_SCENE_TREE_PACKED_COLORS : 0) |
                   (source->normals.buffer != NULL && source->packed_normals ? SVO_SCENE_TREE_PACKED_NORMALS : 0);
    arena->is_packed =
        arena->is_packed || (place->flags & (SVO_SCENE_TREE_PACKED_COLORS | SVO_SCENE_TREE_PACKED_NORMALS)) != 0;
    SVO_I_TRY(append(arena, device, function, layout_of_colors, source->colors, &place->color_begin));
    SVO_I_TRY(append(arena, device, function, layout_of_normals(source), source->normals, &place->normal_begin));
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
        SVO_I_TRY(source_of(device, function, options, i, &out->sources[i]));
        SVO_I_TRY(place_tree(out, device, function, i));
    }
    out->bytes[SVO_I_SCENE_TREE_PARAMS] = options->tree_count * sizeof *out->params;
    out->bytes[SVO_I_SCENE_TREES] = options->tree_count * sizeof *out->places;
    out->bytes[SVO_I_SCENE_BOUNDS] = options->tree_count * BOUNDS_BYTES;
    return SVO_OK;
}

void svo_i_arena_free(svo_i_arena *arena)
{
    svo_i_free(arena->sources);
    svo_i_free(arena->places);
    svo_i_free(arena->params);
}

/* ---- bounds ---- */

static uint32_t level_of(const svo_i_scene_source *source)
{
    return source->params.depth < BOUNDS_LEVEL_MAX ? source->params.depth : BOUNDS_LEVEL_MAX;
}

/* The box of the occupied cells, enlarged by what the traversal of the tree may round; that of the grid without
   leaves. */
static void make_box(const svo_i_scene_source *source, const cl_int bounds[6], svo_i_scene_box *out)
{
    const double cells = (double)(1u << level_of(source));
    const double margin = source->width * 0x1p-20;
    out->leaf_edge = source->width / (double)(1u << source->params.depth);
    for (int axis = 0; axis < 3; ++axis) {
        const double low = source->empty ? 0 : bounds[axis];
        const double high = source->empty ? cells : bounds[axis + 3];
        out->low[axis] = source->origin[axis] + source->width * low / cells - margin;
        out->high[axis] = source->origin[axis] + source->width * high / cells + margin;
    }
}

static svo_status launch_bounds(const svo_scene *scene, const char *function, cl_command_queue queue, cl_kernel kernel,
                                cl_uint tree, cl_uint level)
{
    svo_i_argument arguments[SVO_I_SCENE_NODE_BUFFERS + 4];
    cl_uint count = 0;
    for (; count < scene->node_buffers; ++count) {
        arguments[count] = SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_NODES_0 + count]);
    }
    arguments[count++] = SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_TREES]);
    arguments[count++] = SVO_I_ARGUMENT(tree);
    arguments[count++] = SVO_I_ARGUMENT(level);
    arguments[count++] = SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_BOUNDS]);
    SVO_I_TRY(svo_i_kernel_set(scene->device, function, kernel, arguments, count));
    const size_t local = SVO_GROUP_ITEMS;
    const size_t cells = (size_t)1 << 3 * level;
    const size_t global = (cells + local - 1) / local * local;
    const cl_int error = clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &global, &local, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(scene->device, function, "clEnqueueNDRangeKernel", error);
}

/* Their order does not matter: each has its own bounds. */
static svo_status launch_each(const svo_scene *scene, const char *function, cl_command_queue queue, cl_kernel kernel,
                              const svo_i_scene_source *sources)
{
    for (uint32_t i = 0; i < scene->info.tree_count; ++i) {
        if (!sources[i].empty) {
            SVO_I_TRY(launch_bounds(scene, function, queue, kernel, i, level_of(&sources[i])));
        }
    }
    return SVO_OK;
}

static svo_status launch_all(const svo_scene *scene, const char *function, cl_command_queue queue,
                             const svo_i_scene_source *sources)
{
    cl_program program = NULL;
    cl_kernel kernel = NULL;
    SVO_I_TRY(svo_i_program_get(scene->device, function, &svo_i_program_scene_bounds, scene->form, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(scene->device, function, program, "svo_k_scene_bounds", &kernel));
    const svo_status status = launch_each(scene, function, queue, kernel, sources);
    clReleaseKernel(kernel);
    const cl_int error = clFinish(queue); /* also after a failure: buffers may be released next */
    SVO_I_TRY(status);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clFinish", error);
}

static svo_status run_bounds(const svo_scene *scene, const char *function, cl_command_queue queue,
                             const svo_i_scene_source *sources, cl_int *bounds)
{
    const cl_mem buffer = scene->buffers[SVO_I_SCENE_BOUNDS];
    const size_t bytes = scene->info.tree_count * BOUNDS_BYTES;
    for (size_t i = 0; i < bytes / sizeof *bounds; ++i) {
        bounds[i] = i % 6 < 3 ? INT_MAX : INT_MIN;
    }
    SVO_I_TRY(svo_i_device_write(scene->device, function, queue, buffer, 0, bounds, bytes));
    SVO_I_TRY(launch_all(scene, function, queue, sources));
    const cl_int error = clEnqueueReadBuffer(queue, buffer, CL_TRUE, 0, bytes, bounds, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clEnqueueReadBuffer", error);
}

/* Fills scene->tree_boxes from the trees in the scene's buffers. Waits. */
static svo_status find_bounds(svo_scene *scene, const char *function, cl_command_queue queue,
                              const svo_i_scene_source *sources)
{
    svo_status status = SVO_OK;
    cl_int *bounds = svo_i_alloc_zeroed(&scene->device->memory, scene->info.tree_count, BOUNDS_BYTES);
    if (bounds == NULL) {
        return svo_i_device_fail(scene->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u trees", function,
                                 scene->info.tree_count);
    }
    SVO_I_TRY_CLEANUP(run_bounds(scene, function, queue, sources, bounds));
    for (uint32_t i = 0; i < scene->info.tree_count; ++i) {
        make_box(&sources[i], bounds + (size_t)6 * i, &scene->tree_boxes[i]);
    }

cleanup:
    svo_i_free(bounds);
    return status;
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
    SVO_I_TRY(copy(scene, function, queue, source->normals, layout_of_normals(source), place->normal_begin));
    SVO_I_TRY(copy(scene, function, queue, source->ray_nodes, layout_of_ray_nodes, place->node_begin));
    return copy(scene, function, queue, source->ray_leaves, layout_of_ray_leaves, place->leaf_begin);
}

static svo_status write_array(const svo_scene *scene, const char *function, cl_command_queue queue,
                              svo_i_scene_buffer to, uint64_t bytes, const void *array)
{
    return svo_i_device_write(scene->device, function, queue, scene->buffers[to], 0, array, (size_t)bytes);
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

/* Whether all of a tree's nodes show, by the first words of its colors. Of plain ones the root's is the first, which
   has the mean of all alpha. */
static bool is_opaque(const svo_scene_tree *place, const uint32_t words[SVO_I_PACKED_ALPHA_WORDS])
{
    return (place->flags & SVO_SCENE_TREE_PACKED_COLORS) != 0 ? svo_i_packed_is_opaque(words)
                                                              : ((const uint8_t *)words)[3] == 255;
}

/* Marks the trees that show in part. */
static svo_status mark_clear(const svo_i_arena *arena, svo_scene *scene, const char *function, cl_command_queue queue)
{
    for (uint32_t i = 0; i < arena->tree_count; ++i) {
        svo_scene_tree *place = &arena->places[i];
        uint32_t words[SVO_I_PACKED_ALPHA_WORDS] = {0};
        const bool is_packed = (place->flags & SVO_SCENE_TREE_PACKED_COLORS) != 0;
        if ((place->flags & SVO_SCENE_TREE_COLORS) == 0 || arena->sources[i].colors.bytes == 0) {
            continue;
        }
        const cl_int error = clEnqueueReadBuffer(queue, scene->buffers[SVO_I_SCENE_COLORS], CL_TRUE,
                                                 (size_t)place->color_begin * sizeof *words,
                                                 is_packed ? sizeof words : sizeof *words, words, 0, NULL, NULL);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(scene->device, function, "clEnqueueReadBuffer", error);
        }
        const bool is_clear = !is_opaque(place, words);
        place->flags |= is_clear ? SVO_SCENE_TREE_CLEAR : 0;
        scene->is_clear = scene->is_clear || is_clear;
    }
    return SVO_OK;
}

svo_status svo_i_arena_fill(const svo_i_arena *arena, svo_scene *scene, const char *function, cl_command_queue queue)
{
    SVO_I_TRY(copy_trees(arena, scene, function, queue));
    SVO_I_TRY(mark_clear(arena, scene, function, queue));
    SVO_I_TRY(write_array(scene, function, queue, SVO_I_SCENE_TREE_PARAMS, arena->bytes[SVO_I_SCENE_TREE_PARAMS],
                          arena->params));
    SVO_I_TRY(write_array(scene, function, queue, SVO_I_SCENE_TREES, arena->bytes[SVO_I_SCENE_TREES], arena->places));
    return find_bounds(scene, function, queue, arena->sources);
}
