/* SPDX-License-Identifier: MIT */
/* Batches of rays and points against the triangles of a tree: launches kernels/rays/trace.cl and nearest.cl. */
#include <string.h>

#include "rays/rays.h"
#include "svocl/trace.h"

/* One batch: records in, records out, one work-item each. */
typedef struct batch {
    const char *function; /* for messages */
    const char *kernel_name, *defines; /* of the program */
    const char *input_name, *output_name; /* of the arguments */
    size_t input_bytes, output_bytes; /* of a record */
    size_t count;
    size_t per_item; /* records a work-item takes */
    const cl_uint *last_argument; /* after the count; NULL: none */
} batch;

/* ---- checks ---- */

static svo_status check_batch(const svo_tree *tree, const batch *asked, const void *input, const void *output)
{
    if (asked->count > 0 && (input == NULL || output == NULL)) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", asked->function,
                                 input == NULL ? asked->input_name : asked->output_name);
    }
    if (asked->count > SVO_TRACE_RAYS_MAX) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: %zu %s are above %u", asked->function,
                                 asked->count, asked->input_name, SVO_TRACE_RAYS_MAX);
    }
    return svo_i_rays_check(tree, asked->function);
}

/* Whether a caller's buffer holds all records. An empty batch needs none. */
static svo_status check_buffer(const svo_tree *tree, const batch *asked, const char *name, cl_mem buffer, size_t bytes)
{
    return asked->count > 0 || buffer != NULL
               ? svo_i_device_check_memory(tree->device, asked->function, name, buffer, bytes)
               : SVO_OK;
}

/* ---- launches ---- */

static svo_status make_kernel(svo_tree *tree, const batch *asked, cl_mem input, cl_mem output, cl_kernel *out)
{
    const cl_uint count = (cl_uint)asked->count;
    cl_program program = NULL;
    SVO_I_TRY(svo_i_program_get(tree->device, asked->function, SVO_I_PROGRAM_TRACE, asked->defines, &program, NULL));
    SVO_I_TRY(svo_i_kernel_create(tree->device, asked->function, program, asked->kernel_name, out));
    SVO_I_TRY(svo_i_rays_set_tree(tree, asked->function, *out, 0));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(input), SVO_I_ARGUMENT(output), SVO_I_ARGUMENT(count),
                                        (svo_i_argument){sizeof(cl_uint), asked->last_argument, false}};
    return svo_i_rays_set(tree, asked->function, *out, SVO_TREE_ARGUMENTS, arguments,
                          asked->last_argument != NULL ? 4 : 3);
}

static svo_status enqueue(svo_tree *tree, const batch *asked, cl_mem input, cl_mem output, cl_command_queue queue,
                          cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    const size_t groups = (asked->count + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    const size_t local = SVO_GROUP_ITEMS / asked->per_item;
    const size_t global = groups * local;
    cl_kernel kernel = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(check_batch(tree, asked, input, output));
    SVO_I_TRY(svo_i_device_check_queue(tree->device, asked->function, queue));
    SVO_I_TRY(svo_i_device_check_wait(tree->device, asked->function, num_wait, wait));
    SVO_I_TRY(check_buffer(tree, asked, asked->input_name, input, asked->count * asked->input_bytes));
    SVO_I_TRY(check_buffer(tree, asked, asked->output_name, output, asked->count * asked->output_bytes));
    if (asked->count > 0) {
        SVO_I_TRY_CLEANUP(make_kernel(tree, asked, input, output, &kernel));
    }
    /* An empty batch signals its event all the same. */
    const cl_int error = asked->count > 0
                             ? clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &global, &local, num_wait, wait, event)
                             : clEnqueueMarkerWithWaitList(queue, num_wait, wait, event);
    if (error != CL_SUCCESS) {
        status = svo_i_device_fail_cl(tree->device, asked->function, "clEnqueueNDRangeKernel", error);
    }

cleanup:
    if (kernel != NULL) {
        clReleaseKernel(kernel);
    }
    return status;
}

