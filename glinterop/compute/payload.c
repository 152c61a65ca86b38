/* SPDX-License-Identifier: MIT */
/*
 * The payload of a tree by compute shaders: materials, then what shaders/area.comp and filter.comp make.
 */
#include "compute/payload.h"

#include "commands/commands.h"
#include "compute/material.h"
#include "compute/windows.h"
#include "stages/inputs.h"
#include "stages/material.h"

/* ---- projected areas ---- */

/*
 * Runs shaders/area.comp: every fragment adds its areas to the sums of its leaf, for any number of chunks and of
 * triangles per voxel. The sums are those of a window.
 */

#define AREA_SUM_BYTES 48

static svo_status sum_window(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface, GLuint sums, uint32_t begin,
                             uint32_t end)
{
    const svo_filter_params params = svo_i_payload_params(gl_build->build);
    svo_i_range range = svo_i_range_of(begin, end, AREA_SUM_BYTES);
    range.local = true;
    svo_i_launch launch = {.entry = SVO_I_ENTRY_AREA,
                           .buffers = {[9] = sums},
                           .ranges = {[9] = range},
                           .window_begin = begin,
                           .window_count = end - begin};
    svo_i_compute_fill_zero(gl_build->compute, sums);
    SVO_I_TRY(svo_i_gl_launch_fragments(gl_build, surface, params, launch));
    launch.entry = SVO_I_ENTRY_ROUND_AREAS;
    launch.buffers[10] = gl_build->arrays[SVO_TREE_AREAS];
    launch.ranges[10] = svo_i_range_of(begin, end, 12);
    launch.params = &params;
    launch.items = end - begin;
    return svo_i_compute_launch(gl_build->compute, &launch);
}

static svo_status sum_areas(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface, GLuint *sums)
{
    svo_i_compute *compute = gl_build->compute;
    const uint64_t leaves = gl_build->build->tree->info.leaf_count;
    const uint64_t most = svo_i_compute_range_max(compute) / AREA_SUM_BYTES;
    const uint64_t size = leaves < most ? leaves : most;
    svo_i_compute_stage_begin(compute);
    SVO_I_TRY(svo_i_compute_alloc_array(compute, "areas", leaves * 12, &gl_build->arrays[SVO_TREE_AREAS]));
    SVO_I_TRY(svo_i_compute_alloc(compute, "area_sums", size * AREA_SUM_BYTES + SVO_I_RANGE_SLACK, sums));
    for (uint64_t begin = 0; begin < leaves; begin += size) {
        const uint64_t end = leaves - begin < size ? leaves : begin + size;
        SVO_I_TRY(sum_window(gl_build, surface, *sums, (uint32_t)begin, (uint32_t)end));
    }
    return svo_i_compute_stage_end(compute, gl_build->build, SVO_STAGE_FILTER);
}

static svo_status make_areas(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    GLuint sums = 0;
    const svo_status status = sum_areas(gl_build, surface, &sums);
    svo_i_compute_free(gl_build->compute, &sums);
    return status;
}

/* ---- colors, normals and fills ---- */

/*
 * Adds the contribution of every fragment to the sums of its leaf, then sums up children level by level and writes
 * every node's color, normal and fill. Sums of leaves are those of a window at a time. Lists of leaves that are walked
 * would do without atomics, but invocations that run together would wait for the longest list.
 */

typedef struct filterer {
    svo_i_gl_build *gl_build;
    const svo_i_gl_surface *surface;
    GLuint sums[2]; /* of levels at an even and at an odd distance from the leaves */
    GLuint leaf_sums; /* of a window */
    uint64_t node_bytes; /* bytes of a node's sums */
    svo_filter_params params;
} filterer;

static bool needs(const filterer *f, svo_need bit)
{
    return (f->gl_build->build->commands.plan->work.made & (uint32_t)bit) != 0;
}

static svo_status allocate_payload(filterer *f)
{
    static const svo_need bits[] = {SVO_NEED_COLOR, SVO_NEED_NORMAL, SVO_NEED_FILL};
    static const svo_tree_buffer arrays[] = {SVO_TREE_COLORS, SVO_TREE_NORMALS, SVO_TREE_FILLS};
    static const unsigned node_bytes[] = {4, 6, 2};
    const uint64_t nodes = f->gl_build->build->tree->info.node_count;
    for (unsigned i = 0; i < 3; ++i) {
        if (needs(f, bits[i])) {
            SVO_I_TRY(svo_i_compute_alloc_array_zero(f->gl_build->compute, svo_name(SVO_NAME_TREE_BUFFER, arrays[i]),
                                                     nodes * node_bytes[i], &f->gl_build->arrays[arrays[i]]));
        }
    }
    return SVO_OK;
}

