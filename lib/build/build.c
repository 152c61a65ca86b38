/* SPDX-License-Identifier: MIT */
/*
 * The builder: has the fragment list made (list.c), runs the OpenCL stages, hands out the tree. Makes the nodes again
 * when there was too little room for them.
 */
#include "build/build.h"

#include <stdlib.h>
#include <string.h>

#include "build/frontend_choice.h"
#include "core/struct_size.h"

const char *svo_stage_name(svo_stage stage)
{
    static const char *const names[SVO_STAGE_COUNT] = {"grid",      "compile", "voxelize", "transfer",
                                                       "subdivide", "pack",    "link",     "filter"};
    return stage < SVO_STAGE_COUNT ? names[stage] : "unknown stage";
}

/* Copies the used front of a buffer to one of that size, and releases the large one. */
static svo_status trim(svo_i_build *build, svo_tree_buffer which, uint64_t bytes)
{
    cl_mem *buffer = &build->tree->buffers[which];
    cl_mem exact = NULL;
    svo_status status = svo_i_build_alloc(build, svo_tree_buffer_name(which), bytes, &exact);
    if (status == SVO_OK) {
        status = svo_i_build_copy(build, *buffer, exact, 0, bytes);
    }
    if (status == SVO_OK) {
        svo_i_build_free(build, buffer);
        *buffer = exact;
    } else {
        svo_i_build_free(build, &exact);
    }
    return status;
}

/* Masks and first children in arrays of the plan's capacities. */
static svo_status make_nodes_in_place(svo_i_build *build)
{
    bool fits = false;
    cl_mem *buffers = build->tree->buffers;
    build->inner_capacity = build->tree->info.inner_count;
    svo_status status = svo_i_build_alloc(build, svo_tree_buffer_name(SVO_TREE_CHILD_MASK),
                                          (build->inner_capacity + 3) / 4 * 4, &buffers[SVO_TREE_CHILD_MASK]);
    if (status == SVO_OK) {
        status = svo_i_build_alloc(build, svo_tree_buffer_name(SVO_TREE_FIRST_CHILD), build->inner_capacity * 4,
                                   &buffers[SVO_TREE_FIRST_CHILD]);
    }
    return status == SVO_OK ? svo_i_subdivide(build, &fits) : status;
}

/* Masks and first children, rerun once with room for certain when the fragment estimate misjudged the scene. */
static svo_status make_nodes(svo_i_build *build)
{
    bool fits = false;
    if (build->in_place) {
        return make_nodes_in_place(build);
    }
    for (unsigned attempt = 0; attempt < 2 && !fits; ++attempt) {
        build->inner_capacity = svo_i_plan_inner_nodes(build->plan, build->fragment_count,
                                                       attempt > 0 || build->plan->options.worst_case_nodes != 0);
        svo_i_build_free(build, &build->tree->buffers[SVO_TREE_CHILD_MASK]);
        svo_i_build_free(build, &build->tree->buffers[SVO_TREE_FIRST_CHILD]);
        const uint64_t mask_bytes = (build->inner_capacity + 3) / 4 * 4;
        svo_status status =
            svo_i_build_alloc(build, "child_mask_pool", mask_bytes, &build->tree->buffers[SVO_TREE_CHILD_MASK]);
        if (status == SVO_OK) {
            status = svo_i_build_alloc(build, "first_child_pool", build->inner_capacity * 4,
                                       &build->tree->buffers[SVO_TREE_FIRST_CHILD]);
        }
        if (status == SVO_OK) {
            status = svo_i_subdivide(build, &fits);
        }
        if (status != SVO_OK) {
            return status;
        }
        build->report->reruns += fits ? 0 : 1;
    }
    if (!fits) {
        return svo_i_device_fail(build->device, SVO_INTERNAL, "svo_build: %llu fragments made more than %llu nodes",
                                 (unsigned long long)build->fragment_count, (unsigned long long)build->inner_capacity);
    }
    const svo_status status = trim(build, SVO_TREE_CHILD_MASK, build->tree->info.inner_count);
    return status == SVO_OK ? trim(build, SVO_TREE_FIRST_CHILD, build->tree->info.inner_count * 4) : status;
}

