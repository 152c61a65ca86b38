/* SPDX-License-Identifier: MIT */
/*
 * The table of stages. A plan takes from it which stages run, which kernels are compiled and what each buffer's bytes
 * follow from; a build runs it from top to bottom.
 */
#include "build/stage_table.h"

#include <stdio.h>

#include "stages/bottom_up.h"
#include "stages/constants.h"
#include "stages/filter.h"
#include "stages/geometry.h"
#include "stages/material.h"
#include "stages/pack.h"
#include "stages/sort.h"
#include "stages/subdivide.h"
#include "stages/surface.h"

static bool has(const svo_plan *plan, svo_need bit)
{
    return (plan->work.made & (uint32_t)bit) != 0;
}

static void add(char *text, size_t bytes, const char *define)
{
    (void)snprintf(text, bytes, "%s", define);
}

/* ---- when they run ---- */

static bool voxelize_runs(const svo_plan *plan)
{
    return plan->triangle_count > 0;
}

static bool sort_runs(const svo_plan *plan)
{
    return plan->work.sorted;
}

static bool subdivide_runs(const svo_plan *plan)
{
    return !plan->work.sorted;
}

static bool geometry_runs(const svo_plan *plan)
{
    return plan->work.lists;
}

static bool pack_runs(const svo_plan *plan)
{
    return plan->work.lists && !plan->work.sorted;
}

static bool bottom_up_lists_runs(const svo_plan *plan)
{
    return plan->work.lists && plan->work.sorted;
}

static bool surface_runs(const svo_plan *plan)
{
    return plan->work.surface;
}

static bool ranges_runs(const svo_plan *plan)
{
    return plan->work.ranges && !plan->work.lists && !plan->work.sorted;
}

static bool bottom_up_ranges_runs(const svo_plan *plan)
{
    return plan->work.ranges && !plan->work.lists && plan->work.sorted;
}

static bool material_runs(const svo_plan *plan)
{
    return has(plan, SVO_NEED_MATERIAL);
}

static bool link_runs(const svo_plan *plan)
{
    return plan->work.filter && plan->triangle_count > 0;
}

static bool filter_runs(const svo_plan *plan)
{
    return plan->work.filter;
}

static bool constants_runs(const svo_plan *plan)
{
    return plan->work.constant != 0;
}

/* ---- why they do not ---- */

static const char *no_voxelization(const svo_plan *plan)
{
    (void)plan;
    return "no accepted triangle is inside the grid";
}

static const char *no_lists(const svo_plan *plan)
{
    (void)plan;
    return "rays were not asked for: no lists, no snapped vertices, indices or triangle ids";
}

static const char *no_packing(const svo_plan *plan)
{
    if (plan->work.lists) {
        return "the sorted list is in the order of the lists";
    }
    return plan->work.ranges ? "no lists; only where each leaf's entries begin is found, for the materials"
                             : "there are no lists to pack";
}

/* ---- what is compiled for them ---- */

static void sort_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)plan;
    add(text, bytes, " -DSVO_SORT");
}

static void subdivide_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)plan;
    add(text, bytes, " -DSVO_LEVELS");
}

static void pack_defines(const svo_plan *plan, char *text, size_t bytes)
{
    add(text, bytes, plan->work.lists ? " -DSVO_RANGES -DSVO_LISTS" : " -DSVO_RANGES");
}

static void surface_defines(const svo_plan *plan, char *text, size_t bytes)
{
    static const char *const weights[] = {" -DSVO_WEIGHTS_AREA", "", " -DSVO_WEIGHTS_CENTER"};
    (void)snprintf(text, bytes, "%s%s%s%s", plan->work.vertex_colors ? " -DSVO_VERTEX_COLOR" : "",
                   plan->work.textures ? " -DSVO_TEXTURE" : "", plan->work.vertex_normals ? " -DSVO_VERTEX_NORMAL" : "",
                   weights[plan->options.weights]);
}

static void material_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)plan;
    add(text, bytes, " -DSVO_MATERIAL");
}