/* Sums for the parents of leaves and for their parents. */
static svo_status allocate_sums(filterer *f)
{
    const svo_tree_info *info = &f->gl_build->build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t above =
        info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    SVO_I_TRY(svo_i_compute_alloc_array(f->gl_build->compute, "sums", above * f->node_bytes, &f->sums[0]));
    return svo_i_compute_alloc_array(f->gl_build->compute, "sums", parents * f->node_bytes, &f->sums[1]);
}

/* The children of a level's nodes from begin on, as many as a launch can bind the sums of. */
static svo_status next_window(filterer *f, const svo_i_offsets *children, svo_i_window *window)
{
    const uint64_t most = svo_i_compute_range_max(f->gl_build->compute) / f->node_bytes;
    return svo_i_gl_window(f->gl_build, children, window->end, most, most, "children", window);
}

/* Binds the payload of a window's children, and that of the root with its children. */
static void bind_payload(const filterer *f, const svo_i_window *window, unsigned colors, svo_i_launch *launch)
{
    const GLuint *arrays = f->gl_build->arrays;
    const uint64_t begin = window->first + (uint64_t)f->params.child_begin;
    const uint64_t end = window->last + (uint64_t)f->params.child_begin;
    launch->buffers[colors] = arrays[SVO_TREE_COLORS];
    launch->buffers[colors + 1] = arrays[SVO_TREE_NORMALS];
    launch->buffers[colors + 2] = arrays[SVO_TREE_FILLS];
    launch->ranges[colors] = svo_i_range_of(begin, end, 4);
    launch->ranges[colors + 1] = svo_i_range_of(begin, end, 6);
    launch->ranges[colors + 2] = svo_i_range_of(begin, end, 2);
}

/* Sums up the children of each node of a window, and writes the children's payload. */
static svo_status filter_window(filterer *f, const svo_i_window *window, GLuint child_sums, bool local, GLuint sums)
{
    svo_i_gl_build *gl_build = f->gl_build;
    const uint64_t first_node = (uint64_t)f->params.level_begin + window->begin;
    svo_i_launch launch = {
        .entry = SVO_I_ENTRY_FILTER,
        .buffers = {gl_build->arrays[SVO_TREE_CHILD_MASK], gl_build->arrays[SVO_TREE_FIRST_CHILD], child_sums, sums},
        .ranges = {[1] = svo_i_range_of(first_node, first_node + window->end - window->begin, 4),
                   [2] = svo_i_range_of(window->first, window->last, (unsigned)f->node_bytes),
                   [3] = svo_i_range_of(window->begin, window->end, (unsigned)f->node_bytes)},
        .params = &f->params,
        .window_begin = window->begin,
        .window_count = window->end - window->begin,
        .items = window->end - window->begin};
    launch.ranges[2].local = local;
    bind_payload(f, window, 4, &launch);
    return svo_i_compute_launch(gl_build->compute, &launch);
}

/* Adds the fragments of a window's leaves to sums, which hold these alone. */
static svo_status gather_window(filterer *f, const svo_i_window *window, GLuint sums)
{
    const svo_i_gl_surface *surface = f->surface;
    svo_i_launch launch = {.entry = SVO_I_ENTRY_GATHER,
                           .buffers = {[6] = surface->materials,
                                       [7] = surface->texels[0],
                                       [8] = surface->texels[1],
                                       [9] = sums,
                                       [10] = surface->texels[2],
                                       surface->texels[3],
                                       surface->texels[4],
                                       surface->texels[5],
                                       surface->texels[6]},
                           .ranges = {[9] = svo_i_range_of(window->first, window->last, (unsigned)f->node_bytes)},
                           .window_begin = window->first,
                           .window_count = window->last - window->first};
    launch.ranges[9].local = true;
    svo_i_compute_fill_zero(f->gl_build->compute, sums);
    return svo_i_gl_launch_fragments(f->gl_build, surface, f->params, launch);
}

static svo_status add_windows(filterer *f)
{
    const uint32_t level = f->gl_build->build->tree->info.depth - 1;
    const svo_i_offsets children = svo_i_gl_child_offsets(f->gl_build, level);
    svo_i_params_of_level(&f->params, &f->gl_build->build->tree->info, level);
    for (svo_i_window window = {0}; window.end < children.count;) {
        SVO_I_TRY(next_window(f, &children, &window));
        SVO_I_TRY(gather_window(f, &window, f->leaf_sums));
        SVO_I_TRY(filter_window(f, &window, f->leaf_sums, true, f->sums[1]));
    }
    return SVO_OK;
}

