/* SPDX-License-Identifier: MIT */
/*
 * Updates of a scene that moves. An update makes new pairs of what changed, a new list and a new tree beside the old
 * ones, and takes them only when all has succeeded.
 *
 * Those with an svo_submit do not wait: they have the room of lists in place of counts, which stay on the device until
 * the update is finished. Then the new list and tree are taken, or dropped where the room was too small.
 */
#include "plan/update.h"
#include "core/struct_size.h"
#include "core/submit.h"
#include "moving/objects.h"
#include "moving/tree.h"

static const char update_name[] = "svo_moving_update";
static const char finish_name[] = "svo_moving_finish";

#define SIZES_OF_REPORT SVO_I_STRUCT_SIZES(svo_moving_report, total_ms)

/* ---- both kinds ---- */

/* What updates that wait and those that are enqueued have in common. */
typedef struct update {
    svo_moving *moving;
    svo_i_chain chain;
    uint64_t fragment_limit; /* most pairs of the scene */
    bool timed;
    svo_moving_report report;
    double start_ms; /* of the current stage */
    svo_i_kept_list *changed; /* lists of the objects in members */
    uint32_t *members; /* indices of objects whose pairs are made anew */
    uint32_t changed_count;
    svo_i_kept_list list; /* of the new tree */
    svo_tree *tree;
} update;

static svo_status check_report(svo_moving *moving, const char *function, const svo_moving_report *report)
{
    return report != NULL ? svo_i_struct_check(&moving->device->message, function, "report", report, SIZES_OF_REPORT)
                          : SVO_OK;
}

/* The time since the last call goes to a stage. */
static void tell(update *u, double *stage_ms)
{
    const double now = svo_i_now_ms();
    *stage_ms += now - u->start_ms;
    u->start_ms = now;
}

/* Whether the pairs of an object are to be made anew. */
static bool is_new(const svo_i_moving_object *object)
{
    return svo_i_moving_shows(object) && !svo_i_moving_stays(object);
}

/* Whether anything in the list is to change. */
static bool is_due(const svo_moving *moving)
{
    bool due = moving->tree == NULL;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        due = due || (object->listed && !svo_i_moving_stays(object)) || is_new(object);
    }
    return due;
}

/* Makes changed and members, empty, with room for all objects. */
static svo_status alloc_changed(update *u)
{
    const svo_i_memory *memory = &u->moving->device->memory;
    u->changed = svo_i_alloc_zeroed(memory, u->moving->object_count, sizeof *u->changed);
    u->members = svo_i_alloc_zeroed(memory, u->moving->object_count, sizeof *u->members);
    return u->changed != NULL && u->members != NULL
               ? SVO_OK
               : svo_i_device_fail(u->moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects",
                                   u->chain.function, u->moving->object_count);
}

/* Counts the pairs of the scene and those that changed. */
static svo_status count_pairs(update *u)
{
    const svo_moving *moving = u->moving;
    u->report.fragments = 0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        const bool stays = svo_i_moving_stays(object);
        u->report.fragments += stays ? object->fragments : 0;
        u->report.changed_fragments += object->listed && !stays ? object->fragments : 0;
        u->report.changed_objects += !stays && (object->listed || svo_i_moving_shows(object)) ? 1 : 0;
    }
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        u->report.fragments += u->changed[i].count;
        u->report.changed_fragments += u->changed[i].count;
    }
    return u->report.fragments <= u->fragment_limit
               ? SVO_OK
               : svo_i_device_fail(moving->device, SVO_CAPACITY_EXCEEDED,
                                   "%s: the scene has %llu fragments, and room for %llu; see options.fragment_capacity",
                                   u->chain.function, (unsigned long long)u->report.fragments,
                                   (unsigned long long)u->fragment_limit);
}

/* Makes the list of the new tree. Counts pairs for the report: the most, where the device counts them. */
static svo_status merge_changed(update *u)
{
    svo_moving *moving = u->moving;
    SVO_I_TRY(count_pairs(u));
    SVO_I_TRY(svo_i_moving_merge(moving, &u->chain, u->changed, u->changed_count, u->report.fragments, &u->list));
    tell(u, &u->report.merge_ms);
    return SVO_OK;
}

