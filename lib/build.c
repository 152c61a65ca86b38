/* SPDX-License-Identifier: MIT */
/*
 * The builder: asks the front end for the fragment list, runs the OpenCL stages, hands out the tree. Grows and reruns when
 * a capacity was too small.
 */
#include "build.h"

#include "rays.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Cutting chunks in halves until they fit ends long before this. */
#define RERUNS_MAX 32u

const char *svo_stage_name(svo_stage stage)
{
    static const char *const names[SVO_STAGE_COUNT] = {"grid",      "compile", "voxelize", "transfer",
                                                       "subdivide", "pack",    "link",     "filter"};
    return stage < SVO_STAGE_COUNT ? names[stage] : "unknown stage";
}

svo_status svo_i_build_alloc(svo_i_build *build, const char *name, uint64_t bytes, cl_mem *out)
{
    const svo_status status =
        svo_i_device_buffer(build->device, SVO_I_BUILD, name, CL_MEM_READ_WRITE, (size_t)bytes, out);
    if (status == SVO_OK) {
        svo_i_plan_buffer_add(build->plan, name, bytes > 0 ? bytes : 1);
    }
    return status;
}

/* Makes event the newest; on failure turns the error into a status. */
static svo_status follow(svo_i_build *build, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(build->device, SVO_I_BUILD, call, error);
    }
    if (build->stage_first == NULL) {
        clRetainEvent(event);
        build->stage_first = event;
    }
    if (build->last != NULL) {
        clReleaseEvent(build->last);
    }
    build->last = event;
    return SVO_OK;
}

static cl_uint wait_count(const svo_i_build *build)
{
    return build->last != NULL ? 1 : 0;
}

static const cl_event *wait_list(const svo_i_build *build)
{
    return build->last != NULL ? &build->last : NULL;
}

svo_status svo_i_build_upload(svo_i_build *build, const char *name, const void *data, uint64_t bytes, cl_mem *out)
{
    const svo_status status = svo_i_build_alloc(build, name, bytes, out);
    if (status != SVO_OK || bytes == 0) {
        return status;
    }
    cl_event event = NULL;
    const cl_int error = clEnqueueWriteBuffer(build->queue, *out, CL_TRUE, 0, (size_t)bytes, data, wait_count(build),
                                              wait_list(build), &event);
    return follow(build, "clEnqueueWriteBuffer", error, event);
}

