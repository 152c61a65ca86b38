/* SPDX-License-Identifier: MIT */
/* Runs shaders/material.comp: the material of every node, in a scene with several materials. */
#include "compute/material.h"

#include "compute/buffer.h"
#include "core/message.h"
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
    SVO_I_TRY(svo_i_compute_alloc(compute, "entry_counts", info->leaf_count * 4, &s->levels[0].counts));
    SVO_I_TRY(svo_i_compute_alloc(compute, "entry_begins", grandparents * 4, &s->levels[0].begins));
    SVO_I_TRY(svo_i_compute_alloc(compute, "entry_counts", parents * 4, &s->levels[1].counts));
    SVO_I_TRY(svo_i_compute_alloc(compute, "entry_begins", parents * 4, &s->levels[1].begins));
    for (unsigned odd = 0; odd < 2; ++odd) {
        SVO_I_TRY(svo_i_compute_alloc(compute, "entries", fragments * 8, &s->levels[odd].entries));
    }
    SVO_I_TRY(svo_i_compute_alloc(compute, "materials", info->node_count * 2, materials));
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

static svo_status scatter(sorter *s)
{
    svo_i_gl_build *gl_build = s->gl_build;
    const svo_i_gl_surface *surface = s->surface;
    svo_i_compute_fill_zero(gl_build->compute, s->levels[0].counts);
    svo_i_compute_fill_zero(gl_build->compute, s->materials);
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        s->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_MATERIAL_SCATTER,
                                     .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i], surface->vertices,
                                                 surface->indices, surface->records, s->list_begin, s->levels[0].counts,
                                                 s->levels[0].entries},
                                     .params = &s->params,
                                     .items = s->params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status launch_leaves(sorter *s, svo_i_entry entry, const svo_filter_params *params, uint64_t items)
{
    const svo_i_launch launch = {
        .entry = entry,
        .buffers = {s->list_begin, s->levels[0].counts, s->levels[0].entries, s->levels[1].entries, s->materials},
        .params = params,
        .items = items};
    return svo_i_compute_launch(s->gl_build->compute, &launch);
}

/* Sorts leaves of any length in an even number of passes, so that the result ends in the first array. */
static svo_status sort_long_leaves(sorter *s)
{
    const uint64_t fragments = s->gl_build->build->fragment_count;
    svo_filter_params params = s->params;
    params.fragment_count = (cl_uint)fragments;
    SVO_I_TRY(scatter(s));
    for (params.level = 0; fragments >> params.level != 0 || params.level % 2 != 0; ++params.level) {
        SVO_I_TRY(launch_leaves(s, SVO_I_ENTRY_MATERIAL_PASS, &params, fragments));
    }
    params.digit_passes = 1;
    return launch_leaves(s, SVO_I_ENTRY_MATERIAL_LEAVES, &params, params.leaf_count);
}

/* One invocation sorts a leaf, unless a leaf has more triangles than it is given (shaders/compute.glsl). */
static svo_status sort_leaves(sorter *s)
{
    bool exhausted = false;
    SVO_I_TRY(launch_leaves(s, SVO_I_ENTRY_MATERIAL_LEAVES, &s->params, s->params.leaf_count));
    SVO_I_TRY(svo_i_compute_exhausted(s->gl_build->compute, &exhausted));
    return exhausted ? sort_long_leaves(s) : SVO_OK;
}

static svo_status merge_level(sorter *s, uint32_t level)
{
    svo_i_gl_build *gl_build = s->gl_build;
    const svo_tree_info *info = &gl_build->build->tree->info;
    const unsigned odd = (info->depth - level) % 2;
    const level_entries *children = &s->levels[1 - odd];
    const level_entries *nodes = &s->levels[odd];
    const GLuint child_begins = level + 1 == info->depth ? s->list_begin : children->begins;
    svo_i_params_of_level(&s->params, info, level);
    const svo_i_launch launch = {
        .entry = SVO_I_ENTRY_MATERIAL_MERGE,
        .buffers = {gl_build->arrays[SVO_TREE_CHILD_MASK], gl_build->arrays[SVO_TREE_FIRST_CHILD], child_begins,
                    children->counts, children->entries, nodes->begins, nodes->counts, nodes->entries, s->materials},
        .params = &s->params,
        .items = s->params.level_count};
    return svo_i_compute_launch(gl_build->compute, &launch);
}

static svo_status run(sorter *s)
{
    SVO_I_TRY(allocate(s));
    SVO_I_TRY(scatter(s));
    SVO_I_TRY(sort_leaves(s));
    for (uint32_t level = s->gl_build->build->tree->info.depth; level-- > 0;) {
        SVO_I_TRY(merge_level(s, level));
    }
    return SVO_OK;
}

svo_status svo_i_gl_material(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    sorter s = {.gl_build = gl_build,
                .surface = surface,
                .list_begin = gl_build->arrays[SVO_TREE_LIST_BEGIN],
                .params = svo_i_payload_params(gl_build->build)};
    svo_status status = SVO_OK;
    svo_i_compute_stage_begin(gl_build->compute);
    SVO_I_TRY_CLEANUP(run(&s));
    SVO_I_TRY_CLEANUP(svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_FILTER));
    SVO_I_TRY_CLEANUP(svo_i_gl_check_loops(gl_build, "sorting its materials"));
cleanup:
    release(&s);
    return status;
}
