/* SPDX-License-Identifier: MIT */
#include "core/submit.h"

#include "core/device.h"

/* ---- arrays ---- */

static svo_status check_given(const svo_i_commands *commands, const char *name, const svo_array *array)
{
    if (array->host == NULL && array->buffer == NULL) {
        return svo_i_device_fail(commands->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", commands->function, name);
    }
    return SVO_OK;
}

/* The call waits for what is in host memory. */
static svo_status make_own(svo_i_commands *commands, const char *name, cl_mem_flags flags, size_t bytes, cl_mem *out)
{
    SVO_I_TRY(svo_i_device_buffer(commands->device, commands->function, name, flags, bytes, out));
    commands->own[commands->own_count++] = *out;
    commands->waits = true;
    commands->event = &commands->done;
    return SVO_OK;
}

svo_status svo_i_commands_input(svo_i_commands *commands, const char *name, const svo_array *array, size_t bytes,
                                cl_mem *out)
{
    *out = array->buffer;
    if (bytes == 0 && array->buffer == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(check_given(commands, name, array));
    if (array->host == NULL) {
        return svo_i_device_check_memory(commands->device, commands->function, name, array->buffer, bytes);
    }
    SVO_I_TRY(make_own(commands, name, CL_MEM_READ_ONLY, bytes, out));
    const cl_int error = clEnqueueWriteBuffer(commands->queue, *out, CL_TRUE, 0, bytes, array->host, 0, NULL, NULL);
    return error == CL_SUCCESS
               ? SVO_OK
               : svo_i_device_fail_cl(commands->device, commands->function, "clEnqueueWriteBuffer", error);
}

svo_status svo_i_commands_output(svo_i_commands *commands, const char *name, const svo_array *array, size_t bytes,
                                 size_t first_byte, size_t read_bytes, cl_mem *out)
{
    *out = array->buffer;
    if (bytes == 0 && array->buffer == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(check_given(commands, name, array));
    if (array->host == NULL) {
        return svo_i_device_check_output(commands->device, commands->function, name, array->buffer, bytes);
    }
    SVO_I_TRY(make_own(commands, name, CL_MEM_WRITE_ONLY, bytes, out));
    commands->from = *out;
    commands->to = array->host;
    commands->first_byte = first_byte;
    commands->read_bytes = read_bytes;
    return SVO_OK;
}

/* ---- commands ---- */

svo_status svo_i_commands_begin(svo_device *device, const char *function, const svo_submit *submit, svo_i_commands *out)
{
    static const svo_submit own = {.queue = NULL};
    const svo_submit *asked = submit != NULL ? submit : &own;
    *out = (svo_i_commands){.device = device,
                            .function = function,
                            .num_wait = asked->num_wait,
                            .wait = asked->wait,
                            .given = asked->event,
                            .waits = submit == NULL};
    out->event = out->waits ? &out->done : out->given;
    SVO_I_TRY(svo_i_device_queue(device, function, asked->queue, &out->queue));
    SVO_I_TRY(svo_i_device_check_wait(device, function, out->num_wait, out->wait));
    return SVO_OK;
}

svo_status svo_i_commands_none(svo_i_commands *commands)
{
    const cl_int error =
        clEnqueueMarkerWithWaitList(commands->queue, commands->num_wait, commands->wait, commands->event);
    return error == CL_SUCCESS
               ? SVO_OK
               : svo_i_device_fail_cl(commands->device, commands->function, "clEnqueueMarkerWithWaitList", error);
}

/* Reads the result, or waits. */
static svo_status finish(svo_i_commands *commands)
{
    cl_int error = CL_SUCCESS;
    const char *call = "clWaitForEvents";
    if (commands->to != NULL) {
        call = "clEnqueueReadBuffer";
        error = clEnqueueReadBuffer(commands->queue, commands->from, CL_TRUE, commands->first_byte,
                                    commands->read_bytes, commands->to, 1, &commands->done, NULL);
    } else {
        error = clWaitForEvents(1, &commands->done);
    }
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(commands->device, commands->function, call, error);
}

svo_status svo_i_commands_end(svo_i_commands *commands, svo_status status)
{
    if (status == SVO_OK && commands->waits) {
        status = finish(commands);
    }
    if (commands->done != NULL) {
        (void)svo_i_event_settle(commands->done);
    }
    if (status == SVO_OK && commands->waits && commands->given != NULL) {
        *commands->given = commands->done;
    } else if (commands->done != NULL) {
        clReleaseEvent(commands->done);
    }
    for (cl_uint i = 0; i < commands->own_count; ++i) {
        clReleaseMemObject(commands->own[i]);
    }
    commands->own_count = 0;
    commands->done = NULL;
    return status;
}