static svo_status write_input(const svo_tree *tree, const batch *asked, cl_command_queue queue, cl_mem to,
                              const void *input)
{
    const size_t bytes = asked->count * asked->input_bytes;
    const cl_int error = clEnqueueWriteBuffer(queue, to, CL_TRUE, 0, bytes, input, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(tree->device, asked->function, "clEnqueueWriteBuffer", error);
}

static svo_status read_output(const svo_tree *tree, const batch *asked, cl_command_queue queue, cl_mem from,
                              const cl_event *done, void *output)
{
    const size_t bytes = asked->count * asked->output_bytes;
    const cl_int error = clEnqueueReadBuffer(queue, from, CL_TRUE, 0, bytes, output, 1, done, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(tree->device, asked->function, "clEnqueueReadBuffer", error);
}

/* Host arrays through buffers that live for this call. */
static svo_status run_blocking(svo_tree *tree, const batch *asked, const void *input, void *output,
                               cl_command_queue queue)
{
    cl_mem buffers[2] = {NULL, NULL};
    cl_event done = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(check_batch(tree, asked, input, output));
    if (asked->count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(tree->device, asked->function, queue, &queue));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(tree->device, asked->function, asked->input_name, CL_MEM_READ_ONLY,
                                          asked->count * asked->input_bytes, &buffers[0]));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(tree->device, asked->function, asked->output_name, CL_MEM_WRITE_ONLY,
                                          asked->count * asked->output_bytes, &buffers[1]));
    SVO_I_TRY_CLEANUP(write_input(tree, asked, queue, buffers[0], input));
    SVO_I_TRY_CLEANUP(enqueue(tree, asked, buffers[0], buffers[1], queue, 0, NULL, &done));
    SVO_I_TRY_CLEANUP(read_output(tree, asked, queue, buffers[1], &done, output));

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

/* ---- rays ---- */

/* any: 1 for SVO_TRACE_ANY, else 0; lives as long as the batch. */
static svo_status ray_batch(const svo_tree *tree, const char *function, size_t ray_count, uint32_t flags, cl_uint *any,
                            batch *out)
{
    const bool streams = flags != SVO_TRACE_COUNT && tree->device != NULL && tree->device->is_cpu;
    *any = flags == SVO_TRACE_ANY;
    *out = (batch){.function = function,
                   .kernel_name = "svo_k_trace",
                   .defines = flags == SVO_TRACE_COUNT ? " -DSVO_COUNT_HITS"
                              : streams                ? " -DSVO_RAY_STREAMS"
                                                       : "",
                   .input_name = "rays",
                   .output_name = "hits",
                   .input_bytes = sizeof(svo_ray),
                   .output_bytes = sizeof(svo_hit),
                   .count = ray_count,
                   .per_item = streams ? SVO_GROUP_ITEMS : 1, /* see kernels/rays/trace.cl */
                   .last_argument = any};
    return flags <= SVO_TRACE_COUNT
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: flags %u is not in 0 .. %u", function,
                                   flags, (unsigned)SVO_TRACE_COUNT);
}

svo_status svo_tree_trace_enqueue(svo_tree *tree, cl_mem rays, cl_mem hits, size_t ray_count, uint32_t flags,
                                  cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    cl_uint any = 0;
    batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(ray_batch(tree, "svo_tree_trace_enqueue", ray_count, flags, &any, &asked));
    return enqueue(tree, &asked, rays, hits, queue, num_wait, wait, event);
}

svo_status svo_tree_trace(svo_tree *tree, const svo_ray *rays, svo_hit *hits, size_t ray_count, uint32_t flags,
                          cl_command_queue queue)
{
    cl_uint any = 0;
    batch asked;
    if (tree == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    SVO_I_TRY(ray_batch(tree, "svo_tree_trace", ray_count, flags, &any, &asked));
    return run_blocking(tree, &asked, rays, hits, queue);
}

/* ---- points ---- */

static batch point_batch(const char *function, size_t point_count)
{
    return (batch){.function = function,
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
    const batch asked = point_batch("svo_tree_nearest_enqueue", point_count);
    return tree != NULL ? enqueue(tree, &asked, points, results, queue, num_wait, wait, event) : SVO_INVALID_ARGUMENT;
}

svo_status svo_tree_nearest(svo_tree *tree, const svo_query_point *points, svo_nearest *results, size_t point_count,
                            cl_command_queue queue)
{
    const batch asked = point_batch("svo_tree_nearest", point_count);
    return tree != NULL ? run_blocking(tree, &asked, points, results, queue) : SVO_INVALID_ARGUMENT;
}
