/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/material.comp: the material of every node, of a scene that has several.
 */
#include "compute/material.h"

#include "compute/buffer.h"
#include "stages/payload_params.h"

/* Where the entries of a level's nodes are. */
typedef struct level_entries {
    GLuint begins, counts, entries;
} level_entries;

typedef struct sorter {
    svo_i_gl_build *gl_build;
    const svo_i_gl_surface *surface;
    GLuint list_begin, materials;
    level_entries levels[2]; /* of levels whose distance from the leaves is even, and odd */
    svo_filter_params params;
} sorter;

static svo_status allocate(sorter *s)
{
    svo_i_compute *compute = s->gl_build->compute;
    const svo_tree_info *info = &s->gl_build->build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t grandparents =
        info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    svo_status status = svo_i_compute_alloc(compute, "entry_counts", info->leaf_count * 4, &s->levels[0].counts);
    if (status == SVO_OK) {
        status = svo_i_compute_alloc(compute, "entry_begins", grandparents * 4, &s->levels[0].begins);
    }
    if (status == SVO_OK) {
        status = svo_i_compute_alloc(compute, "entry_counts", parents * 4, &s->levels[1].counts);
    }
    if (status == SVO_OK) {
        status = svo_i_compute_alloc(compute, "entry_begins", parents * 4, &s->levels[1].begins);
    }
    for (unsigned odd = 0; odd < 2 && status == SVO_OK; ++odd) {
        status =
            svo_i_compute_alloc(compute, "entries", s->gl_build->build->fragment_count * 8, &s->levels[odd].entries);
    }
    if (status == SVO_OK) {
        status =
            svo_i_compute_alloc(compute, "materials", info->node_count * 2, &s->gl_build->arrays[SVO_TREE_MATERIALS]);
    }
    s->materials = s->gl_build->arrays[SVO_TREE_MATERIALS];
    return status;
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
    svo_status status = SVO_OK;
    svo_i_compute_fill_zero(gl_build->compute, s->levels[0].counts);
    svo_i_compute_fill_zero(gl_build->compute, s->materials);
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count && status == SVO_OK; ++i) {
        s->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        status = svo_i_compute_launch(
            gl_build->compute, &(svo_i_launch){.entry = SVO_I_ENTRY_MATERIAL_SCATTER,
                                               .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i],
                                                           surface->vertices, surface->indices, surface->records,
                                                           s->list_begin, s->levels[0].counts, s->levels[0].entries},
                                               .params = &s->params,
                                               .items = s->params.fragment_count});
    }
    return status;
}

static svo_status launch_leaves(sorter *s, svo_i_entry entry, const svo_filter_params *params, uint64_t items)
{
    return svo_i_compute_launch(s->gl_build->compute,
                                &(svo_i_launch){.entry = entry,
                                                .buffers = {s->list_begin, s->levels[0].counts, s->levels[0].entries,
                                                            s->levels[1].entries, s->materials},
                                                .params = params,
                                                .items = items});
}

/* Sorts leaves of any length, pass by pass: an even number of them, so that the result ends where it began. */
static svo_status sort_long_leaves(sorter *s)
{
    const uint64_t fragments = s->gl_build->build->fragment_count;
    svo_filter_params params = s->params;
    params.fragment_count = (cl_uint)fragments;
    svo_status status = scatter(s);
    for (params.level = 0; (fragments >> params.level != 0 || params.level % 2 != 0) && status == SVO_OK;
         ++params.level) {
        status = launch_leaves(s, SVO_I_ENTRY_MATERIAL_PASS, &params, fragments);
    }
    params.digit_passes = 1;
    return status == SVO_OK ? launch_leaves(s, SVO_I_ENTRY_MATERIAL_LEAVES, &params, params.leaf_count) : status;
}

/* One invocation sorts a leaf, unless some leaf has more triangles than it may turn loops for
   (shaders/compute.glsl). */
static svo_status sort_leaves(sorter *s)
{
    bool exhausted = false;
    svo_status status = launch_leaves(s, SVO_I_ENTRY_MATERIAL_LEAVES, &s->params, s->params.leaf_count);
    if (status == SVO_OK) {
        status = svo_i_compute_exhausted(s->gl_build->compute, &exhausted);
    }
    return status == SVO_OK && exhausted ? sort_long_leaves(s) : status;
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
    return svo_i_compute_launch(
        gl_build->compute,
        &(svo_i_launch){.entry = SVO_I_ENTRY_MATERIAL_MERGE,
                        .buffers = {gl_build->arrays[SVO_TREE_CHILD_MASK], gl_build->arrays[SVO_TREE_FIRST_CHILD],
                                    child_begins, children->counts, children->entries, nodes->begins, nodes->counts,
                                    nodes->entries, s->materials},
                        .params = &s->params,
                        .items = s->params.level_count});
}

static svo_status run(sorter *s)
{
    svo_status status = allocate(s);
    if (status == SVO_OK) {
        status = scatter(s);
    }
    if (status == SVO_OK) {
        status = sort_leaves(s);
    }
    for (uint32_t level = s->gl_build->build->tree->info.depth; level-- > 0 && status == SVO_OK;) {
        status = merge_level(s, level);
    }
    return status;
}

svo_status svo_i_gl_material(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    sorter s = {.gl_build = gl_build,
                .surface = surface,
                .list_begin = gl_build->arrays[SVO_TREE_LIST_BEGIN],
                .params = svo_i_payload_params(gl_build->build)};
    svo_i_compute_stage_begin(gl_build->compute);
    svo_status status = run(&s);
    if (status == SVO_OK) {
        status = svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_FILTER);
    }
    if (status == SVO_OK) {
        status = svo_i_gl_check_loops(gl_build, "sorting its materials");
    }
    release(&s);
    return status;
}