void svo_i_build_free(svo_i_build *build, cl_mem *buffer)
{
    if (*buffer == NULL) {
        return;
    }
    size_t bytes = 0;
    clGetMemObjectInfo(*buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    svo_i_plan_buffer_remove(build->plan, bytes);
    clReleaseMemObject(*buffer);
    *buffer = NULL;
}

svo_status svo_i_build_fill(svo_i_build *build, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                            uint64_t bytes)
{
    cl_event event = NULL;
    const cl_int error = clEnqueueFillBuffer(build->queue, buffer, pattern, pattern_bytes, 0, (size_t)bytes,
                                             wait_count(build), wait_list(build), &event);
    return follow(build, "clEnqueueFillBuffer", error, event);
}

svo_status svo_i_build_fill_zero(svo_i_build *build, cl_mem buffer, uint64_t bytes)
{
    const cl_uint zero = 0;
    return svo_i_build_fill(build, buffer, &zero, bytes % sizeof zero == 0 ? sizeof zero : 1, bytes);
}

svo_status svo_i_build_copy(svo_i_build *build, cl_mem from, cl_mem to, uint64_t to_offset, uint64_t bytes)
{
    if (bytes == 0) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_int error = clEnqueueCopyBuffer(build->queue, from, to, 0, (size_t)to_offset, (size_t)bytes,
                                             wait_count(build), wait_list(build), &event);
    return follow(build, "clEnqueueCopyBuffer", error, event);
}

svo_status svo_i_build_wait(svo_i_build *build)
{
    const cl_int error = build->last != NULL ? clWaitForEvents(1, &build->last) : CL_SUCCESS;
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(build->device, SVO_I_BUILD, "clWaitForEvents", error);
}

svo_status svo_i_build_read(svo_i_build *build, cl_mem buffer, void *to, size_t bytes)
{
    cl_event event = NULL;
    const cl_int error =
        clEnqueueReadBuffer(build->queue, buffer, CL_TRUE, 0, bytes, to, wait_count(build), wait_list(build), &event);
    return follow(build, "clEnqueueReadBuffer", error, event);
}

svo_status svo_i_build_kernel(svo_i_build *build, const char *name, cl_kernel *out)
{
    return svo_i_kernel_create(build->device, SVO_I_BUILD, build->program, name, out);
}

svo_status svo_i_build_run(svo_i_build *build, const char *name, const svo_i_argument *arguments,
                           cl_uint argument_count, uint64_t items)
{
    cl_kernel kernel = NULL;
    svo_status status = svo_i_build_kernel(build, name, &kernel);
    if (status == SVO_OK) {
        status = svo_i_build_launch(build, kernel, arguments, argument_count, items);
        clReleaseKernel(kernel);
    }
    return status;
}

svo_status svo_i_build_launch(svo_i_build *build, cl_kernel kernel, const svo_i_argument *arguments,
                              cl_uint argument_count, uint64_t items)
{
    if (items == 0) {
        return SVO_OK;
    }
    const svo_status status = svo_i_kernel_set(build->device, SVO_I_BUILD, kernel, arguments, argument_count);
    if (status != SVO_OK) {
        return status;
    }
    const size_t local = SVO_GROUP_ITEMS;
    const size_t global = (size_t)((items + local - 1) / local) * local;
    cl_event event = NULL;
    const cl_int error = clEnqueueNDRangeKernel(build->queue, kernel, 1, NULL, &global, &local, wait_count(build),
                                                wait_list(build), &event);
    return follow(build, "clEnqueueNDRangeKernel", error, event);
}

void svo_i_build_stage_begin(svo_i_build *build)
{
    if (build->stage_first != NULL) {
        clReleaseEvent(build->stage_first);
        build->stage_first = NULL;
    }
    build->stage_start_ms = svo_i_now_ms();
}

/* From the start of the first to the end of the last launch; negative where the queue does not say. */
static double event_span_ms(cl_event first, cl_event last)
{
    cl_ulong start = 0;
    cl_ulong end = 0;
    if (clGetEventProfilingInfo(first, CL_PROFILING_COMMAND_START, sizeof start, &start, NULL) != CL_SUCCESS ||
        clGetEventProfilingInfo(last, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL) != CL_SUCCESS || end < start) {
        return -1.0;
    }
    return (double)(end - start) * 1e-6;
}

svo_status svo_i_build_stage_end(svo_i_build *build, svo_stage stage)
{
    if (build->stage_first == NULL) {
        return SVO_OK;
    }
    const cl_int error = clWaitForEvents(1, &build->last);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(build->device, SVO_I_BUILD, svo_stage_name(stage), error);
    }
    const double span = build->profiling ? event_span_ms(build->stage_first, build->last) : -1.0;
    if (span >= 0.0) {
        svo_i_report_add(build->report, stage, span, "cl-event");
    } else {
        svo_i_report_add(build->report, stage, svo_i_now_ms() - build->stage_start_ms, "wall");
    }
    clReleaseEvent(build->stage_first);
    build->stage_first = NULL;
    return SVO_OK;
}

