/* SPDX-License-Identifier: MIT */
/*
 * Updates that do not wait: the stages of moving.c, with the room of lists in place of counts, which stay on the device
 * until the update is finished. Then the new list and tree are taken, or dropped where the room was too small.
 */

#include "core/struct_size.h"
#include "moving/changes.h"
#include "moving/moving.h"
#include "moving/objects.h"
#include "moving/pairs.h"
#include "moving/tree.h"
#include "plan/update.h"

static const char enqueue_name[] = "svo_moving_update_enqueue";
static const char finish_name[] = "svo_moving_finish";

/* What the device tells of an object that is made anew. */
typedef struct news_of_object {
    svo_i_pair_count pairs;
    bool moved; /* its vertices are new, and so are the totals */
    svo_i_mesh_totals totals;
} news_of_object;

typedef struct svo_i_flight {
    svo_i_moving_update update;
    news_of_object *news; /* of the update's members */
    uint64_t *counts; /* of the same, their pairs */
    uint32_t *moved; /* those that moved */
    uint32_t moved_count;
    svo_build_state state; /* of the new tree */
    double start_ms;
    cl_event done; /* of all commands */
} svo_i_flight;

static void release(svo_i_flight *flight)
{
    if (flight->done != NULL) {
        clReleaseEvent(flight->done);
    }
    svo_tree_destroy(&flight->update.tree);
    svo_i_moving_release_update(&flight->update);
    svo_i_free(flight->news);
    svo_i_free(flight->counts);
    svo_i_free(flight->moved);
    svo_i_free(flight);
}

/* The plans of objects that moved may not have their vertices. */
static void forget_moves(const svo_i_flight *flight)
{
    for (uint32_t i = 0; i < flight->moved_count; ++i) {
        flight->update.moving->objects[flight->moved[i]].moved = true;
    }
}

/* ---- enqueue ---- */

static svo_status prepare(svo_i_flight *flight, svo_moving *moving, cl_command_queue queue)
{
    const svo_i_memory *memory = &moving->device->memory;
    flight->start_ms = svo_i_now_ms();
    flight->update = (svo_i_moving_update){.moving = moving,
                                           .chain = {.function = enqueue_name, .queue = queue},
                                           .fragment_limit = SVO_I_FRAGMENTS_MAX,
                                           .start_ms = flight->start_ms};
    flight->news = svo_i_alloc_zeroed(memory, moving->object_count, sizeof *flight->news);
    flight->counts = svo_i_alloc_zeroed(memory, moving->object_count, sizeof *flight->counts);
    flight->moved = svo_i_alloc_zeroed(memory, moving->object_count, sizeof *flight->moved);
    return flight->news != NULL && flight->counts != NULL && flight->moved != NULL
               ? SVO_OK
               : svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects", enqueue_name,
                                   moving->object_count);
}

static svo_status wait_first(svo_i_flight *flight, cl_uint num_wait, const cl_event *wait)
{
    svo_i_chain *chain = &flight->update.chain;
    const cl_int error = clEnqueueMarkerWithWaitList(chain->queue, num_wait, wait, &chain->last);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(flight->update.moving->device, enqueue_name,
                                                      "clEnqueueMarkerWithWaitList", error);
}

/* Brings new vertices to the object's plan, and their totals to the host. */
static svo_status move_object(svo_i_flight *flight, uint32_t index, news_of_object *news)
{
    svo_i_chain *chain = &flight->update.chain;
    svo_i_moving_object *object = &flight->update.moving->objects[index];
    svo_build_report discarded = {0};
    cl_event moved = NULL;
    SVO_I_TRY(svo_plan_update_enqueue(object->plan, &object->mesh, chain->queue, 1, &chain->last, &moved));
    clReleaseEvent(chain->last);
    chain->last = moved;
    object->moved = false;
    news->moved = true;
    flight->moved[flight->moved_count++] = index;
    svo_i_commands commands = svo_i_chain_begin_commands(chain, object->plan, &discarded);
    const svo_i_update *update = object->plan->update;
    svo_i_mesh_totals *totals = &news->totals;
    svo_status status = svo_i_commands_read(&commands, update->sums, totals->sums, sizeof totals->sums);
    if (status == SVO_OK) {
        status = svo_i_commands_read(&commands, update->error, &totals->error, sizeof totals->error);
    }
    if (status == SVO_OK && update->sums_edges) {
        status = svo_i_commands_read(&commands, update->edges, &totals->edges, sizeof totals->edges);
    }
    svo_i_chain_end_commands(chain, &commands, status);
    return status;
}

