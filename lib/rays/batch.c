/* SPDX-License-Identifier: MIT */
/* The launch that all batches share: of trees (trace.c) and of scenes. */
#include "rays/batch.h"

#include "shared/layout.h"
#include "svocl/trace.h"

svo_status svo_i_batch_check(const svo_i_batch *batch, const void *input, const void *output)
{
    if (batch->count > 0 && (input == NULL || output == NULL)) {
        return svo_i_device_fail(batch->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", batch->function,
                                 input == NULL ? batch->input_name : batch->output_name);
    }
    if (batch->count > SVO_TRACE_RAYS_MAX) {
        return svo_i_device_fail(batch->device, SVO_INVALID_ARGUMENT, "%s: %zu %s are above %u", batch->function,
                                 batch->count, batch->input_name, SVO_TRACE_RAYS_MAX);
    }
    return SVO_OK;
}

/* Whether a caller's buffer holds all records. An empty batch needs none. */
static svo_status check_buffer(const svo_i_batch *batch, const char *name, cl_mem buffer, size_t bytes)
{
    return batch->count > 0 || buffer != NULL
               ? svo_i_device_check_memory(batch->device, batch->function, name, buffer, bytes)
               : SVO_OK;
}

svo_status svo_i_batch_enqueue(const svo_i_batch *batch, cl_mem input, cl_mem output, cl_command_queue queue,
                               cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    const size_t groups = (batch->count + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    const size_t local = SVO_GROUP_ITEMS / batch->per_item;
    const size_t global = groups * local;
    cl_kernel kernel = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_device_check_queue(batch->device, batch->function, queue));
    SVO_I_TRY(svo_i_device_check_wait(batch->device, batch->function, num_wait, wait));
    SVO_I_TRY(check_buffer(batch, batch->input_name, input, batch->count * batch->input_bytes));
    SVO_I_TRY(check_buffer(batch, batch->output_name, output, batch->count * batch->output_bytes));
    if (batch->count > 0) {
        SVO_I_TRY_CLEANUP(batch->make_kernel(batch, input, output, &kernel));
    }
    const cl_int error = batch->count > 0
                             ? clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &global, &local, num_wait, wait, event)
                             : clEnqueueMarkerWithWaitList(queue, num_wait, wait, event);
    if (error != CL_SUCCESS) {
        status = svo_i_device_fail_cl(batch->device, batch->function, "clEnqueueNDRangeKernel", error);
    }

cleanup:
    if (kernel != NULL) {
        clReleaseKernel(kernel);
    }
    return status;
}

static svo_status write_input(const svo_i_batch *batch, cl_command_queue queue, cl_mem to, const void *input)
{
    const size_t bytes = batch->count * batch->input_bytes;
    const cl_int error = clEnqueueWriteBuffer(queue, to, CL_TRUE, 0, bytes, input, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(batch->device, batch->function, "clEnqueueWriteBuffer", error);
}

static svo_status read_output(const svo_i_batch *batch, cl_command_queue queue, cl_mem from, const cl_event *done,
                              void *output)
{
    const size_t bytes = batch->count * batch->output_bytes;
    const cl_int error = clEnqueueReadBuffer(queue, from, CL_TRUE, 0, bytes, output, 1, done, NULL);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(batch->device, batch->function, "clEnqueueReadBuffer", error);
}

svo_status svo_i_batch_run(const svo_i_batch *batch, const void *input, void *output, cl_command_queue queue)
{
    cl_mem buffers[2] = {NULL, NULL};
    cl_event done = NULL;
    svo_status status = SVO_OK;
    if (batch->count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(batch->device, batch->function, queue, &queue));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(batch->device, batch->function, batch->input_name, CL_MEM_READ_ONLY,
                                          batch->count * batch->input_bytes, &buffers[0]));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(batch->device, batch->function, batch->output_name, CL_MEM_WRITE_ONLY,
                                          batch->count * batch->output_bytes, &buffers[1]));
    SVO_I_TRY_CLEANUP(write_input(batch, queue, buffers[0], input));
    SVO_I_TRY_CLEANUP(svo_i_batch_enqueue(batch, buffers[0], buffers[1], queue, 0, NULL, &done));
    SVO_I_TRY_CLEANUP(read_output(batch, queue, buffers[1], &done, output));

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
