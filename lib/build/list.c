/* SPDX-License-Identifier: MIT */
/*
 * The fragment list of a build: the front end draws it into chunks, and again with more room where they were too small,
 * until all fragments are there.
 */
#include <stdlib.h>

#include "build/build.h"
#include "build/frontend_choice.h"

/* Cutting chunks in halves until they fit ends long before this. */
#define RERUNS_MAX 32u

static uint64_t chunk_bytes(const svo_i_build *build, const svo_frontend *frontend)
{
    uint64_t bytes = frontend->chunk_bytes_max;
    bytes = build->device->max_allocation_bytes < bytes ? build->device->max_allocation_bytes : bytes;
    const uint64_t asked = build->plan->options.chunk_bytes;
    return asked != 0 && asked < bytes ? asked : bytes;
}

/* The list's counts; whether every chunk held its fragments. */
static bool list_is_whole(svo_i_build *build, uint64_t *needed)
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

/* Lists the chunks' buffers, which live while the front end draws into them and after; or takes them off again. */
static void list_chunks(svo_i_build *build, const svo_i_layout *layout, bool live)
{
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        const uint64_t bytes = layout->chunks[i].capacity * svo_i_plan_fragment_bytes(build->plan);
        if (live) {
            svo_i_plan_buffer_add(build->plan, "fragments", bytes);
        } else {
            svo_i_plan_buffer_remove(build->plan, bytes);
        }
    }
}

void svo_i_build_release_list(svo_i_build *build, svo_frontend *frontend)
{
    if (build->list.chunks == NULL) {
        return;
    }
    if (build->owns_list) { /* by buffers of the build's */
        for (uint32_t i = 0; i < build->list.chunk_count; ++i) {
            svo_i_build_free(build, &build->list.chunks[i].buffer);
        }
    } else {
        for (uint32_t i = 0; frontend->make_tree == NULL && i < build->list.chunk_count; ++i) {
            svo_i_plan_buffer_remove(build->plan,
                                     build->list.chunks[i].capacity * svo_i_plan_fragment_bytes(build->plan));
        }
        frontend->release(frontend->self, &build->list);
    }
    free(build->list.chunks);
    build->list = (svo_i_fragment_list){0};
}

/* One attempt at the list, with the layout as it is. */
static svo_status draw_list(svo_i_build *build, svo_frontend *frontend, svo_i_layout *layout, uint64_t limit,
                            bool *whole)
{
    build->list.chunk_count = layout->chunk_count;
    build->list.chunks = calloc(layout->chunk_count + 1u, sizeof *build->list.chunks);
    uint64_t *needed = calloc(layout->chunk_count + 1u, sizeof *needed);
    svo_status status = SVO_OK;
    if (build->list.chunks == NULL || needed == NULL) {
        status = svo_i_device_fail(build->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u chunks",
                                   layout->chunk_count);
        build->list.chunk_count = 0;
    } else {
        if (frontend->make_tree == NULL) { /* a list that stays with the front end has no OpenCL buffers */
            list_chunks(build, layout, true);
        }
        status = frontend->voxelize(frontend->self, build->plan, layout, build->queue, &build->list, build->report);
        *whole = status == SVO_OK && list_is_whole(build, needed);
    }
    if (status != SVO_OK || !*whole) {
        frontend->release(frontend->self, &build->list);
        if (frontend->make_tree == NULL) {
            list_chunks(build, layout, false);
        }
        free(build->list.chunks);
        build->list = (svo_i_fragment_list){0};
    }
    if (status == SVO_OK && !*whole) {
        ++build->report->reruns;
        status = svo_i_layout_grow(build->plan, limit, needed, layout);
    }
    free(needed);
    return status;
}