static void filter_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)snprintf(text, bytes, "%s%s%s", has(plan, SVO_NEED_COLOR) ? " -DSVO_COLOR" : "",
                   has(plan, SVO_NEED_NORMAL) ? " -DSVO_NORMAL" : "", has(plan, SVO_NEED_FILL) ? " -DSVO_FILL" : "");
}

/* ---- the rows ---- */

#define MESH(name)                 \
    {                              \
        name, SVO_I_OF_MESH, false \
    }
#define FRAGMENTS(name)                 \
    {                                   \
        name, SVO_I_OF_FRAGMENTS, false \
    }
#define LEAVES(name)                 \
    {                                \
        name, SVO_I_OF_LEAVES, false \
    }
#define NODES(name)                 \
    {                               \
        name, SVO_I_OF_NODES, false \
    }
#define TREE_MESH(name)           \
    {                             \
        name, SVO_I_OF_MESH, true \
    }
#define TREE_FRAGMENTS(name)           \
    {                                  \
        name, SVO_I_OF_FRAGMENTS, true \
    }
#define TREE_LEAVES(name)           \
    {                               \
        name, SVO_I_OF_LEAVES, true \
    }
#define TREE_NODES(name)           \
    {                              \
        name, SVO_I_OF_NODES, true \
    }

