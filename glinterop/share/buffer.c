/* SPDX-License-Identifier: MIT */
/* Buffers of callers: kernels of theirs or of svocl write them, and OpenGL reads; or the other way (update.c). */
#include "share/buffer.h"

#include "core/message.h"
#include "core/struct_size.h"
#include "share/share_host.h"

svo_status svo_i_gl_buffer_named(svo_device *device, const char *function, svo_status status)
{
    if (status != SVO_OK) {
        svo_i_message_rename(&device->message, function);
    }
    return status;
}

void svo_i_gl_buffer_settle(svo_gl_buffer *buffer)
{
    svo_i_in_flight_end(&buffer->released);
}

/* Maps the memory of a buffer that OpenGL is to write first. */
static svo_status give_to_gl(svo_i_share_buffer *shared, const char *function)
{
    cl_command_queue queue = NULL;
    SVO_I_TRY(svo_i_device_queue(shared->device, function, NULL, &queue));
    return svo_i_share_host_map(shared, CL_MAP_READ | CL_MAP_WRITE, queue);
}

svo_status svo_gl_buffer_create(svo_device *device, svo_gl_context *context, size_t bytes, svo_gl_share share,
                                svo_gl_buffer **out)
{
    static const char function[] = "svo_gl_buffer_create";
    svo_gl_share choice = SVO_GL_SHARE_COPY;
    svo_status status = SVO_OK;
    if (device == NULL || context == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 device == NULL    ? "device"
                                 : context == NULL ? "context"
                                                   : "out");
    }
    if ((unsigned)share >= SVO_I_SHARES) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: share %d is not in 0 .. %d", function, (int)share,
                                 SVO_I_SHARES - 1);
    }
    svo_gl_buffer *buffer = svo_i_alloc_zeroed(&device->memory, 1, sizeof *buffer);
    if (buffer == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the handle", function);
    }
    SVO_I_TRY_CLEANUP(svo_i_share_choose(device, context, function, share, &buffer->reasons, &choice));
    SVO_I_TRY_CLEANUP(svo_i_gl_buffer_named(
        device, function, svo_i_share_buffer_create(device, context, choice, bytes, &buffer->shared)));
    if (choice == SVO_GL_SHARE_HOST) {
        SVO_I_TRY_CLEANUP(svo_i_gl_buffer_named(device, function, give_to_gl(&buffer->shared, function)));
    }
    *out = buffer;
    buffer = NULL;

cleanup:
    svo_gl_buffer_destroy(&buffer);
    return status;
}

void svo_gl_buffer_destroy(svo_gl_buffer **buffer)
{
    if (buffer == NULL || *buffer == NULL) {
        return;
    }
    svo_i_gl_buffer_settle(*buffer);
    svo_i_share_buffer_destroy(&(*buffer)->shared);
    svo_i_free(*buffer);
    *buffer = NULL;
}

svo_status svo_gl_buffer_get_info(const svo_gl_buffer *buffer, svo_gl_buffer_info *info)
{
    const svo_gl_buffer_info found = {.share = buffer->shared.share,
                                      .name = buffer->shared.name,
                                      .offset_bytes = buffer->shared.offset_bytes,
                                      .bytes = buffer->shared.bytes,
                                      .memory = buffer->shared.memory};
    return svo_i_struct_write(&buffer->shared.device->message, "svo_gl_buffer_get_info", "info", &found, info,
                              SVO_I_STRUCT_SIZES(svo_gl_buffer_info, memory));
}

const char *svo_gl_buffer_share_reason(const svo_gl_buffer *buffer, svo_gl_share share)
{
    return (unsigned)share < SVO_I_SHARES ? buffer->reasons.text[share] : "unknown";
}

svo_status svo_gl_buffer_to_cl(svo_gl_buffer *buffer, cl_command_queue queue)
{
    static const char function[] = "svo_gl_buffer_to_cl";
    if (buffer == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    svo_device *device = buffer->shared.device;
    SVO_I_TRY(svo_i_device_queue(device, function, queue, &queue));
    svo_i_gl_buffer_settle(buffer);
    SVO_I_TRY(svo_i_gl_buffer_named(device, function, svo_i_share_buffer_begin_cl(&buffer->shared, queue)));
    buffer->is_in_cl = true;
    return SVO_OK;
}

svo_status svo_gl_buffer_to_gl(svo_gl_buffer *buffer, size_t used_bytes, cl_command_queue queue, cl_uint num_wait,
                               const cl_event *wait)
{
    static const char function[] = "svo_gl_buffer_to_gl";
    if (buffer == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    svo_device *device = buffer->shared.device;
    SVO_I_TRY(svo_i_device_queue(device, function, queue, &queue));
    SVO_I_TRY(svo_i_device_check_wait(device, function, num_wait, wait));
    if (!buffer->is_in_cl) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: svo_gl_buffer_to_cl was not called before",
                                 function);
    }
    const cl_int error = num_wait > 0 ? clWaitForEvents(num_wait, wait) : CL_SUCCESS;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, function, "clWaitForEvents", error);
    }
    SVO_I_TRY(svo_i_gl_buffer_named(device, function, svo_i_share_buffer_end_cl(&buffer->shared, used_bytes, queue)));
    buffer->is_in_cl = false;
    return SVO_OK;
}
