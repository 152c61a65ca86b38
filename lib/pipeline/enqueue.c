/* SPDX-License-Identifier: MIT */
/*
 * Enqueued builds: the stages run in a workspace's memory, with the plan's capacities instead of counts. The device's
 * counts are read when the tree is finished.
 */
#include <string.h>

#include "core/staging.h"
#include "core/submit.h"
#include "pipeline/run.h"
#include "pipeline/workspace.h"
#include "plan/estimate.h"

static void move_buffer(cl_mem *from, cl_mem *to)
{
    *to = *from;
    *from = NULL;
}

/* Moves the tree's buffers to the workspace's allocations, from which the build takes them. */
static void lend_buffers(svo_workspace *workspace, svo_tree *tree)
{
    for (size_t i = 0; i < workspace->allocations.count; ++i) {
        svo_i_allocation *entry = &workspace->allocations.entries[i];
        if (entry->persistent) {
            move_buffer(svo_i_tree_slot(tree, entry->name), &entry->memory);
        }
    }
}

/* Moves them back to the tree. */
static void return_buffers(svo_workspace *workspace, svo_tree *tree)
{
    for (size_t i = 0; i < workspace->allocations.count; ++i) {
        svo_i_allocation *entry = &workspace->allocations.entries[i];
        if (entry->persistent) {
            move_buffer(&entry->memory, svo_i_tree_slot(tree, entry->name));
        }
    }
}

/* Enqueues a wait for the caller's events, for the workspace's previous build, and for a plan's newest update. */
static svo_status wait_first(svo_workspace *workspace, svo_i_build *build, const svo_i_call *call)
{
    svo_i_update *update = workspace->plan->update;
    SVO_I_TRY(svo_i_in_flight_reserve(&workspace->builds, workspace->device, "svo_build_enqueue"));
    SVO_I_TRY(update != NULL ? svo_i_in_flight_reserve(&update->commands, workspace->device, "svo_build_enqueue")
                             : SVO_OK);
    const cl_event build_before = svo_i_in_flight_newest(&workspace->builds);
    const cl_event update_before = update != NULL ? svo_i_in_flight_newest(&update->commands) : NULL;
    cl_event *all = svo_i_alloc_zeroed(&workspace->device->memory, (size_t)call->num_wait + 2, sizeof *all);
    cl_uint count = call->num_wait;
    if (all == NULL) {
        return svo_i_device_fail(workspace->device, SVO_OUT_OF_HOST_MEMORY,
                                 "svo_build_enqueue: no memory for %u events to wait for", call->num_wait);
    }
    if (call->num_wait > 0) {
        memcpy(all, call->wait, call->num_wait * sizeof *all);
    }
    if (build_before != NULL) {
        all[count++] = build_before;
    }
    if (update_before != NULL) {
        all[count++] = update_before;
    }
    const cl_int error = clEnqueueMarkerWithWaitList(call->queue, count, count > 0 ? all : NULL, &build->commands.last);
    svo_i_free(all);
    return error == CL_SUCCESS
               ? SVO_OK
               : svo_i_device_fail_cl(workspace->device, "svo_build_enqueue", "clEnqueueMarkerWithWaitList", error);
}

/* Draws the list with a front end that does not issue the build's commands. The host waits first and gets the count. */
static svo_status draw_now(svo_workspace *workspace, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    svo_frontend *frontend = build->frontend;
    const cl_int error = build->commands.last != NULL ? clWaitForEvents(1, &build->commands.last) : CL_SUCCESS;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(workspace->device, "svo_build_enqueue", "clWaitForEvents", error);
    }
    pending->releases_list = true;
    SVO_I_TRY(svo_i_frontend_voxelize(frontend, &build->commands, &workspace->chunking, &build->list));
    const uint64_t needed = build->list.chunk_count > 0 ? build->list.chunks[0].needed : 0;
    pending->state.fragments_low = (cl_uint)needed;
    pending->state.fragments_high = (cl_uint)(needed >> 32);
    pending->state.overflow = needed > workspace->info.fragment_capacity ? SVO_SHORT_LIST : 0;
    return SVO_OK;
}

