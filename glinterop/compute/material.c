/* SPDX-License-Identifier: MIT */
/*
 * The materials of all nodes by shaders/material.comp: entries of leaves, sorted and summed up, then merged level by
 * level. A launch works on a window of leaves or nodes, whose entries it can bind.
 */
#include "compute/material.h"

#include "compute/windows.h"
#include "stages/inputs.h"

/* The entries of a level's nodes, and where those of each node begin. */
typedef struct level_entries {
    GLuint begins, counts, entries;
} level_entries;

typedef struct sorter {
    svo_i_gl_build *gl_build;
    const svo_i_gl_surface *surface;
    GLuint list_begin, materials;
    level_entries levels[2]; /* of levels at an even and at an odd distance from the leaves */
    svo_filter_params params;
} sorter;

static svo_status allocate(sorter *s)
{
    svo_i_compute *compute = s->gl_build->compute;
    const svo_tree_info *info = &s->gl_build->build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t grandparents =
        info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    const uint64_t fragments = s->gl_build->build->fragment_count;
    GLuint *materials = &s->gl_build->arrays[SVO_TREE_MATERIALS];
    SVO_I_TRY(svo_i_compute_alloc_array_zero(compute, "entry_counts", info->leaf_count * 4, &s->levels[0].counts));
    SVO_I_TRY(svo_i_compute_alloc_array(compute, "entry_begins", (grandparents + 1) * 4, &s->levels[0].begins));
    SVO_I_TRY(svo_i_compute_alloc_array(compute, "entry_counts", parents * 4, &s->levels[1].counts));
    SVO_I_TRY(svo_i_compute_alloc_array(compute, "entry_begins", (parents + 1) * 4, &s->levels[1].begins));
    for (unsigned odd = 0; odd < 2; ++odd) {
        SVO_I_TRY(svo_i_compute_alloc_array(compute, "entries", fragments * 8, &s->levels[odd].entries));
    }
    SVO_I_TRY(svo_i_compute_alloc_array_zero(compute, "materials", info->node_count * 2, materials));
    s->materials = *materials;
    return SVO_OK;
}

static void release(sorter *s)
{
    for (unsigned odd = 0; odd < 2; ++odd) {
        svo_i_compute_free(s->gl_build->compute, &s->levels[odd].counts);
        svo_i_compute_free(s->gl_build->compute, &s->levels[odd].begins);
        svo_i_compute_free(s->gl_build->compute, &s->levels[odd].entries);
    }
}

/* Writes the entries of a window's leaves, whose counts are 0. */
static svo_status scatter(sorter *s, const svo_i_window *window)
{
    const svo_i_launch launch = {
        .entry = SVO_I_ENTRY_MATERIAL_SCATTER,
        .buffers = {[8] = s->list_begin, [6] = s->levels[0].counts, [7] = s->levels[0].entries},
        .ranges = {[8] = svo_i_range_of(window->begin, window->end, 4),
                   [6] = svo_i_range_of(window->begin, window->end, 4),
                   [7] = svo_i_range_of(window->first, window->last, 8)},
        .window_begin = window->begin,
        .window_count = window->end - window->begin};
    return svo_i_gl_launch_fragments(s->gl_build, s->surface, s->params, launch);
}

static svo_status launch_leaves(sorter *s, svo_i_entry entry, const svo_filter_params *params,
                                const svo_i_window *window, uint64_t items)
{
    const uint64_t leaf_begin = params->leaf_begin;
    const svo_i_range entries = svo_i_range_of(window->first, window->last, 8);
    const svo_i_launch launch = {
        .entry = entry,
        .buffers = {s->list_begin, s->levels[0].counts, s->levels[0].entries, s->levels[1].entries, s->materials},
        .ranges = {svo_i_range_of(window->begin, window->end + UINT64_C(1), 4),
                   svo_i_range_of(window->begin, window->end, 4), entries, entries,
                   svo_i_range_of(leaf_begin + window->begin, leaf_begin + window->end, 2)},
        .params = params,
        .window_begin = window->begin,
        .window_count = window->end - window->begin,
        .items = items};
    return svo_i_compute_launch(s->gl_build->compute, &launch);
}

/* Sorts leaves of any length in an even number of passes, so that the result ends in the first array. */
static svo_status pass_window(sorter *s, const svo_i_window *window)
{
    svo_filter_params params = s->params;
    params.fragment_count = window->last - window->first;
    for (params.level = 0; params.fragment_count >> params.level != 0 || params.level % 2 != 0; ++params.level) {
        SVO_I_TRY(launch_leaves(s, SVO_I_ENTRY_MATERIAL_PASS, &params, window, params.fragment_count));
    }
    return SVO_OK;
}

