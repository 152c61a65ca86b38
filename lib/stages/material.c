/* SPDX-License-Identifier: MIT */
/*
 * Runs kernels/material.cl: the material of every node. Comes before the filter, which turns the fragments' cursors
 * into links.
 */
#include "build/build.h"

/* Where the entries of a level's nodes are. */
typedef struct level_entries {
    cl_mem begins, counts, entries;
} level_entries;

typedef struct sorter {
    svo_i_build *build;
    const svo_i_surface *surface;
    cl_mem list_begin, materials;
    level_entries levels[2]; /* of levels whose distance from the leaves is even, and odd */
    cl_kernel merge;
    svo_filter_params params;
} sorter;

static svo_status allocate(sorter *s)
{
    svo_i_build *build = s->build;
    const svo_tree_info *info = &build->tree->info;
    const uint64_t parents = info->inner_count - info->level_begin[info->depth - 1];
    const uint64_t grandparents =
        info->depth > 1 ? info->level_begin[info->depth - 1] - info->level_begin[info->depth - 2] : 1;
    svo_status status = svo_i_build_alloc(build, "entry_counts", info->leaf_count * 4, &s->levels[0].counts);
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "entry_begins", grandparents * 4, &s->levels[0].begins);
    }
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "entry_counts", parents * 4, &s->levels[1].counts);
    }
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "entry_begins", parents * 4, &s->levels[1].begins);
    }
    for (unsigned odd = 0; odd < 2 && status == SVO_OK; ++odd) {
        status = svo_i_build_alloc(build, "entries", build->fragment_count * 8, &s->levels[odd].entries);
    }
    return status;
}

static void release(sorter *s)
{
    if (s->merge != NULL) {
        clReleaseKernel(s->merge);
    }
    for (unsigned odd = 0; odd < 2; ++odd) {
        svo_i_build_free(s->build, &s->levels[odd].counts);
        svo_i_build_free(s->build, &s->levels[odd].begins);
        svo_i_build_free(s->build, &s->levels[odd].entries);
    }
}

static svo_status scatter(sorter *s)
{
    svo_i_build *build = s->build;
    svo_status status = svo_i_build_fill_zero(build, s->levels[0].counts, s->params.leaf_count * UINT64_C(4));
    for (uint32_t i = 0; i < build->list.chunk_count && status == SVO_OK; ++i) {
        s->params.fragment_count = (cl_uint)build->list.chunks[i].needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[i].buffer),
                                            SVO_I_ARGUMENT(build->cursors[i]),
                                            SVO_I_ARGUMENT(s->surface->vertices),
                                            SVO_I_ARGUMENT(s->surface->indices),
                                            SVO_I_ARGUMENT(s->surface->records),
                                            SVO_I_ARGUMENT(s->list_begin),
                                            SVO_I_ARGUMENT(s->levels[0].counts),
                                            SVO_I_ARGUMENT(s->levels[0].entries),
                                            SVO_I_ARGUMENT(build->state),
                                            SVO_I_ARGUMENT(s->params)};
        status = svo_i_build_run(build, "svo_k_material_scatter", arguments, 10, s->params.fragment_count);
    }
    return status;
}

static svo_status sort_leaves(sorter *s)
{
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(s->list_begin),
                                        SVO_I_ARGUMENT(s->levels[0].counts),
                                        SVO_I_ARGUMENT(s->levels[0].entries),
                                        SVO_I_ARGUMENT(s->levels[1].entries),
                                        SVO_I_ARGUMENT(s->materials),
                                        SVO_I_ARGUMENT(s->build->state),
                                        SVO_I_ARGUMENT(s->params)};
    return svo_i_build_run(s->build, "svo_k_material_leaves", arguments, 7, s->params.leaf_count);
}

static svo_status merge_level(sorter *s, uint32_t level)
{
    svo_tree *tree = s->build->tree;
    const bool odd = (tree->info.depth - level) % 2 != 0;
    const level_entries *children = &s->levels[odd ? 0 : 1];
    const level_entries *nodes = &s->levels[odd ? 1 : 0];
    const bool of_leaves = level + 1 == tree->info.depth;
    svo_i_params_of_level(&s->params, &tree->info, level);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                        of_leaves ? SVO_I_ARGUMENT(s->list_begin) : SVO_I_ARGUMENT(children->begins),
                                        SVO_I_ARGUMENT(children->counts),
                                        SVO_I_ARGUMENT(children->entries),
                                        SVO_I_ARGUMENT(nodes->begins),
                                        SVO_I_ARGUMENT(nodes->counts),
                                        SVO_I_ARGUMENT(nodes->entries),
                                        SVO_I_ARGUMENT(s->materials),
                                        SVO_I_ARGUMENT(s->build->state),
                                        SVO_I_ARGUMENT(s->params)};
    return svo_i_build_launch(s->build, s->merge, arguments, 11, s->params.level_count);
}

static svo_status run(sorter *s)
{
    svo_status status = allocate(s);
    if (status == SVO_OK) {
        status = svo_i_build_kernel(s->build, "svo_k_material_merge", &s->merge);
    }
    if (status == SVO_OK) {
        status = scatter(s);
    }
    if (status == SVO_OK) {
        status = sort_leaves(s);
    }
    const uint32_t last_level = s->params.payload_level;
    for (uint32_t level = s->build->tree->info.depth; level-- > last_level && status == SVO_OK;) {
        status = merge_level(s, level);
    }
    return status;
}

svo_status svo_i_material(svo_i_build *build, const svo_i_surface *surface)
{
    const svo_tree_info *info = &build->tree->info;
    const bool may_be_empty = info->leaf_count == 0 || build->mode == SVO_I_BUILD_ENQUEUES; /* a root alone */
    svo_status status =
        svo_i_build_alloc(build, "materials", (info->node_count - info->level_begin[info->payload_level]) * 2,
                          &build->tree->buffers[SVO_TREE_MATERIALS]);
    if (status != SVO_OK) {
        return status;
    }
    svo_i_build_stage_begin(build);
    if (may_be_empty && info->payload_level == 0) {
        status = svo_i_build_fill_zero(build, build->tree->buffers[SVO_TREE_MATERIALS], sizeof(cl_ushort));
    }
    if (status != SVO_OK || info->leaf_count == 0) {
        return status == SVO_OK ? svo_i_build_stage_end(build, SVO_STAGE_FILTER) : status;
    }
    sorter s = {.build = build,
                .surface = surface,
                .list_begin = build->tree->buffers[SVO_TREE_LIST_BEGIN],
                .materials = build->tree->buffers[SVO_TREE_MATERIALS],
                .params = svo_i_payload_params(build)};
    status = run(&s);
    if (status == SVO_OK) {
        status = svo_i_build_stage_end(build, SVO_STAGE_FILTER);
    }
    release(&s);
    return status;
}