/* Notes what of each object is in the newest tree. */
static void note_parts(svo_moving *moving)
{
    uint64_t vertices = 0;
    uint64_t triangles = 0;
    uint64_t ids = 0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_moving_object *object = &moving->objects[i];
        object->part = (svo_i_moving_part){.is_there = svo_i_moving_shows(object)};
        if (object->part.is_there) {
            object->part = (svo_i_moving_part){.first_vertex = vertices,
                                               .vertex_count = object->plan->vertex_count,
                                               .first_triangle = (uint32_t)triangles,
                                               .triangle_count = (uint32_t)object->plan->update->kept_triangles,
                                               .first_id = (uint32_t)ids,
                                               .is_there = true,
                                               .identity = object->identity,
                                               .version = object->version};
            vertices += object->part.vertex_count;
            triangles += object->part.triangle_count;
            ids += object->plan->info.triangles;
        }
    }
}

/* Takes the new list and tree; the old list's buffers serve the next update. counts: the pairs of each member. */
static void commit(update *u, const uint64_t *counts)
{
    svo_moving *moving = u->moving;
    svo_i_moving_note_changes(moving);
    moving->area = 0.0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_moving_object *object = &moving->objects[i];
        object->fragments = svo_i_moving_stays(object) ? object->fragments : 0;
        object->listed = svo_i_moving_shows(object);
        object->stale = object->listed ? false : object->stale;
        moving->area += object->listed ? object->plan->info.area : 0.0;
    }
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        moving->objects[u->members[i]].fragments = counts[i];
        moving->objects[u->members[i]].version = ++moving->serial;
    }
    svo_i_kept_list_free(&moving->spare);
    moving->spare = moving->list;
    moving->list = u->list;
    u->list = (svo_i_kept_list){.count = 0};
    note_parts(moving);
    svo_tree_destroy(&moving->tree);
    moving->tree = u->tree;
    u->tree = NULL;
}

/* Releases what was not taken. */
static void release_update(update *u)
{
    for (uint32_t i = 0; u->changed != NULL && i < u->changed_count; ++i) {
        svo_i_kept_list_free(&u->changed[i]);
    }
    svo_i_kept_list_free(&u->list);
    svo_i_free(u->changed);
    svo_i_free(u->members);
}

/* ---- updates that wait ---- */

/* Brings new vertices to the plans of the objects. */
static svo_status move_objects(update *u)
{
    svo_moving *moving = u->moving;
    double area = 0.0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_moving_object *object = &moving->objects[i];
        if (!svo_i_moving_shows(object)) {
            continue;
        }
        if (object->moved) {
            const svo_submit submit = {.queue = u->chain.queue};
            SVO_I_TRY(svo_plan_update(object->plan, &object->mesh, &submit));
            SVO_I_TRY(svo_i_update_settle(object->plan, update_name, u->chain.queue));
            object->moved = false;
        }
        area += object->plan->info.area;
    }
    SVO_I_TRY(svo_i_update_check_area(&moving->whole, update_name, area));
    tell(u, &u->report.move_ms);
    return SVO_OK;
}

/* Makes the pairs of the objects that changed. */
static svo_status make_pairs(update *u)
{
    svo_moving *moving = u->moving;
    SVO_I_TRY(alloc_changed(u));
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        if (is_new(&moving->objects[i])) {
            svo_i_kept_list *list = &u->changed[u->changed_count];
            u->members[u->changed_count++] = i;
            SVO_I_TRY(svo_i_moving_voxelize(moving, i, &u->chain, NULL, list));
            tell(u, &u->report.voxelize_ms);
            SVO_I_TRY(svo_i_moving_weigh(moving, i, &u->chain, list));
            tell(u, &u->report.weigh_ms);
        }
    }
    return SVO_OK;
}

static svo_status run_stages(update *u)
{
    svo_status status = SVO_OK;
    uint64_t *counts = NULL;
    SVO_I_TRY_CLEANUP(move_objects(u));
    SVO_I_TRY_CLEANUP(make_pairs(u));
    counts = svo_i_alloc_zeroed(&u->moving->device->memory, u->changed_count + 1u, sizeof *counts);
    if (counts == NULL) {
        status = svo_i_device_fail(u->moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects",
                                   update_name, u->changed_count);
        goto cleanup;
    }
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        counts[i] = u->changed[i].count;
    }
    SVO_I_TRY_CLEANUP(merge_changed(u));
    SVO_I_TRY_CLEANUP(svo_i_moving_tree(u->moving, &u->chain, &u->list, NULL, u->timed ? &u->report : NULL, &u->tree));
    commit(u, counts);
cleanup:
    svo_i_free(counts);
    return status;
}