/* has_crowds: leaves may have more triangles than one invocation sorts (shaders/compute.glsl). */
static svo_status sort_window(sorter *s, const svo_i_window *window, bool has_crowds)
{
    svo_filter_params params = s->params;
    params.digit_passes = has_crowds;
    SVO_I_TRY(scatter(s, window));
    if (has_crowds) {
        SVO_I_TRY(pass_window(s, window));
    }
    return launch_leaves(s, SVO_I_ENTRY_MATERIAL_LEAVES, &params, window, window->end - window->begin);
}

/* The counts and materials must be zero. */
static svo_status sort_leaves(sorter *s, bool has_crowds)
{
    const svo_i_offsets offsets = svo_i_gl_list_offsets(s->gl_build);
    const uint64_t most = svo_i_compute_range_max(s->gl_build->compute) / 8;
    for (svo_i_window window = {0}; window.end < offsets.count;) {
        SVO_I_TRY(svo_i_gl_window(s->gl_build, &offsets, window.end, most, most, "triangles", &window));
        SVO_I_TRY(sort_window(s, &window, has_crowds));
    }
    return SVO_OK;
}

/* One invocation sorts a leaf, unless a leaf has more triangles than it is given: then all leaves are sorted again. */
static svo_status make_leaves(sorter *s)
{
    svo_i_compute *compute = s->gl_build->compute;
    bool has_crowds = false;
    SVO_I_TRY(sort_leaves(s, false));
    SVO_I_TRY(svo_i_compute_exhausted(compute, &has_crowds));
    if (!has_crowds) {
        return SVO_OK;
    }
    svo_i_compute_fill_zero(compute, s->levels[0].counts);
    svo_i_compute_fill_zero(compute, s->materials);
    return sort_leaves(s, true);
}

/* A level that is merged: its arrays and those of the level below. */
typedef struct merged_level {
    const level_entries *nodes, *children;
    GLuint child_begins;
    svo_i_offsets child_nodes; /* of each node: its children */
} merged_level;

