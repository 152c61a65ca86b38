/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/pack.comp and the list scans of shaders/scan.comp: computes where each leaf's range of entries begins
 * and, for requests that read them, the sorted lists of the leaves.
 */
#include "compute/pack.h"

#include "compute/buffer.h"
#include "core/message.h"
#include "stages/inputs.h"

typedef struct packer {
    svo_i_gl_build *gl_build;
    GLuint counts, spare, long_leaves;
    GLuint launches; /* groups that sort long lists */
    svo_filter_params params;
} packer;

static svo_status allocate_lists(packer *p)
{
    static const uint32_t no_groups[3] = {0, 1, 1};
    svo_i_gl_build *gl_build = p->gl_build;
    const uint64_t fragments = gl_build->build->fragment_count;
    gl_build->build->tree->info.list_count = fragments;
    const uint64_t long_leaves = fragments / (SVO_SHORT_LIST_MAX + 1) + 1;
    svo_i_compute *compute = gl_build->compute;
    SVO_I_TRY(svo_i_compute_alloc(compute, "list", fragments * 4, &gl_build->arrays[SVO_TREE_LIST]));
    SVO_I_TRY(svo_i_compute_alloc(compute, "list_spare", fragments * 4, &p->spare));
    SVO_I_TRY(svo_i_compute_alloc(compute, "long_leaves", long_leaves * 4, &p->long_leaves));
    return svo_i_compute_upload(compute, "launches", no_groups, sizeof no_groups, &p->launches);
}

static svo_status count_lists(packer *p)
{
    svo_i_gl_build *gl_build = p->gl_build;
    const uint64_t bytes = p->params.leaf_count * UINT64_C(4);
    SVO_I_TRY(svo_i_compute_alloc_zero(gl_build->compute, "list_counts", bytes, &p->counts));
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        p->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_COUNT,
                                     .buffers = {gl_build->cursors[i], p->counts},
                                     .params = &p->params,
                                     .items = p->params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status scan_lists(packer *p)
{
    const uint64_t items = (uint64_t)SVO_SCAN_GROUPS * SVO_GROUP_ITEMS;
    const GLuint partials = p->gl_build->partials;
    const GLuint list_begin = p->gl_build->arrays[SVO_TREE_LIST_BEGIN];
    const svo_i_launch launches[] = {{.entry = SVO_I_ENTRY_SCAN_LISTS_REDUCE,
                                      .buffers = {p->counts, partials},
                                      .params = &p->params,
                                      .items = items},
                                     {.entry = SVO_I_ENTRY_SCAN_LISTS_PARTIALS,
                                      .buffers = {partials, list_begin},
                                      .params = &p->params,
                                      .items = SVO_GROUP_ITEMS},
                                     {.entry = SVO_I_ENTRY_SCAN_LISTS_ADD,
                                      .buffers = {p->counts, partials, list_begin},
                                      .params = &p->params,
                                      .items = items}};
    for (unsigned i = 0; i < 3; ++i) {
        SVO_I_TRY(svo_i_compute_launch(p->gl_build->compute, &launches[i]));
    }
    return SVO_OK;
}

static svo_status scatter(packer *p)
{
    svo_i_gl_build *gl_build = p->gl_build;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        p->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_SCATTER,
                                     .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i], p->counts,
                                                 gl_build->arrays[SVO_TREE_LIST_BEGIN],
                                                 gl_build->arrays[SVO_TREE_LIST]},
                                     .params = &p->params,
                                     .items = p->params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status sort_lists(packer *p)
{
    svo_i_gl_build *gl_build = p->gl_build;
    const GLuint list_begin = gl_build->arrays[SVO_TREE_LIST_BEGIN];
    const GLuint list = gl_build->arrays[SVO_TREE_LIST];
    const svo_i_launch sort_short = {.entry = SVO_I_ENTRY_SORT_SHORT,
                                     .buffers = {list_begin, list, p->long_leaves, gl_build->state, p->launches},
                                     .params = &p->params,
                                     .items = p->params.leaf_count};
    SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &sort_short));
    svo_filter_params pass = p->params; /* level: which digit */
    const svo_i_launch sort_long = {.entry = SVO_I_ENTRY_SORT_LONG,
                                    .buffers = {list_begin, list, p->spare, p->long_leaves, gl_build->state},
                                    .params = &pass,
                                    .indirect = p->launches};
    for (pass.level = 0; pass.level < pass.digit_passes; ++pass.level) {
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &sort_long));
    }
    return SVO_OK;
}

static svo_status make_ranges(packer *p)
{
    const uint64_t bytes = (p->params.leaf_count + UINT64_C(1)) * 4;
    GLuint *list_begin = &p->gl_build->arrays[SVO_TREE_LIST_BEGIN];
    SVO_I_TRY(svo_i_compute_alloc(p->gl_build->compute, "list_begin", bytes, list_begin));
    SVO_I_TRY(count_lists(p));
    return scan_lists(p);
}

static svo_status make_lists(packer *p)
{
    SVO_I_TRY(allocate_lists(p));
    SVO_I_TRY(scatter(p));
    return sort_lists(p);
}

svo_status svo_i_gl_pack(svo_i_gl_build *gl_build, bool with_lists)
{
    packer p = {.gl_build = gl_build, .params = svo_i_payload_params(gl_build->build)};
    p.params.digit_passes = svo_i_digit_passes(gl_build->build->commands.plan->triangle_count);
    GLuint *scratch[] = {&p.counts, &p.spare, &p.long_leaves, &p.launches};
    svo_status status = SVO_OK;
    svo_i_compute_stage_begin(gl_build->compute);
    SVO_I_TRY_CLEANUP(make_ranges(&p));
    if (with_lists) {
        SVO_I_TRY_CLEANUP(make_lists(&p));
    }
    SVO_I_TRY_CLEANUP(svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_PACK));
    if (with_lists) {
        SVO_I_TRY_CLEANUP(svo_i_gl_check_loops(gl_build, "sorting them"));
    }
cleanup:
    for (unsigned i = 0; i < sizeof scratch / sizeof scratch[0]; ++i) {
        svo_i_compute_free(gl_build->compute, scratch[i]);
    }
    return status;
}
