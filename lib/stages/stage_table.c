/* SPDX-License-Identifier: MIT */
/*
 * The table of stages, in the order in which they run. A plan takes from it which stages run, which kernels are
 * compiled and what the size of each buffer depends on. A build runs it from top to bottom.
 */
#include "stages/stage_table.h"

#include <stdio.h>

#include "plan/arrays.h"
#include "stages/bottom_up.h"
#include "stages/drop.h"
#include "stages/filter.h"
#include "stages/inputs.h"
#include "stages/material.h"
#include "stages/pack.h"
#include "stages/programs.h"
#include "stages/sort.h"
#include "stages/subdivide.h"

/* Whether kernels compute this payload for each node. */
static bool computes(const svo_plan *plan, svo_need bit)
{
    return (plan->work.made & (uint32_t)bit) != 0;
}

/* ---- when a stage runs ---- */

static bool voxelize_runs(const svo_plan *plan)
{
    return plan->triangle_count > 0;
}

/* Triangles inside one voxel leave nothing undecided. */
static bool decide_runs(const svo_plan *plan)
{
    const bool *tests = plan->work.tests;
    return voxelize_runs(plan) && (tests[SVO_I_TEST_NARROW] || tests[SVO_I_TEST_REGULAR] || tests[SVO_I_TEST_WIDE]);
}

static bool drop_runs(const svo_plan *plan)
{
    return plan->work.drop;
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
    return plan->work.made != 0;
}

static bool ranges_runs(const svo_plan *plan)
{
    return (plan->work.ranges || plan->work.order) && !plan->work.lists && !plan->work.sorted;
}

static bool bottom_up_ranges_runs(const svo_plan *plan)
{
    return plan->work.ranges && !plan->work.lists && plan->work.sorted;
}

static bool material_runs(const svo_plan *plan)
{
    return computes(plan, SVO_NEED_MATERIAL);
}

static bool link_runs(const svo_plan *plan)
{
    return plan->work.pair_lanes && plan->triangle_count > 0;
}

static bool filter_runs(const svo_plan *plan)
{
    return plan->work.filter;
}

static bool areas_runs(const svo_plan *plan)
{
    return computes(plan, SVO_NEED_PROJECTED_AREA);
}

static bool constants_runs(const svo_plan *plan)
{
    return plan->work.constant != 0;
}

/* ---- why a stage is left out ---- */

static const char *no_voxelization(const svo_plan *plan)
{
    (void)plan;
    return "no accepted triangle is inside the grid";
}

static const char *no_lists(const svo_plan *plan)
{
    (void)plan;
    return "rays are not requested: no lists, no vertices, indices or triangle ids";
}

static const char *no_packing(const svo_plan *plan)
{
    if (plan->work.lists) {
        return "the sorted list is in the order of the lists";
    }
    return plan->work.order    ? "no lists; only the order of the leaves' fragments is found, for the payload"
           : plan->work.ranges ? "no lists; only where each leaf's entries begin is found, for the materials"
                               : "there are no lists to pack";
}

/* ---- the defines that select a stage's kernels ---- */

static const char *const weight_defines[] = {" -DSVO_WEIGHTS_AREA", "", " -DSVO_WEIGHTS_CENTER"}; /* by svo_weights */

static void sort_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)snprintf(text, bytes, "%s", svo_i_sort_defines(plan->device));
}

static void worker_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)snprintf(text, bytes, "%s", plan->device->cpu_path ? " -DSVO_ONE_WORKER" : "");
}

/* What the mesh has, whatever the payload reads of it. */
static void drop_defines(const svo_plan *plan, char *text, size_t bytes)
{
    const bool colors = svo_i_plan_has(plan->colors, plan->memory.colors);
    (void)snprintf(text, bytes, " -DSVO_COLOR%s%s%s%s", colors ? " -DSVO_VERTEX_COLOR" : "",
                   plan->texel_count > 0 ? " -DSVO_TEXTURE" : "", weight_defines[plan->options.weights],
                   plan->device->cpu_path ? " -DSVO_ONE_WORKER" : "");
}

static void pack_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)snprintf(text, bytes, " -DSVO_RANGES%s%s", plan->work.lists ? " -DSVO_LISTS" : "",
                   plan->work.order ? " -DSVO_ORDER" : "");
}

static void surface_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)snprintf(text, bytes, "%s%s%s%s%s", plan->work.vertex_colors ? " -DSVO_VERTEX_COLOR" : "",
                   plan->work.textures ? " -DSVO_TEXTURE" : "", plan->work.vertex_normals ? " -DSVO_VERTEX_NORMAL" : "",
                   weight_defines[plan->options.weights], plan->work.pair_lanes ? " -DSVO_PAIR_LANES" : "");
}

