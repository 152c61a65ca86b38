/* SPDX-License-Identifier: MIT */
/*
 * The builder: has the fragment list made (list.c), runs the OpenCL stages, hands out the tree. Makes the nodes again
 * when there was too little room for them.
 */
#include "stages/build_state.h"

#include <stdlib.h>
#include <string.h>

const char *svo_stage_name(svo_stage stage)
{
    static const char *const names[SVO_STAGE_COUNT] = {"grid",      "compile", "voxelize", "transfer",
                                                       "subdivide", "pack",    "link",     "filter"};
    return stage < SVO_STAGE_COUNT ? names[stage] : "unknown stage";
}

/* Refuses what the fragment estimate says cannot fit, before anything is allocated. */
static svo_status check_size(svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    if (plan->info.expected_fragments >= (double)UINT32_MAX) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the scene needs about %.0f fragments at depth %u, above 2^32 - 1",
                                 plan->info.expected_fragments, plan->info.depth);
    }
    if (plan->predicted_bytes > build->commands.device->global_bytes) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the scene needs about %llu bytes at depth %u, above the device's %llu",
                                 (unsigned long long)plan->predicted_bytes, plan->info.depth,
                                 (unsigned long long)build->commands.device->global_bytes);
    }
    return SVO_OK;
}

/* Nodes and cursors, by the builder asked for. */
static svo_status make_tree(svo_i_build *build, svo_frontend *frontend)
{
    if (build->commands.plan->work.sorted) {
        return svo_i_sorted(build, frontend);
    }
    SVO_I_TRY(svo_i_build_alloc_cursors(build));
    return make_nodes(build);
}

/* Where leaf lists begin, and the lists themselves. */
static svo_status make_lists(svo_i_build *build, bool with_lists)
{
    return build->commands.plan->work.sorted ? svo_i_sorted_lists(build, with_lists) : svo_i_pack(build, with_lists);
}

/* What kernels make of the mesh's attributes. Ranges of entries that only the materials need do not stay. */
static svo_status make_payload(svo_i_build *build)
{
    const svo_i_work *work = &build->commands.plan->work;
    const bool own_ranges = work->ranges && !work->lists;
    svo_i_surface surface = {0};
    svo_status status = svo_i_surface_upload(build, &surface);
    if (status == SVO_OK && own_ranges) {
        status = make_lists(build, false);
    }
    if (status == SVO_OK && (work->made & SVO_NEED_MATERIAL) != 0) {
        status = svo_i_material(build, &surface);
    }
    if (status == SVO_OK && own_ranges) {
        svo_i_commands_free(&build->commands, &build->tree->buffers[SVO_TREE_LIST_BEGIN]);
    }
    if (status == SVO_OK && work->filter) {
        status = svo_i_filter(build, &surface);
    }
    svo_i_surface_free(build, &surface);
    return status;
}

static svo_status make_arrays(svo_i_build *build, svo_frontend *frontend)
{
    const svo_i_work *work = &build->commands.plan->work;
    svo_status status = make_tree(build, frontend);
    if (status == SVO_OK && work->lists) {
        status = svo_i_keep_geometry(build);
        if (status == SVO_OK) {
            status = make_lists(build, true);
        }
    }
    return status == SVO_OK && work->surface ? make_payload(build) : status;
}

svo_status svo_i_build_make_arrays(svo_i_build *build, svo_frontend *frontend)
{
    SVO_I_TRY(make_arrays(build, frontend));
    return store_constants(build);
}

static svo_status run_stages(svo_i_build *build, svo_frontend *frontend)
{
    SVO_I_TRY(check_size(build));
    SVO_I_TRY(svo_i_build_make_list(build, frontend));
    svo_i_build_fill_info(build);
    if (frontend->make_tree == NULL) {
        SVO_I_TRY(svo_i_build_make_arrays(build, frontend));
    } else {
        SVO_I_TRY(frontend->make_tree(frontend->self, build));
        SVO_I_TRY(store_constants(build));
    }
    return SVO_OK;
}

/* Waits for what was launched, also after a failure, and releases everything but the tree. */
static void finish(svo_i_build *build, svo_frontend *frontend)
{
    if (build->commands.last != NULL) {
        clWaitForEvents(1, &build->commands.last);
        clReleaseEvent(build->commands.last);
    }
    if (build->commands.stage_first != NULL) {
        clReleaseEvent(build->commands.stage_first);
    }
    release_scratch(build, frontend);
}

/* The list, and what is made of it. */
static svo_status measure_stages(svo_i_build *build, const svo_frontend *frontend, const svo_i_chunking *chunking)
{
    build->list.chunk_count = chunking->chunk_count;
    build->list.chunks = calloc(chunking->chunk_count + 1u, sizeof *build->list.chunks);
    if (build->list.chunks == NULL) {
        return svo_i_device_fail(build->commands.device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory for %u chunks",
                                 chunking->chunk_count);
    }
    build->owns_list = true;
    if (frontend == NULL || frontend->enqueue != NULL) { /* others have their lists in memory of their own */
        SVO_I_TRY(svo_i_voxelize_enqueue(build, chunking));
    }
    if (!build->in_place) { /* a build that waits has read them by now */
        svo_i_commands_free(&build->commands, &build->counters);
    }
    for (uint32_t i = 0; i < chunking->chunk_count; ++i) {
        build->list.chunks[i].needed = chunking->chunks[i].capacity;
        build->fragment_count += chunking->chunks[i].capacity;
    }
    svo_i_build_fill_info(build);
    svo_i_build_assume_counts(build);
    return svo_i_build_make_arrays(build, NULL);
}