static const svo_i_stage rows[] = {
    {.name = "voxelize",
     .stage = SVO_STAGE_VOXELIZE,
     .runs = voxelize_runs,
     .left_out = "voxelization",
     .reason = no_voxelization,
     .program = SVO_I_PROGRAM_VOXELIZE,
     .kernels = {"svo_k_voxelize"},
     /* Tiles: about as many as the large triangles have columns. */
     .buffers = {MESH("mesh_vertices"), MESH("mesh_indices"), MESH("mesh_items"), NODES("mesh_tiles"), MESH("counters"),
                 FRAGMENTS("fragments")}},
    {.name = "sort",
     .stage = SVO_STAGE_SUBDIVIDE,
     .runs = sort_runs,
     .run = svo_i_sort,
     .program = SVO_I_PROGRAM_SORT,
     .defines = sort_defines,
     .kernels = {"svo_k_sort_count", "svo_k_sort_scatter", "svo_k_scan_lists_reduce", "svo_k_scan_lists_partials",
                 "svo_k_scan_lists_add"},
     .buffers = {FRAGMENTS("sorted"), MESH("sort_counts"), MESH("partials")}},
    {.name = "bottom_up",
     .stage = SVO_STAGE_SUBDIVIDE,
     .runs = sort_runs,
     .run = svo_i_bottom_up,
     .program = SVO_I_PROGRAM_SORT,
     .kernels = {"svo_k_bottom_up_count", "svo_k_bottom_up_flags", "svo_k_bottom_up_leaves", "svo_k_bottom_up_nodes"},
     .buffers = {FRAGMENTS("cursors"), MESH("level_counts"), MESH("state"), FRAGMENTS("begin_flags"),
                 NODES("level_codes"), TREE_NODES("child_mask"), TREE_NODES("first_child")}},
    {.name = "subdivide",
     .stage = SVO_STAGE_SUBDIVIDE,
     .runs = subdivide_runs,
     .run = svo_i_subdivide,
     .program = SVO_I_PROGRAM_BUILD,
     .defines = subdivide_defines,
     .kernels = {"svo_k_take_count", "svo_k_mark", "svo_k_descend", "svo_k_scan_masks_reduce",
                 "svo_k_scan_masks_partials", "svo_k_scan_masks_add"},
     .buffers = {FRAGMENTS("cursors"), MESH("state"), MESH("partials"), NODES("child_mask_pool"),
                 NODES("first_child_pool"), TREE_NODES("child_mask"), TREE_NODES("first_child")}},
    {.name = "geometry",
     .stage = SVO_STAGE_TRANSFER,
     .runs = geometry_runs,
     .run = svo_i_geometry_upload,
     .left_out = "leaf lists",
     .reason = no_lists,
     .buffers = {TREE_MESH("vertices"), TREE_MESH("indices"), TREE_MESH("triangle_ids")}},
    {.name = "pack",
     .stage = SVO_STAGE_PACK,
     .runs = pack_runs,
     .run = svo_i_pack,
     .left_out = "packing",
     .reason = no_packing,
     .program = SVO_I_PROGRAM_BUILD,
     .defines = pack_defines,
     .kernels = {"svo_k_count", "svo_k_scan_lists_reduce", "svo_k_scan_lists_partials", "svo_k_scan_lists_add",
                 "svo_k_scatter", "svo_k_sort_short", "svo_k_sort_long"},
     .buffers = {TREE_LEAVES("list_begin"), LEAVES("list_counts"), TREE_FRAGMENTS("list"), FRAGMENTS("list_spare"),
                 FRAGMENTS("long_leaves")}},
    {.name = "bottom_up lists",
     .stage = SVO_STAGE_PACK,
     .runs = bottom_up_lists_runs,
     .run = svo_i_bottom_up_lists,
     .program = SVO_I_PROGRAM_SORT,
     .kernels = {"svo_k_bottom_up_lists"},
     .buffers = {TREE_LEAVES("list_begin"), TREE_FRAGMENTS("list")}},
    {.name = "surface",
     .stage = SVO_STAGE_TRANSFER,
     .runs = surface_runs,
     .run = svo_i_surface_upload,
     .program = SVO_I_PROGRAM_BUILD,
     .defines = surface_defines,
     .buffers = {MESH("vertices"), MESH("indices"), MESH("records"), MESH("vertex_colors"), MESH("vertex_normals"),
                 MESH("uvs"), MESH("material_records"), MESH("texels")}},
    {.name = "ranges",
     .stage = SVO_STAGE_PACK,
     .runs = ranges_runs,
     .run = svo_i_pack,
     .program = SVO_I_PROGRAM_BUILD,
     .defines = pack_defines,
     .kernels = {"svo_k_count", "svo_k_scan_lists_reduce", "svo_k_scan_lists_partials", "svo_k_scan_lists_add"},
     .buffers = {LEAVES("list_begin"), LEAVES("list_counts")}},
    {.name = "bottom_up ranges",
     .stage = SVO_STAGE_PACK,
     .runs = bottom_up_ranges_runs,
     .run = svo_i_bottom_up_lists,
     .program = SVO_I_PROGRAM_SORT,
     .kernels = {"svo_k_bottom_up_lists"},
     .buffers = {LEAVES("list_begin")}},
    {.name = "material",
     .stage = SVO_STAGE_FILTER,
     .runs = material_runs,
     .run = svo_i_material,
     .program = SVO_I_PROGRAM_BUILD,
     .defines = material_defines,
     .kernels = {"svo_k_material_scatter", "svo_k_material_leaves", "svo_k_material_merge"},
     .buffers = {TREE_NODES("materials"), NODES("entry_counts"), NODES("entry_begins"), FRAGMENTS("entries")}},
    {.name = "link", /* the filter runs it, chunk by chunk */
     .stage = SVO_STAGE_LINK,
     .runs = link_runs,
     .program = SVO_I_PROGRAM_BUILD,
     .kernels = {"svo_k_link"},
     .buffers = {LEAVES("heads")}},
    {.name = "filter",
     .stage = SVO_STAGE_FILTER,
     .runs = filter_runs,
     .run = svo_i_filter,
     .program = SVO_I_PROGRAM_BUILD,
     .defines = filter_defines,
     .kernels = {"svo_k_gather", "svo_k_gather_level", "svo_k_filter"},
     .buffers = {NODES("weights"), NODES("color_sums"), NODES("normal_sums"), TREE_NODES("colors"),
                 TREE_NODES("normals"), TREE_NODES("fills")}},
    {.name = "constants",
     .stage = SVO_STAGE_TRANSFER,
     .runs = constants_runs,
     .run = svo_i_constants_store,
     .buffers = {TREE_NODES("colors"), TREE_NODES("normals"), TREE_NODES("materials")}},
};

const svo_i_stage *svo_i_stage_table(size_t *count)
{
    *count = sizeof rows / sizeof rows[0];
    return rows;
}
