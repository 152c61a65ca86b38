/* SPDX-License-Identifier: MIT */
/* Launches batches, from buffers of the caller and from host arrays: of a tree, rays and points; see kernels/rays. */
#include "rays/batch.h"

#include <math.h>

#include "core/device.h"
#include "rays/programs.h"
#include "rays/rays.h"
#include "shared/layout.h"
#include "svocl/trace.h"

/* ---- checks ---- */

static svo_status check_batch(const svo_i_batch *asked, const void *input, const void *output)
{
    if (asked->count > 0 && (input == NULL || output == NULL)) {
        return svo_i_device_fail(asked->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", asked->function,
                                 input == NULL ? asked->input_name : asked->output_name);
    }
    if (asked->count > SVO_TRACE_RAYS_MAX) {
        return svo_i_device_fail(asked->device, SVO_INVALID_ARGUMENT, "%s: %zu %s are above %u", asked->function,
                                 asked->count, asked->input_name, SVO_TRACE_RAYS_MAX);
    }
    return asked->target.check(asked->target.of, asked->function);
}

/* Whether a caller's buffers hold all records, and kernels may write the output. An empty batch needs none. */
static svo_status check_buffers(const svo_i_batch *asked, cl_mem input, cl_mem output)
{
    const size_t input_bytes = asked->count * asked->input_bytes;
    const size_t output_bytes = asked->count * asked->output_bytes;
    if (asked->count > 0 || input != NULL) {
        SVO_I_TRY(svo_i_device_check_memory(asked->device, asked->function, asked->input_name, input, input_bytes));
    }
    if (asked->count > 0 || output != NULL) {
        SVO_I_TRY(svo_i_device_check_output(asked->device, asked->function, asked->output_name, output, output_bytes));
    }
    return SVO_OK;
}

/* ---- launches ---- */

static svo_status make_kernel(const svo_i_batch *asked, cl_mem input, cl_mem output, cl_kernel *out)
{
    const cl_uint count = (cl_uint)asked->count;
    const cl_uint first = asked->target.arguments;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(input), SVO_I_ARGUMENT(output), SVO_I_ARGUMENT(count),
                                        asked->last_argument};
    cl_program program = NULL;
    SVO_I_TRY(svo_i_program_get(asked->device, asked->function, asked->program, asked->defines, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(asked->device, asked->function, program, asked->kernel_name, out));
    SVO_I_TRY(asked->target.set(asked->target.of, asked->function, *out, 0));
    return svo_i_kernel_set_from(asked->device, asked->function, *out, first, arguments,
                                 asked->last_argument.value != NULL ? 4 : 3);
}

static svo_status launch(const svo_i_batch *asked, cl_mem input, cl_mem output, cl_command_queue queue,
                         cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    const size_t items = (asked->count + asked->per_item - 1) / asked->per_item;
    const size_t local = asked->per_item == 1 ? SVO_GROUP_ITEMS : 1;
    const size_t global = (items + local - 1) / local * local;
    cl_kernel kernel = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(make_kernel(asked, input, output, &kernel));
    const cl_int error = clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &global, &local, num_wait, wait, event);
    if (error != CL_SUCCESS) {
        status = svo_i_device_fail_cl(asked->device, asked->function, "clEnqueueNDRangeKernel", error);
    }

cleanup:
    if (kernel != NULL) {
        clReleaseKernel(kernel);
    }
    return status;
}

svo_status svo_i_batch_enqueue(const svo_i_batch *asked, cl_mem input, cl_mem output, cl_command_queue queue,
                               cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    SVO_I_TRY(check_batch(asked, input, output));
    SVO_I_TRY(svo_i_device_queue(asked->device, asked->function, queue, &queue));
    SVO_I_TRY(svo_i_device_check_wait(asked->device, asked->function, num_wait, wait));
    SVO_I_TRY(check_buffers(asked, input, output));
    if (asked->count > 0) {
        return launch(asked, input, output, queue, num_wait, wait, event);
    }
    /* An empty batch signals its event all the same. */
    const cl_int error = clEnqueueMarkerWithWaitList(queue, num_wait, wait, event);
    return error == CL_SUCCESS
               ? SVO_OK
               : svo_i_device_fail_cl(asked->device, asked->function, "clEnqueueMarkerWithWaitList", error);
}

