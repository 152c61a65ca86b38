/* SPDX-License-Identifier: MIT */
/* The commands of one call, between a device handle and what the caller gave: an svo_submit and arrays. */
#include "core/submit.h"

#include "core/device.h"

/* ---- arrays ---- */

static svo_status check_given(const svo_i_call *call, const char *name, const svo_array *array)
{
    return array->host != NULL || array->buffer != NULL
               ? SVO_OK
               : svo_i_device_fail(call->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", call->function, name);
}

/* Whether there is nothing to check: an array of no bytes, unless it is a buffer. */
static bool is_nothing(const svo_array *array, size_t bytes)
{
    return bytes == 0 && (array->host != NULL || array->buffer == NULL);
}

void svo_i_call_wait(svo_i_call *call)
{
    call->waits = true;
    call->event = &call->done;
}

/* The call waits for what is in host memory. */
static svo_status make_own(svo_i_call *call, const char *name, cl_mem_flags flags, size_t bytes, cl_mem *out)
{
    SVO_I_TRY(svo_i_device_buffer(call->device, call->function, name, flags, bytes, out));
    call->own[call->own_count++] = *out;
    svo_i_call_wait(call);
    return SVO_OK;
}

svo_status svo_i_call_input(svo_i_call *call, const char *name, const svo_array *array, size_t bytes, cl_mem *out)
{
    *out = NULL;
    if (is_nothing(array, bytes)) {
        return SVO_OK;
    }
    SVO_I_TRY(check_given(call, name, array));
    if (array->host == NULL) {
        *out = array->buffer;
        return svo_i_device_check_memory(call->device, call->function, name, array->buffer, bytes);
    }
    SVO_I_TRY(make_own(call, name, CL_MEM_READ_ONLY, bytes, out));
    return svo_i_device_write(call->device, call->function, call->queue, *out, 0, array->host, bytes);
}

svo_status svo_i_call_output(svo_i_call *call, const char *name, const svo_array *array, size_t bytes,
                             size_t first_byte, size_t read_bytes, cl_mem *out)
{
    *out = NULL;
    if (is_nothing(array, bytes)) {
        return SVO_OK;
    }
    SVO_I_TRY(check_given(call, name, array));
    if (array->host == NULL) {
        *out = array->buffer;
        return svo_i_device_check_output(call->device, call->function, name, array->buffer, bytes);
    }
    SVO_I_TRY(make_own(call, name, CL_MEM_WRITE_ONLY, bytes, out));
    call->from = *out;
    call->to = array->host;
    call->first_byte = first_byte;
    call->read_bytes = read_bytes;
    return SVO_OK;
}

/* ---- commands ---- */

svo_status svo_i_call_begin(svo_device *device, const char *function, const svo_submit *submit, svo_i_call *out)
{
    static const svo_submit own = {.queue = NULL};
    const svo_submit *asked = submit != NULL ? submit : &own;
    *out = (svo_i_call){.device = device,
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

svo_status svo_i_call_none(svo_i_call *call)
{
    const cl_int error = clEnqueueMarkerWithWaitList(call->queue, call->num_wait, call->wait, call->event);
    return error == CL_SUCCESS
               ? SVO_OK
               : svo_i_device_fail_cl(call->device, call->function, "clEnqueueMarkerWithWaitList", error);
}

/* Reads the result, or waits. */
static svo_status finish(svo_i_call *call)
{
    cl_int error = CL_SUCCESS;
    const char *name = "clWaitForEvents";
    if (call->to != NULL) {
        name = "clEnqueueReadBuffer";
        error = clEnqueueReadBuffer(call->queue, call->from, CL_TRUE, call->first_byte, call->read_bytes, call->to, 1,
                                    &call->done, NULL);
    } else {
        error = clWaitForEvents(1, &call->done);
    }
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(call->device, call->function, name, error);
}

svo_status svo_i_call_end(svo_i_call *call, svo_status status)
{
    if (status == SVO_OK && call->waits) {
        status = finish(call);
    }
    if (call->done != NULL) {
        (void)svo_i_event_settle(call->done);
    }
    if (status == SVO_OK && call->waits && call->given != NULL) {
        *call->given = call->done;
    } else if (call->done != NULL) {
        clReleaseEvent(call->done);
    }
    for (cl_uint i = 0; i < call->own_count; ++i) {
        clReleaseMemObject(call->own[i]);
    }
    call->own_count = 0;
    call->done = NULL;
    return status;
}
