/* SPDX-License-Identifier: MIT */
/*
 * Builds that do not wait: the stages of build.c in memory that was measured and made before, with the plan's capacities in
 * place of counts. What the device counts is read when the tree is finished.
 */
#include "workspace.h"

#include <stdlib.h>
#include <string.h>

#include "build.h"

#define SVO_I_WORKSPACE "svo_workspace_create"

struct svo_workspace {
    svo_device *device;
    svo_plan *plan;
    svo_frontend *frontend;
    svo_i_layout layout; /* one chunk, or none for a plan without triangles */
    svo_i_kept_tiles kept;
    svo_i_allocations allocations;
    svo_workspace_info info;
    cl_mem scratch; /* owned, or the caller's retained */
    cl_program program; /* the device's */
    cl_event last; /* of the newest build; NULL at first */
    svo_tree *trees; /* made from it, and not trimmed or destroyed */
};

/* A build that was enqueued. */
struct svo_i_pending {
    svo_i_build build; /* without its events */
    svo_frontend *frontend; /* that has to release the list; NULL: it is scratch */
    svo_build_report report;
    cl_event done;
    svo_build_state state; /* read back when it is done */
    cl_uint counter[2];
};

static svo_status check(svo_plan *plan, svo_frontend *frontend)
{
    if (frontend == NULL || frontend->device != plan->device) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, SVO_I_WORKSPACE ": frontend is %s",
                                 frontend == NULL ? "NULL" : "of another device than plan");
    }
    if (frontend->make_tree != NULL) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 SVO_I_WORKSPACE ": builder %s cannot be enqueued, only cl", frontend->builder);
    }
    if (plan->work.sorted) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 SVO_I_WORKSPACE ": builder sorted waits for counts; only cl can be enqueued");
    }
    return SVO_OK;
}

/* One chunk that holds the whole list. */
static svo_status lay_out(svo_workspace *workspace)
{
    const svo_plan *plan = workspace->plan;
    const uint64_t allocation = workspace->device->max_allocation_bytes;
    const uint64_t chunk = workspace->frontend->chunk_bytes_max;
    const uint64_t most = chunk < allocation ? chunk : allocation;
    const uint64_t asked = plan->options.chunk_bytes;
    const svo_status status = svo_i_layout_create(plan, asked != 0 && asked < most ? asked : most, &workspace->layout);
    if (status == SVO_OK && workspace->layout.chunk_count > 1) {
        return svo_i_device_fail(workspace->device, SVO_UNSUPPORTED,
                                 SVO_I_WORKSPACE ": the list of about %.0f fragments takes %u chunks, and builds that "
                                                 "are enqueued have one",
                                 plan->info.expected_fragments, workspace->layout.chunk_count);
    }
    return status;
}

static uint64_t alignment_of(const svo_device *device)
{
    cl_uint bits = 0;
    clGetDeviceInfo(device->device, CL_DEVICE_MEM_BASE_ADDR_ALIGN, sizeof bits, &bits, NULL);
    return bits >= 1024 ? bits / 8 : 128;
}

/* Lists the allocations of a build and places its scratch. */
static svo_status measure(svo_workspace *workspace)
{
    svo_i_allocations *list = &workspace->allocations;
    svo_status status = check(workspace->plan, workspace->frontend);
    status = status == SVO_OK ? lay_out(workspace) : status;
    workspace->plan->built = true; /* capacities are what is allocated */
    if (status == SVO_OK) {
        status = svo_i_build_measure(workspace->plan, workspace->frontend, &workspace->layout, list, &workspace->kept);
    }
    if (status != SVO_OK) {
        return status;
    }
    workspace->info.scratch_alignment = alignment_of(workspace->device);
    svo_i_allocations_place(list, workspace->info.scratch_alignment);
    workspace->info.scratch_bytes = list->scratch_bytes;
    for (size_t i = 0; i < list->count; ++i) {
        workspace->info.tree_bytes += list->entries[i].stays ? list->entries[i].bytes : 0;
    }
    workspace->info.fragment_capacity = workspace->layout.chunk_count > 0 ? workspace->layout.chunks[0].capacity : 0;
    workspace->info.inner_capacity = svo_i_plan_inner_nodes(workspace->plan, workspace->info.fragment_capacity,
                                                            workspace->plan->options.certain_nodes != 0);
    return SVO_OK;
}