svo_status svo_i_keep_geometry(svo_i_build *build)
{
    const svo_plan *plan = build->plan;
    svo_status status = SVO_OK;
    svo_i_build_stage_begin(build);
    if (build->tree->buffers[SVO_TREE_VERTICES] == NULL) {
        status = svo_i_build_upload(build, "vertices", plan->vertices, (uint64_t)plan->vertex_count * 12,
                                    &build->tree->buffers[SVO_TREE_VERTICES]);
    }
    if (status == SVO_OK) {
        status = svo_i_build_upload(build, "indices", plan->indices, (uint64_t)plan->triangle_count * 12,
                                    &build->tree->buffers[SVO_TREE_INDICES]);
    }
    if (status == SVO_OK) {
        status = svo_i_build_upload(build, "triangle_ids", plan->triangle_ids, (uint64_t)plan->triangle_count * 4,
                                    &build->tree->buffers[SVO_TREE_TRIANGLE_IDS]);
    }
    build->tree->info.vertex_count = plan->vertex_count;
    build->tree->info.list_triangle_count = plan->triangle_count;
    return status == SVO_OK ? svo_i_build_stage_end(build, SVO_STAGE_TRANSFER) : status;
}

void svo_i_build_fill_info(svo_i_build *build)
{
    const svo_plan_info *from = &build->plan->info;
    svo_tree_info *to = &build->tree->info;
    to->depth = from->depth;
    to->snap_bits = from->snap_bits;
    to->coverage = from->coverage;
    to->need = from->need;
    to->constant = from->constant;
    to->weights = build->plan->options.weights;
    to->payload_level = build->plan->options.payload_level;
    memcpy(to->origin, from->origin, sizeof to->origin);
    to->edge = from->edge;
    to->scale = from->scale;
    to->snap_error = from->snap_error;
    to->triangles = from->triangles;
    to->refused_triangles = from->refused_triangles;
    to->fragments = build->fragment_count;
}

/* Of a tree too large to be built: builds refuse it, plans are made of it. */
static uint32_t limited(uint64_t nodes)
{
    return nodes < UINT32_MAX ? (uint32_t)nodes : UINT32_MAX;
}

void svo_i_build_assume_counts(svo_i_build *build)
{
    const svo_plan *plan = build->plan;
    svo_tree_info *info = &build->tree->info;
    uint64_t nodes = 0;
    for (uint32_t level = 0; level < info->depth; ++level) {
        info->level_begin[level] = limited(nodes);
        nodes += svo_i_plan_level_nodes(plan, level, build->fragment_count, plan->options.worst_case_nodes != 0);
    }
    info->level_begin[info->depth] = limited(nodes);
    info->inner_count = nodes;
    info->leaf_count = build->fragment_count;
    info->node_count = nodes + build->fragment_count;
    info->level_begin[info->depth + 1] = limited(info->node_count);
    info->fragments = build->fragment_count;
}

/* Refuses what the fragment estimate says cannot fit, before anything is allocated. */
static svo_status check_size(svo_i_build *build)
{
    const svo_plan *plan = build->plan;
    if (plan->info.expected_fragments >= (double)UINT32_MAX) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the scene needs about %.0f fragments at depth %u, above 2^32 - 1",
                                 plan->info.expected_fragments, plan->info.depth);
    }
    if (plan->predicted_bytes > build->device->global_bytes) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_build: the scene needs about %llu bytes at depth %u, above the device's %llu",
                                 (unsigned long long)plan->predicted_bytes, plan->info.depth,
                                 (unsigned long long)build->device->global_bytes);
    }
    return SVO_OK;
}

/* Nodes and cursors, by the builder asked for. */
static svo_status make_tree(svo_i_build *build, svo_frontend *frontend)
{
    if (build->plan->work.sorted) {
        return svo_i_sorted(build, frontend);
    }
    const svo_status status = svo_i_build_alloc_cursors(build);
    return status == SVO_OK ? make_nodes(build) : status;
}

/* Where leaf lists begin, and the lists themselves. */
static svo_status make_lists(svo_i_build *build, bool with_lists)
{
    return build->plan->work.sorted ? svo_i_sorted_lists(build, with_lists) : svo_i_pack(build, with_lists);
}

