/* SPDX-License-Identifier: MIT */
/*
 * Workspaces: all the memory that enqueued builds of a plan need. A measuring build finds the sizes; the memory is
 * allocated once. Their builds end here: finished, failed, or with their tree destroyed.
 */
#include "pipeline/workspace.h"

#include <string.h>

#include "core/struct_size.h"
#include "pipeline/run.h"
#include "plan/accounts.h"
#include "plan/chunking.h"
#include "plan/estimate.h"
#include "plan/update.h"

/* ---- pending builds ---- */

void svo_i_pending_release(svo_i_pending *pending)
{
    if (pending->done != NULL) {
        clReleaseEvent(pending->done);
    }
    svo_i_stage_collect(&pending->build.commands);
    if (pending->releases_list) {
        svo_frontend *frontend = pending->build.frontend;
        frontend->release(frontend->self, &pending->build.list);
    }
    svo_i_free(pending->build.list.chunks);
    svo_i_free(pending->build.cursors);
    svo_i_free(pending);
}

static bool is_done(cl_event event)
{
    cl_int status = CL_QUEUED;
    clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, NULL);
    return status <= CL_COMPLETE;
}

void svo_i_pending_release_given_up(svo_workspace *workspace, bool all)
{
    for (svo_i_pending **at = &workspace->given_up; *at != NULL;) {
        svo_i_pending *pending = *at;
        if (all || is_done(pending->done)) {
            *at = pending->next;
            svo_i_pending_release(pending);
        } else {
            at = &pending->next;
        }
    }
}

/* The commands of a failed build may still wait for the caller's events, and write to the pending build. */
void svo_i_pending_give_up(svo_workspace *workspace, svo_i_pending *pending)
{
    if (pending->done == NULL || is_done(pending->done)) {
        svo_i_pending_release(pending);
    } else {
        pending->next = workspace->given_up;
        workspace->given_up = pending;
    }
}

/* Removes the tree from its workspace's list. */
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

/* Takes the workspace away from its trees. Those with a pending build, which the caller has waited for, are
   abandoned. */
static void abandon_trees(svo_workspace *workspace)
{
    for (svo_tree *tree = workspace->trees; tree != NULL; tree = tree->next) {
        tree->workspace = NULL;
        if (tree->pending != NULL) {
            svo_i_pending_release(tree->pending);
            tree->pending = NULL;
            tree->content = SVO_I_TREE_ABANDONED;
        }
    }
}

void svo_i_pending_leave_workspace(svo_tree *tree)
{
    if (tree->pending != NULL) {
        (void)svo_i_event_settle(tree->pending->done);
        svo_i_pending_release(tree->pending);
        tree->pending = NULL;
    }
    leave_workspace(tree);
}

/* ---- workspaces ---- */

#define SVO_I_WORKSPACE "svo_workspace_create"

static svo_status check(svo_plan *plan, svo_frontend *frontend)
{
    if (frontend == NULL || frontend->device != plan->device) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, SVO_I_WORKSPACE ": frontend is %s",
                                 frontend == NULL ? "NULL" : "of another device than plan");
    }
    const char *wrong = svo_i_update_wrong(plan, frontend->on_device);
    if (wrong != NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, SVO_I_WORKSPACE ": %s", wrong);
    }
    if (frontend->make_tree != NULL) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 SVO_I_WORKSPACE ": builder %s cannot be enqueued, only cl", frontend->builder);
    }
    if (svo_i_plan_is_part(plan)) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 SVO_I_WORKSPACE ": the plan is that of a part, which svo_build makes");
    }
    if (plan->work.sorted) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 SVO_I_WORKSPACE ": builder sorted waits for counts; only cl can be enqueued");
    }
    return SVO_OK;
}

/* Cuts the list, which must be one chunk. */
static svo_status cut_list(svo_workspace *workspace)
{
    const svo_plan *plan = workspace->plan;
    const uint64_t chunk_bytes = svo_i_chunk_bytes_max(plan, workspace->frontend->chunk_bytes_max);
    SVO_I_TRY(svo_i_chunking_create(plan, chunk_bytes, &workspace->chunking));
    workspace->chunking.tile_cache = &workspace->tile_cache;
    if (workspace->chunking.chunk_count > 1) {
        return svo_i_device_fail(workspace->device, SVO_UNSUPPORTED,
                                 SVO_I_WORKSPACE ": the list of about %.0f fragments takes %u chunks, and builds that "
                                                 "are enqueued have one",
                                 plan->info.expected_fragments, workspace->chunking.chunk_count);
    }
    return SVO_OK;
}

