/* SPDX-License-Identifier: MIT */
/* Launches kernels/scene/bounds.cl for each tree. */
#include "scene/bounds.h"

#include "scene/programs.h"

#include <limits.h>

/* The deepest level whose cells are looked at. */
#define BOUNDS_LEVEL_MAX 6u

static uint32_t level_of(const svo_i_scene_source *source)
{
    return source->params.depth < BOUNDS_LEVEL_MAX ? source->params.depth : BOUNDS_LEVEL_MAX;
}

/* The box of the occupied cells, enlarged by what the traversal of the tree may round; that of the grid without
   leaves. */
static void make_box(const svo_i_scene_source *source, const cl_int bounds[6], svo_i_scene_box *out)
{
    const double cells = (double)(1u << level_of(source));
    const double margin = source->width * 0x1p-20;
    out->leaf_edge = source->width / (double)(1u << source->params.depth);
    for (int axis = 0; axis < 3; ++axis) {
        const double low = source->empty ? 0 : bounds[axis];
        const double high = source->empty ? cells : bounds[axis + 3];
        out->low[axis] = source->origin[axis] + source->width * low / cells - margin;
        out->high[axis] = source->origin[axis] + source->width * high / cells + margin;
    }
}

static svo_status launch(const svo_scene *scene, const char *function, cl_command_queue queue, cl_kernel kernel,
                         cl_uint tree, cl_uint level)
{
    svo_i_argument arguments[SVO_I_SCENE_NODE_BUFFERS + 4];
    cl_uint count = 0;
    for (; count < scene->node_buffers; ++count) {
        arguments[count] = SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_NODES_0 + count]);
    }
    arguments[count++] = SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_TREES]);
    arguments[count++] = SVO_I_ARGUMENT(tree);
    arguments[count++] = SVO_I_ARGUMENT(level);
    arguments[count++] = SVO_I_ARGUMENT(scene->buffers[SVO_I_SCENE_BOUNDS]);
    SVO_I_TRY(svo_i_kernel_set(scene->device, function, kernel, arguments, count));
    const size_t local = SVO_GROUP_ITEMS;
    const size_t cells = (size_t)1 << 3 * level;
    const size_t global = (cells + local - 1) / local * local;
    const cl_int error = clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &global, &local, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(scene->device, function, "clEnqueueNDRangeKernel", error);
}

/* Their order does not matter: each has its own bounds. */
static svo_status launch_each(const svo_scene *scene, const char *function, cl_command_queue queue, cl_kernel kernel,
                              const svo_i_scene_source *sources)
{
    for (uint32_t i = 0; i < scene->info.tree_count; ++i) {
        if (!sources[i].empty) {
            SVO_I_TRY(launch(scene, function, queue, kernel, i, level_of(&sources[i])));
        }
    }
    return SVO_OK;
}

static svo_status launch_all(const svo_scene *scene, const char *function, cl_command_queue queue,
                             const svo_i_scene_source *sources)
{
    cl_program program = NULL;
    cl_kernel kernel = NULL;
    SVO_I_TRY(svo_i_program_get(scene->device, function, &svo_i_program_scene_bounds, scene->form, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(scene->device, function, program, "svo_k_scene_bounds", &kernel));
    const svo_status status = launch_each(scene, function, queue, kernel, sources);
    clReleaseKernel(kernel);
    const cl_int error = clFinish(queue); /* also after a failure: buffers may be released next */
    SVO_I_TRY(status);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clFinish", error);
}

static svo_status run(const svo_scene *scene, const char *function, cl_command_queue queue,
                      const svo_i_scene_source *sources, cl_int *bounds)
{
    const cl_mem buffer = scene->buffers[SVO_I_SCENE_BOUNDS];
    const size_t bytes = scene->info.tree_count * SVO_I_BOUNDS_BYTES;
    for (size_t i = 0; i < bytes / sizeof *bounds; ++i) {
        bounds[i] = i % 6 < 3 ? INT_MAX : INT_MIN;
    }
    cl_int error = clEnqueueWriteBuffer(queue, buffer, CL_TRUE, 0, bytes, bounds, 0, NULL, NULL);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(scene->device, function, "clEnqueueWriteBuffer", error);
    }
    SVO_I_TRY(launch_all(scene, function, queue, sources));
    error = clEnqueueReadBuffer(queue, buffer, CL_TRUE, 0, bytes, bounds, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(scene->device, function, "clEnqueueReadBuffer", error);
}

svo_status svo_i_scene_find_bounds(svo_scene *scene, const char *function, cl_command_queue queue,
                                   const svo_i_scene_source *sources)
{
    svo_status status = SVO_OK;
    cl_int *bounds = svo_i_alloc_zeroed(&scene->device->memory, scene->info.tree_count, SVO_I_BOUNDS_BYTES);
    if (bounds == NULL) {
        return svo_i_device_fail(scene->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u trees", function,
                                 scene->info.tree_count);
    }
    SVO_I_TRY_CLEANUP(run(scene, function, queue, sources, bounds));
    for (uint32_t i = 0; i < scene->info.tree_count; ++i) {
        make_box(&sources[i], bounds + (size_t)6 * i, &scene->tree_boxes[i]);
    }

cleanup:
    svo_i_free(bounds);
    return status;
}
