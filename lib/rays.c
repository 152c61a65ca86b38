/* SPDX-License-Identifier: MIT */
/*
 * Rays against triangles, the host's side of kernels/rays.clh: what a tree keeps for them, and the way into svocl's and
 * an integrator's kernels. Reads finished trees; rays_batch.c launches.
 */
#include "rays.h"

#include <math.h>

#include "svocl/plan.h"
#include "svocl/trace.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_rays[];

/* ---- what a tree keeps ---- */

/* The largest coordinate there is, at least the width of the grid. */
static float find_reach(const int32_t *vertices, uint64_t vertex_count, uint32_t snap_bits)
{
    int32_t reach = (int32_t)(1u << snap_bits);
    for (uint64_t i = 0; i < vertex_count * 3; ++i) {
        const int32_t far_off = vertices[i] < 0 ? -vertices[i] : vertices[i];
        reach = far_off > reach ? far_off : reach;
    }
    return (float)reach;
}

/* What the launches of one preparation share. */
typedef struct preparation {
    svo_tree *tree;
    svo_device *device;
    const char *function;
    cl_program program;
    cl_command_queue queue;
    const cl_event *wait; /* NULL: nothing to wait for */
    double device_ms; /* of the launches, as far as the queue says */
} preparation;

/* Milliseconds of a finished command; 0 where its queue does not say. */
static double event_ms(cl_event event)
{
    cl_ulong start = 0;
    cl_ulong end = 0;
    const bool known =
        clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START, sizeof start, &start, NULL) == CL_SUCCESS &&
        clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL) == CL_SUCCESS;
    return known && end > start ? (double)(end - start) * 1e-6 : 0.0;
}

/* Launches a kernel and waits for it. */
static svo_status run(preparation *p, const char *name, const svo_i_argument *arguments, cl_uint argument_count,
                      uint64_t items)
{
    cl_kernel kernel = NULL;
    svo_status status = svo_i_kernel_create(p->device, p->function, p->program, name, &kernel);
    if (status != SVO_OK) {
        return status;
    }
    status = svo_i_kernel_set(p->device, p->function, kernel, arguments, argument_count);
    if (status == SVO_OK && items > 0) {
        const size_t local = SVO_GROUP_ITEMS;
        const size_t global = (size_t)((items + local - 1) / local * local);
        cl_event done = NULL;
        cl_int error =
            clEnqueueNDRangeKernel(p->queue, kernel, 1, NULL, &global, &local, p->wait != NULL ? 1 : 0, p->wait, &done);
        if (error == CL_SUCCESS) {
            error = clWaitForEvents(1, &done);
            p->device_ms += event_ms(done);
            clReleaseEvent(done);
        }
        status = error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(p->device, p->function, name, error);
    }
    clReleaseKernel(kernel);
    return status;
}

static svo_status spread_triangles(preparation *p)
{
    svo_tree *tree = p->tree;
    const cl_uint count = (cl_uint)tree->info.list_count;
    size_t bytes = SIZE_MAX;
    (void)svo_i_mul_size(count, SVO_I_RAY_TRIANGLE_BYTES, &bytes);
    const svo_status status =
        svo_i_device_buffer(p->device, p->function, "ray_triangles", CL_MEM_READ_WRITE, bytes, &tree->ray_triangles);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_VERTICES]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_INDICES]),
                                        SVO_I_ARGUMENT(tree->buffers[SVO_TREE_TRIANGLE_IDS]),
                                        SVO_I_ARGUMENT(tree->ray_triangles),
                                        SVO_I_ARGUMENT(count)};
    return status == SVO_OK ? run(p, "svo_k_spread", arguments, 6, count) : status;
}

/* Levels of wide nodes, from the root's on: every second one, counted from the leaves' parents' parents up. */
static uint32_t wide_levels(uint32_t depth)
{
    return (depth + 1) / 2;
}

/* The octree's level that wide level k begins at. An odd depth leaves the root for itself. */
static uint32_t octree_level(uint32_t depth, uint32_t wide_level)
{
    const uint32_t level = 2 * wide_level;
    return level - (depth % 2 == 1 && wide_level > 0 ? 1 : 0);
}

uint64_t svo_i_ray_node_count(const uint32_t *level_begin, uint32_t depth)
{
    uint64_t count = 0;
    for (uint32_t k = 0; k < wide_levels(depth); ++k) {
        const uint32_t level = octree_level(depth, k);
        count += level_begin[level + 1] - level_begin[level];
    }
    return count;
}

static svo_status widen_levels(preparation *p)
{
    svo_tree *tree = p->tree;
    const svo_tree_info *info = &tree->info;
    const uint32_t *begin = info->level_begin;
    const uint64_t count = svo_i_ray_node_count(begin, info->depth);
    svo_status status = svo_i_device_buffer(p->device, p->function, "ray_nodes", CL_MEM_READ_WRITE,
                                            (size_t)count * SVO_I_RAY_NODE_BYTES, &tree->ray_nodes);
    svo_widen_params params = {.node_begin = 0};
    for (uint32_t k = 0; k < wide_levels(info->depth) && status == SVO_OK; ++k) {
        const uint32_t level = octree_level(info->depth, k);
        const uint32_t below = octree_level(info->depth, k + 1);
        params.node_begin = begin[level];
        params.node_count = begin[level + 1] - begin[level];
        params.child_begin = begin[below];
        params.wide_child_begin = below < info->depth ? params.wide_begin + params.node_count : 0;
        params.lone_root = below == level + 1;
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                            SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                            SVO_I_ARGUMENT(tree->ray_nodes), SVO_I_ARGUMENT(params)};
        status = run(p, "svo_k_widen", arguments, 4, params.node_count);
        params.wide_begin += params.node_count;
    }
    return status;
}