static void release(svo_workspace *workspace)
{
    svo_i_layout_destroy(&workspace->layout);
    svo_i_tiles_free(&workspace->kept.tiles);
    free(workspace->kept.begin);
    svo_i_allocations_free(&workspace->allocations);
    if (workspace->scratch != NULL) {
        clReleaseMemObject(workspace->scratch);
    }
}

svo_status svo_workspace_measure(svo_plan *plan, svo_frontend *frontend, svo_workspace_info *info)
{
    if (plan == NULL || info == NULL) {
        return svo_i_device_fail(plan != NULL ? plan->device : NULL, SVO_INVALID_ARGUMENT,
                                 "svo_workspace_measure: %s is NULL", plan == NULL ? "plan" : "info");
    }
    svo_workspace measured = {.device = plan->device, .plan = plan, .frontend = frontend};
    const svo_status status = measure(&measured);
    if (status == SVO_OK) {
        *info = measured.info;
    }
    release(&measured);
    return status;
}

/* The caller's scratch, checked, or a buffer of the workspace's. */
static svo_status get_scratch(svo_workspace *workspace, const svo_workspace_options *options)
{
    const svo_workspace_info *info = &workspace->info;
    if (options->scratch == NULL) {
        return svo_i_device_buffer(workspace->device, SVO_I_WORKSPACE, "scratch", CL_MEM_READ_WRITE,
                                   (size_t)info->scratch_bytes, &workspace->scratch);
    }
    size_t bytes = 0;
    cl_context context = NULL;
    clGetMemObjectInfo(options->scratch, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    clGetMemObjectInfo(options->scratch, CL_MEM_CONTEXT, sizeof context, &context, NULL);
    if (context != workspace->device->context) {
        return svo_i_device_fail(workspace->device, SVO_INVALID_ARGUMENT,
                                 SVO_I_WORKSPACE ": options.scratch is of another context than the device");
    }
    if (options->offset_bytes % info->scratch_alignment != 0 || options->offset_bytes > bytes ||
        bytes - options->offset_bytes < info->scratch_bytes) {
        return svo_i_device_fail(
            workspace->device, SVO_INVALID_ARGUMENT,
            SVO_I_WORKSPACE
            ": options.scratch has %zu bytes, and %llu are needed from offset %llu on, a multiple of %llu",
            bytes, (unsigned long long)info->scratch_bytes, (unsigned long long)options->offset_bytes,
            (unsigned long long)info->scratch_alignment);
    }
    clRetainMemObject(options->scratch);
    workspace->scratch = options->scratch;
    return SVO_OK;
}

/* A sub-buffer for every scratch entry. */
static svo_status cut_scratch(svo_workspace *workspace, uint64_t offset_bytes)
{
    for (size_t i = 0; i < workspace->allocations.count; ++i) {
        svo_i_allocation *entry = &workspace->allocations.entries[i];
        const cl_buffer_region region = {(size_t)(offset_bytes + entry->offset_bytes), (size_t)entry->bytes};
        cl_int error = CL_SUCCESS;
        if (entry->stays) {
            continue;
        }
        entry->memory = clCreateSubBuffer(workspace->scratch, 0, CL_BUFFER_CREATE_TYPE_REGION, &region, &error);
        if (error != CL_SUCCESS) {
            entry->memory = NULL;
            return svo_i_device_fail_cl(workspace->device, SVO_I_WORKSPACE, "clCreateSubBuffer", error);
        }
    }
    return SVO_OK;
}

static svo_status compile(svo_workspace *workspace, cl_command_queue queue)
{
    svo_build_report unread = {0};
    svo_i_build build = {.device = workspace->device, .plan = workspace->plan, .queue = queue, .report = &unread};
    const svo_status status = svo_i_build_compile(&build, workspace->frontend);
    if (build.last != NULL) {
        clWaitForEvents(1, &build.last);
        clReleaseEvent(build.last);
    }
    if (build.stage_first != NULL) {
        clReleaseEvent(build.stage_first);
    }
    workspace->program = build.program;
    return status;
}

static const char *wrong_argument(const svo_plan *plan, cl_command_queue queue, const svo_workspace_options *options,
                                  svo_workspace *const *out)
{
    if (out == NULL) {
        return "out is NULL";
    }
    if (options != NULL && options->struct_size != sizeof *options) {
        return "options.struct_size is not sizeof(svo_workspace_options)";
    }
    return svo_i_wrong_queue(plan->device, queue);
}

svo_status svo_workspace_create(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue,
                                const svo_workspace_options *options, svo_workspace **out)
{
    static const svo_workspace_options defaults = {.struct_size = sizeof defaults};
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const char *wrong = wrong_argument(plan, queue, options, out);
    if (wrong != NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, SVO_I_WORKSPACE ": %s", wrong);
    }
    svo_workspace *workspace = calloc(1, sizeof *workspace);
    if (workspace == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, SVO_I_WORKSPACE ": no memory for the handle");
    }
    *workspace = (svo_workspace){.device = plan->device, .plan = plan, .frontend = frontend};
    const svo_workspace_options *given = options != NULL ? options : &defaults;
    svo_status status = measure(workspace);
    if (status == SVO_OK) {
        status = get_scratch(workspace, given);
    }
    if (status == SVO_OK) {
        status = cut_scratch(workspace, options != NULL && options->scratch != NULL ? options->offset_bytes : 0);
    }
    if (status == SVO_OK) {
        status = compile(workspace, queue);
    }
    if (status != SVO_OK) {
        svo_workspace_destroy(&workspace);
        return status;
    }
    *out = workspace;
    return SVO_OK;
}

