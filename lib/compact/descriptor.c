/* SPDX-License-Identifier: MIT */
/*
 * SVO_FORM_DESCRIPTOR: sizes of subtrees bottom-up, places top-down, words. The kernels are in kernels/compact, one
 * file per stage.
 */
#include "compact/descriptor.h"

#include "compact/payload.h"
#include "compact/programs.h"
#include "shared/descriptor.h"
#include "shared/layout.h"

/* What the stages hand on: an element per inner node. */
typedef struct words {
    svo_i_device_work *work;
    const svo_i_compact_source *source;
    cl_mem sizes; /* u32: words of its descendants */
    cl_mem far; /* u8: those of its inner children that have far words */
    cl_mem places; /* u32: of its word */
    cl_mem groups; /* u32: the first word of its inner children */
} words;

static svo_compact_params level_params(const svo_i_compact_source *source, uint32_t level)
{
    return (svo_compact_params){.first_node = svo_i_source_level_begin(&source->info, level),
                                .node_count = source->info.level_inner[level]};
}

static svo_status find_sizes(const words *w)
{
    for (uint32_t level = w->source->info.depth; level-- > 0;) {
        const svo_compact_params params = level_params(w->source, level);
        const svo_i_argument arguments[] = {
            SVO_I_ARGUMENT(w->source->valid), SVO_I_ARGUMENT(w->source->leaf), SVO_I_ARGUMENT(w->source->first_inner),
            SVO_I_ARGUMENT(w->sizes),         SVO_I_ARGUMENT(w->far),          SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(w->work, "svo_k_compact_sizes", SVO_I_ARGUMENTS(arguments), params.node_count));
    }
    return SVO_OK;
}

static svo_status find_places(const words *w)
{
    const cl_uint root_word = 0;
    const cl_uint root_group = 1;
    SVO_I_TRY(svo_i_work_write(w->work, w->places, &root_word, sizeof root_word));
    SVO_I_TRY(svo_i_work_write(w->work, w->groups, &root_group, sizeof root_group));
    for (uint32_t level = 0; level + 1 < w->source->info.depth; ++level) {
        const svo_compact_params params = level_params(w->source, level);
        const svo_i_argument arguments[] = {
            SVO_I_ARGUMENT(w->source->valid), SVO_I_ARGUMENT(w->source->leaf), SVO_I_ARGUMENT(w->source->first_inner),
            SVO_I_ARGUMENT(w->sizes),         SVO_I_ARGUMENT(w->far),          SVO_I_ARGUMENT(w->places),
            SVO_I_ARGUMENT(w->groups),        SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(w->work, "svo_k_compact_places", SVO_I_ARGUMENTS(arguments), params.node_count));
    }
    return SVO_OK;
}

static svo_status write_words(const words *w, cl_mem nodes)
{
    const svo_compact_params params = {.node_count = svo_i_source_level_begin(&w->source->info, w->source->info.depth)};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(w->source->valid),
                                        SVO_I_ARGUMENT(w->source->leaf),
                                        SVO_I_ARGUMENT(w->source->first_inner),
                                        SVO_I_ARGUMENT(w->sizes),
                                        SVO_I_ARGUMENT(w->far),
                                        SVO_I_ARGUMENT(w->groups),
                                        SVO_I_ARGUMENT(nodes),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(w->work, "svo_k_compact_words", SVO_I_ARGUMENTS(arguments), params.node_count);
}

/* A member of a group is far from its children if its elder siblings' descendants take that many words: the group
   itself and its far words are 16 at most. */
#define FAR_WORDS_MIN (SVO_WORD_DISTANCE_MAX - 15u)

void svo_i_descriptor_count(svo_compact_info *info)
{
    const uint64_t inner_count = svo_i_source_level_begin(info, info->depth);
    /* Seven members of a group at most are far, and only if its descendants are FAR_WORDS_MIN words. Those of a level's
       groups are disjoint, so there are at most 7 (depth - 1) words / FAR_WORDS_MIN, far ones included. */
    const uint64_t far_per_words = 7 * (uint64_t)(info->depth - 1);
    info->far_count =
        inner_count > SVO_WORD_DISTANCE_MAX ? far_per_words * inner_count / (FAR_WORDS_MIN - far_per_words) : 0;
    info->stored_count = inner_count + info->far_count;
}

svo_status svo_i_descriptor_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    const uint64_t inner_count = svo_i_source_level_begin(&source->info, source->info.depth);
    words w = {.work = work, .source = source};
    cl_mem targets = NULL;
    cl_uint below_root = 0;
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_compact, " -DSVO_SORT"));
    SVO_I_TRY(svo_i_work_alloc(work, "word_sizes", inner_count * 4, &w.sizes));
    SVO_I_TRY(svo_i_work_alloc(work, "word_far", inner_count, &w.far));
    SVO_I_TRY(svo_i_work_alloc(work, "word_places", inner_count * 4, &w.places));
    SVO_I_TRY(svo_i_work_alloc(work, "word_groups", inner_count * 4, &w.groups));
    SVO_I_TRY(find_sizes(&w));
    SVO_I_TRY(svo_i_work_read(work, w.sizes, 0, &below_root, sizeof below_root));
    compact->info.stored_count = 1 + (uint64_t)below_root;
    compact->info.far_count = compact->info.stored_count - inner_count;
    svo_i_compact_count(&compact->info);
    SVO_I_TRY(find_places(&w));
    SVO_I_TRY(
        svo_i_work_result(work, "nodes", compact->info.bytes[SVO_COMPACT_NODES], &compact->buffers[SVO_COMPACT_NODES]));
    SVO_I_TRY(write_words(&w, compact->buffers[SVO_COMPACT_NODES]));
    svo_i_work_free(work, &w.sizes);
    svo_i_work_free(work, &w.far);
    svo_i_work_free(work, &w.groups);
    SVO_I_TRY(svo_i_payload_bases(work, source, w.places, compact, &targets));
    svo_i_work_free(work, &w.places);
    return svo_i_payload_make(work, source, targets, compact);
}