static svo_status make_list(svo_workspace *workspace, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    svo_frontend *frontend = build->frontend;
    build->list.chunk_count = workspace->chunking.chunk_count;
    build->list.chunks =
        svo_i_alloc_zeroed(&workspace->device->memory, build->list.chunk_count + 1u, sizeof *build->list.chunks);
    if (build->list.chunks == NULL) {
        return svo_i_device_fail(workspace->device, SVO_OUT_OF_HOST_MEMORY, "svo_build_enqueue: no memory for a chunk");
    }
    return frontend->on_device ? svo_i_frontend_voxelize(frontend, &build->commands, &workspace->chunking, &build->list)
                               : draw_now(workspace, pending);
}

/* Enqueues the copies of the counts to the tree, for kernels, and to the host. */
static svo_status publish_counts(svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    const svo_i_update *update = build->commands.plan->update;
    svo_i_mesh_totals *totals = &pending->totals;
    if (update != NULL) {
        SVO_I_TRY(svo_i_commands_read(&build->commands, update->grid.sums, totals->sums, sizeof totals->sums));
    }
    if (build->list.counters != NULL && build->commands.plan->work.drop) {
        SVO_I_TRY(
            svo_i_commands_read(&build->commands, build->list.counters, pending->counters, sizeof pending->counters));
    }
    SVO_I_TRY(svo_i_commands_copy(&build->commands, build->state, build->tree->build_state, 0, sizeof pending->state));
    return svo_i_commands_read(&build->commands, build->state, &pending->state, sizeof pending->state);
}

/* Enqueues all stages and what tells their outcome. */
static svo_status enqueue_stages(svo_workspace *workspace, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    svo_i_commands *commands = &build->commands;
    build->fragment_count = workspace->info.fragment_capacity;
    svo_i_build_fill_info(build);
    svo_i_build_assume_counts(build);
    SVO_I_TRY(svo_i_build_alloc_published(build));
    SVO_I_TRY(make_list(workspace, pending));
    if (pending->state.overflow != 0) { /* draw_now has counted the fragments */
        return svo_i_commands_write(commands, build->tree->build_state, &pending->state, sizeof pending->state);
    }
    SVO_I_TRY(svo_i_order_run(build));
    return publish_counts(pending);
}

/* Returns the tree's buffers and keeps the last command, after success and failure. */
static void close_build(svo_workspace *workspace, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    if (build->commands.stage_first != NULL) {
        clReleaseEvent(build->commands.stage_first);
        build->commands.stage_first = NULL;
    }
    return_buffers(workspace, build->tree);
    if (build->commands.last != NULL) {
        svo_i_update *update = workspace->plan->update;
        pending->done = build->commands.last;
        build->commands.last = NULL;
        (void)svo_i_in_flight_add(&workspace->builds, workspace->device, "svo_build_enqueue", pending->done);
        if (update != NULL) {
            (void)svo_i_in_flight_add(&update->commands, workspace->device, "svo_build_enqueue", pending->done);
        }
    }
}

static void begin_build(svo_workspace *workspace, svo_i_pending *pending, svo_tree *tree, cl_command_queue queue)
{
    svo_i_build *build = &pending->build;
    *build = (svo_i_build){.commands = svo_i_commands_begin(workspace->plan, queue, &pending->report),
                           .frontend = workspace->frontend,
                           .in_place = true,
                           .tree = tree};
    build->commands.mode = SVO_I_MODE_ENQUEUE;
    build->commands.allocations = &workspace->allocations;
    memcpy(build->programs, workspace->programs, sizeof build->programs);
}

/* Why an argument is wrong, or NULL. */
static const char *wrong_enqueue(const svo_workspace *workspace, const svo_tree *tree)
{
    if (tree == NULL) {
        return "tree is NULL";
    }
    if (tree->workspace != workspace) {
        return "tree is not of this workspace, or was trimmed";
    }
    if (tree->pending != NULL) {
        return "tree has a build in flight; call svo_tree_finish first";
    }
    return svo_i_update_wrong(workspace->plan, true);
}

/* Sends the commands to the device and gives the caller the event. */
static svo_status hand_over(svo_workspace *workspace, const svo_i_pending *pending, svo_i_call *call)
{
    cl_int error = clFlush(call->queue);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(workspace->device, "svo_build_enqueue", "clFlush", error);
    }
    if (call->event != NULL) {
        error = clRetainEvent(pending->done);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(workspace->device, "svo_build_enqueue", "clRetainEvent", error);
        }
        *call->event = pending->done;
    }
    return svo_i_call_end(call, SVO_OK);
}