void svo_workspace_destroy(svo_workspace **workspace)
{
    if (workspace == NULL || *workspace == NULL) {
        return;
    }
    if ((*workspace)->last != NULL) {
        clWaitForEvents(1, &(*workspace)->last);
        clReleaseEvent((*workspace)->last);
    }
    for (svo_tree *tree = (*workspace)->trees; tree != NULL; tree = tree->next) {
        tree->workspace = NULL;
    }
    release(*workspace);
    free(*workspace);
    *workspace = NULL;
}

void svo_workspace_get_info(const svo_workspace *workspace, svo_workspace_info *info)
{
    *info = workspace->info;
}

/* Which array of a tree an allocation of that name is. */
static svo_tree_buffer buffer_named(const char *name)
{
    svo_tree_buffer buffer = SVO_TREE_CHILD_MASK;
    while (buffer < SVO_TREE_BUFFER_COUNT && strcmp(svo_tree_buffer_name(buffer), name) != 0) {
        ++buffer;
    }
    return buffer;
}

svo_status svo_workspace_make_tree(svo_workspace *workspace, svo_tree **out)
{
    static const char function[] = "svo_workspace_make_tree";
    if (workspace == NULL || out == NULL) {
        return svo_i_device_fail(workspace != NULL ? workspace->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL",
                                 function, workspace == NULL ? "workspace" : "out");
    }
    svo_tree *tree = svo_i_tree_new();
    svo_status status = SVO_OK;
    if (tree == NULL) {
        return svo_i_device_fail(workspace->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the tree", function);
    }
    tree->device = workspace->device;
    tree->workspace = workspace;
    tree->next = workspace->trees;
    workspace->trees = tree;
    for (size_t i = 0; i < workspace->allocations.count && status == SVO_OK; ++i) {
        const svo_i_allocation *entry = &workspace->allocations.entries[i];
        if (entry->stays) {
            status = svo_i_device_buffer(workspace->device, function, entry->name, CL_MEM_READ_WRITE,
                                         (size_t)entry->bytes, &tree->buffers[buffer_named(entry->name)]);
        }
    }
    if (status != SVO_OK) {
        svo_tree_destroy(&tree);
        return status;
    }
    *out = tree;
    return SVO_OK;
}

/* The tree's buffers become allocations of the workspace's, to be handed out to its build; and the tree's again. */
static void lend_buffers(svo_workspace *workspace, svo_tree *tree, bool back)
{
    for (size_t i = 0; i < workspace->allocations.count; ++i) {
        svo_i_allocation *entry = &workspace->allocations.entries[i];
        if (entry->stays) {
            cl_mem *buffer = &tree->buffers[buffer_named(entry->name)];
            *(back ? buffer : &entry->memory) = back ? entry->memory : *buffer;
            *(back ? &entry->memory : buffer) = NULL;
        }
    }
}

/* Waits for the caller's events and for the build before. */
static svo_status wait_first(svo_workspace *workspace, svo_i_build *build, cl_uint num_wait, const cl_event *wait)
{
    cl_event *all = calloc(num_wait + 1u, sizeof *all);
    cl_uint count = num_wait;
    if (all == NULL) {
        return svo_i_device_fail(workspace->device, SVO_OUT_OF_HOST_MEMORY,
                                 "svo_build_enqueue: no memory for %u events", num_wait + 1u);
    }
    if (num_wait > 0) {
        memcpy(all, wait, num_wait * sizeof *all);
    }
    if (workspace->last != NULL) {
        all[count++] = workspace->last;
    }
    const cl_int error = clEnqueueMarkerWithWaitList(build->queue, count, count > 0 ? all : NULL, &build->last);
    free(all);
    return error == CL_SUCCESS
               ? SVO_OK
               : svo_i_device_fail_cl(workspace->device, "svo_build_enqueue", "clEnqueueMarkerWithWaitList", error);
}

/* The list of a front end that draws now, waiting for what the build waits for: its count is the host's. */
static svo_status draw_now(svo_workspace *workspace, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    svo_frontend *frontend = workspace->frontend;
    const cl_int error = build->last != NULL ? clWaitForEvents(1, &build->last) : CL_SUCCESS;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(workspace->device, "svo_build_enqueue", "clWaitForEvents", error);
    }
    pending->frontend = frontend;
    const svo_status status = frontend->voxelize(frontend->self, build->plan, &workspace->layout, build->queue,
                                                 &build->list, &pending->report);
    const uint64_t needed = build->list.chunk_count > 0 ? build->list.chunks[0].needed : 0;
    pending->counter[0] = (cl_uint)needed;
    pending->counter[1] = (cl_uint)(needed >> 32);
    pending->state.overflow = needed > workspace->info.fragment_capacity ? SVO_SHORT_LIST : 0;
    return status;
}