static svo_status write_input(const svo_i_batch *asked, cl_command_queue queue, cl_mem to, const void *input)
{
    const size_t bytes = asked->count * asked->input_bytes;
    const cl_int error = clEnqueueWriteBuffer(queue, to, CL_TRUE, 0, bytes, input, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(asked->device, asked->function, "clEnqueueWriteBuffer", error);
}

static svo_status read_output(const svo_i_batch *asked, cl_command_queue queue, cl_mem from, const cl_event *done,
                              void *output)
{
    const size_t bytes = asked->count * asked->output_bytes;
    const cl_int error = clEnqueueReadBuffer(queue, from, CL_TRUE, 0, bytes, output, 1, done, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(asked->device, asked->function, "clEnqueueReadBuffer", error);
}

/* Host arrays through buffers that live for this call. */
svo_status svo_i_batch_run(const svo_i_batch *asked, const void *input, void *output, cl_command_queue queue)
{
    cl_mem buffers[2] = {NULL, NULL};
    cl_event done = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(check_batch(asked, input, output));
    if (asked->count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(asked->device, asked->function, queue, &queue));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(asked->device, asked->function, asked->input_name, CL_MEM_READ_ONLY,
                                          asked->count * asked->input_bytes, &buffers[0]));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(asked->device, asked->function, asked->output_name, CL_MEM_WRITE_ONLY,
                                          asked->count * asked->output_bytes, &buffers[1]));
    SVO_I_TRY_CLEANUP(write_input(asked, queue, buffers[0], input));
    SVO_I_TRY_CLEANUP(svo_i_batch_enqueue(asked, buffers[0], buffers[1], queue, 0, NULL, &done));
    SVO_I_TRY_CLEANUP(read_output(asked, queue, buffers[1], &done, output));

cleanup:
    if (done != NULL) {
        clReleaseEvent(done);
    }
    for (int i = 0; i < 2; ++i) {
        if (buffers[i] != NULL) {
            clReleaseMemObject(buffers[i]);
        }
    }
    return status;
}

svo_status svo_i_batch_of_voxels(svo_i_batch *batch, size_t ray_count, const cl_float *footprint)
{
    batch->kernel_name = "svo_k_trace_voxels";
    batch->input_name = "rays";
    batch->output_name = "hits";
    batch->input_bytes = sizeof(svo_ray);
    batch->output_bytes = sizeof(svo_voxel_hit);
    batch->count = ray_count;
    batch->per_item = 1;
    batch->last_argument = (svo_i_argument){sizeof *footprint, footprint, false};
    return *footprint >= 0.0F && isfinite(*footprint)
               ? SVO_OK
               : svo_i_device_fail(batch->device, SVO_INVALID_ARGUMENT, "%s: footprint %g is negative or not finite",
                                   batch->function, (double)*footprint);
}

#define STREAM_ITEMS     4096u
#define STREAM_SHARE_MAX 256u

/* ---- rays ---- */

/* Rays of a work-item with streams, whose last rays have few others beside them: many, but enough work-items for the
   threads of a large machine. */
static size_t stream_share(size_t ray_count)
{
    const size_t share = ray_count / STREAM_ITEMS / SVO_GROUP_ITEMS * SVO_GROUP_ITEMS;
    return share < SVO_GROUP_ITEMS ? SVO_GROUP_ITEMS : share < STREAM_SHARE_MAX ? share : STREAM_SHARE_MAX;
}

