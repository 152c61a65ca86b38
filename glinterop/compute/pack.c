/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/pack.comp and the list scans of shaders/scan.comp: where each leaf's range of entries begins, and sorted
 * leaf lists, for requests that read them.
 */
#include "compute/pack.h"

#include "compute/buffer.h"
#include "stages/payload_params.h"

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
    svo_status status = svo_i_compute_alloc(gl_build->compute, "list", fragments * 4, &gl_build->arrays[SVO_TREE_LIST]);
    if (status == SVO_OK) {
        status = svo_i_compute_alloc(gl_build->compute, "list_spare", fragments * 4, &p->spare);
    }
    if (status == SVO_OK) {
        status = svo_i_compute_alloc(gl_build->compute, "long_leaves", (fragments / (SVO_SHORT_LIST_MAX + 1) + 1) * 4,
                                     &p->long_leaves);
    }
    return status == SVO_OK
               ? svo_i_compute_upload(gl_build->compute, "launches", no_groups, sizeof no_groups, &p->launches)
               : status;
}

static svo_status count_lists(packer *p)
{
    svo_i_gl_build *gl_build = p->gl_build;
    svo_status status =
        svo_i_compute_alloc_zero(gl_build->compute, "list_counts", p->params.leaf_count * UINT64_C(4), &p->counts);
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count && status == SVO_OK; ++i) {
        p->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        status = svo_i_compute_launch(gl_build->compute, &(svo_i_launch){.entry = SVO_I_ENTRY_COUNT,
                                                                         .buffers = {gl_build->cursors[i], p->counts},
                                                                         .params = &p->params,
                                                                         .items = p->params.fragment_count});
    }
    return status;
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
    svo_status status = SVO_OK;
    for (unsigned i = 0; i < 3 && status == SVO_OK; ++i) {
        status = svo_i_compute_launch(p->gl_build->compute, &launches[i]);
    }
    return status;
}

static svo_status scatter(packer *p)
{
    svo_i_gl_build *gl_build = p->gl_build;
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count && status == SVO_OK; ++i) {
        p->params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        status = svo_i_compute_launch(
            gl_build->compute,
            &(svo_i_launch){.entry = SVO_I_ENTRY_SCATTER,
                            .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i], p->counts,
                                        gl_build->arrays[SVO_TREE_LIST_BEGIN], gl_build->arrays[SVO_TREE_LIST]},
                            .params = &p->params,
                            .items = p->params.fragment_count});
    }
    return status;
}

static svo_status sort_lists(packer *p)
{
    svo_i_gl_build *gl_build = p->gl_build;
    const GLuint list_begin = gl_build->arrays[SVO_TREE_LIST_BEGIN];
    const GLuint list = gl_build->arrays[SVO_TREE_LIST];
    svo_status status = svo_i_compute_launch(
        gl_build->compute, &(svo_i_launch){.entry = SVO_I_ENTRY_SORT_SHORT,
                                           .buffers = {list_begin, list, p->long_leaves, gl_build->state, p->launches},
                                           .params = &p->params,
                                           .items = p->params.leaf_count});
    svo_filter_params pass = p->params; /* level: which digit */
    for (pass.level = 0; pass.level < pass.digit_passes && status == SVO_OK; ++pass.level) {
        status = svo_i_compute_launch(
            gl_build->compute, &(svo_i_launch){.entry = SVO_I_ENTRY_SORT_LONG,
                                               .buffers = {list_begin, list, p->spare, p->long_leaves, gl_build->state},
                                               .params = &pass,
                                               .indirect = p->launches});
    }
    return status;
}

static svo_status make_ranges(packer *p)
{
    const uint64_t bytes = (p->params.leaf_count + UINT64_C(1)) * 4;
    svo_status status =
        svo_i_compute_alloc(p->gl_build->compute, "list_begin", bytes, &p->gl_build->arrays[SVO_TREE_LIST_BEGIN]);
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

svo_status svo_i_gl_pack(svo_i_gl_build *gl_build, bool with_lists)
{
    packer p = {.gl_build = gl_build, .params = svo_i_payload_params(gl_build->build)};
    p.params.digit_passes = svo_i_digit_passes(gl_build->build->commands.plan->triangle_count);
    svo_i_compute_stage_begin(gl_build->compute);
    svo_status status = make_ranges(&p);
    if (status == SVO_OK && with_lists) {
        status = make_lists(&p);
    }
    if (status == SVO_OK) {
        status = svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_PACK);
    }
    if (status == SVO_OK && with_lists) {
        status = svo_i_gl_check_loops(gl_build, "sorting them");
    }
    GLuint *scratch[] = {&p.counts, &p.spare, &p.long_leaves, &p.launches};
    for (unsigned i = 0; i < sizeof scratch / sizeof scratch[0]; ++i) {
        svo_i_compute_free(gl_build->compute, scratch[i]);
    }
    return status;
}