/* Payload that is the same in every node, once. Without any leaf all payload is zero. */
static svo_status store_constants(svo_i_build *build)
{
    static const unsigned char none[8] = {0};
    const svo_i_work *work = &build->plan->work;
    const struct {
        svo_need bit;
        svo_tree_buffer array;
        const void *value;
    } constants[] = {{SVO_NEED_COLOR, SVO_TREE_COLORS, &work->constant_color},
                     {SVO_NEED_NORMAL, SVO_TREE_NORMALS, work->constant_normal},
                     {SVO_NEED_MATERIAL, SVO_TREE_MATERIALS, &work->constant_material}};
    svo_status status = SVO_OK;
    svo_i_build_stage_begin(build);
    for (unsigned i = 0; i < sizeof constants / sizeof constants[0] && status == SVO_OK; ++i) {
        const svo_tree_buffer array = constants[i].array;
        if ((work->constant & (uint32_t)constants[i].bit) != 0) {
            status = svo_i_build_upload(build, svo_tree_buffer_name(array),
                                        build->tree->info.leaf_count > 0 ? constants[i].value : none,
                                        svo_i_tree_element_bytes(array), &build->tree->buffers[array]);
        }
    }
    return status == SVO_OK ? svo_i_build_stage_end(build, SVO_STAGE_TRANSFER) : status;
}

/* What kernels make of the mesh's attributes. Ranges of entries that only the materials need do not stay. */
static svo_status make_payload(svo_i_build *build)
{
    const svo_i_work *work = &build->plan->work;
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
        svo_i_build_free(build, &build->tree->buffers[SVO_TREE_LIST_BEGIN]);
    }
    if (status == SVO_OK && work->filter) {
        status = svo_i_filter(build, &surface);
    }
    svo_i_surface_free(build, &surface);
    return status;
}

static svo_status make_arrays(svo_i_build *build, svo_frontend *frontend)
{
    const svo_i_work *work = &build->plan->work;
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
    const svo_status status = make_arrays(build, frontend);
    return status == SVO_OK ? store_constants(build) : status;
}

static svo_status run_stages(svo_i_build *build, svo_frontend *frontend)
{
    svo_status status = check_size(build);
    if (status == SVO_OK) {
        status = svo_i_build_make_list(build, frontend);
    }
    if (status != SVO_OK) {
        return status;
    }
    svo_i_build_fill_info(build);
    if (frontend->make_tree == NULL) {
        status = svo_i_build_make_arrays(build, frontend);
    } else {
        status = frontend->make_tree(frontend->self, build);
        status = status == SVO_OK ? store_constants(build) : status;
    }
    return status;
}

/* Everything but the tree, none of it in use any more. */
static void release_scratch(svo_i_build *build, svo_frontend *frontend)
{
    for (uint32_t i = 0; build->cursors != NULL && i < build->list.chunk_count; ++i) {
        svo_i_build_free(build, &build->cursors[i]);
    }
    free(build->cursors);
    svo_i_build_free(build, &build->counters);
    svo_i_build_free(build, &build->state);
    svo_i_build_free(build, &build->partials);
    svo_i_build_release_list(build, frontend);
}

/* Waits for what was launched, also after a failure, and releases everything but the tree. */
static void finish(svo_i_build *build, svo_frontend *frontend)
{
    if (build->last != NULL) {
        clWaitForEvents(1, &build->last);
        clReleaseEvent(build->last);
    }
    if (build->stage_first != NULL) {
        clReleaseEvent(build->stage_first);
    }
    release_scratch(build, frontend);
}

/* The list, and what is made of it. */
static svo_status measure_stages(svo_i_build *build, const svo_frontend *frontend, const svo_i_layout *layout)
{
    build->list.chunk_count = layout->chunk_count;
    build->list.chunks = calloc(layout->chunk_count + 1u, sizeof *build->list.chunks);
    if (build->list.chunks == NULL) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory for %u chunks",
                                 layout->chunk_count);
    }
    build->owns_list = true;
    svo_status status = SVO_OK;
    if (frontend == NULL || frontend->enqueue != NULL) { /* others have their lists in memory of their own */
        status = svo_i_voxelize_enqueue(build, layout);
    }
    if (!build->in_place) { /* a build that waits has read them by now */
        svo_i_build_free(build, &build->counters);
    }
    for (uint32_t i = 0; i < layout->chunk_count; ++i) {
        build->list.chunks[i].needed = layout->chunks[i].capacity;
        build->fragment_count += layout->chunks[i].capacity;
    }
    svo_i_build_fill_info(build);
    svo_i_build_assume_counts(build);
    return status == SVO_OK ? svo_i_build_make_arrays(build, NULL) : status;
}

/* The handles in a measured tree are none: the allocations behind them are the tree's. */
static void mark_staying(svo_i_build *build)
{
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (build->tree->buffers[i] != NULL) {
            build->allocations->entries[(size_t)(uintptr_t)build->tree->buffers[i] - 1].persistent = true;
            build->tree->buffers[i] = NULL;
        }
    }
}