svo_status svo_build_enqueue(svo_workspace *workspace, svo_tree *tree, const svo_submit *submit)
{
    svo_i_call call;
    if (workspace == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const char *wrong = wrong_enqueue(workspace, tree);
    if (wrong != NULL) {
        return svo_i_device_fail(workspace->device, SVO_INVALID_ARGUMENT, "svo_build_enqueue: %s", wrong);
    }
    SVO_I_TRY(svo_i_call_begin(workspace->device, "svo_build_enqueue", submit, &call));
    svo_i_pending_release_given_up(workspace, false);
    svo_i_pending *pending = svo_i_alloc_zeroed(&workspace->device->memory, 1, sizeof *pending);
    if (pending == NULL) {
        return svo_i_device_fail(workspace->device, SVO_OUT_OF_HOST_MEMORY, "svo_build_enqueue: no memory for a build");
    }
    svo_status status = SVO_OK;
    begin_build(workspace, pending, tree, call.queue);
    svo_i_tree_forget(tree);
    tree->content = SVO_I_TREE_FAILED; /* until all commands are enqueued */
    lend_buffers(workspace, tree);
    SVO_I_TRY_CLEANUP(wait_first(workspace, &pending->build, &call));
    SVO_I_TRY_CLEANUP(enqueue_stages(workspace, pending));
cleanup:
    close_build(workspace, pending);
    if (status == SVO_OK) {
        status = hand_over(workspace, pending, &call);
    } else {
        (void)clFlush(call.queue);
    }
    if (status != SVO_OK) {
        svo_i_pending_give_up(workspace, pending);
        return status;
    }
    tree->pending = pending;
    tree->content = SVO_I_TREE_IN_FLIGHT;
    return SVO_OK;
}

/* Sets what an updatable plan's mesh tells of the tree. */
static svo_status take_mesh(svo_tree *tree, const svo_i_pending *pending)
{
    svo_plan *plan = pending->build.commands.plan;
    svo_tree_info *info = &tree->info;
    if (plan->update == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_update_take(plan, "svo_tree_finish", &pending->totals));
    info->refused_triangles = plan->info.refused_triangles;
    info->list_triangle_count = (info->need & SVO_NEED_RAYS) != 0 ? plan->update->kept_triangles : 0;
    return SVO_OK;
}

/* Sets the tree's counts, or fails with the capacities that the build would have needed. */
static svo_status take_counts(svo_tree *tree, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    const svo_build_state *state = &pending->state;
    const svo_workspace_info *room = &tree->workspace->info;
    const uint64_t needed = (uint64_t)state->fragments_high << 32 | state->fragments_low;
    pending->report.fragments = needed;
    pending->report.dropped = build->commands.plan->work.drop && state->overflow == 0 ? pending->counters[2] : 0;
    build->fragment_count = needed;
    if (state->overflow == SVO_DAMAGED_LIST) {
        return svo_i_build_fail_damaged(build);
    }
    if (state->overflow != 0) {
        pending->report.inner_nodes = svo_i_plan_inner_nodes(build->commands.plan, needed, true);
        return svo_i_device_fail(tree->device, SVO_CAPACITY_EXCEEDED,
                                 "svo_tree_finish: the build needs room for %llu fragments, the plan has %llu, and for "
                                 "at most %llu inner nodes, the plan has %llu",
                                 (unsigned long long)needed, (unsigned long long)room->fragment_capacity,
                                 (unsigned long long)pending->report.inner_nodes,
                                 (unsigned long long)room->inner_capacity);
    }
    bool fits = false;
    SVO_I_TRY(take_mesh(tree, pending));
    tree->info.fragments = needed;
    tree->info.list_count = (tree->info.need & SVO_NEED_RAYS) != 0 ? needed : 0;
    return svo_i_build_take_state(build, state, &fits);
}

/* Zeroes constant payload in a tree without leaves. */
static svo_status clear_constants(svo_tree *tree, cl_command_queue queue)
{
    static const unsigned char none[8] = {0};
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT && tree->info.leaf_count == 0; ++i) {
        if (svo_i_tree_is_constant(&tree->info, i)) {
            SVO_I_TRY(svo_i_device_write(tree->device, "svo_tree_finish", queue, tree->buffers[i], 0, none,
                                         svo_i_tree_element_bytes(i)));
        }
    }
    return SVO_OK;
}