static svo_status make_list(svo_workspace *workspace, svo_i_pending *pending)
{
    svo_frontend *frontend = workspace->frontend;
    return frontend->enqueue != NULL ? frontend->enqueue(&pending->build, &workspace->layout)
                                     : draw_now(workspace, pending);
}

/* All stages, and the counts on their way to the host. */
static svo_status enqueue_stages(svo_workspace *workspace, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    build->fragment_count = workspace->info.fragment_capacity;
    svo_i_build_fill_info(build);
    svo_i_build_assume_counts(build);
    build->list.chunk_count = workspace->layout.chunk_count;
    build->list.chunks = calloc(build->list.chunk_count + 1u, sizeof *build->list.chunks);
    if (build->list.chunks == NULL) {
        return svo_i_device_fail(workspace->device, SVO_OUT_OF_HOST_MEMORY, "svo_build_enqueue: no memory for a chunk");
    }
    svo_status status = make_list(workspace, pending);
    if (status != SVO_OK || pending->state.overflow != 0) { /* known already */
        return status;
    }
    status = svo_i_build_make_arrays(build, workspace->frontend);
    if (status == SVO_OK && build->counters != NULL) {
        status = svo_i_build_read(build, build->counters, pending->counter, sizeof pending->counter);
    }
    return status == SVO_OK ? svo_i_build_read(build, build->state, &pending->state, sizeof pending->state) : status;
}