static svo_status run_now(svo_moving *moving, cl_command_queue queue, svo_moving_report *report)
{
    const double start_ms = svo_i_now_ms();
    update u = {.moving = moving,
                .chain = {.function = update_name, .queue = queue, .waits = true},
                .timed = report != NULL,
                .fragment_limit = moving->fragment_limit,
                .start_ms = start_ms};
    u.report.fragments = moving->list.count;
    const bool due = is_due(moving);
    const svo_status status = due ? run_stages(&u) : SVO_OK;
    if (!due) {
        svo_i_moving_forget_changes(moving);
    }
    release_update(&u);
    u.report.total_ms = svo_i_now_ms() - start_ms;
    if (report != NULL) {
        (void)svo_i_struct_write(NULL, update_name, "report", &u.report, report, SIZES_OF_REPORT);
    }
    return status;
}

/* ---- updates that do not wait ---- */

/* What the device tells of an object that is made anew. */
typedef struct news_of_object {
    svo_i_pair_count pairs;
    bool moved; /* its vertices are new, and so are the totals */
    svo_i_mesh_totals totals;
} news_of_object;

typedef struct svo_i_flight {
    update update;
    news_of_object *news; /* of the update's members */
    uint64_t *counts; /* of the same, their pairs */
    uint32_t *moved; /* those that moved */
    uint32_t moved_count;
    svo_build_state state; /* of the new tree */
    double start_ms;
    cl_event done; /* of all commands */
} svo_i_flight;

static void release_flight(svo_i_flight *flight)
{
    if (flight->done != NULL) {
        clReleaseEvent(flight->done);
    }
    svo_tree_destroy(&flight->update.tree);
    release_update(&flight->update);
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

static svo_status prepare(svo_i_flight *flight, svo_moving *moving, cl_command_queue queue)
{
    const svo_i_memory *memory = &moving->device->memory;
    flight->start_ms = svo_i_now_ms();
    flight->update = (update){.moving = moving,
                              .chain = {.function = update_name, .queue = queue},
                              .fragment_limit = SVO_I_FRAGMENTS_MAX,
                              .start_ms = flight->start_ms};
    flight->news = svo_i_alloc_zeroed(memory, moving->object_count, sizeof *flight->news);
    flight->counts = svo_i_alloc_zeroed(memory, moving->object_count, sizeof *flight->counts);
    flight->moved = svo_i_alloc_zeroed(memory, moving->object_count, sizeof *flight->moved);
    return flight->news != NULL && flight->counts != NULL && flight->moved != NULL
               ? SVO_OK
               : svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects", update_name,
                                   moving->object_count);
}

static svo_status wait_first(svo_i_flight *flight, const svo_i_call *call)
{
    svo_i_chain *chain = &flight->update.chain;
    const cl_int error = clEnqueueMarkerWithWaitList(chain->queue, call->num_wait, call->wait, &chain->last);
    return error == CL_SUCCESS
               ? SVO_OK
               : svo_i_device_fail_cl(flight->update.moving->device, update_name, "clEnqueueMarkerWithWaitList", error);
}

/* Brings new vertices to the object's plan, and their totals to the host. */
static svo_status move_object(svo_i_flight *flight, uint32_t index, news_of_object *news)
{
    svo_i_chain *chain = &flight->update.chain;
    svo_i_moving_object *object = &flight->update.moving->objects[index];
    svo_build_report discarded = {0};
    cl_event moved = NULL;
    const svo_submit submit = {.queue = chain->queue, .num_wait = 1, .wait = &chain->last, .event = &moved};
    SVO_I_TRY(svo_plan_update(object->plan, &object->mesh, &submit));
    clReleaseEvent(chain->last);
    chain->last = moved;
    object->moved = false;
    news->moved = true;
    flight->moved[flight->moved_count++] = index;
    svo_i_commands commands = svo_i_chain_begin_commands(chain, object->plan, &discarded);
    const svo_i_update *of_plan = object->plan->update;
    svo_i_mesh_totals *totals = &news->totals;
    svo_status status = svo_i_commands_read(&commands, of_plan->grid.sums, totals->sums, sizeof totals->sums);
    if (status == SVO_OK && of_plan->sums_edges) {
        status = svo_i_commands_read(&commands, of_plan->edges, &totals->edges, sizeof totals->edges);
    }
    svo_i_chain_end_commands(chain, &commands, status);
    return status;
}

static svo_status enqueue_pairs(svo_i_flight *flight)
{
    update *u = &flight->update;
    svo_moving *moving = u->moving;
    SVO_I_TRY(alloc_changed(u));
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        if (!is_new(&moving->objects[i])) {
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
    update *u = &flight->update;
    svo_i_moving_news news = {.moved = flight->moved, .state = &flight->state};
    SVO_I_TRY(enqueue_pairs(flight));
    news.moved_count = flight->moved_count;
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        news.pairs += flight->news[i].pairs.capacity;
    }
    SVO_I_TRY(merge_changed(u));
    return svo_i_moving_tree(u->moving, &u->chain, &u->list, &news, NULL, &u->tree);
}