/* The handles in a measured tree are none: the allocations behind them are the tree's. */
static void mark_staying(svo_i_build *build)
{
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (build->tree->buffers[i] != NULL) {
            build->commands.allocations->entries[(size_t)(uintptr_t)build->tree->buffers[i] - 1].persistent = true;
            build->tree->buffers[i] = NULL;
        }
    }
}

svo_status svo_i_build_measure(svo_plan *plan, const svo_frontend *frontend, const svo_i_chunking *chunking,
                               svo_i_allocations *allocations, svo_i_kept_tiles *kept)
{
    svo_i_allocations unread = {0};
    svo_build_report report = {0};
    svo_i_build build = {.mode = SVO_I_MODE_MEASURE,
                         .device = plan->device,
                         .plan = plan,
                         .report = &report,
                         .in_place = allocations != NULL,
                         .allocations = allocations != NULL ? allocations : &unread,
                         .kept = kept,
                         .tree = svo_i_tree_new()};
    svo_status status = SVO_OK;
    if (build.tree == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory to predict sizes");
    }
    svo_i_plan_buffers_reset(plan);
    status = measure_stages(&build, frontend, chunking);
    release_scratch(&build, NULL);
    mark_staying(&build);
    svo_i_allocations_free(&unread);
    svo_tree_destroy(&build.tree);
    return status;
}

const char *svo_i_wrong_queue(const svo_device *device, cl_command_queue queue)
{
    if (queue == NULL) {
        return "queue is NULL";
    }
    cl_context context = NULL;
    clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof context, &context, NULL);
    return context != device->context ? "queue is of another context than the device" : NULL;
}

/* Which argument is wrong, or NULL. */
static const char *wrong_argument(const svo_plan *plan, const svo_frontend *frontend, cl_command_queue queue,
                                  svo_tree *const *out)
{
    if (frontend == NULL) {
        return "frontend is NULL";
    }
    if (frontend->device != plan->device) {
        return "frontend is of another device than plan";
    }
    const char *wrong = svo_i_wrong_queue(plan->device, queue);
    return wrong == NULL && out == NULL ? "out is NULL" : wrong;
}

bool svo_i_queue_profiles(cl_command_queue queue)
{
    cl_command_queue_properties properties = 0;
    clGetCommandQueueInfo(queue, CL_QUEUE_PROPERTIES, sizeof properties, &properties, NULL);
    return (properties & CL_QUEUE_PROFILING_ENABLE) != 0;
}

static svo_status compile_kernels(svo_i_build *build)
{
    const svo_i_work *work = &build->commands.plan->work;
    char defines[SVO_I_DEFINES_BYTES];
    bool fresh = false;
    svo_i_plan_defines(build->commands.plan, defines, sizeof defines);
    svo_status status = SVO_OK;
    if (work->builder_kernels) {
        status = svo_i_program_get(build->commands.device, SVO_I_BUILD, SVO_I_PROGRAM_BUILD, defines, &build->program, &fresh);
    }
    if (status == SVO_OK && fresh) {
        status = svo_i_build_warm(build, SVO_I_PROGRAM_BUILD);
    }
    return status == SVO_OK && build->commands.plan->work.sorted ? svo_i_sorted_prepare(build) : status;
}

svo_status svo_i_build_compile(svo_i_build *build, svo_frontend *frontend)
{
    const double start_ms = svo_i_now_ms();
    SVO_I_TRY(frontend->make_tree == NULL ? compile_kernels(build) : SVO_OK);
    SVO_I_TRY(frontend->prepare(frontend->self, build->commands.plan, build->commands.queue));
    svo_i_report_add(build->commands.report, SVO_STAGE_COMPILE, svo_i_now_ms() - start_ms, "wall");
    return SVO_OK;
}

svo_status svo_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                     svo_build_report *report)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const char *wrong = wrong_argument(plan, frontend, queue, out);
    if (wrong != NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "svo_build: %s", wrong);
    }
    if (report != NULL && report->struct_size != sizeof *report) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "svo_build: report.struct_size is %zu, not %zu",
                                 report->struct_size, sizeof *report);
    }
    svo_build_report unread = {0};
    svo_i_build build = {.device = plan->device,
                         .plan = plan,
                         .queue = queue,
                         .profiling = svo_i_queue_profiles(queue),
                         .report = report != NULL ? report : &unread};
    *build.commands.report = (svo_build_report){.struct_size = sizeof *report,
                                       .frontend = frontend->name,
                                       .share = frontend->share,
                                       .builder = frontend->make_tree != NULL ? frontend->builder
                                                                              : svo_builder_name(plan->options.builder),
                                       .renderer = frontend->renderer != NULL ? frontend->renderer : ""};
    svo_i_report_add(build.commands.report, SVO_STAGE_GRID, plan->info.grid_ms, "wall");
    svo_i_plan_buffers_reset(plan);
    plan->built = true;
    build.tree = svo_i_tree_new();
    if (build.tree == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for the tree");
    }
    build.tree->device = plan->device;
    svo_status status = svo_i_build_compile(&build, frontend);
    if (status == SVO_OK) {
        status = run_stages(&build, frontend);
    }
    build.commands.report->fragments = build.fragment_count;
    build.commands.report->list_chunks = build.list.chunk_count;
    finish(&build, frontend);
    if (status != SVO_OK) {
        svo_tree_destroy(&build.tree);
        return status;
    }
    *out = build.tree;
    return SVO_OK;
}