void svo_i_build_keys(const svo_plan *plan, char *keys, size_t bytes)
{
    const bool color = (plan->info.need & SVO_NEED_COLOR) != 0;
    const bool normal = (plan->info.need & SVO_NEED_NORMAL) != 0;
    static const char *const weights[] = {" -DSVO_WEIGHTS_AREA", "", " -DSVO_WEIGHTS_CENTRE"};
    const bool weighs = svo_i_plan_reads_surface(plan);
    /* Every key begins with a space: some compilers choke on options that end in one. */
    (void)snprintf(keys, bytes, "%s%s%s%s%s%s%s%s%s", plan->info.depth > SVO_CODE30_DEPTH_MAX ? " -DSVO_CODE48" : "",
                   color ? " -DSVO_COLOR" : "", color && plan->colors != NULL ? " -DSVO_VERTEX_COLOR" : "",
                   color && plan->uvs != NULL ? " -DSVO_TEXTURE" : "", normal ? " -DSVO_NORMAL" : "",
                   normal && plan->normals != NULL ? " -DSVO_VERTEX_NORMAL" : "",
                   svo_i_plan_sorts_materials(plan) ? " -DSVO_MATERIAL" : "",
                   (plan->info.need & SVO_NEED_FILL) != 0 ? " -DSVO_FILL" : "",
                   weighs ? weights[plan->options.weights] : "");
}

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
    if (build->owns_list) {
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

static svo_status make_list(svo_i_build *build, svo_frontend *frontend)
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

/* Copies the used front of a buffer to one of that size, and releases the large one. */
static svo_status trim(svo_i_build *build, svo_tree_buffer which, uint64_t bytes)
{
    cl_mem *buffer = &build->tree->buffers[which];
    size_t held = 0;
    clGetMemObjectInfo(*buffer, CL_MEM_SIZE, sizeof held, &held, NULL);
    if (held == bytes || bytes == 0) {
        return SVO_OK;
    }
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

/* Masks and first children, rerun once with room for certain when the count law misjudged the scene. */
static svo_status make_nodes(svo_i_build *build)
{
    bool fits = false;
    for (unsigned attempt = 0; attempt < 2 && !fits; ++attempt) {
        build->inner_capacity = svo_i_plan_inner_nodes(build->plan, build->fragment_count, attempt > 0);
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

/* What the ray kernels read beside the tree's arrays. */
static svo_status prepare_rays(svo_i_build *build)
{
    const svo_plan *plan = build->plan;
    const svo_tree_info *info = &build->tree->info;
    const double start_ms = svo_i_now_ms();
    double device_ms = 0.0;
    const svo_status status = svo_i_rays_prepare(build->tree, build->device, SVO_I_BUILD, build->program,
                                                 plan->vertices, build->queue, wait_list(build), &device_ms);
    if (status == SVO_OK) {
        svo_i_plan_buffer_add(build->plan, "ray_triangles", info->list_count * SVO_I_RAY_TRIANGLE_BYTES);
        svo_i_plan_buffer_add(build->plan, "ray_nodes",
                              svo_i_ray_node_count(info->level_begin, info->depth) * SVO_I_RAY_NODE_BYTES);
    }
    if (build->profiling) {
        svo_i_report_add(build->report, SVO_STAGE_PACK, device_ms, "cl-event");
    } else {
        svo_i_report_add(build->report, SVO_STAGE_PACK, svo_i_now_ms() - start_ms, "wall");
    }
    return status;
}

static void fill_info(svo_i_build *build)
{
    const svo_plan_info *from = &build->plan->info;
    svo_tree_info *to = &build->tree->info;
    to->depth = from->depth;
    to->snap_bits = from->snap_bits;
    to->coverage = from->coverage;
    to->need = from->need;
    to->weights = build->plan->options.weights;
    memcpy(to->origin, from->origin, sizeof to->origin);
    to->edge = from->edge;
    to->scale = from->scale;
    to->snap_error = from->snap_error;
    to->triangles = from->triangles;
    to->refused_triangles = from->refused_triangles;
    to->fragments = build->fragment_count;
}

/* Refuses what the count law says cannot fit, before anything is allocated. */
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
    if (build->plan->options.builder == SVO_BUILDER_SORTED) {
        return svo_i_sorted(build, frontend);
    }
    const svo_status status = svo_i_build_alloc_cursors(build);
    return status == SVO_OK ? make_nodes(build) : status;
}

/* Where leaf lists begin, and the lists themselves. */
static svo_status make_lists(svo_i_build *build, bool with_lists)
{
    return build->plan->options.builder == SVO_BUILDER_SORTED ? svo_i_sorted_lists(build, with_lists)
                                                              : svo_i_pack(build, with_lists);
}

/* What is made of the mesh's attributes. Ranges of entries that only the materials need do not stay. */
static svo_status make_payload(svo_i_build *build)
{
    const uint32_t need = build->plan->info.need;
    svo_i_surface surface = {0};
    const bool own_ranges = svo_i_plan_sorts_materials(build->plan) && (need & SVO_NEED_RAYS) == 0;
    svo_status status = svo_i_plan_reads_surface(build->plan) ? svo_i_surface_upload(build, &surface) : SVO_OK;
    if (status == SVO_OK && own_ranges) {
        status = make_lists(build, false);
    }
    if (status == SVO_OK && (need & SVO_NEED_MATERIAL) != 0) {
        status = svo_i_material(build, &surface);
    }
    if (own_ranges) {
        svo_i_build_free(build, &build->tree->buffers[SVO_TREE_LIST_BEGIN]);
    }
    if (status == SVO_OK && (need & SVO_I_NEED_FILTER) != 0) {
        status = svo_i_filter(build, &surface);
    }
    svo_i_surface_free(build, &surface);
    return status;
}

/* All of the tree, by OpenCL. */
static svo_status make_arrays(svo_i_build *build, svo_frontend *frontend)
{
    const uint32_t need = build->plan->info.need;
    svo_status status = make_tree(build, frontend);
    if (status == SVO_OK && (need & SVO_NEED_RAYS) != 0) {
        status = svo_i_keep_geometry(build);
        if (status == SVO_OK) {
            status = make_lists(build, true);
        }
    }
    if (status == SVO_OK && (need & SVO_I_NEED_PAYLOAD) != 0) {
        status = make_payload(build);
    }
    return status;
}

static svo_status run_stages(svo_i_build *build, svo_frontend *frontend)
{
    svo_status status = check_size(build);
    if (status == SVO_OK) {
        status = make_list(build, frontend);
    }
    if (status != SVO_OK) {
        return status;
    }
    fill_info(build);
    status = frontend->make_tree != NULL ? frontend->make_tree(frontend->self, build) : make_arrays(build, frontend);
    return status == SVO_OK && (build->plan->info.need & SVO_NEED_RAYS) != 0 ? prepare_rays(build) : status;
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
    for (uint32_t i = 0; build->cursors != NULL && i < build->list.chunk_count; ++i) {
        svo_i_build_free(build, &build->cursors[i]);
    }
    free(build->cursors);
    svo_i_build_free(build, &build->state);
    svo_i_build_free(build, &build->partials);
    svo_i_build_release_list(build, frontend);
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
    if (queue == NULL) {
        return "queue is NULL";
    }
    cl_context context = NULL;
    clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof context, &context, NULL);
    if (context != plan->device->context) {
        return "queue is of another context than the device";
    }
    return out == NULL ? "out is NULL" : NULL;
}

bool svo_i_queue_profiles(cl_command_queue queue)
{
    cl_command_queue_properties properties = 0;
    clGetCommandQueueInfo(queue, CL_QUEUE_PROPERTIES, sizeof properties, &properties, NULL);
    return (properties & CL_QUEUE_PROFILING_ENABLE) != 0;
}

static svo_status compile_kernels(svo_i_build *build)
{
    char keys[SVO_I_KEYS_BYTES];
    bool fresh = false;
    svo_i_build_keys(build->plan, keys, sizeof keys);
    svo_status status =
        svo_i_program_get(build->device, SVO_I_BUILD, SVO_I_PROGRAM_BUILD, keys, &build->program, &fresh);
    if (status == SVO_OK && fresh) {
        status = svo_i_build_warm(build, SVO_I_PROGRAM_BUILD);
    }
    return status == SVO_OK && build->plan->options.builder == SVO_BUILDER_SORTED ? svo_i_sorted_prepare(build)
                                                                                  : status;
}

/* Kernels and shaders, as far as this device and context have not compiled them before. */
static svo_status compile(svo_i_build *build, svo_frontend *frontend)
{
    const double start_ms = svo_i_now_ms();
    svo_status status = frontend->make_tree == NULL ? compile_kernels(build) : SVO_OK;
    if (status == SVO_OK) {
        status = frontend->prepare(frontend->self, build->plan, build->queue);
    }
    svo_i_report_add(build->report, SVO_STAGE_COMPILE, svo_i_now_ms() - start_ms, "wall");
    return status;
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
    *build.report = (svo_build_report){.struct_size = sizeof *report,
                                       .frontend = frontend->name,
                                       .share = frontend->share,
                                       .builder = frontend->make_tree != NULL ? frontend->builder
                                                                              : svo_builder_name(plan->options.builder),
                                       .renderer = frontend->renderer != NULL ? frontend->renderer : ""};
    svo_i_report_add(build.report, SVO_STAGE_GRID, plan->info.grid_ms, "wall");
    svo_i_plan_buffers_reset(plan);
    build.tree = svo_i_tree_new();
    if (build.tree == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_build: no memory for the tree");
    }
    build.tree->device = plan->device;
    svo_status status = compile(&build, frontend);
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
