/* SPDX-License-Identifier: MIT */
/*
 * svo_build, the blocking build: has the front end draw the fragment list, runs the stages and returns the tree. What
 * goes before it: svo_plan_count, svo_device_warm, and the front end of a caller who passes NULL, one "cl" per device.
 */
#include "pipeline/build.h"

#include <string.h>

#include "core/memory.h"
#include "pipeline/run.h"
#include "plan/accounts.h"
#include "plan/chunking.h"
#include "plan/estimate.h"
#include "plan/update.h"
#include "stages/inputs.h"

/* ---- the front end ---- */

/* Attaches the front end to its device. */
typedef struct own_frontend {
    svo_i_attachment attachment;
    svo_frontend *frontend;
} own_frontend;

static void release_frontend(svo_i_attachment *attachment)
{
    svo_frontend_destroy(&((own_frontend *)attachment)->frontend);
    svo_i_free(attachment);
}

/* *out: given, or if that is NULL the device's own front end "cl", which is created on first use and owned by the
   device. */
static svo_status default_frontend(svo_device *device, svo_frontend *given, svo_frontend **out)
{
    const svo_i_attachment *known = svo_i_attachment_find(device->attachments, release_frontend);
    if (given != NULL || known != NULL) {
        *out = given != NULL ? given : ((const own_frontend *)known)->frontend;
        return SVO_OK;
    }
    svo_frontend *frontend = NULL;
    SVO_I_TRY(svo_frontend_create_cl(device, &frontend));
    own_frontend *own = svo_i_alloc_zeroed(&device->memory, 1, sizeof *own);
    if (own == NULL) {
        svo_frontend_destroy(&frontend);
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_frontend_create_cl: no memory for the handle");
    }
    *own = (own_frontend){.attachment.destroy = release_frontend, .frontend = frontend};
    svo_i_attachment_add(&device->attachments, &own->attachment);
    *out = frontend;
    return SVO_OK;
}

/* ---- the fragment list ---- */

/*
 * The fragment list of a blocking build, and svo_plan_count. The front end draws the list into chunks. If chunks were
 * too small, it draws again with larger ones.
 */

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
    SVO_I_TRY(default_frontend(plan->device, frontend, &frontend));
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
    svo_i_build_mesh_free(&build.commands);
    svo_i_commands_end(&build.commands);
    svo_i_chunking_destroy(&chunking);
    return status;
}

/* ---- the build ---- */

/* Refuses a scene that, by the fragment estimate, exceeds the caller's budget. Nothing is compiled yet. A front end
   that makes the tree has all but the tree in memory of its own. */
static svo_status check_budget(const svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    return svo_i_plan_check_budget(
        plan, SVO_I_BUILD, build->frontend->make_tree != NULL ? plan->predicted_tree_bytes : plan->predicted_bytes);
}

/* Refuses a scene that, by the fragment estimate, does not fit the device. Nothing is allocated yet. */
static svo_status check_size(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    if (plan->info.expected_fragments >= (double)UINT32_MAX) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the scene needs about %.0f fragments at depth %u, above 2^32 - 1; "
                                 "svo_parts_create builds it in parts",
                                 plan->info.expected_fragments, plan->info.depth);
    }
    if (plan->predicted_bytes > build->commands.device->global_bytes) {
        return svo_i_device_fail(
            build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
            "svo_build: the scene needs about %s at depth %u, above the device's %s; svo_parts_create "
            "builds it in parts",
            svo_i_bytes(plan->predicted_bytes).text, plan->info.depth,
            svo_i_bytes(build->commands.device->global_bytes).text);
    }
    return SVO_OK;
}

static svo_status run_stages(svo_i_build *build)
{
    svo_frontend *frontend = build->frontend;
    SVO_I_TRY(check_size(build));
    SVO_I_TRY(svo_i_list_make(build));
    svo_i_build_fill_info(build);
    if (frontend->make_tree == NULL) {
        return svo_i_order_run(build);
    }
    SVO_I_TRY(frontend->make_tree(frontend->self, build));
    return svo_i_constants_store(build);
}

/* Why an argument is wrong, or NULL. */
static const char *wrong_argument(const svo_plan *plan, const svo_frontend *frontend, svo_tree *const *out)
{
    if (frontend->device != plan->device) {
        return "frontend is of another device than plan";
    }
    return out == NULL ? "out is NULL" : svo_i_update_wrong(plan, frontend->on_device);
}