svo_status svo_i_build_make_list(svo_i_build *build, svo_frontend *frontend)
{
    const uint64_t limit = chunk_bytes(build, frontend);
    svo_i_layout layout;
    svo_status status = svo_i_layout_create(build->plan, limit, &layout);
    bool whole = false;
    while (status == SVO_OK && !whole) {
        if (build->report->reruns > RERUNS_MAX) {
            status = svo_i_device_fail(build->device, SVO_INTERNAL, "svo_build: the list does not fit after %u reruns",
                                       build->report->reruns);
            break;
        }
        status = draw_list(build, frontend, &layout, limit, &whole);
    }
    svo_i_layout_destroy(&layout);
    if (status == SVO_OK && build->fragment_count > SVO_I_FRAGMENTS_MAX) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the scene has %llu fragments, above %u; lower the depth",
                                 (unsigned long long)build->fragment_count, SVO_I_FRAGMENTS_MAX);
    }
    return status;
}

/* How many fragments a layout has, without keeping them: one per chunk at most. */
static svo_status count_fragments(svo_i_build *build, svo_frontend *frontend, svo_i_layout *layout, uint64_t *total)
{
    svo_i_fragment_list list = {.chunk_count = layout->chunk_count};
    list.chunks = calloc(layout->chunk_count + 1u, sizeof *list.chunks);
    if (list.chunks == NULL) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_count: no memory for %u chunks",
                                 layout->chunk_count);
    }
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        layout->chunks[i].capacity = 1;
    }
    const svo_status status =
        frontend->voxelize(frontend->self, build->plan, layout, build->queue, &list, build->report);
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        *total += list.chunks[i].needed;
    }
    frontend->release(frontend->self, &list);
    free(list.chunks);
    return status;
}

svo_status svo_plan_count(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_default_frontend(plan->device, frontend, &frontend));
    SVO_I_TRY(svo_i_device_queue(plan->device, "svo_plan_count", queue, &queue));
    const char *wrong = frontend->device != plan->device ? "frontend is of another device than plan"
                                                         : svo_i_wrong_queue(plan->device, queue);
    if (wrong != NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "svo_plan_count: %s", wrong);
    }
    svo_build_report unread = {0};
    svo_i_build build = {.device = plan->device, .plan = plan, .queue = queue, .report = &unread};
    svo_i_layout layout = {0};
    uint64_t total = 0;
    svo_status status = frontend->prepare(frontend->self, plan, queue);
    status = status == SVO_OK ? svo_i_layout_create(plan, chunk_bytes(&build, frontend), &layout) : status;
    const bool one_chunk = layout.chunk_count <= 1;
    status = status == SVO_OK ? count_fragments(&build, frontend, &layout, &total) : status;
    svo_i_layout_destroy(&layout);
    if (status != SVO_OK) {
        return status;
    }
    if (total > SVO_I_FRAGMENTS_MAX) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_plan_count: the scene has %llu fragments, above %u; lower the depth",
                                 (unsigned long long)total, SVO_I_FRAGMENTS_MAX);
    }
    plan->counted = one_chunk; /* several chunks have room to spare each */
    plan->info.fragments = total;
    plan->options.fragment_capacity = total > 0 ? total : 1;
    plan->built = false;
    return svo_i_plan_predict(plan);
}

svo_status svo_i_build_fail_damaged(svo_i_build *build)
{
    return svo_i_device_fail(build->device, SVO_INTERNAL,
                             "svo_build: %s made a fragment outside the grid or of no triangle",
                             build->report->frontend);
}

svo_status svo_i_build_alloc_cursors(svo_i_build *build)
{
    build->cursors = calloc(build->list.chunk_count + 1u, sizeof(cl_mem));
    if (build->cursors == NULL) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for %u chunks",
                                 build->list.chunk_count);
    }
    svo_status status = SVO_OK;
    for (uint32_t i = 0; i < build->list.chunk_count && status == SVO_OK; ++i) {
        status = svo_i_build_alloc(build, "cursors", build->list.chunks[i].needed * 4, &build->cursors[i]);
    }
    return status;
}
