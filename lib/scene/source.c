/* SPDX-License-Identifier: MIT */
/* Checks the trees of a scene, and finds their arrays. */
#include "scene/source.h"

#include <string.h>

#include "compact/form.h"
#include "core/compact.h"
#include "core/tree.h"
#include "rays/rays.h"
#include "svocl/plan.h"

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
                           .scale = info->scale};
    *out = (svo_i_scene_source){
        .form = svo_i_form_defines(info),
        .nodes = {compact_array(compact, SVO_COMPACT_NODES), compact_array(compact, SVO_COMPACT_LINKS),
                  compact_array(compact, SVO_COMPACT_BASES)},
        .colors = compact_payload(compact, SVO_COMPACT_COLORS, options->need & SVO_NEED_COLOR),
        .normals = compact_payload(compact, SVO_COMPACT_NORMALS, options->need & SVO_NEED_NORMAL),
        .one_color = svo_i_compact_is_constant(info, SVO_COMPACT_COLORS),
        .one_normal = svo_i_compact_is_constant(info, SVO_COMPACT_NORMALS),
        .empty = info->leaf_count == 0,
        .origin = {info->origin[0], info->origin[1], info->origin[2]},
        .width = grid_width(info->snap_bits, info->scale)};
    return svo_i_rays_params(device, function, &grid, info->edge, &out->params);
}

svo_status svo_i_scene_source_of(svo_device *device, const char *function, const svo_scene_options *options,
                                 uint32_t index, svo_i_scene_source *out)
{
    return options->compacts != NULL ? describe_compact(device, function, options, index, out)
                                     : describe_tree(device, function, options, index, out);
}