/* Sends the commands to the device and gives the caller the event. */
static svo_status hand_over(svo_i_flight *flight, cl_event *event)
{
    svo_i_chain *chain = &flight->update.chain;
    svo_device *device = flight->update.moving->device;
    cl_int error = clFlush(chain->queue);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, update_name, "clFlush", error);
    }
    error = event != NULL ? clRetainEvent(chain->last) : CL_SUCCESS;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, update_name, "clRetainEvent", error);
    }
    if (event != NULL) {
        *event = chain->last;
    }
    flight->done = chain->last;
    chain->last = NULL;
    return SVO_OK;
}

/* Enqueues an update, whose queue is checked, and which is in flight then. */
static svo_status take_off(svo_moving *moving, const svo_i_call *call)
{
    svo_status status = SVO_OK;
    svo_i_flight *flight = svo_i_alloc_zeroed(&moving->device->memory, 1, sizeof *flight);
    if (flight == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for an update", update_name);
    }
    SVO_I_TRY_CLEANUP(prepare(flight, moving, call->queue));
    SVO_I_TRY_CLEANUP(wait_first(flight, call));
    SVO_I_TRY_CLEANUP(is_due(moving) ? enqueue_stages(flight) : SVO_OK);
    SVO_I_TRY_CLEANUP(hand_over(flight, call->event));
    moving->flight = flight;
    return SVO_OK;
cleanup:
    (void)clFlush(call->queue);
    svo_i_chain_settle(&flight->update.chain); /* its commands write to the flight */
    forget_moves(flight);
    release_flight(flight);
    return status;
}

/* An update that waits, between the caller's events. */
static svo_status update_now(svo_moving *moving, svo_i_call *call, svo_moving_report *report)
{
    if (call->num_wait > 0) {
        const cl_int error = clWaitForEvents(call->num_wait, call->wait);
        SVO_I_TRY(error == CL_SUCCESS ? SVO_OK
                                      : svo_i_device_fail_cl(moving->device, update_name, "clWaitForEvents", error));
    }
    SVO_I_TRY(run_now(moving, call->queue, report));
    if (call->given == NULL) {
        return SVO_OK;
    }
    svo_i_call_wait(call);
    return svo_i_call_end(call, svo_i_call_none(call));
}

svo_status svo_moving_update(svo_moving *moving, const svo_submit *submit, svo_moving_report *report)
{
    svo_i_call call;
    if (moving == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_call_begin(moving->device, update_name, submit, &call));
    SVO_I_TRY(svo_i_moving_check_still(moving, update_name));
    SVO_I_TRY(check_report(moving, update_name, report));
    return submit == NULL || report != NULL ? update_now(moving, &call, report) : take_off(moving, &call);
}

/* Takes what the device has counted of the objects. Each is told of, whatever became of the others. */
static svo_status take_objects(svo_i_flight *flight)
{
    update *u = &flight->update;
    svo_status first = SVO_OK;
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        const news_of_object *news = &flight->news[i];
        svo_i_moving_object *object = &u->moving->objects[u->members[i]];
        svo_status status = news->moved ? svo_i_update_take(object->plan, finish_name, &news->totals) : SVO_OK;
        const uint64_t pairs = (uint64_t)news->pairs.words[1] << 32 | news->pairs.words[0];
        flight->counts[i] = pairs;
        u->report.changed_fragments += pairs - news->pairs.capacity;
        u->report.fragments += pairs - news->pairs.capacity;
        const uint64_t dropped = object->plan->work.drop ? news->pairs.words[2] : 0;
        svo_i_moving_remember(object, pairs + dropped);
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
    update *u = &flight->update;
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
    commit(u, flight->counts);
    return SVO_OK;
}

svo_status svo_moving_finish(svo_moving *moving, svo_moving_report *report)
{
    if (moving == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(check_report(moving, finish_name, report));
    svo_i_flight *flight = moving->flight;
    if (flight == NULL) {
        return svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT, "%s: no update is in flight", finish_name);
    }
    moving->flight = NULL;
    const svo_status status = finish(flight);
    flight->update.report.total_ms = svo_i_now_ms() - flight->start_ms;
    if (report != NULL) {
        (void)svo_i_struct_write(NULL, finish_name, "report", &flight->update.report, report, SIZES_OF_REPORT);
    }
    release_flight(flight);
    return status;
}