static void material_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)snprintf(text, bytes, " -DSVO_MATERIAL%s", plan->device->cpu_path ? "" : " -DSVO_LONG_LEAVES");
}

static void filter_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)snprintf(text, bytes, "%s%s%s", computes(plan, SVO_NEED_COLOR) ? " -DSVO_COLOR" : "",
                   computes(plan, SVO_NEED_NORMAL) ? " -DSVO_NORMAL" : "",
                   computes(plan, SVO_NEED_FILL) ? " -DSVO_FILL" : "");
}

static void area_defines(const svo_plan *plan, char *text, size_t bytes)
{
    (void)plan;
    (void)snprintf(text, bytes, " -DSVO_AREAS");
}

/* ---- the rows ---- */

/* A buffer of a stage: scratch, or part of the tree. basis: what its bytes depend on. */
#define SCRATCH(name, basis)          \
    {                                 \
        name, SVO_I_OF_##basis, false \
    }
#define TREE(name, basis)            \
    {                                \
        name, SVO_I_OF_##basis, true \
    }

#define BUFFERS(...) ((const svo_i_buffer_kind[]){__VA_ARGS__, {.name = NULL}})

/* svo_i_stage (plan/plan_data.h) describes the columns. */
static const svo_i_stage rows[] = {
    {.name = "voxelize",
     .stage = SVO_STAGE_VOXELIZE,
     .runs = voxelize_runs,
     .left_out = "voxelization",
     .reason = no_voxelization,
     .program = &svo_i_program_voxelize,
     /* The number of tiles is an estimate, as that of nodes is. */
     .buffers = BUFFERS(SCRATCH("mesh_vertices", MESH), SCRATCH("mesh_indices", MESH), SCRATCH("mesh_items", MESH),
                        SCRATCH("mesh_tiles", NODES), SCRATCH("tile_count", MESH), SCRATCH("counters", MESH),
                        SCRATCH("fragments", FRAGMENTS))},
    {.name = "decide", /* of the same chunks */
     .stage = SVO_STAGE_VOXELIZE,
     .runs = decide_runs,
     .program = &svo_i_program_decide,
     .defines = worker_defines,
     .buffers = BUFFERS(SCRATCH("mesh_positions", MESH))},
    {.name = "drop",
     .stage = SVO_STAGE_DROP,
     .runs = drop_runs,
     .run = svo_i_drop,
     .item_ns = 30.0,
     .program = &svo_i_program_drop,
     .defines = drop_defines,
     .buffers = BUFFERS(SCRATCH("drop_tally", MESH), SCRATCH("drop_places", FRAGMENTS), SCRATCH("counters", MESH))},
    {.name = "sort",
     .stage = SVO_STAGE_SUBDIVIDE,
     .runs = sort_runs,
     .run = svo_i_sort,
     .program = &svo_i_program_sort,
     .defines = sort_defines,
     .buffers = BUFFERS(SCRATCH("sorted", FRAGMENTS), SCRATCH("sort_counts", MESH), SCRATCH("partials", MESH))},
    {.name = "bottom_up",
     .stage = SVO_STAGE_SUBDIVIDE,
     .runs = sort_runs,
     .run = svo_i_bottom_up,
     .item_ns = 15.0,
     .program = &svo_i_program_sort,
     .buffers = BUFFERS(SCRATCH("cursors", FRAGMENTS), SCRATCH("level_counts", MESH), SCRATCH("state", MESH),
                        SCRATCH("begin_flags", FRAGMENTS), SCRATCH("level_codes", NODES), TREE("child_mask", NODES),
                        TREE("first_child", NODES))},
    {.name = "subdivide",
     .stage = SVO_STAGE_SUBDIVIDE,
     .runs = subdivide_runs,
     .run = svo_i_subdivide,
     .item_ns = 12.0,
     .program = &svo_i_program_subdivide,
     .defines = worker_defines,
     .buffers = BUFFERS(SCRATCH("cursors", FRAGMENTS), SCRATCH("state", MESH), SCRATCH("partials", MESH),
                        SCRATCH("blocks", NODES), SCRATCH("block_ranks", NODES), SCRATCH("child_mask_pool", NODES),
                        SCRATCH("first_child_pool", NODES), TREE("child_mask", NODES), TREE("first_child", NODES),
                        TREE(SVO_I_TREE_BUILD_STATE, MESH))},
    {.name = "geometry",
     .stage = SVO_STAGE_TRANSFER,
     .runs = geometry_runs,
     .run = svo_i_geometry_upload,
     .left_out = "leaf lists",
     .reason = no_lists,
     .buffers = BUFFERS(TREE("vertices", MESH), TREE("indices", MESH), TREE("triangle_ids", MESH),
                        TREE("positions", MESH), TREE("positions_double", MESH))},
    {.name = "pack",
     .stage = SVO_STAGE_PACK,
     .runs = pack_runs,
     .run = svo_i_pack,
     .item_ns = 15.0,
     .left_out = "packing",
     .reason = no_packing,
     .program = &svo_i_program_pack,
     .defines = pack_defines,
     .buffers =
         BUFFERS(TREE("list_begin", LEAVES), SCRATCH("list_counts", LEAVES), TREE("list", FRAGMENTS),
                 SCRATCH("list_spare", FRAGMENTS), SCRATCH("long_leaves", FRAGMENTS), SCRATCH("order", FRAGMENTS))},
    {.name = "bottom_up lists",
     .stage = SVO_STAGE_PACK,
     .runs = bottom_up_lists_runs,
     .run = svo_i_bottom_up_lists,
     .item_ns = 10.0,
     .program = &svo_i_program_sort,
     .buffers = BUFFERS(TREE("list_begin", LEAVES), TREE("list", FRAGMENTS))},
    {.name = "surface",
     .stage = SVO_STAGE_TRANSFER,
     .runs = surface_runs,
     .run = svo_i_surface_upload,
     .program = &svo_i_program_filter,
     .defines = surface_defines,
     .buffers = BUFFERS(SCRATCH("vertices", MESH), SCRATCH("vertex_remainders", MESH), SCRATCH("indices", MESH),
                        SCRATCH("records", MESH), SCRATCH("vertex_colors", MESH), SCRATCH("vertex_normals", MESH),
                        SCRATCH("uvs", MESH), SCRATCH("material_records", MESH), SCRATCH("texels", MESH))},
    {.name = "ranges",
     .stage = SVO_STAGE_PACK,
     .runs = ranges_runs,
     .run = svo_i_pack,
     .item_ns = 15.0,
     .program = &svo_i_program_pack,
     .defines = pack_defines,
     .buffers = BUFFERS(SCRATCH("list_begin", LEAVES), SCRATCH("list_counts", LEAVES), SCRATCH("order", FRAGMENTS))},
    {.name = "bottom_up ranges",
     .stage = SVO_STAGE_PACK,
     .runs = bottom_up_ranges_runs,
     .run = svo_i_bottom_up_lists,
     .item_ns = 10.0,
     .program = &svo_i_program_sort,
     .buffers = BUFFERS(SCRATCH("list_begin", LEAVES))},
    {.name = "material",
     .stage = SVO_STAGE_FILTER,
     .runs = material_runs,
     .run = svo_i_material,
     .item_ns = 60.0,
     .program = &svo_i_program_filter,
     .defines = material_defines,
     .buffers = BUFFERS(TREE("materials", NODES), SCRATCH("entry_counts", NODES), SCRATCH("entry_begins", NODES),
                        SCRATCH("entries", FRAGMENTS), SCRATCH("long_leaves", FRAGMENTS))},
    {.name = "link", /* filter launches it, chunk by chunk */
     .stage = SVO_STAGE_LINK,
     .runs = link_runs,
     .program = &svo_i_program_filter,
     .buffers = BUFFERS(SCRATCH("heads", LEAVES))},
    {.name = "filter",
     .stage = SVO_STAGE_FILTER,
     .runs = filter_runs,
     .run = svo_i_filter,
     .program = &svo_i_program_filter,
     .defines = filter_defines,
     .buffers = BUFFERS(SCRATCH("weights", NODES), SCRATCH("color_sums", NODES), SCRATCH("normal_sums", NODES),
                        TREE("colors", NODES), TREE("normals", NODES), TREE("fills", NODES))},
    {.name = "areas", /* filter makes them with the rest */
     .stage = SVO_STAGE_FILTER,
     .runs = areas_runs,
     .program = &svo_i_program_filter,
     .defines = area_defines,
     .buffers = BUFFERS(SCRATCH("area_sums", LEAVES), TREE("areas", LEAVES))},
    {.name = "constants",
     .stage = SVO_STAGE_TRANSFER,
     .runs = constants_runs,
     .run = svo_i_constants_store,
     .buffers = BUFFERS(TREE("colors", NODES), TREE("normals", NODES), TREE("materials", NODES))},
};

const svo_i_stage *svo_i_stage_table(size_t *count)
{
    *count = sizeof rows / sizeof rows[0];
    return rows;
}
