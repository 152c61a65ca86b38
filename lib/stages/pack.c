/* SPDX-License-Identifier: MIT */
/*
 * Runs kernels/pack.cl and the list scans of kernels/scan.cl: where each leaf's range of entries begins, and sorted
 * leaf lists, for requests that read them.
 */
#include "build/build.h"

typedef struct packer {
    svo_i_build *build;
    cl_mem counts, spare, long_leaves;
    cl_mem list_begin, list;
    svo_filter_params params;
} packer;

static svo_status allocate_ranges(packer *p)
{
    svo_i_build *build = p->build;
    const svo_tree_info *info = &build->tree->info;
    svo_status status =
        svo_i_build_alloc(build, "list_begin", (info->leaf_count + 1) * 4, &build->tree->buffers[SVO_TREE_LIST_BEGIN]);
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "list_counts", info->leaf_count * 4, &p->counts);
    }
    p->list_begin = build->tree->buffers[SVO_TREE_LIST_BEGIN];
    return status;
}

static svo_status allocate_lists(packer *p)
{
    svo_i_build *build = p->build;
    const uint64_t long_leaves = build->fragment_count / (SVO_SHORT_LIST_MAX + 1) + 1;
    build->tree->info.list_count = build->fragment_count;
    svo_status status =
        svo_i_build_alloc(build, "list", build->fragment_count * 4, &build->tree->buffers[SVO_TREE_LIST]);
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "list_spare", build->fragment_count * 4, &p->spare);
    }
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, "long_leaves", long_leaves * 4, &p->long_leaves);
    }
    p->list = build->tree->buffers[SVO_TREE_LIST];
    return status;
}

static svo_status count_lists(packer *p)
{
    svo_i_build *build = p->build;
    svo_status status = svo_i_build_fill_zero(build, p->counts, p->params.leaf_count * UINT64_C(4));
    for (uint32_t i = 0; i < build->list.chunk_count && status == SVO_OK; ++i) {
        p->params.fragment_count = (cl_uint)build->list.chunks[i].needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->cursors[i]), SVO_I_ARGUMENT(p->counts),
                                            SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(p->params)};
        status = svo_i_build_run(p->build, "svo_k_count", arguments, 4, p->params.fragment_count);
    }
    return status;
}

static svo_status scan_lists(packer *p)
{
    svo_i_build *build = p->build;
    const uint64_t items = (uint64_t)SVO_SCAN_GROUPS * SVO_GROUP_ITEMS;
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(p->counts), SVO_I_ARGUMENT(build->partials),
                                     SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(p->params), scratch};
    const svo_i_argument partials[] = {SVO_I_ARGUMENT(build->partials), SVO_I_ARGUMENT(p->list_begin),
                                       SVO_I_ARGUMENT(build->state), SVO_I_ARGUMENT(p->params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(p->counts),     SVO_I_ARGUMENT(build->partials),
                                  SVO_I_ARGUMENT(p->list_begin), SVO_I_ARGUMENT(build->state),
                                  SVO_I_ARGUMENT(p->params),     scratch};
    svo_status status = svo_i_build_run(p->build, "svo_k_scan_lists_reduce", reduce, 5, items);
    if (status == SVO_OK) {
        status = svo_i_build_run(p->build, "svo_k_scan_lists_partials", partials, 5, SVO_GROUP_ITEMS);
    }
    return status == SVO_OK ? svo_i_build_run(p->build, "svo_k_scan_lists_add", add, 6, items) : status;
}

static svo_status scatter(packer *p)
{
    svo_i_build *build = p->build;
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < build->list.chunk_count && status == SVO_OK; ++i) {
        p->params.fragment_count = (cl_uint)build->list.chunks[i].needed;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.chunks[i].buffer),
                                            SVO_I_ARGUMENT(build->cursors[i]),
                                            SVO_I_ARGUMENT(p->counts),
                                            SVO_I_ARGUMENT(p->list_begin),
                                            SVO_I_ARGUMENT(p->list),
                                            SVO_I_ARGUMENT(build->state),
                                            SVO_I_ARGUMENT(p->params)};
        status = svo_i_build_run(p->build, "svo_k_scatter", arguments, 7, p->params.fragment_count);
    }
    return status;
}

static svo_status sort_lists(packer *p)
{
    svo_i_build *build = p->build;
    const svo_i_argument short_lists[] = {SVO_I_ARGUMENT(p->list_begin), SVO_I_ARGUMENT(p->list),
                                          SVO_I_ARGUMENT(p->long_leaves), SVO_I_ARGUMENT(build->state),
                                          SVO_I_ARGUMENT(p->params)};
    svo_status status = svo_i_build_run(p->build, "svo_k_sort_short", short_lists, 5, p->params.leaf_count);
    const svo_i_argument long_lists[] = {SVO_I_ARGUMENT(p->list_begin),
                                         SVO_I_ARGUMENT(p->list),
                                         SVO_I_ARGUMENT(p->spare),
                                         SVO_I_ARGUMENT(p->long_leaves),
                                         SVO_I_ARGUMENT(build->state),
                                         SVO_I_ARGUMENT(p->params),
                                         SVO_I_LOCAL(sizeof(cl_uint) * SVO_DIGITS * SVO_GROUP_ITEMS),
                                         SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint))};
    if (status == SVO_OK) {
        status =
            svo_i_build_run(p->build, "svo_k_sort_long", long_lists, 8, (uint64_t)SVO_SCAN_GROUPS * SVO_GROUP_ITEMS);
    }
    return status;
}

uint32_t svo_i_digit_passes(uint32_t triangle_count)
{
    uint32_t passes = 0;
    while (passes < 32 / SVO_DIGIT_BITS && triangle_count > 1u &&
           ((triangle_count - 1u) >> (SVO_DIGIT_BITS * passes)) != 0) {
        passes += 2;
    }
    return passes;
}

static svo_status make_ranges(packer *p)
{
    svo_status status = allocate_ranges(p);
    if (status == SVO_OK) {
        status = count_lists(p);
    }
    return status == SVO_OK ? scan_lists(p) : status;
}

static svo_status make_lists(packer *p)
{
    svo_status status = allocate_lists(p);
    if (status == SVO_OK) {
        status = scatter(p);
    }
    return status == SVO_OK ? sort_lists(p) : status;
}

svo_status svo_i_pack(svo_i_build *build, bool with_lists)
{
    const svo_tree_info *info = &build->tree->info;
    packer p = {.build = build,
                .params = {.depth = info->depth,
                           .leaf_begin = (cl_uint)info->inner_count,
                           .leaf_count = (cl_uint)info->leaf_count,
                           .digit_passes = svo_i_digit_passes(build->plan->triangle_count)}};
    svo_i_build_stage_begin(build);
    svo_status status = make_ranges(&p);
    if (status == SVO_OK && with_lists) {
        status = make_lists(&p);
    }
    if (status == SVO_OK) {
        status = svo_i_build_stage_end(build, SVO_STAGE_PACK);
    }
    svo_i_build_free(build, &p.counts);
    svo_i_build_free(build, &p.spare);
    svo_i_build_free(build, &p.long_leaves);
    return status;
}