static svo_status make_pairs(svo_i_flight *flight)
{
    svo_i_moving_update *u = &flight->update;
    svo_moving *moving = u->moving;
    SVO_I_TRY(svo_i_moving_alloc_changed(u));
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        if (!svo_i_moving_is_new(&moving->objects[i])) {
            continue;
        }
        news_of_object *news = &flight->news[u->changed_count];
        svo_i_kept_list *list = &u->changed[u->changed_count];
        u->members[u->changed_count++] = i;
        SVO_I_TRY(moving->objects[i].moved ? move_object(flight, i, news) : SVO_OK);
        SVO_I_TRY(svo_i_moving_voxelize(moving, i, &u->chain, &news->pairs, list));
        SVO_I_TRY(svo_i_moving_weigh(moving, i, &u->chain, list));
    }
    return SVO_OK;
}

static svo_status enqueue_stages(svo_i_flight *flight)
{
    svo_i_moving_update *u = &flight->update;
    svo_i_moving_news news = {.moved = flight->moved};
    SVO_I_TRY(make_pairs(flight));
    news.moved_count = flight->moved_count;
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        news.pairs += flight->news[i].pairs.capacity;
    }
    SVO_I_TRY(svo_i_moving_merge_changed(u));
    return svo_i_moving_tree_later(u->moving, &u->chain, &u->list, &news, &flight->state, &u->tree);
}

/* Sends the commands to the device and gives the caller the event. */
static svo_status hand_over(svo_i_flight *flight, cl_event *event)
{
    svo_i_chain *chain = &flight->update.chain;
    svo_device *device = flight->update.moving->device;
    cl_int error = clFlush(chain->queue);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, enqueue_name, "clFlush", error);
    }
    error = event != NULL ? clRetainEvent(chain->last) : CL_SUCCESS;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, enqueue_name, "clRetainEvent", error);
    }
    if (event != NULL) {
        *event = chain->last;
    }
    flight->done = chain->last;
    chain->last = NULL;
    return SVO_OK;
}

svo_status svo_moving_update_enqueue(svo_moving *moving, cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event)
{
    svo_status status = SVO_OK;
    if (moving == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_device_queue(moving->device, enqueue_name, queue, &queue));
    SVO_I_TRY(svo_i_device_check_wait(moving->device, enqueue_name, num_wait, wait));
    SVO_I_TRY(svo_i_moving_check_still(moving, enqueue_name));
    svo_i_flight *flight = svo_i_alloc_zeroed(&moving->device->memory, 1, sizeof *flight);
    if (flight == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for an update", enqueue_name);
    }
    SVO_I_TRY_CLEANUP(prepare(flight, moving, queue));
    SVO_I_TRY_CLEANUP(wait_first(flight, num_wait, wait));
    SVO_I_TRY_CLEANUP(svo_i_moving_is_due(moving) ? enqueue_stages(flight) : SVO_OK);
    SVO_I_TRY_CLEANUP(hand_over(flight, event));
    moving->flight = flight;
    return SVO_OK;
cleanup:
    (void)clFlush(queue);
    svo_i_chain_settle(&flight->update.chain); /* its commands write to the flight */
    forget_moves(flight);
    release(flight);
    return status;
}

/* ---- finish ---- */

