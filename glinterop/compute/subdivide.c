/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/subdivide.comp and the mask scans of shaders/scan.comp: all levels in one go, without reading anything
 * back between them. How large a level is, the device knows: its scans are launched indirectly. The counts come to the
 * host once, at the end.
 */
#include "compute/subdivide.h"

#include <string.h>

#include "compute/buffer.h"

typedef struct subdivider {
    svo_i_gl_build *gl_build;
    GLuint masks, first_child;
    GLuint launches; /* groups of each level's scans, three words a level */
} subdivider;

/* A root without children; only the root's own scans have something to do yet. */
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
    svo_status status = svo_i_compute_upload(gl_build->compute, "state", &state, sizeof state, &gl_build->state);
    if (status == SVO_OK) {
        status = svo_i_compute_upload(gl_build->compute, "launches", launches, sizeof launches, &s->launches);
    }
    if (status == SVO_OK && gl_build->partials == 0) {
        status =
            svo_i_compute_alloc(gl_build->compute, "partials", SVO_SCAN_GROUPS * sizeof(GLuint), &gl_build->partials);
    }
    svo_i_compute_fill_zero(gl_build->compute, s->masks);
    return status;
}

static svo_status mark_root(subdivider *s, svo_subdivide_params params)
{
    svo_i_gl_build *gl_build = s->gl_build;
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count && status == SVO_OK; ++i) {
        params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        status = svo_i_compute_launch(
            gl_build->compute, &(svo_i_launch){.entry = SVO_I_ENTRY_MARK,
                                               .buffers = {svo_i_gl_chunk(gl_build, i), s->masks, gl_build->state},
                                               .params = &params,
                                               .items = params.fragment_count});
    }
    return status;
}

/* first_child of the level's nodes, and where the level below the next begins. */
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
    svo_status status = SVO_OK;
    for (unsigned i = 0; i < 3 && status == SVO_OK; ++i) {
        status = svo_i_compute_launch(compute, &launches[i]);
    }
    return status;
}

static svo_status descend(subdivider *s, svo_subdivide_params params)
{
    svo_i_gl_build *gl_build = s->gl_build;
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < gl_build->build->list.chunk_count && status == SVO_OK; ++i) {
        params.fragment_count = (cl_uint)gl_build->build->list.chunks[i].needed;
        status = svo_i_compute_launch(gl_build->compute,
                                      &(svo_i_launch){.entry = SVO_I_ENTRY_DESCEND,
                                                      .buffers = {svo_i_gl_chunk(gl_build, i), gl_build->cursors[i],
                                                                  s->masks, s->first_child, gl_build->state},
                                                      .params = &params,
                                                      .items = params.fragment_count});
    }
    return status;
}

static svo_status run_levels(subdivider *s)
{
    const svo_i_build *build = s->gl_build->build;
    svo_subdivide_params params = {.depth = build->commands.plan->info.depth,
                                   .inner_capacity = (cl_uint)build->inner_capacity};
    svo_status status = mark_root(s, params);
    for (params.level = 0; params.level < params.depth && status == SVO_OK; ++params.level) {
        status = scan_level(s, params);
        if (status == SVO_OK) {
            status = descend(s, params);
        }
    }
    return status;
}

svo_status svo_i_gl_subdivide(svo_i_gl_build *gl_build, bool *fits)
{
    subdivider s = {.gl_build = gl_build,
                    .masks = gl_build->arrays[SVO_TREE_CHILD_MASK],
                    .first_child = gl_build->arrays[SVO_TREE_FIRST_CHILD]};
    svo_build_state state;
    svo_i_compute_stage_begin(gl_build->compute);
    svo_status status = begin(&s);
    if (status == SVO_OK) {
        status = run_levels(&s);
    }
    if (status == SVO_OK) {
        status = svo_i_compute_stage_end(gl_build->compute, gl_build->build, SVO_STAGE_SUBDIVIDE);
    }
    if (status == SVO_OK) {
        status = svo_i_compute_read(gl_build->compute, gl_build->state, &state, sizeof state);
    }
    svo_i_compute_free(gl_build->compute, &s.launches);
    return status == SVO_OK ? svo_i_build_take_state(gl_build->build, &state, fits) : status;
}
