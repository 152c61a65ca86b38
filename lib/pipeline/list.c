/* SPDX-License-Identifier: MIT */
/*
 * The fragment list of a blocking build, and svo_plan_count. The front end draws the list into chunks. If chunks were
 * too small, it draws again with larger ones.
 */
#include "pipeline/list.h"

#include <string.h>

#include "pipeline/default_frontend.h"
#include "pipeline/measure.h"
#include "plan/accounts.h"
#include "plan/chunking.h"
#include "plan/estimate.h"
#include "stages/inputs.h"

/* A bound on halving chunks, far above what a list can need. */
#define RERUNS_MAX 32u

/* Counts the list's fragments. Returns whether all of them fitted their chunks. */
static bool count_list(svo_i_build *build, uint64_t *needed)
{
    bool whole = true;
    build->fragment_count = 0;
    for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
        needed[i] = build->list.chunks[i].needed;
        build->fragment_count += needed[i];
        whole = whole && needed[i] <= build->list.chunks[i].capacity;
    }
    return whole;
}

/* Adds the chunks' buffers to the plan's list. */
static svo_status list_chunks(svo_plan *plan, const svo_i_chunking *chunking)
{
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        const uint64_t bytes = chunking->chunks[i].capacity * svo_i_plan_fragment_bytes(plan);
        SVO_I_TRY(svo_i_plan_buffer_add(plan, "fragments", bytes));
    }
    return SVO_OK;
}

/* Removes them. */
static void unlist_chunks(svo_plan *plan, const svo_i_chunking *chunking)
{
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        svo_i_plan_buffer_remove(plan, chunking->chunks[i].capacity * svo_i_plan_fragment_bytes(plan));
    }
}

/* Allocates an empty list, and *needed for the counts of its chunks. */
static svo_status alloc_list(svo_i_build *build, uint32_t chunk_count, uint64_t **needed)
{
    build->list.chunks =
        svo_i_alloc_zeroed(&build->commands.device->memory, chunk_count + 1u, sizeof *build->list.chunks);
    *needed = svo_i_alloc_zeroed(&build->commands.device->memory, chunk_count + 1u, sizeof **needed);
    if (build->list.chunks == NULL || *needed == NULL) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u chunks",
                                 chunk_count);
    }
    build->list.chunk_count = chunk_count;
    return SVO_OK;
}

/* Draws the list once. If it did not fit, *whole is false and *chunking becomes one in which it should fit. */
static svo_status draw_list(svo_i_build *build, svo_i_chunking *chunking, uint64_t limit, bool *whole)
{
    svo_status status = SVO_OK;
    svo_frontend *frontend = build->frontend;
    const bool has_buffers = frontend->make_tree == NULL; /* else the front end keeps the list */
    uint64_t *needed = NULL;
    bool listed = false;
    SVO_I_TRY_CLEANUP(alloc_list(build, chunking->chunk_count, &needed));
    if (has_buffers) {
        SVO_I_TRY_CLEANUP(list_chunks(build->commands.plan, chunking));
        listed = true;
    }
    SVO_I_TRY_CLEANUP(svo_i_frontend_voxelize(frontend, &build->commands, chunking, &build->list));
    *whole = count_list(build, needed);
cleanup:
    if (status != SVO_OK || !*whole) {
        frontend->release(frontend->self, &build->list);
        if (listed) {
            unlist_chunks(build->commands.plan, chunking);
        }
        svo_i_commands_free(&build->commands, &build->list.counters);
        svo_i_free(build->list.chunks);
        memset(&build->list, 0, sizeof build->list);
    }
    if (status == SVO_OK && !*whole) {
        ++build->commands.report->reruns;
        status = svo_i_chunking_grow(build->commands.plan, limit, needed, chunking);
    }
    svo_i_free(needed);
    return status;
}