/* Counts the children's entries of each node, and finds places for so many. */
static svo_status make_room(sorter *s, const merged_level *level)
{
    svo_i_gl_build *gl_build = s->gl_build;
    const GLuint *arrays = gl_build->arrays;
    const uint64_t most = svo_i_compute_range_max(gl_build->compute) / 4;
    for (svo_i_window window = {0}; window.end < level->child_nodes.count;) {
        SVO_I_TRY(svo_i_gl_window(gl_build, &level->child_nodes, window.end, most, most, "children", &window));
        const uint64_t first_node = (uint64_t)s->params.level_begin + window.begin;
        const svo_i_launch launch = {
            .entry = SVO_I_ENTRY_MATERIAL_ROOM,
            .buffers = {arrays[SVO_TREE_CHILD_MASK],
                        arrays[SVO_TREE_FIRST_CHILD], [3] = level->children->counts, [6] = level->nodes->counts},
            .ranges = {[1] = svo_i_range_of(first_node, first_node + window.end - window.begin, 4),
                       [3] = svo_i_range_of(window.first, window.last, 4),
                       [6] = svo_i_range_of(window.begin, window.end, 4)},
            .params = &s->params,
            .window_begin = window.begin,
            .window_count = window.end - window.begin,
            .items = window.end - window.begin};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return svo_i_gl_scan(gl_build, level->nodes->counts, level->nodes->begins, level->child_nodes.count);
}

/* The elements of a window's nodes in the other arrays. */
typedef struct merged_window {
    svo_i_range nodes, children, child_begins, entries;
} merged_window;

static svo_status find_ranges(sorter *s, const merged_level *level, const svo_i_window *window, merged_window *out)
{
    svo_i_gl_build *gl_build = s->gl_build;
    const uint64_t first_node = (uint64_t)s->params.level_begin + window->begin;
    const svo_i_offsets rooms = {.buffer = level->nodes->begins, .count = level->child_nodes.count + 1};
    uint32_t children[2];
    uint32_t entries[2];
    for (unsigned i = 0; i < 2; ++i) {
        const uint32_t node = i == 0 ? window->begin : window->end;
        SVO_I_TRY(svo_i_gl_offset(gl_build, &level->child_nodes, node, &children[i]));
        SVO_I_TRY(svo_i_gl_offset(gl_build, &rooms, node, &entries[i]));
    }
    out->nodes = svo_i_range_of(first_node, first_node + window->end - window->begin, 4);
    out->children = svo_i_range_of(children[0], children[1], 4);
    out->child_begins = svo_i_range_of(children[0], children[1] + UINT64_C(1), 4);
    out->entries = svo_i_range_of(entries[0], entries[1], 8);
    return SVO_OK;
}

static svo_status merge_window(sorter *s, const merged_level *level, const svo_i_window *window)
{
    svo_i_gl_build *gl_build = s->gl_build;
    const GLuint *arrays = gl_build->arrays;
    const uint64_t first_node = (uint64_t)s->params.level_begin + window->begin;
    const svo_i_range own = svo_i_range_of(window->begin, window->end, 4);
    merged_window ranges;
    SVO_I_TRY(find_ranges(s, level, window, &ranges));
    const svo_i_launch launch = {
        .entry = SVO_I_ENTRY_MATERIAL_MERGE,
        .buffers = {arrays[SVO_TREE_CHILD_MASK], arrays[SVO_TREE_FIRST_CHILD], level->child_begins,
                    level->children->counts, level->children->entries, level->nodes->begins, level->nodes->counts,
                    level->nodes->entries, s->materials},
        .ranges = {[1] = ranges.nodes,
                   [2] = ranges.children,
                   [3] = ranges.children,
                   [4] = svo_i_range_of(window->first, window->last, 8),
                   [5] = own,
                   [6] = own,
                   [7] = ranges.entries,
                   [8] = svo_i_range_of(first_node, first_node + window->end - window->begin, 2)},
        .params = &s->params,
        .window_begin = window->begin,
        .window_count = window->end - window->begin,
        .items = window->end - window->begin};
    return svo_i_compute_launch(gl_build->compute, &launch);
}

/* Where the entries of the children of each node begin. */
static svo_status find_child_entries(sorter *s, const merged_level *level, svo_i_offsets *out)
{
    const svo_i_offsets all = {.buffer = level->child_begins, .count = level->child_nodes.end + 1};
    *out = level->child_nodes;
    out->through = level->child_begins;
    return svo_i_gl_offset(s->gl_build, &all, level->child_nodes.end, &out->end);
}

static svo_status merge_level(sorter *s, uint32_t depth_level)
{
    svo_i_gl_build *gl_build = s->gl_build;
    const svo_tree_info *info = &gl_build->build->tree->info;
    const unsigned odd = (info->depth - depth_level) % 2;
    const uint64_t most = svo_i_compute_range_max(gl_build->compute) / 8;
    svo_i_params_of_level(&s->params, info, depth_level);
    const merged_level level = {.nodes = &s->levels[odd],
                                .children = &s->levels[1 - odd],
                                .child_begins =
                                    depth_level + 1 == info->depth ? s->list_begin : s->levels[1 - odd].begins,
                                .child_nodes = svo_i_gl_child_offsets(gl_build, depth_level)};
    svo_i_offsets entries;
    SVO_I_TRY(make_room(s, &level));
    SVO_I_TRY(find_child_entries(s, &level, &entries));
    for (svo_i_window window = {0}; window.end < entries.count;) {
        SVO_I_TRY(svo_i_gl_window(gl_build, &entries, window.end, most, most, "triangles", &window));
        SVO_I_TRY(merge_window(s, &level, &window));
    }
    return SVO_OK;
}

static svo_status sort_materials(sorter *s)
{
    SVO_I_TRY(allocate(s));
    SVO_I_TRY(make_leaves(s));
    for (uint32_t level = s->gl_build->build->tree->info.depth; level-- > 0;) {
        SVO_I_TRY(merge_level(s, level));
    }
    return SVO_OK;
}

svo_status svo_i_gl_materials(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    sorter s = {.gl_build = gl_build,
                .surface = surface,
                .list_begin = gl_build->arrays[SVO_TREE_LIST_BEGIN],
                .params = svo_i_payload_params(gl_build->build)};
    svo_status status = SVO_OK;
    svo_i_compute_stage_begin(gl_build->compute);
    SVO_I_TRY_CLEANUP(sort_materials(&s));
    SVO_I_TRY_CLEANUP(svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_FILTER));
    SVO_I_TRY_CLEANUP(svo_i_gl_check_loops(gl_build, "sorting its materials"));
cleanup:
    release(&s);
    return status;
}
