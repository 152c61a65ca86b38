/* SPDX-License-Identifier: MIT */
/*
 * Runs shaders/decide.comp on the undecided fragments of a chunk, and copies those that touch to the chunk's others.
 * The host reads how many they are, not the fragments.
 */
#include "compute/decide.h"

#include "core/message.h"
#include "plan/estimate.h"
#include "stages/inputs.h"

static uint64_t positions_bytes(const svo_plan *plan)
{
    return (uint64_t)plan->vertex_count * (plan->positions_double != NULL ? 24 : 12);
}

static svo_status upload_mesh(svo_i_gl_decider *decider, const svo_plan *plan)
{
    const void *positions = plan->positions_double != NULL ? (const void *)plan->positions_double : plan->positions;
    if (decider->indices != 0) {
        return SVO_OK;
    }
    SVO_I_TRY(
        svo_i_compute_upload(decider->compute, "positions", positions, positions_bytes(plan), &decider->positions));
    return svo_i_compute_upload(decider->compute, "indices", plan->indices, (uint64_t)plan->triangle_count * 12,
                                &decider->indices);
}

/* The buffers of one chunk. */
typedef struct chunk_scratch {
    GLuint grid, kept, counters;
} chunk_scratch;

/* Fills kept; counters: the fragments in it, and those of triangles that the mesh does not have. */
static svo_status launch(const svo_i_gl_decider *decider, const svo_plan *plan, GLuint fragments, uint32_t capacity,
                         uint32_t undecided, chunk_scratch *scratch, uint32_t counters[2])
{
    svo_i_compute *compute = decider->compute;
    const svo_filter_params params = {.fragment_count = undecided};
    svo_decide_params grid = svo_i_decide_params(plan);
    grid.capacity = capacity;
    SVO_I_TRY(svo_i_compute_upload(compute, "grid", &grid, sizeof grid, &scratch->grid));
    SVO_I_TRY(
        svo_i_compute_alloc(compute, "kept", undecided * (uint64_t)svo_i_plan_fragment_bytes(plan), &scratch->kept));
    SVO_I_TRY(svo_i_compute_alloc_zero(compute, "decide_counters", 8, &scratch->counters));
    const svo_i_launch launch = {
        .entry = SVO_I_ENTRY_DECIDE,
        .buffers = {fragments, decider->positions, decider->indices, scratch->grid, scratch->kept, scratch->counters},
        .params = &params,
        .items = undecided};
    SVO_I_TRY(svo_i_compute_launch(compute, &launch));
    return svo_i_compute_read(compute, scratch->counters, counters, 8);
}

static svo_status run(svo_i_gl_decider *decider, const svo_plan *plan, GLuint fragments, uint32_t capacity,
                      svo_i_raster_count count, chunk_scratch *scratch, uint32_t *kept)
{
    svo_i_compute *compute = decider->compute;
    const size_t fragment_bytes = svo_i_plan_fragment_bytes(plan);
    uint32_t counters[2] = {0, 0};
    SVO_I_TRY(upload_mesh(decider, plan));
    SVO_I_TRY(launch(decider, plan, fragments, capacity, count.undecided, scratch, counters));
    if (counters[0] > count.undecided || counters[1] != 0) {
        return svo_i_device_fail(compute->device, SVO_GL_ERROR,
                                 SVO_I_GL_BUILD ": %s kept %u of %u fragments, %u of them of no triangle",
                                 compute->gl->renderer, counters[0], count.undecided, counters[1]);
    }
    *kept = counters[0];
    return svo_i_compute_copy(compute, scratch->kept, fragments, count.decided * (uint64_t)fragment_bytes,
                              counters[0] * (uint64_t)fragment_bytes);
}

/* Implements svo_i_decider.decide. */
static svo_status decide(void *self, const svo_plan *plan, const svo_i_share_buffer *fragments, uint32_t capacity,
                         svo_i_raster_count count, uint32_t *kept)
{
    svo_i_gl_decider *decider = self;
    chunk_scratch scratch = {0};
    const svo_status status = run(decider, plan, fragments->name, capacity, count, &scratch, kept);
    svo_i_compute_free(decider->compute, &scratch.grid);
    svo_i_compute_free(decider->compute, &scratch.kept);
    svo_i_compute_free(decider->compute, &scratch.counters);
    return status;
}

svo_i_decider svo_i_gl_decider_begin(svo_i_gl_decider *decider, svo_i_compute *compute, const svo_plan *plan)
{
    const uint64_t most = (uint64_t)compute->gl->limits.storage_block_bytes - 4;
    const bool fits = positions_bytes(plan) <= most && (uint64_t)plan->triangle_count * 12 <= most;
    *decider = (svo_i_gl_decider){.compute = compute};
    return (svo_i_decider){.self = decider, .decide = fits ? decide : NULL};
}

void svo_i_gl_decider_end(svo_i_gl_decider *decider)
{
    svo_i_compute_free(decider->compute, &decider->positions);
    svo_i_compute_free(decider->compute, &decider->indices);
}