static void release_pending(svo_i_pending *pending)
{
    if (pending->done != NULL) {
        clReleaseEvent(pending->done);
    }
    svo_i_build_take_spans(&pending->build);
    if (pending->frontend != NULL) {
        pending->frontend->release(pending->frontend->self, &pending->build.list);
    }
    free(pending->build.list.chunks);
    free(pending->build.cursors);
    free(pending);
}

/* What the build holds on to when it has been enqueued, or given up. */
static void close_build(svo_workspace *workspace, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    if (build->stage_first != NULL) {
        clReleaseEvent(build->stage_first);
        build->stage_first = NULL;
    }
    lend_buffers(workspace, build->tree, true);
    if (build->last != NULL) {
        if (workspace->last != NULL) {
            clReleaseEvent(workspace->last);
        }
        workspace->last = build->last;
        clRetainEvent(build->last);
        pending->done = build->last;
        build->last = NULL;
    }
}

static const char *wrong_enqueue(const svo_workspace *workspace, const svo_tree *tree, cl_command_queue queue,
                                 cl_uint num_wait, const cl_event *wait)
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
    if ((num_wait > 0) != (wait != NULL)) {
        return "num_wait and wait disagree";
    }
    return svo_i_wrong_queue(workspace->device, queue);
}

svo_status svo_build_enqueue(svo_workspace *workspace, svo_tree *tree, cl_command_queue queue, cl_uint num_wait,
                             const cl_event *wait, cl_event *event)
{
    if (workspace == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const char *wrong = wrong_enqueue(workspace, tree, queue, num_wait, wait);
    if (wrong != NULL) {
        return svo_i_device_fail(workspace->device, SVO_INVALID_ARGUMENT, "svo_build_enqueue: %s", wrong);
    }
    svo_i_pending *pending = calloc(1, sizeof *pending);
    if (pending == NULL) {
        return svo_i_device_fail(workspace->device, SVO_OUT_OF_HOST_MEMORY, "svo_build_enqueue: no memory for a build");
    }
    pending->build = (svo_i_build){.mode = SVO_I_BUILD_ENQUEUES,
                                   .device = workspace->device,
                                   .plan = workspace->plan,
                                   .queue = queue,
                                   .profiling = svo_i_queue_profiles(queue),
                                   .program = workspace->program,
                                   .report = &pending->report,
                                   .stays_in_place = true,
                                   .allocations = &workspace->allocations,
                                   .kept = &workspace->kept,
                                   .tree = tree};
    svo_i_tree_forget(tree);
    lend_buffers(workspace, tree, false);
    svo_status status = wait_first(workspace, &pending->build, num_wait, wait);
    status = status == SVO_OK ? enqueue_stages(workspace, pending) : status;
    close_build(workspace, pending);
    if (status != SVO_OK) {
        if (pending->done != NULL) {
            clWaitForEvents(1, &pending->done);
        }
        release_pending(pending);
        return status;
    }
    clFlush(queue);
    tree->pending = pending;
    if (event != NULL) {
        clRetainEvent(pending->done);
        *event = pending->done;
    }
    return SVO_OK;
}

/* The tree's counts, or what it would have needed. */
static svo_status take_counts(svo_tree *tree, svo_i_pending *pending)
{
    svo_i_build *build = &pending->build;
    const svo_build_state *state = &pending->state;
    const svo_workspace_info *room = &tree->workspace->info;
    const uint64_t needed = (uint64_t)pending->counter[1] << 32 | pending->counter[0];
    pending->report.fragments = needed;
    build->fragment_count = needed;
    if (state->overflow == SVO_DAMAGED_LIST) {
        return svo_i_build_fail_damaged(build);
    }
    if (state->overflow != 0) {
        pending->report.inner_nodes = svo_i_plan_inner_nodes(build->plan, needed, true);
        return svo_i_device_fail(tree->device, SVO_NEED_MORE,
                                 "svo_tree_finish: the build needs room for %llu fragments, the plan has %llu, and for "
                                 "at most %llu inner nodes, the plan has %llu",
                                 (unsigned long long)needed, (unsigned long long)room->fragment_capacity,
                                 (unsigned long long)pending->report.inner_nodes,
                                 (unsigned long long)room->inner_capacity);
    }
    bool fits = false;
    tree->info.fragments = needed;
    tree->info.list_count = (tree->info.need & SVO_NEED_RAYS) != 0 ? needed : 0;
    return svo_i_take_state(build, state, &fits);
}

/* Payload that is stored once is zero in a tree without leaves. */
static svo_status clear_constants(svo_tree *tree, cl_command_queue queue)
{
    static const unsigned char none[8] = {0};
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT && tree->info.leaf_count == 0; ++i) {
        if (svo_i_tree_is_constant(&tree->info, i)) {
            const cl_int error = clEnqueueWriteBuffer(queue, tree->buffers[i], CL_TRUE, 0, svo_i_tree_element_bytes(i),
                                                      none, 0, NULL, NULL);
            if (error != CL_SUCCESS) {
                return svo_i_device_fail_cl(tree->device, "svo_tree_finish", "clEnqueueWriteBuffer", error);
            }
        }
    }
    return SVO_OK;
}