/* any: 1 for SVO_TRACE_ANY, else 0; lives as long as the batch. */
static svo_status ray_batch(svo_tree *tree, const char *function, size_t ray_count, uint32_t flags, cl_uint *any,
                            svo_i_batch *out)
{
    const bool streams = flags != SVO_TRACE_COUNT && tree->device != NULL && tree->device->cpu_path;
    *any = flags == SVO_TRACE_ANY;
    *out = (svo_i_batch){.device = tree->device,
                         .function = function,
                         .target = svo_i_rays_target(tree),
                         .program = &svo_i_program_trace,
                         .kernel_name = "svo_k_trace",
                         .defines = flags == SVO_TRACE_COUNT ? " -DSVO_COUNT_HITS"
                                    : streams                ? " -DSVO_RAY_STREAMS"
                                                             : "",
                         .input_name = "rays",
                         .output_name = "hits",
                         .input_bytes = sizeof(svo_ray),
                         .output_bytes = sizeof(svo_hit),
                         .count = ray_count,
                         .per_item = streams ? stream_share(ray_count) : 1, /* see kernels/rays/trace.cl */
                         .last_argument = {sizeof *any, any, false}};
    return flags <= SVO_TRACE_COUNT
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: flags %u is not in 0 .. %u", function,
                                   flags, (unsigned)SVO_TRACE_COUNT);
}

svo_status svo_tree_trace_enqueue(svo_tree *tree, cl_mem rays, cl_mem hits, size_t ray_count, uint32_t flags,
                                  cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    cl_uint any = 0;
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(ray_batch(tree, "svo_tree_trace_enqueue", ray_count, flags, &any, &asked));
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_tree_trace(svo_tree *tree, const svo_ray *rays, svo_hit *hits, size_t ray_count, uint32_t flags,
                          cl_command_queue queue)
{
    cl_uint any = 0;
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(ray_batch(tree, "svo_tree_trace", ray_count, flags, &any, &asked));
    return svo_i_batch_run(&asked, rays, hits, queue);
}

/* ---- points ---- */

static svo_i_batch point_batch(svo_tree *tree, const char *function, size_t point_count)
{
    return (svo_i_batch){.device = tree->device,
                         .function = function,
                         .target = svo_i_rays_target(tree),
                         .program = &svo_i_program_trace,
                         .kernel_name = "svo_k_nearest",
                         .defines = "",
                         .input_name = "points",
                         .output_name = "results",
                         .input_bytes = sizeof(svo_query_point),
                         .output_bytes = sizeof(svo_nearest),
                         .count = point_count,
                         .per_item = 1};
}

svo_status svo_tree_nearest_enqueue(svo_tree *tree, cl_mem points, cl_mem results, size_t point_count,
                                    cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = point_batch(tree, "svo_tree_nearest_enqueue", point_count);
    return svo_i_batch_enqueue(&asked, points, results, queue, num_wait, wait, event);
}

svo_status svo_tree_nearest(svo_tree *tree, const svo_query_point *points, svo_nearest *results, size_t point_count,
                            cl_command_queue queue)
{
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const svo_i_batch asked = point_batch(tree, "svo_tree_nearest", point_count);
    return svo_i_batch_run(&asked, points, results, queue);
}

/* ---- voxels ---- */

/* footprint: lives as long as the batch. */
static svo_status voxel_batch(svo_tree *tree, const char *function, size_t ray_count, const cl_float *footprint,
                              svo_i_batch *out)
{
    *out = (svo_i_batch){.device = tree->device,
                         .function = function,
                         .target = svo_i_voxels_target(tree),
                         .program = &svo_i_program_trace_voxels,
                         .defines = ""};
    return svo_i_batch_of_voxels(out, ray_count, footprint);
}

svo_status svo_tree_trace_voxels_enqueue(svo_tree *tree, cl_mem rays, cl_mem hits, size_t ray_count, float footprint,
                                         cl_command_queue queue, cl_uint num_wait, const cl_event *wait,
                                         cl_event *event)
{
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(voxel_batch(tree, "svo_tree_trace_voxels_enqueue", ray_count, &footprint, &asked));
    return svo_i_batch_enqueue(&asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_tree_trace_voxels(svo_tree *tree, const svo_ray *rays, svo_voxel_hit *hits, size_t ray_count,
                                 float footprint, cl_command_queue queue)
{
    svo_i_batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(voxel_batch(tree, "svo_tree_trace_voxels", ray_count, &footprint, &asked));
    return svo_i_batch_run(&asked, rays, hits, queue);
}