svo_status svo_i_build_measure(svo_plan *plan, const svo_frontend *frontend, const svo_i_layout *layout,
                               svo_i_allocations *allocations, svo_i_kept_tiles *kept)
{
    svo_i_allocations unread = {0};
    svo_build_report report = {0};
    svo_i_build build = {.mode = SVO_I_BUILD_MEASURES,
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
    status = measure_stages(&build, frontend, layout);
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
    const svo_i_work *work = &build->plan->work;
    char defines[SVO_I_DEFINES_BYTES];
    bool fresh = false;
    svo_i_plan_defines(build->plan, defines, sizeof defines);
    svo_status status = SVO_OK;
    if (work->builder_kernels) {
        status = svo_i_program_get(build->device, SVO_I_BUILD, SVO_I_PROGRAM_BUILD, defines, &build->program, &fresh);
    }
    if (status == SVO_OK && fresh) {
        status = svo_i_build_warm(build, SVO_I_PROGRAM_BUILD);
    }
    return status == SVO_OK && build->plan->work.sorted ? svo_i_sorted_prepare(build) : status;
}

svo_status svo_i_build_compile(svo_i_build *build, svo_frontend *frontend)
{
    const double start_ms = svo_i_now_ms();
    svo_status status = frontend->make_tree == NULL ? compile_kernels(build) : SVO_OK;
    if (status == SVO_OK) {
        status = frontend->prepare(frontend->self, build->plan, build->queue);
    }
    svo_i_report_add(build->report, SVO_STAGE_COMPILE, svo_i_now_ms() - start_ms, "wall");
    return status;
}

static svo_status run_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                            svo_build_report *report)
{
    svo_i_build build = {.device = plan->device,
                         .plan = plan,
                         .queue = queue,
                         .profiling = svo_i_queue_profiles(queue),
                         .report = report};
    *build.report = (svo_build_report){.frontend = frontend->name,
                                       .share = frontend->share,
                                       .builder = frontend->make_tree != NULL ? frontend->builder
                                                                              : svo_builder_name(plan->options.builder),
                                       .renderer = frontend->renderer != NULL ? frontend->renderer : ""};
    svo_i_report_add(build.report, SVO_STAGE_GRID, plan->info.grid_ms, "wall");
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
    build.report->fragments = build.fragment_count;
    build.report->list_chunks = build.list.chunk_count;
    finish(&build, frontend);
    if (status != SVO_OK) {
        svo_tree_destroy(&build.tree);
        return status;
    }
    *out = build.tree;
    return SVO_OK;
}

/* The sizes of svo_build_report. Its stage times are its last field, so that shorter reports have none. */
svo_status svo_i_report_check(svo_device *device, const char *function, const svo_build_report *report)
{
    return report == NULL ? SVO_OK
                          : svo_i_struct_check(&device->message, function, "report", report,
                                               SVO_I_STRUCT_SIZES(svo_build_report, renderer));
}

void svo_i_report_write(const svo_build_report *made, svo_build_report *report)
{
    if (report != NULL) {
        (void)svo_i_struct_write(NULL, "", "report", made, report, SVO_I_STRUCT_SIZES(svo_build_report, renderer));
    }
}

svo_status svo_build(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, svo_tree **out,
                     svo_build_report *report)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(svo_i_report_check(plan->device, SVO_I_BUILD, report));
    SVO_I_TRY(svo_i_default_frontend(plan->device, frontend, &frontend));
    SVO_I_TRY(svo_i_device_queue(plan->device, SVO_I_BUILD, queue, &queue));
    const char *wrong = wrong_argument(plan, frontend, queue, out);
    if (wrong != NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "svo_build: %s", wrong);
    }
    svo_build_report made;
    const svo_status status = run_build(plan, frontend, queue, out, &made);
    svo_i_report_write(&made, report);
    return status;
}

size_t svo_build_report_stage(const svo_build_report *report, size_t index, svo_stage_time *time)
{
    const size_t end_bytes = offsetof(svo_build_report, stage_times) + (index + 1) * sizeof report->stage_times[0];
    const bool known = index < SVO_STAGE_COUNT && end_bytes <= report->struct_size;
    if (time != NULL) {
        *time = known ? report->stage_times[index] : (svo_stage_time){.clock = NULL};
    }
    return SVO_STAGE_COUNT;
}