/* Adds every fragment to its leaf's sums, for any number of chunks, and of triangles per voxel; then computes the
   leaves' payload and the sums of their parents. */
static svo_status add_leaves(filterer *f)
{
    svo_i_compute *compute = f->gl_build->compute;
    const uint64_t most = svo_i_compute_range_max(compute) / f->node_bytes * f->node_bytes;
    const uint64_t all = f->params.leaf_count * f->node_bytes;
    const uint64_t bytes = (all < most ? all : most) + SVO_I_RANGE_SLACK;
    SVO_I_TRY(svo_i_compute_alloc(compute, "leaf_sums", bytes, &f->leaf_sums));
    return add_windows(f);
}

/* Sums up the children of each node of a level, and writes the nodes' payload. */
static svo_status filter_level(filterer *f, uint32_t level)
{
    const unsigned odd = (f->gl_build->build->tree->info.depth - level) % 2;
    const svo_i_offsets children = svo_i_gl_child_offsets(f->gl_build, level);
    svo_i_params_of_level(&f->params, &f->gl_build->build->tree->info, level);
    for (svo_i_window window = {0}; window.end < children.count;) {
        SVO_I_TRY(next_window(f, &children, &window));
        SVO_I_TRY(filter_window(f, &window, f->sums[1 - odd], false, f->sums[odd]));
    }
    return SVO_OK;
}

static svo_status run_levels(filterer *f)
{
    svo_i_compute_stage_begin(f->gl_build->compute);
    SVO_I_TRY(allocate_sums(f));
    SVO_I_TRY(add_leaves(f));
    for (uint32_t level = f->gl_build->build->tree->info.depth - 1; level-- > 0;) {
        SVO_I_TRY(filter_level(f, level));
    }
    return svo_i_compute_stage_end(f->gl_build->compute, f->gl_build->build, SVO_STAGE_FILTER);
}

static svo_status sum_colors(filterer *f)
{
    SVO_I_TRY(allocate_payload(f));
    if (f->params.leaf_count == 0) {
        return SVO_OK; /* a root without leaves, whose payload is zero */
    }
    return run_levels(f);
}

static svo_status make_colors(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    filterer f = {.gl_build = gl_build, .surface = surface, .params = svo_i_payload_params(gl_build->build)};
    f.node_bytes = UINT64_C(8) * (1u + (needs(&f, SVO_NEED_COLOR) ? 4u : 0u) + (needs(&f, SVO_NEED_NORMAL) ? 3u : 0u));
    const svo_status status = sum_colors(&f);
    svo_i_compute_free(gl_build->compute, &f.sums[0]);
    svo_i_compute_free(gl_build->compute, &f.sums[1]);
    svo_i_compute_free(gl_build->compute, &f.leaf_sums);
    return status;
}

/* ---- all of it ---- */

/* The materials of the nodes. Frees ranges of entries that nothing else needs. */
static svo_status fill_materials(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    svo_i_build *build = gl_build->build;
    const svo_i_work *work = &build->commands.plan->work;
    if ((work->made & SVO_NEED_MATERIAL) != 0) {
        /* A root without leaves needs no shader: OpenCL fills its payload. */
        SVO_I_TRY(build->tree->info.leaf_count > 0 ? svo_i_gl_materials(gl_build, surface) : svo_i_material(build));
    }
    if (!work->lists) {
        svo_i_compute_free(gl_build->compute, &gl_build->arrays[SVO_TREE_LIST_BEGIN]);
    }
    return SVO_OK;
}

svo_status svo_i_gl_payload(svo_i_gl_build *gl_build)
{
    const uint32_t made = gl_build->build->commands.plan->work.made;
    svo_status status = SVO_OK;
    svo_i_gl_surface surface = {0};
    SVO_I_TRY_CLEANUP(svo_i_gl_surface_upload(gl_build, &surface));
    SVO_I_TRY_CLEANUP(fill_materials(gl_build, &surface));
    if ((made & SVO_I_NEED_FILTER) != 0) {
        SVO_I_TRY_CLEANUP(make_colors(gl_build, &surface));
    }
    if ((made & SVO_NEED_PROJECTED_AREA) != 0) {
        SVO_I_TRY_CLEANUP(make_areas(gl_build, &surface));
    }
cleanup:
    svo_i_gl_surface_free(gl_build, &surface);
    return status;
}
