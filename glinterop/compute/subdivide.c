/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/subdivide.comp and the mask scans of shaders/scan.comp for all levels, without reading anything back
 * between them. Only the device knows the size of a level, so the scans are launched indirectly. The host reads the
 * counts once, at the end.
 */
#include "compute/subdivide.h"

#include <string.h>

#include "compute/buffer.h"
#include "core/message.h"

typedef struct subdivider {
    svo_i_gl_build *gl_build;
    GLuint masks, first_child;
    GLuint launches; /* groups of each level's scans, three words per level */
} subdivider;

/* Starts with a root without children: only the root's scans have work. */
static svo_status begin(subdivider *s)
{
    svo_i_gl_build *gl_build = s->gl_build;
    svo_build_state state;
    uint32_t launches[3 * SVO_LEVELS_MAX];
    memset(&state, 0, sizeof state);
    state.triangle_count = gl_build->build->commands.plan->triangle_count;
    for (unsigned level = 0; level < SVO_LEVELS_MAX; ++level) {
        state.level_begin[level] = level > 0 ? 1 : 0;
        launches[(size_t)3 * level] = level > 0 ? 0 : 1;
        launches[(size_t)3 * level + 1] = 1;
        launches[(size_t)3 * level + 2] = 1;
    }
    svo_i_compute_free(gl_build->compute, &gl_build->state);
    svo_i_compute *compute = gl_build->compute;
    SVO_I_TRY(svo_i_compute_upload(compute, "state", &state, sizeof state, &gl_build->state));
    SVO_I_TRY(svo_i_compute_upload(compute, "launches", launches, sizeof launches, &s->launches));
    if (gl_build->partials == 0) {
        const uint64_t bytes = SVO_SCAN_GROUPS * sizeof(GLuint);
        SVO_I_TRY(svo_i_compute_alloc(compute, "partials", bytes, &gl_build->partials));
    }
    svo_i_compute_fill_zero(compute, s->masks);
    return SVO_OK;
}

static svo_status mark_root(subdivider *s, svo_subdivide_params params)
{
    svo_i_gl_build *gl_build = s->gl_build;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_MARK,
                                     .buffers = {svo_i_gl_chunk(gl_build, i), s->masks, gl_build->state},
                                     .params = &params,
                                     .items = params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

/* Computes first_child of the level's nodes, and where the level after the next begins. */
static svo_status scan_level(subdivider *s, svo_subdivide_params params)
{
    svo_i_compute *compute = s->gl_build->compute;
    const GLuint partials = s->gl_build->partials;
    const GLuint state = s->gl_build->state;
    const svo_i_launch launches[] = {{.entry = SVO_I_ENTRY_SCAN_MASKS_REDUCE,
                                      .buffers = {s->masks, partials, state},
                                      .params = &params,
                                      .indirect = s->launches,
                                      .indirect_word = 3 * params.level},
                                     {.entry = SVO_I_ENTRY_SCAN_MASKS_PARTIALS,
                                      .buffers = {partials, state, s->launches},
                                      .params = &params,
                                      .items = SVO_GROUP_ITEMS},
                                     {.entry = SVO_I_ENTRY_SCAN_MASKS_ADD,
                                      .buffers = {s->masks, partials, s->first_child, state},
                                      .params = &params,
                                      .indirect = s->launches,
                                      .indirect_word = 3 * params.level}};
    for (unsigned i = 0; i < 3; ++i) {
        SVO_I_TRY(svo_i_compute_launch(compute, &launches[i]));
    }
    return SVO_OK;
}

static svo_status descend(subdivider *s, svo_subdivide_params params)
{
    svo_i_gl_build *gl_build = s->gl_build;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count; ++i) {
        params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        const svo_i_launch launch = {
            .entry = SVO_I_ENTRY_DESCEND,
            .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i], s->masks, s->first_child, gl_build->state},
            .params = &params,
            .items = params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status run_levels(subdivider *s)
{
    const svo_i_build *build = s->gl_build->build;
    svo_subdivide_params params = {.depth = build->commands.plan->info.depth,
                                   .inner_capacity = (cl_uint)build->inner_capacity};
    SVO_I_TRY(mark_root(s, params));
    for (params.level = 0; params.level < params.depth; ++params.level) {
        SVO_I_TRY(scan_level(s, params));
        SVO_I_TRY(descend(s, params));
    }
    return SVO_OK;
}

svo_status svo_i_gl_subdivide(svo_i_gl_build *gl_build, bool *fits)
{
    subdivider s = {.gl_build = gl_build,
                    .masks = gl_build->arrays[SVO_TREE_CHILD_MASK],
                    .first_child = gl_build->arrays[SVO_TREE_FIRST_CHILD]};
    svo_build_state state;
    svo_status status = SVO_OK;
    svo_i_compute_stage_begin(gl_build->compute);
    SVO_I_TRY_CLEANUP(begin(&s));
    SVO_I_TRY_CLEANUP(run_levels(&s));
    SVO_I_TRY_CLEANUP(svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_SUBDIVIDE));
    SVO_I_TRY_CLEANUP(svo_i_compute_read(gl_build->compute, gl_build->state, &state, sizeof state));
    SVO_I_TRY_CLEANUP(svo_i_build_take_state(gl_build->build, &state, fits));
cleanup:
    svo_i_compute_free(gl_build->compute, &s.launches);
    return status;
}
