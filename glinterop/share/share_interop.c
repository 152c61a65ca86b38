/* SPDX-License-Identifier: MIT */
/*
 * The share path `interop`: an OpenGL buffer that is an OpenCL buffer too. Acquire and release pass it between the
 * APIs.
 *
 * OpenCL may touch the buffer only while it is acquired, OpenGL only while it is not (The OpenCL Extension
 * Specification, version 1.2, section 9.7.6). The host waits for the event of either call, so the caller's queue may be
 * out-of-order.
 */
#include "share/share_interop.h"

#include "core/message.h"

svo_status svo_i_share_interop_create(svo_i_share_buffer *buffer)
{
    svo_device *device = buffer->device;
    svo_message reason = {""};
    if (svo_i_interop_find(device, buffer->context, &buffer->interop, &reason) != SVO_OK) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, "svo_i_share_buffer_create: %.512s", reason.text);
    }
    if (!svo_i_interop_is_joined(device, buffer->context)) {
        return svo_i_device_fail(
            device, SVO_UNSUPPORTED,
            "svo_i_share_buffer_create: the OpenCL context was not created against the OpenGL context");
    }
    cl_int error = CL_SUCCESS;
    buffer->memory = buffer->interop.CreateFromGLBuffer(device->context, CL_MEM_READ_WRITE, buffer->name, &error);
    if (buffer->memory == NULL || error != CL_SUCCESS) {
        buffer->memory = NULL;
        return svo_i_device_fail_cl(device, "svo_i_share_buffer_create", "clCreateFromGLBuffer", error);
    }
    return SVO_OK;
}

/* Waits for an event and releases it. error: of the call that enqueued it, returned if it failed. */
static cl_int wait_and_release(cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return error;
    }
    error = clWaitForEvents(1, &event);
    clReleaseEvent(event);
    return error;
}

svo_status svo_i_share_interop_acquire(svo_i_share_buffer *buffer, cl_command_queue queue)
{
    if (!buffer->interop.has_gl_event) {
        svo_i_gl_context_functions(buffer->context)->Finish();
    }
    cl_event event = NULL;
    const cl_int enqueued = buffer->interop.EnqueueAcquireGLObjects(queue, 1, &buffer->memory, 0, NULL, &event);
    cl_int error = wait_and_release(enqueued, event);
    if (enqueued == CL_SUCCESS && clRetainCommandQueue(queue) == CL_SUCCESS) {
        buffer->acquiring_queue = queue;
    } else if (enqueued == CL_SUCCESS) {
        (void)buffer->interop.EnqueueReleaseGLObjects(queue, 1, &buffer->memory, 0, NULL, NULL);
        error = CL_OUT_OF_RESOURCES;
    }
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(buffer->device, "svo_i_share_buffer_to_cl", "clEnqueueAcquireGLObjects", error);
    }
    return SVO_OK;
}

svo_status svo_i_share_interop_release(svo_i_share_buffer *buffer)
{
    if (buffer->acquiring_queue == NULL) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_int enqueued =
        buffer->interop.EnqueueReleaseGLObjects(buffer->acquiring_queue, 1, &buffer->memory, 0, NULL, &event);
    const cl_int error = wait_and_release(enqueued, event);
    clReleaseCommandQueue(buffer->acquiring_queue);
    buffer->acquiring_queue = NULL;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(buffer->device, "svo_i_share_buffer_to_gl", "clEnqueueReleaseGLObjects", error);
    }
    return SVO_OK;
}