svo_status svo_i_rays_prepare(svo_tree *tree, svo_device *device, const char *function, cl_program program,
                              const int32_t *vertices, cl_command_queue queue, const cl_event *wait, double *device_ms)
{
    preparation p = {
        .tree = tree, .device = device, .function = function, .program = program, .queue = queue, .wait = wait};
    svo_status status = SVO_OK;
    if (program == NULL) {
        status = svo_i_program_get(device, function, SVO_I_PROGRAM_TRACE, "", &p.program, NULL);
    }
    if (status == SVO_OK) {
        status = spread_triangles(&p);
    }
    if (status == SVO_OK) {
        status = widen_levels(&p);
    }
    tree->ray_reach = find_reach(vertices, tree->info.vertex_count, tree->info.snap_bits);
    if (status != SVO_OK) {
        svo_i_rays_release(tree);
    }
    *device_ms = p.device_ms;
    return status;
}

void svo_i_rays_release(svo_tree *tree)
{
    cl_mem *const buffers[] = {&tree->ray_triangles, &tree->ray_nodes};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        if (*buffers[i] != NULL) {
            clReleaseMemObject(*buffers[i]);
            *buffers[i] = NULL;
        }
    }
}

/* ---- kernel arguments ---- */

/* A double as a sum of three floats, exactly; false where floats do not reach that far. */
static bool split(double value, float parts[3])
{
    if (!(fabs(value) < 0x1p120) || (value != 0 && fabs(value) < 0x1p-70)) {
        return false;
    }
    for (int i = 0; i < 3; ++i) {
        parts[i] = (float)value;
        value -= (double)parts[i];
    }
    return true;
}

static svo_status fill_params(const svo_tree *tree, const char *function, svo_ray_params *params)
{
    const svo_tree_info *info = &tree->info;
    bool fits = split(info->scale, params->scale);
    for (int axis = 0; axis < 3 && fits; ++axis) {
        float parts[3] = {0};
        /* A corner next to zero is as good as zero. */
        fits = split(fabs(info->origin[axis]) < info->edge * 0x1p-60 ? 0.0 : info->origin[axis], parts);
        for (int part = 0; part < 3; ++part) {
            params->origin[3 * part + axis] = parts[part];
        }
    }
    if (!fits) {
        return svo_i_device_fail(tree->device, SVO_UNSUPPORTED,
                                 "%s: a grid of edge %g at %g, %g, %g is beyond what rays of floats reach", function,
                                 info->edge, info->origin[0], info->origin[1], info->origin[2]);
    }
    params->depth = info->depth;
    params->snap_bits = info->snap_bits;
    params->levels = wide_levels(info->depth);
    params->reach = tree->ray_reach;
    return SVO_OK;
}

svo_status svo_i_rays_check(const svo_tree *tree, const char *function)
{
    if ((tree->info.need & SVO_NEED_RAYS) == 0) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree holds no leaf lists; build it with SVO_NEED_RAYS", function);
    }
    if (tree->info.coverage == SVO_COVERAGE_THIN) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree's coverage is thin, which leaves out voxels that triangles touch",
                                 function);
    }
    if (tree->ray_triangles == NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                 "%s: the tree is not on a device; call svo_tree_upload first", function);
    }
    return SVO_OK;
}

/* Sets arguments from first_index on. */
svo_status svo_i_rays_set(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index,
                          const svo_i_argument *arguments, cl_uint argument_count)
{
    for (cl_uint i = 0; i < argument_count; ++i) {
        const cl_int error = clSetKernelArg(kernel, first_index + i, arguments[i].bytes, arguments[i].value);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(tree->device, function, "clSetKernelArg", error);
        }
    }
    return SVO_OK;
}

svo_status svo_i_rays_set_tree(const svo_tree *tree, const char *function, cl_kernel kernel, cl_uint first_index)
{
    svo_ray_params params = {.depth = 0};
    const svo_status status = fill_params(tree, function, &params);
    const svo_i_argument arguments[SVO_TREE_ARGUMENTS] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_CHILD_MASK]),
                                                          SVO_I_ARGUMENT(tree->buffers[SVO_TREE_FIRST_CHILD]),
                                                          SVO_I_ARGUMENT(tree->ray_nodes),
                                                          SVO_I_ARGUMENT(tree->buffers[SVO_TREE_LIST_BEGIN]),
                                                          SVO_I_ARGUMENT(tree->ray_triangles),
                                                          SVO_I_ARGUMENT(params)};
    return status == SVO_OK ? svo_i_rays_set(tree, function, kernel, first_index, arguments, SVO_TREE_ARGUMENTS)
                            : status;
}

svo_status svo_tree_set_args(const svo_tree *tree, cl_kernel kernel, cl_uint first_index)
{
    static const char function[] = "svo_tree_set_args";
    if (tree == NULL || kernel == NULL) {
        return svo_i_device_fail(tree != NULL ? tree->device : NULL, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 tree == NULL ? "tree" : "kernel");
    }
    if (tree->device == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    return svo_i_rays_set_tree(tree, function, kernel, first_index);
}

const char *svo_tree_kernel_source(void)
{
    return svo_i_source_rays;
}

const char *svo_tree_kernel_options(void)
{
    return "-cl-std=CL1.2";
}
