/* SPDX-License-Identifier: MIT */
/*
 * Counts the entries of each leaf and scans the counts into the beginnings of their ranges. Where leaf lists are
 * needed, scatters the triangles into the ranges and sorts each. Where the order of leaves is needed, scatters the
 * fragments' indices in the same launch.
 */
#include "stages/pack.h"

#include "stages/inputs.h"
#include "stages/programs.h"
#include "stages/sort.h"

typedef struct packer {
    svo_i_build *build;
    cl_mem counts, spare, long_leaves;
    cl_mem list_begin, list;
    svo_filter_params params;
} packer;

/* The most leaves that svo_k_sort_long may have to sort, or 1. */
static uint64_t most_long_leaves(const svo_i_build *build)
{
    return build->fragment_count / (SVO_SHORT_LIST_MAX + 1) + 1;
}

/* Allocates the ranges, and the order where the plan asks for one; with lists the ranges are the tree's. */
static svo_status allocate_ranges(packer *p)
{
    svo_i_build *build = p->build;
    const svo_i_work *work = &build->commands.plan->work;
    cl_mem *list_begin = &build->tree->buffers[SVO_TREE_LIST_BEGIN];
    const uint64_t begin_bytes = (build->tree->info.leaf_count + 1) * 4;
    const svo_i_request requests[] = {{"order", build->fragment_count * 4, &build->order},
                                      {"list_begin", begin_bytes, list_begin}};
    const bool has_order = work->order && build->list.chunk_count == 1;
    if (work->lists) {
        SVO_I_TRY(svo_i_commands_alloc(&build->commands, "list_begin", begin_bytes, list_begin));
    }
    const size_t first = has_order ? 0 : 1;
    const size_t end = work->lists ? 1 : 2;
    SVO_I_TRY(svo_i_commands_alloc_all(&build->commands, requests + first, end > first ? end - first : 0));
    p->list_begin = *list_begin;
    return SVO_OK;
}

/* Allocates what the stage alone needs. */
static svo_status allocate_scratch(packer *p)
{
    svo_i_build *build = p->build;
    const svo_i_request requests[] = {{"list_counts", build->tree->info.leaf_count * 4, &p->counts},
                                      {"list_spare", build->fragment_count * 4, &p->spare},
                                      {"long_leaves", most_long_leaves(build) * 4, &p->long_leaves}};
    return svo_i_commands_alloc_all(&build->commands, requests, build->commands.plan->work.lists ? 3 : 1);
}

static svo_status allocate(packer *p)
{
    svo_i_build *build = p->build;
    SVO_I_TRY(allocate_ranges(p));
    SVO_I_TRY(allocate_scratch(p));
    if (!build->commands.plan->work.lists) {
        return SVO_OK;
    }
    build->tree->info.list_count = build->fragment_count;
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "list", build->fragment_count * 4,
                                   &build->tree->buffers[SVO_TREE_LIST]));
    p->list = build->tree->buffers[SVO_TREE_LIST];
    return SVO_OK;
}

static svo_status count_lists(packer *p)
{
    svo_i_build *build = p->build;
    SVO_I_TRY(svo_i_commands_fill_zero(&build->commands, p->counts, p->params.leaf_count * UINT64_C(4)));
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        p->params.fragment_count = (cl_uint)build->list.chunks[i].needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->cursors[i]), SVO_I_ARGUMENT(p->counts),
                                            SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(p->params)};
        SVO_I_TRY(svo_i_commands_run(&p->build->commands, svo_i_build_program(p->build, &svo_i_program_pack),
                                     "svo_k_count", SVO_I_ARGUMENTS(arguments), p->params.fragment_count));
    }
    return SVO_OK;
}

static svo_status scatter(packer *p)
{
    svo_i_build *build = p->build;
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        p->params.fragment_count = (cl_uint)build->list.chunks[i].needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[i].buffer),
                                            SVO_I_ARGUMENT(build->cursors[i]),
                                            SVO_I_ARGUMENT(p->counts),
                                            SVO_I_ARGUMENT(p->list_begin),
                                            SVO_I_ARGUMENT(p->list),
                                            SVO_I_ARGUMENT(build->order),
                                            SVO_I_ARGUMENT(build->state),
                                            SVO_I_ARGUMENT(p->params)};
        SVO_I_TRY(svo_i_commands_run(&p->build->commands, svo_i_build_program(p->build, &svo_i_program_pack),
                                     "svo_k_scatter", SVO_I_ARGUMENTS(arguments), p->params.fragment_count));
    }
    return SVO_OK;
}

static svo_status sort_lists(packer *p)
{
    svo_i_build *build = p->build;
    const svo_i_argument short_lists[] = {SVO_I_ARGUMENT(p->list_begin), SVO_I_ARGUMENT(p->list),
                                          SVO_I_ARGUMENT(p->long_leaves), SVO_I_ARGUMENT(build->state),
                                          SVO_I_ARGUMENT(p->params)};
    SVO_I_TRY(svo_i_commands_run(&p->build->commands, svo_i_build_program(p->build, &svo_i_program_pack),
                                 "svo_k_sort_short", SVO_I_ARGUMENTS(short_lists), p->params.leaf_count));
    const svo_i_argument long_lists[] = {SVO_I_ARGUMENT(p->list_begin),
                                         SVO_I_ARGUMENT(p->list),
                                         SVO_I_ARGUMENT(p->spare),
                                         SVO_I_ARGUMENT(p->long_leaves),
                                         SVO_I_ARGUMENT(build->state),
                                         SVO_I_ARGUMENT(p->params),
                                         SVO_I_LOCAL(sizeof(cl_uint) * SVO_DIGITS * SVO_GROUP_ITEMS),
                                         SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint))};
    const uint64_t most = most_long_leaves(build);
    const uint64_t groups = most < build->commands.device->scan_groups ? most : build->commands.device->scan_groups;
    return svo_i_commands_run(&p->build->commands, svo_i_build_program(p->build, &svo_i_program_pack),
                              "svo_k_sort_long", SVO_I_ARGUMENTS(long_lists), groups * SVO_GROUP_ITEMS);
}

static svo_status run(packer *p)
{
    SVO_I_TRY(allocate(p));
    SVO_I_TRY(count_lists(p));
    SVO_I_TRY(svo_i_scan_lists(p->build, &svo_i_program_pack, p->counts, p->list_begin, p->build->state, p->params));
    SVO_I_TRY(p->list != NULL || p->build->order != NULL ? scatter(p) : SVO_OK);
    SVO_I_TRY(p->list != NULL ? sort_lists(p) : SVO_OK);
    return svo_i_stage_end(&p->build->commands, SVO_STAGE_PACK);
}

svo_status svo_i_pack(svo_i_build *build)
{
    if (!build->commands.plan->work.ranges && build->list.chunk_count != 1) {
        return SVO_OK; /* chunks are gathered in any order */
    }
    const svo_tree_info *info = &build->tree->info;
    packer p = {.build = build,
                .params = {.depth = info->depth,
                           .leaf_begin = (cl_uint)info->inner_count,
                           .leaf_count = (cl_uint)info->leaf_count,
                           .digit_passes = svo_i_digit_passes(build->commands.plan->triangle_count)}};
    svo_i_stage_begin(&build->commands);
    const svo_status status = run(&p);
    svo_i_commands_free(&build->commands, &p.counts);
    svo_i_commands_free(&build->commands, &p.spare);
    svo_i_commands_free(&build->commands, &p.long_leaves);
    return status;
}