/* Records the allocations of a build and places its scratch. The plan's list of buffers becomes that of the build. */
static svo_status measure(svo_workspace *workspace)
{
    svo_i_allocations *list = &workspace->allocations;
    SVO_I_TRY(check(workspace->plan, workspace->frontend));
    SVO_I_TRY(cut_list(workspace));
    workspace->plan->built = true; /* sizes are exact: capacities are what is allocated */
    SVO_I_TRY(svo_i_measure(workspace->plan, workspace->frontend, &workspace->chunking, list));
    workspace->info.scratch_alignment = workspace->device->slot_bytes;
    svo_i_allocations_place(list, workspace->info.scratch_alignment);
    workspace->info.scratch_bytes = list->scratch_bytes;
    for (size_t i = 0; i < list->count; ++i) {
        workspace->info.tree_bytes += list->entries[i].persistent ? list->entries[i].bytes : 0;
    }
    workspace->info.fragment_capacity =
        workspace->chunking.chunk_count > 0 ? workspace->chunking.chunks[0].capacity : 0;
    workspace->info.inner_capacity = svo_i_plan_inner_nodes(workspace->plan, workspace->info.fragment_capacity,
                                                            workspace->plan->options.worst_case_nodes != 0);
    return SVO_OK;
}

static void release(svo_workspace *workspace)
{
    svo_i_chunking_destroy(&workspace->chunking);
    svo_i_tiles_free(&workspace->tile_cache.tiles);
    svo_i_free(workspace->tile_cache.begin);
    svo_i_allocations_free(&workspace->allocations);
    if (workspace->scratch != NULL) {
        clReleaseMemObject(workspace->scratch);
    }
}

#define SIZES_OF_INFO SVO_I_STRUCT_SIZES(svo_workspace_info, scratch_alignment)

svo_status svo_workspace_measure(svo_plan *plan, svo_frontend *frontend, svo_workspace_info *info)
{
    if (plan == NULL || info == NULL) {
        return svo_i_device_fail(plan != NULL ? plan->device : NULL, SVO_INVALID_ARGUMENT,
                                 "svo_workspace_measure: %s is NULL", plan == NULL ? "plan" : "info");
    }
    SVO_I_TRY(svo_i_struct_check(&plan->device->message, "svo_workspace_measure", "info", info, SIZES_OF_INFO));
    const svo_plan before = *plan;
    svo_workspace measured = {.device = plan->device, .plan = plan, .frontend = frontend};
    const svo_status status = measure(&measured);
    if (status == SVO_OK) {
        (void)svo_i_struct_write(NULL, "", "info", &measured.info, info, SIZES_OF_INFO);
    }
    release(&measured);
    *plan = before; /* restores its list of buffers */
    return status;
}

/* Checks and retains the caller's scratch memory, or allocates it. */
static svo_status get_scratch(svo_workspace *workspace, const svo_workspace_options *options)
{
    const svo_workspace_info *info = &workspace->info;
    if (options->scratch == NULL) {
        return svo_i_device_buffer(workspace->device, SVO_I_WORKSPACE, "scratch", CL_MEM_READ_WRITE,
                                   (size_t)info->scratch_bytes, &workspace->scratch);
    }
    size_t bytes = 0;
    SVO_I_TRY(svo_i_device_check_memory(workspace->device, SVO_I_WORKSPACE, "options.scratch", options->scratch, 0));
    cl_int error = clGetMemObjectInfo(options->scratch, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(workspace->device, SVO_I_WORKSPACE, "clGetMemObjectInfo", error);
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
    error = clRetainMemObject(options->scratch);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(workspace->device, SVO_I_WORKSPACE, "clRetainMemObject", error);
    }
    workspace->scratch = options->scratch;
    return SVO_OK;
}

