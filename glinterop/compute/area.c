/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/area.comp: every fragment adds its areas to the sums of its leaf, for any number of chunks and of
 * triangles per voxel.
 */
#include "compute/area.h"

#include "compute/buffer.h"
#include "stages/inputs.h"

/* Adds the areas of all fragments to the leaves' sums. */
static svo_status add_fragments(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface, svo_filter_params params,
                                GLuint sums)
{
    const svo_i_fragment_list *list = &gl_build->build->list;
    for (uint32_t i = 0; i < list->chunk_count; ++i) {
        params.fragment_count = (cl_uint)list->chunks[i].needed;
        const svo_i_launch launch = {.entry = SVO_I_ENTRY_AREA,
                                     .buffers = {[0] = svo_i_gl_chunk(gl_build, i),
                                                 [1] = gl_build->cursors[i],
                                                 [2] = surface->vertices,
                                                 [3] = surface->indices,
                                                 [4] = surface->records,
                                                 [9] = sums},
                                     .params = &params,
                                     .items = params.fragment_count};
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launch));
    }
    return SVO_OK;
}

static svo_status run(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface, GLuint *sums)
{
    svo_i_compute *compute = gl_build->compute;
    GLuint *areas = &gl_build->arrays[SVO_TREE_AREAS];
    const svo_filter_params params = svo_i_payload_params(gl_build->build);
    const uint64_t leaves = params.leaf_count;
    svo_i_compute_stage_begin(compute);
    SVO_I_TRY(svo_i_compute_alloc(compute, "areas", leaves * 12, areas));
    SVO_I_TRY(svo_i_compute_alloc_zero(compute, "area_sums", leaves * 48, sums));
    SVO_I_TRY(add_fragments(gl_build, surface, params, *sums));
    const svo_i_launch round = {
        .entry = SVO_I_ENTRY_ROUND_AREAS, .buffers = {[9] = *sums, [10] = *areas}, .params = &params, .items = leaves};
    SVO_I_TRY(svo_i_compute_launch(compute, &round));
    return svo_i_compute_stage_end(compute, gl_build->build, SVO_STAGE_FILTER);
}

svo_status svo_i_gl_areas(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface)
{
    GLuint sums = 0;
    const svo_status status = run(gl_build, surface, &sums);
    svo_i_compute_free(gl_build->compute, &sums);
    return status;
}
