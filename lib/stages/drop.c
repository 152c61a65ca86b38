/* SPDX-License-Identifier: MIT */
/*
 * Launches the kernels chunk by chunk. Where only the device knows how many fragments there are, it counts those that
 * remain; else the host does.
 */
#include "stages/drop.h"

#include "stages/inputs.h"
#include "stages/programs.h"

/* Words of a chunk's tally (kernels/stages/drop.cl). */
#define TALLY_WORDS 3u

typedef struct dropper {
    svo_i_build *build;
    cl_mem tally, places;
    svo_drop_params params;
} dropper;

/* A list that the host has counted gets counters where the host does not learn what remains of it. It is one chunk. */
static svo_status put_counters(const dropper *d)
{
    svo_i_build *build = d->build;
    svo_i_fragment_list *list = &build->list;
    if (list->counters != NULL || !build->in_place || list->chunk_count == 0) {
        return SVO_OK;
    }
    const cl_uint counters[SVO_COUNTER_WORDS] = {(cl_uint)list->chunks[0].needed};
    SVO_I_TRY(svo_i_commands_alloc(&build->commands, "counters", sizeof counters, &list->counters));
    return svo_i_commands_fill(&build->commands, list->counters, counters, sizeof counters, sizeof counters);
}

static svo_status mark(dropper *d, const svo_i_fragments *chunk)
{
    svo_i_build *build = d->build;
    const svo_i_surface *surface = &build->surface;
    const cl_mem no_normals = NULL;
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(chunk->buffer),    SVO_I_ARGUMENT(surface->vertices),    SVO_I_ARGUMENT(surface->remainders),
        SVO_I_ARGUMENT(surface->indices), SVO_I_ARGUMENT(surface->records),     SVO_I_ARGUMENT(surface->colors),
        SVO_I_ARGUMENT(no_normals),       SVO_I_ARGUMENT(surface->uvs),         SVO_I_ARGUMENT(surface->materials),
        SVO_I_ARGUMENT(surface->texels),  SVO_I_ARGUMENT(build->list.counters), SVO_I_ARGUMENT(d->tally),
        SVO_I_ARGUMENT(d->params)};
    return svo_i_commands_run(&build->commands, svo_i_build_program(build, &svo_i_program_drop), "svo_k_drop_pairs",
                              SVO_I_ARGUMENTS(arguments), d->params.capacity);
}

/* Closes the gaps. The two kernels have the same arguments. */
static svo_status move(dropper *d, const svo_i_fragments *chunk)
{
    svo_i_build *build = d->build;
    cl_program program = svo_i_build_program(build, &svo_i_program_drop);
    const svo_i_argument find[] = {SVO_I_ARGUMENT(chunk->buffer), SVO_I_ARGUMENT(build->list.counters),
                                   SVO_I_ARGUMENT(d->tally), SVO_I_ARGUMENT(d->places), SVO_I_ARGUMENT(d->params)};
    SVO_I_TRY(
        svo_i_commands_run(&build->commands, program, "svo_k_find_places", SVO_I_ARGUMENTS(find), d->params.capacity));
    return svo_i_commands_run(&build->commands, program, "svo_k_move_pairs", SVO_I_ARGUMENTS(find),
                              d->params.capacity > 0 ? d->params.capacity / UINT64_C(2) + 1 : 0);
}

/* Sets what remains of a chunk, where the host learns it. */
static svo_status take_count(const dropper *d, svo_i_fragments *chunk)
{
    svo_i_build *build = d->build;
    cl_uint dropped = 0;
    if (build->commands.mode != SVO_I_MODE_RUN || chunk->needed == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_commands_read(&build->commands, d->tally, &dropped, sizeof dropped));
    chunk->needed -= dropped;
    build->fragment_count -= dropped;
    build->commands.report->dropped += dropped;
    return SVO_OK;
}

static svo_status drop_from(dropper *d, svo_i_fragments *chunk)
{
    svo_i_build *build = d->build;
    const svo_i_request requests[] = {{"drop_tally", TALLY_WORDS * sizeof(cl_uint), &d->tally},
                                      {"drop_places", chunk->needed * sizeof(cl_uint), &d->places}};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_commands_alloc_all(&build->commands, SVO_I_REQUESTS(requests)));
    SVO_I_TRY_CLEANUP(svo_i_commands_fill_zero(&build->commands, d->tally, TALLY_WORDS * sizeof(cl_uint)));
    SVO_I_TRY_CLEANUP(mark(d, chunk));
    SVO_I_TRY_CLEANUP(move(d, chunk));
    SVO_I_TRY_CLEANUP(take_count(d, chunk));
cleanup:
    svo_i_commands_free(&build->commands, &d->places);
    svo_i_commands_free(&build->commands, &d->tally);
    return status;
}

svo_status svo_i_drop(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    dropper d = {.build = build,
                 .params = {.least_alpha = plan->least_alpha,
                            .triangle_count = plan->triangle_count,
                            .depth = plan->info.depth,
                            .voxel_log2 = plan->voxel_log2,
                            .weight_log2 = SVO_I_WEIGHT_LOG2_MIN}}; /* weights are of no interest */
    SVO_I_TRY(svo_i_surface_upload(build));
    svo_i_stage_begin(&build->commands);
    SVO_I_TRY(put_counters(&d));
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        d.params.counter = i;
        d.params.capacity = (cl_uint)build->list.chunks[i].needed;
        SVO_I_TRY(drop_from(&d, &build->list.chunks[i]));
    }
    if (build->tree != NULL) { /* else only the list is wanted */
        build->tree->info.fragments = build->fragment_count;
    }
    return svo_i_stage_end(&build->commands, SVO_STAGE_DROP);
}