static void begin_report(svo_build_report *report, const svo_plan *plan, const svo_frontend *frontend)
{
    const char *builder =
        frontend->make_tree != NULL ? frontend->builder : svo_name(SVO_NAME_BUILDER, plan->options.builder);
    *report = (svo_build_report){.frontend = frontend->name,
                                 .share = frontend->share,
                                 .builder = builder,
                                 .renderer = frontend->renderer != NULL ? frontend->renderer : ""};
    svo_i_report_add(report, SVO_STAGE_GRID, plan->info.grid_ms, "wall");
}

/* Where the mesh moves, the host learns its counts now. */
static svo_status run_updated(svo_i_build *build)
{
    svo_plan *plan = build->commands.plan;
    SVO_I_TRY(svo_i_update_settle(plan, SVO_I_BUILD, build->commands.queue));
    SVO_I_TRY(run_stages(build));
    if (build->tree->info.list_triangle_count > 0) {
        build->tree->info.list_triangle_count = plan->update->kept_triangles;
    }
    return SVO_OK;
}

/* asked: whether the caller wants the report. */
static svo_status run_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                            svo_build_report *report, bool asked)
{
    svo_status status = SVO_OK;
    svo_i_build build = {.commands = svo_i_commands_begin(plan, queue, report), .frontend = frontend};
    build.commands.untimed = !asked;
    build.commands.blocks = frontend->make_tree != NULL; /* from memory of OpenGL that is mapped for a moment */
    begin_report(report, plan, frontend);
    svo_i_plan_buffers_reset(plan);
    plan->built = true;
    build.tree = svo_i_tree_new(&plan->device->memory);
    if (build.tree == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for the tree");
    }
    build.tree->device = plan->device;
    SVO_I_TRY_CLEANUP(svo_i_progress_begin(plan, SVO_I_BUILD, SVO_I_STAGES_OF_BUILDS));
    SVO_I_TRY_CLEANUP(check_budget(&build));
    SVO_I_TRY_CLEANUP(svo_i_compile(&build));
    SVO_I_TRY_CLEANUP(plan->update != NULL ? run_updated(&build) : run_stages(&build));
    SVO_I_TRY_CLEANUP(svo_i_commands_wait(&build.commands));
    SVO_I_TRY_CLEANUP(svo_i_progress_end(plan, build.commands.stage));
    *out = build.tree;
    build.tree = NULL;
cleanup:
    report->fragments = build.fragment_count;
    report->list_chunks = build.list.chunk_count;
    svo_i_commands_end(&build.commands);
    svo_i_stage_collect(&build.commands);
    svo_i_order_release_scratch(&build);
    svo_tree_destroy(&build.tree);
    return status;
}

svo_status svo_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                     svo_build_report *report)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_report_check(plan->device, SVO_I_BUILD, report));
    SVO_I_TRY(default_frontend(plan->device, frontend, &frontend));
    SVO_I_TRY(svo_i_device_queue(plan->device, SVO_I_BUILD, queue, &queue));
    const char *wrong = wrong_argument(plan, frontend, out);
    if (wrong != NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "svo_build: %s", wrong);
    }
    if (svo_i_plan_is_part(plan) && frontend->make_tree != NULL) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED, "svo_build: the builder %s makes no parts of trees",
                                 frontend->builder);
    }
    if (plan->work.drop && frontend->make_tree != NULL) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 "svo_build: the builder %s leaves no pairs out, and options.drop_alpha is %g",
                                 frontend->builder, plan->options.drop_alpha);
    }
    svo_build_report made;
    const svo_status status = run_build(plan, frontend, queue, out, &made, report != NULL);
    svo_i_report_write(&made, report);
    return status;
}

/* ---- svo_device_warm ---- */

svo_status svo_device_warm(svo_device *device, svo_plan *plan)
{
    static const char function[] = "svo_device_warm";
    if (device == NULL || plan == NULL || plan->device != device) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s", function,
                                 device == NULL ? "device is NULL"
                                 : plan == NULL ? "plan is NULL"
                                                : "plan is of another device");
    }
    svo_status status = SVO_OK;
    svo_frontend *frontend = NULL;
    cl_command_queue queue = NULL;
    svo_build_report discarded = {0};
    SVO_I_TRY(default_frontend(device, NULL, &frontend));
    SVO_I_TRY(svo_i_device_queue(device, function, NULL, &queue));
    svo_i_build build = {.commands = svo_i_commands_begin(plan, queue, &discarded), .frontend = frontend};
    build.commands.untimed = true;
    SVO_I_TRY_CLEANUP(svo_i_progress_begin(plan, function, SVO_I_STAGE_BIT(SVO_STAGE_COMPILE)));
    SVO_I_TRY_CLEANUP(svo_i_compile(&build));
    SVO_I_TRY_CLEANUP(svo_i_progress_end(plan, SVO_STAGE_COMPILE));
cleanup:
    svo_i_commands_end(&build.commands);
    return status;
}