/* A copy of the front of a buffer in place of it. */
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
    const svo_status status = svo_i_device_buffer(tree->device, "svo_tree_finish", svo_tree_buffer_name(which),
                                                  CL_MEM_READ_WRITE, bytes, &exact);
    if (status != SVO_OK) {
        return status;
    }
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

/* No more builds go into the tree. */
static void leave_workspace(svo_tree *tree)
{
    svo_tree **at = tree->workspace != NULL ? &tree->workspace->trees : NULL;
    while (at != NULL && *at != tree) {
        at = &(*at)->next;
    }
    if (at != NULL) {
        *at = tree->next;
    }
    tree->workspace = NULL;
    tree->next = NULL;
}

static svo_status trim_tree(svo_tree *tree, cl_command_queue queue)
{
    svo_status status = SVO_OK;
    for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT && status == SVO_OK; ++i) {
        status = tree->buffers[i] != NULL ? trim_buffer(tree, i, queue) : SVO_OK;
    }
    leave_workspace(tree);
    return status;
}

void svo_i_tree_leave_workspace(svo_tree *tree)
{
    if (tree->pending != NULL) {
        clWaitForEvents(1, &tree->pending->done);
        release_pending(tree->pending);
        tree->pending = NULL;
    }
    leave_workspace(tree);
}

static void fill_report(const svo_tree *tree, const svo_i_pending *pending, svo_build_report *report)
{
    const svo_frontend *frontend = tree->workspace->frontend;
    *report = pending->report;
    report->struct_size = sizeof *report;
    report->list_chunks = pending->build.list.chunk_count;
    report->frontend = frontend->name;
    report->builder = svo_builder_name(SVO_BUILDER_CL);
    report->share = frontend->share;
    report->renderer = frontend->renderer != NULL ? frontend->renderer : "";
}

svo_status svo_tree_finish(svo_tree *tree, cl_command_queue queue, int trim, svo_build_report *report)
{
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const char *wrong = tree->pending == NULL ? "tree has no build in flight" : svo_i_wrong_queue(tree->device, queue);
    if (wrong == NULL && report != NULL && report->struct_size != sizeof *report) {
        wrong = "report.struct_size is not sizeof(svo_build_report)";
    }
    if (wrong != NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "svo_tree_finish: %s", wrong);
    }
    svo_i_pending *pending = tree->pending;
    tree->pending = NULL;
    const cl_int error = clWaitForEvents(1, &pending->done);
    svo_status status =
        error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(tree->device, "svo_tree_finish", "the build", error);
    svo_i_build_take_spans(&pending->build);
    svo_i_report_add(&pending->report, SVO_STAGE_GRID, tree->workspace->plan->info.grid_ms, "wall");
    status = status == SVO_OK ? take_counts(tree, pending) : status;
    if (report != NULL) {
        fill_report(tree, pending, report);
    }
    release_pending(pending);
    status = status == SVO_OK ? clear_constants(tree, queue) : status;
    return status == SVO_OK && trim != 0 ? trim_tree(tree, queue) : status;
}
