/* SPDX-License-Identifier: MIT */
/* SVO_FORM_IMPLIED: child masks breadth-first and the directory, by kernels/compact/implied.cl. */
#include "compact/implied.h"

#include "compact/payload.h"
#include "compact/programs.h"
#include "shared/layout.h"

/* The masks' bits and their exclusive sums, in scratch buffers. */
static svo_status count_children(svo_i_device_work *work, cl_mem masks, uint64_t mask_count, cl_mem *sums)
{
    const svo_compact_params params = {.node_count = (cl_uint)mask_count};
    cl_mem counts = NULL;
    SVO_I_TRY(svo_i_work_alloc(work, "child_counts", mask_count * 4, &counts));
    SVO_I_TRY(svo_i_work_alloc(work, "child_sums", (mask_count + 1) * 4, sums));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(masks), SVO_I_ARGUMENT(counts), SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_implied_counts", SVO_I_ARGUMENTS(arguments), mask_count));
    SVO_I_TRY(svo_i_work_scan(work, counts, *sums, mask_count));
    svo_i_work_free(work, &counts);
    return SVO_OK;
}

static svo_status make_masks(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem sums,
                             svo_compact *compact)
{
    const svo_compact_params params = {.node_count = svo_i_source_level_begin(&source->info, source->info.depth)};
    const uint64_t bytes = compact->info.bytes[SVO_COMPACT_NODES];
    cl_mem *masks = &compact->buffers[SVO_COMPACT_NODES];
    SVO_I_TRY(svo_i_work_result(work, "nodes", bytes, masks));
    SVO_I_TRY(svo_i_work_fill_zero(work, *masks, bytes));
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(source->valid), SVO_I_ARGUMENT(source->leaf), SVO_I_ARGUMENT(source->first_inner),
        SVO_I_ARGUMENT(sums),          SVO_I_ARGUMENT(*masks),       SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_implied_masks", SVO_I_ARGUMENTS(arguments), params.node_count);
}

static svo_status make_directory(svo_i_device_work *work, svo_compact *compact)
{
    const cl_uint step_log2 = compact->info.directory_step_log2;
    const cl_uint entry_count = (cl_uint)(compact->info.bytes[SVO_COMPACT_LINKS] / 4);
    cl_mem *links = &compact->buffers[SVO_COMPACT_LINKS];
    cl_mem sums = NULL;
    SVO_I_TRY(count_children(work, compact->buffers[SVO_COMPACT_NODES], compact->info.stored_count, &sums));
    SVO_I_TRY(svo_i_work_result(work, "links", entry_count * UINT64_C(4), links));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(sums), SVO_I_ARGUMENT(*links), SVO_I_ARGUMENT(step_log2),
                                        SVO_I_ARGUMENT(entry_count)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_implied_directory", SVO_I_ARGUMENTS(arguments), entry_count));
    svo_i_work_free(work, &sums);
    return SVO_OK;
}

/* bases: the first node that has payload. *targets as svo_i_payload_make takes it; scratch. */
static svo_status make_bases(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem sums,
                             svo_compact *compact, cl_mem *targets)
{
    svo_compact_params params = {.node_count = svo_i_source_level_begin(&source->info, source->info.depth)};
    if (!svo_i_compact_has_places(&compact->info)) {
        return SVO_OK;
    }
    for (uint32_t level = 0; level < compact->info.payload_level; ++level) {
        params.child_begin += compact->info.level_inner[level] + compact->info.level_leaf[level];
    }
    cl_mem *bases = &compact->buffers[SVO_COMPACT_BASES];
    SVO_I_TRY(svo_i_work_result(work, "bases", sizeof params.child_begin, bases));
    SVO_I_TRY(svo_i_work_write(work, *bases, &params.child_begin, sizeof params.child_begin));
    SVO_I_TRY(svo_i_work_alloc(work, "payload_targets", params.node_count * UINT64_C(4), targets));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(sums), SVO_I_ARGUMENT(*targets), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_implied_targets", SVO_I_ARGUMENTS(arguments), params.node_count);
}

void svo_i_implied_count(svo_compact_info *info)
{
    info->stored_count = 0;
    for (uint32_t level = 0; level < info->depth; ++level) {
        info->stored_count += (uint64_t)info->level_inner[level] + info->level_leaf[level];
    }
}

svo_status svo_i_implied_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    cl_mem sums = NULL;
    cl_mem targets = NULL;
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_compact, " -DSVO_SORT"));
    svo_i_implied_count(&compact->info);
    svo_i_compact_count(&compact->info);
    SVO_I_TRY(count_children(work, source->valid, svo_i_source_level_begin(&source->info, source->info.depth), &sums));
    SVO_I_TRY(make_masks(work, source, sums, compact));
    SVO_I_TRY(make_bases(work, source, sums, compact, &targets));
    svo_i_work_free(work, &sums);
    SVO_I_TRY(make_directory(work, compact));
    return svo_i_payload_make(work, source, targets, compact);
}