/* Replaces a buffer by one of the tree's real size. */
static svo_status trim_buffer(svo_tree *tree, svo_tree_buffer which, cl_command_queue queue)
{
    const size_t bytes = (size_t)svo_i_tree_element_count(&tree->info, which) * svo_i_tree_element_bytes(which);
    size_t held = 0;
    clGetMemObjectInfo(tree->buffers[which], CL_MEM_SIZE, sizeof held, &held, NULL);
    if (held == bytes || (bytes == 0 && held == 1)) {
        return SVO_OK;
    }
    cl_mem exact = NULL;
    cl_event copied = NULL;
    SVO_I_TRY(svo_i_device_buffer(tree->device, "svo_tree_finish", svo_name(SVO_NAME_TREE_BUFFER, which),
                                  CL_MEM_READ_WRITE, bytes, &exact));
    cl_int error = CL_SUCCESS;
    if (bytes > 0) {
        error = clEnqueueCopyBuffer(queue, tree->buffers[which], exact, 0, 0, bytes, 0, NULL, &copied);
        error = error == CL_SUCCESS ? clWaitForEvents(1, &copied) : error;
    }
    if (copied != NULL) {
        clReleaseEvent(copied);
    }
    if (error != CL_SUCCESS) {
        clReleaseMemObject(exact);
        return svo_i_device_fail_cl(tree->device, "svo_tree_finish", "clEnqueueCopyBuffer", error);
    }
    clReleaseMemObject(tree->buffers[which]);
    tree->buffers[which] = exact;
    return SVO_OK;
}

static svo_status trim_tree(svo_tree *tree, cl_command_queue queue)
{
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        SVO_I_TRY(tree->buffers[i] != NULL ? trim_buffer(tree, i, queue) : SVO_OK);
    }
    svo_i_pending_leave_workspace(tree);
    return SVO_OK;
}

static void fill_report(const svo_tree *tree, const svo_i_pending *pending, svo_build_report *report)
{
    const svo_frontend *frontend = tree->workspace->frontend;
    svo_build_report made = pending->report;
    made.list_chunks = pending->build.list.chunk_count;
    made.frontend = frontend->name;
    made.builder = svo_name(SVO_NAME_BUILDER, SVO_BUILDER_CL);
    made.share = frontend->share;
    made.renderer = frontend->renderer != NULL ? frontend->renderer : "";
    svo_i_report_write(&made, report);
}

svo_status svo_tree_finish(svo_tree *tree, cl_command_queue queue, int trim, svo_build_report *report)
{
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (tree->pending == NULL) {
        const char *why = tree->content == SVO_I_TREE_ABANDONED ? svo_i_tree_undefined(tree) : "no build is in flight";
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "svo_tree_finish: %s", why);
    }
    SVO_I_TRY(svo_i_device_queue(tree->device, "svo_tree_finish", queue, &queue));
    SVO_I_TRY(svo_i_report_check(tree->device, "svo_tree_finish", report));
    svo_status status = SVO_OK;
    svo_i_pending *pending = tree->pending;
    tree->pending = NULL;
    tree->content = SVO_I_TREE_FAILED; /* until its counts are known */
    const cl_int error = clWaitForEvents(1, &pending->done);
    svo_i_stage_collect(&pending->build.commands);
    svo_i_report_add(&pending->report, SVO_STAGE_GRID, tree->workspace->plan->info.grid_ms, "wall");
    if (error != CL_SUCCESS) {
        (void)svo_i_event_settle(pending->done); /* its last command writes to pending */
        status = svo_i_device_fail_cl(tree->device, "svo_tree_finish", "clWaitForEvents for the build", error);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(take_counts(tree, pending));
    SVO_I_TRY_CLEANUP(clear_constants(tree, queue));
    tree->content = SVO_I_TREE_COMPLETE;
cleanup:
    if (report != NULL) {
        fill_report(tree, pending, report);
    }
    svo_i_pending_release(pending);
    SVO_I_TRY(status);
    return trim != 0 ? trim_tree(tree, queue) : SVO_OK;
}