/* Creates a sub-buffer for every scratch entry. */
static svo_status cut_scratch(svo_workspace *workspace, uint64_t offset_bytes)
{
    for (size_t i = 0; i < workspace->allocations.count; ++i) {
        svo_i_allocation *entry = &workspace->allocations.entries[i];
        const cl_buffer_region region = {(size_t)(offset_bytes + entry->offset_bytes), (size_t)entry->bytes};
        cl_int error = CL_SUCCESS;
        if (entry->persistent) {
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
    svo_build_report discarded = {0};
    svo_i_build build = {.commands = svo_i_commands_begin(workspace->plan, queue, &discarded),
                         .frontend = workspace->frontend};
    svo_status status = SVO_OK;
    build.commands.untimed = true;
    SVO_I_TRY_CLEANUP(svo_i_progress_begin(workspace->plan, SVO_I_WORKSPACE, SVO_I_STAGE_BIT(SVO_STAGE_COMPILE)));
    SVO_I_TRY_CLEANUP(svo_i_compile(&build));
    SVO_I_TRY_CLEANUP(svo_i_progress_end(workspace->plan, SVO_STAGE_COMPILE));
    memcpy(workspace->programs, build.programs, sizeof workspace->programs);
cleanup:
    svo_i_commands_end(&build.commands);
    return status;
}

svo_status svo_workspace_create(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue,
                                const svo_workspace_options *options, svo_workspace **out)
{
    svo_workspace_options asked;
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_struct_read(&plan->device->message, SVO_I_WORKSPACE, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_workspace_options, scratch)));
    SVO_I_TRY(svo_i_device_queue(plan->device, SVO_I_WORKSPACE, queue, &queue));
    if (out == NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, SVO_I_WORKSPACE ": out is NULL");
    }
    svo_workspace *workspace = svo_i_alloc_zeroed(&plan->device->memory, 1, sizeof *workspace);
    if (workspace == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, SVO_I_WORKSPACE ": no memory for the handle");
    }
    svo_status status = SVO_OK;
    const svo_plan before = *plan;
    *workspace = (svo_workspace){.device = plan->device, .plan = plan, .frontend = frontend};
    SVO_I_TRY_CLEANUP(measure(workspace));
    SVO_I_TRY_CLEANUP(svo_i_plan_check_budget(plan, SVO_I_WORKSPACE,
                                              workspace->info.tree_bytes +
                                                  (asked.scratch == NULL ? workspace->info.scratch_bytes : 0)));
    SVO_I_TRY_CLEANUP(get_scratch(workspace, &asked));
    SVO_I_TRY_CLEANUP(cut_scratch(workspace, asked.scratch != NULL ? asked.offset_bytes : 0));
    SVO_I_TRY_CLEANUP(compile(workspace, queue));
    *out = workspace;
    return SVO_OK;
cleanup:
    svo_workspace_destroy(&workspace);
    *plan = before; /* restores its list of buffers */
    return status;
}

void svo_workspace_destroy(svo_workspace **workspace)
{
    if (workspace == NULL || *workspace == NULL) {
        return;
    }
    svo_i_in_flight_end(&(*workspace)->builds);
    svo_i_pending_release_given_up(*workspace, true);
    abandon_trees(*workspace);
    release(*workspace);
    svo_i_free(*workspace);
    *workspace = NULL;
}

svo_status svo_workspace_get_info(const svo_workspace *workspace, svo_workspace_info *info)
{
    return svo_i_struct_write(&workspace->device->message, "svo_workspace_get_info", "info", &workspace->info, info,
                              SIZES_OF_INFO);
}

/* Attached to a tree: removes it from its workspace when it is destroyed. */
typedef struct membership {
    svo_i_attachment attachment;
    svo_tree *tree;
} membership;

static void end_membership(svo_i_attachment *attachment)
{
    svo_i_pending_leave_workspace(((membership *)attachment)->tree);
    svo_i_free(attachment);
}

/* A new empty tree in the workspace's list; NULL when out of memory. */
static svo_tree *new_member(svo_workspace *workspace)
{
    svo_tree *tree = svo_i_tree_new(&workspace->device->memory);
    membership *member = svo_i_alloc_zeroed(&workspace->device->memory, 1, sizeof *member);
    if (tree == NULL || member == NULL) {
        svo_tree_destroy(&tree);
        svo_i_free(member);
        return NULL;
    }
    *member = (membership){.attachment.destroy = end_membership, .tree = tree};
    svo_i_attachment_add(&tree->attachments, &member->attachment);
    tree->device = workspace->device;
    tree->content = SVO_I_TREE_EMPTY;
    tree->moves = workspace->plan->update != NULL;
    tree->workspace = workspace;
    tree->next = workspace->trees;
    workspace->trees = tree;
    return tree;
}

svo_status svo_workspace_make_tree(svo_workspace *workspace, svo_tree **out)
{
    static const char function[] = "svo_workspace_make_tree";
    if (workspace == NULL || out == NULL) {
        return svo_i_device_fail(workspace != NULL ? workspace->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL",
                                 function, workspace == NULL ? "workspace" : "out");
    }
    svo_status status = SVO_OK;
    svo_tree *tree = new_member(workspace);
    if (tree == NULL) {
        return svo_i_device_fail(workspace->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the tree", function);
    }
    const svo_i_build described = {.commands.plan = workspace->plan, .tree = tree};
    svo_i_build_fill_info(&described);
    for (size_t i = 0; i < workspace->allocations.count; ++i) {
        const svo_i_allocation *entry = &workspace->allocations.entries[i];
        if (entry->persistent) {
            SVO_I_TRY_CLEANUP(svo_i_device_buffer(workspace->device, function, entry->name, CL_MEM_READ_WRITE,
                                                  (size_t)entry->bytes, svo_i_tree_slot(tree, entry->name)));
        }
    }
    *out = tree;
    return SVO_OK;
cleanup:
    svo_tree_destroy(&tree);
    return status;
}