/* Takes what the device has counted of the objects. Each is told of, whatever became of the others. */
static svo_status take_objects(svo_i_flight *flight)
{
    svo_i_moving_update *u = &flight->update;
    svo_status first = SVO_OK;
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        const news_of_object *news = &flight->news[i];
        svo_i_moving_object *object = &u->moving->objects[u->members[i]];
        svo_status status = news->moved ? svo_i_update_take(object->plan, finish_name, &news->totals) : SVO_OK;
        const uint64_t pairs = (uint64_t)news->pairs.words[1] << 32 | news->pairs.words[0];
        flight->counts[i] = pairs;
        u->report.changed_fragments += pairs - news->pairs.capacity;
        u->report.fragments += pairs - news->pairs.capacity;
        svo_i_moving_remember(object, pairs);
        if (status == SVO_OK && pairs > news->pairs.capacity) {
            status = svo_i_device_fail(u->moving->device, SVO_CAPACITY_EXCEEDED,
                                       "%s: object %u has %llu fragments, and the update had room for %llu; the next "
                                       "has room for them",
                                       finish_name, u->members[i] - 1, (unsigned long long)pairs,
                                       (unsigned long long)news->pairs.capacity);
        }
        first = first == SVO_OK ? status : first;
    }
    return first;
}

static svo_status check_scene(const svo_i_flight *flight)
{
    const svo_moving *moving = flight->update.moving;
    const uint64_t fragments = flight->update.report.fragments;
    double area = 0.0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        area += svo_i_moving_shows(&moving->objects[i]) ? moving->objects[i].plan->info.area : 0.0;
    }
    SVO_I_TRY(svo_i_update_check_area(&moving->whole, finish_name, area));
    return fragments <= moving->fragment_limit
               ? SVO_OK
               : svo_i_device_fail(moving->device, SVO_CAPACITY_EXCEEDED,
                                   "%s: the scene has %llu fragments, and room for %llu; see options.fragment_capacity",
                                   finish_name, (unsigned long long)fragments,
                                   (unsigned long long)moving->fragment_limit);
}

static svo_status finish(svo_i_flight *flight)
{
    svo_i_moving_update *u = &flight->update;
    svo_device *device = u->moving->device;
    const cl_int error = clWaitForEvents(1, &flight->done);
    if (error != CL_SUCCESS) {
        (void)svo_i_event_settle(flight->done);
        forget_moves(flight);
        return svo_i_device_fail_cl(device, finish_name, "clWaitForEvents for the update", error);
    }
    if (u->tree == NULL) { /* nothing was due */
        svo_i_moving_forget_changes(u->moving);
        return SVO_OK;
    }
    SVO_I_TRY(take_objects(flight));
    SVO_I_TRY(check_scene(flight));
    SVO_I_TRY(svo_i_moving_tree_end(u->moving, &flight->state, u->tree));
    u->list.count = u->report.fragments;
    svo_i_buffer_release(&u->list.counted);
    svo_i_moving_commit(u, flight->counts);
    return SVO_OK;
}

#define SIZES_OF_REPORT SVO_I_STRUCT_SIZES(svo_moving_report, total_ms)

svo_status svo_moving_finish(svo_moving *moving, svo_moving_report *report)
{
    if (moving == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    svo_i_flight *flight = moving->flight;
    if (flight == NULL) {
        return svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT, "%s: no update is in flight", finish_name);
    }
    SVO_I_TRY(report != NULL
                  ? svo_i_struct_check(&moving->device->message, finish_name, "report", report, SIZES_OF_REPORT)
                  : SVO_OK);
    moving->flight = NULL;
    const svo_status status = finish(flight);
    flight->update.report.total_ms = svo_i_now_ms() - flight->start_ms;
    if (report != NULL) {
        (void)svo_i_struct_write(NULL, finish_name, "report", &flight->update.report, report, SIZES_OF_REPORT);
    }
    release(flight);
    return status;
}