svo_status svo_i_list_make(svo_i_build *build)
{
    svo_status status = SVO_OK;
    const uint64_t limit = svo_i_chunk_bytes_max(build->commands.plan, build->frontend->chunk_bytes_max);
    svo_i_chunking chunking = {0};
    bool whole = false;
    SVO_I_TRY(svo_i_chunking_create(build->commands.plan, limit, &chunking));
    while (!whole) {
        if (build->commands.report->reruns > RERUNS_MAX) {
            status =
                svo_i_device_fail(build->commands.device, SVO_INTERNAL,
                                  "svo_build: the list does not fit after %u reruns", build->commands.report->reruns);
            goto cleanup;
        }
        SVO_I_TRY_CLEANUP(draw_list(build, &chunking, limit, &whole));
    }
    if (build->fragment_count > SVO_I_FRAGMENTS_MAX) {
        status = svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
                                   "svo_build: the scene has %llu fragments, above %u; lower the depth",
                                   (unsigned long long)build->fragment_count, SVO_I_FRAGMENTS_MAX);
    }
cleanup:
    svo_i_chunking_destroy(&chunking);
    return status;
}

/* Counts the fragments of a chunking. Each chunk has room for one fragment, so none is kept. */
static svo_status count_fragments(svo_i_commands *commands, svo_frontend *frontend, svo_i_chunking *chunking,
                                  uint64_t *total)
{
    svo_i_fragment_list list = {.chunk_count = chunking->chunk_count};
    list.chunks = svo_i_alloc_zeroed(&commands->device->memory, chunking->chunk_count + 1u, sizeof *list.chunks);
    if (list.chunks == NULL) {
        return svo_i_device_fail(commands->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_count: no memory for %u chunks",
                                 chunking->chunk_count);
    }
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        chunking->chunks[i].capacity = 1;
    }
    const svo_status status = svo_i_frontend_voxelize(frontend, commands, chunking, &list);
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        *total += list.chunks[i].needed;
    }
    frontend->release(frontend->self, &list);
    svo_i_commands_free(commands, &list.counters);
    svo_i_free(list.chunks);
    return status;
}

svo_status svo_plan_count(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_default_frontend(plan->device, frontend, &frontend));
    SVO_I_TRY(svo_i_device_queue(plan->device, "svo_plan_count", queue, &queue));
    if (frontend->device != plan->device) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT,
                                 "svo_plan_count: frontend is of another device than plan");
    }
    if (plan->update != NULL) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 "svo_plan_count: plan is updatable; its capacity is not that of one mesh");
    }
    svo_status status = SVO_OK;
    svo_build_report discarded = {0};
    svo_i_build build = {.commands = svo_i_commands_begin(plan, queue, &discarded), .frontend = frontend};
    build.commands.untimed = true;
    svo_i_chunking chunking = {0};
    uint64_t total = 0;
    SVO_I_TRY_CLEANUP(svo_i_progress_begin(plan, "svo_plan_count",
                                           SVO_I_STAGE_BIT(SVO_STAGE_COMPILE) | SVO_I_STAGE_BIT(SVO_STAGE_VOXELIZE)));
    SVO_I_TRY_CLEANUP(svo_i_compile_frontend(&build));
    SVO_I_TRY_CLEANUP(svo_i_chunking_create(plan, svo_i_chunk_bytes_max(plan, frontend->chunk_bytes_max), &chunking));
    const bool one_chunk = chunking.chunk_count <= 1;
    SVO_I_TRY_CLEANUP(count_fragments(&build.commands, frontend, &chunking, &total));
    if (total > SVO_I_FRAGMENTS_MAX) {
        status = svo_i_device_fail(plan->device, SVO_OUT_OF_DEVICE_MEMORY,
                                   "svo_plan_count: the scene has %llu fragments, above %u; lower the depth",
                                   (unsigned long long)total, SVO_I_FRAGMENTS_MAX);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(svo_i_progress_end(plan, SVO_STAGE_VOXELIZE));
    plan->counted = one_chunk; /* the capacities of several chunks add up to more than the count */
    plan->info.fragments = total;
    plan->options.fragment_capacity = total > 0 ? total : 1;
    plan->built = false;
    SVO_I_TRY_CLEANUP(svo_i_predict(plan));
cleanup:
    svo_i_snapped_mesh_free(&build.commands);
    svo_i_commands_end(&build.commands);
    svo_i_chunking_destroy(&chunking);
    return status;
}
