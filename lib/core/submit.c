/* SPDX-License-Identifier: MIT */
/* The commands of one call, between a device handle and what the caller gave: an svo_submit and arrays. */
#include "core/submit.h"

#include <stdint.h>
#include <string.h>

#include "core/device.h"
#include "core/staging.h"

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

/* Kernels see arrays of 16-byte elements at most. */
#define PLACE_BYTES 16u

/* Whether two ranges of memory share bytes. */
static bool overlap(const void *a, size_t a_bytes, const void *b, size_t b_bytes)
{
    const uintptr_t first = (uintptr_t)a;
    const uintptr_t second = (uintptr_t)b;
    return first < second + b_bytes && second < first + a_bytes;
}

/* Whether a kernel can use an array where it is in host memory: CPUs have the same memory. */
static bool is_in_place(const svo_i_call *call, const void *host)
{
    return call->device->cpu_path && (uintptr_t)host % PLACE_BYTES == 0;
}

/* A buffer of an array in host memory, without a copy. */
static svo_status borrow(svo_i_call *call, cl_mem_flags flags, const void *host, size_t bytes, cl_mem *out)
{
    cl_int error = CL_SUCCESS;
    void *memory = NULL;
    memcpy(&memory, &host, sizeof memory); /* clCreateBuffer takes no pointer to const */
    *out = clCreateBuffer(call->device->context, flags | CL_MEM_USE_HOST_PTR, bytes, memory, &error);
    if (error != CL_SUCCESS) {
        *out = NULL;
        return svo_i_device_fail_cl(call->device, call->function, "clCreateBuffer", error);
    }
    call->own[call->own_count++] = *out;
    svo_i_call_wait(call);
    return SVO_OK;
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
    if (is_in_place(call, array->host)) {
        call->borrowed = array->host;
        call->borrowed_bytes = bytes;
        return borrow(call, CL_MEM_READ_ONLY, array->host, bytes, out);
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
    /* Kernels may write more than the part that is read. */
    call->is_mapped = read_bytes == bytes && is_in_place(call, array->host) &&
                      !overlap(array->host, bytes, call->borrowed, call->borrowed_bytes);
    SVO_I_TRY(call->is_mapped ? borrow(call, CL_MEM_WRITE_ONLY, array->host, bytes, out)
                              : make_own(call, name, CL_MEM_WRITE_ONLY, bytes, out));
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

/* ---- bands ---- */

/* A band may be so many times as large as the one before it, whose first groups may have been the quick ones. */
#define BAND_GROWTH 8.0

static svo_status launch_band(const svo_i_call *call, const svo_i_launch *launch, size_t first, size_t groups,
                              const cl_event *previous, cl_event *event)
{
    const size_t offset = first * launch->group_items;
    const size_t items = groups * launch->group_items;
    /* Each band waits for the previous one, since the queue may be out-of-order. */
    const cl_int error =
        clEnqueueNDRangeKernel(call->queue, launch->kernel, 1, &offset, &items, &launch->group_items,
                               previous != NULL ? 1 : call->num_wait, previous != NULL ? previous : call->wait, event);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(call->device, call->function, "clEnqueueNDRangeKernel", error);
}

/* Waits for a band. The time of the first one has what the queue did before it: it makes the second one too small. */
static svo_status measure_band(const svo_i_call *call, const cl_event *band, double begun_ms, size_t *groups)
{
    const svo_i_bands *bands = &call->device->bands;
    const cl_int error = clWaitForEvents(1, band);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(call->device, call->function, "clWaitForEvents", error);
    }
    const double took_ms = svo_i_now_ms() - begun_ms;
    const double growth =
        took_ms * BAND_GROWTH > bands->target_ms ? bands->target_ms / took_ms : BAND_GROWTH; /* took_ms may be 0 */
    const double next = (double)*groups * growth;
    *groups = next > (double)bands->least_groups ? (size_t)next : bands->least_groups;
    return SVO_OK;
}

svo_status svo_i_call_launch(const svo_i_call *call, const svo_i_launch *launch)
{
    const bool measures = call->waits && !call->device->cpu_path;
    size_t most = launch->band_groups > 0 ? launch->band_groups
                  : measures              ? call->device->bands.first_groups
                                          : launch->groups;
    cl_event previous = NULL;
    svo_status status = SVO_OK;
    for (size_t first = 0; first < launch->groups;) {
        const size_t left = launch->groups - first;
        const bool is_last = left <= most;
        const double begun_ms = measures ? svo_i_now_ms() : 0;
        cl_event launched = NULL;
        SVO_I_TRY_CLEANUP(launch_band(call, launch, first, is_last ? left : most, previous != NULL ? &previous : NULL,
                                      is_last ? call->event : &launched));
        if (previous != NULL) {
            clReleaseEvent(previous);
        }
        previous = launched;
        first += is_last ? left : most;
        if (measures && !is_last) {
            SVO_I_TRY_CLEANUP(measure_band(call, &previous, begun_ms, &most));
        }
    }

cleanup:
    if (previous != NULL) {
        (void)svo_i_event_settle(previous); /* nothing is in progress after a failure */
        clReleaseEvent(previous);
    }
    return status;
}

/* ---- the end ---- */

/* Waits for a result that the kernel wrote in its place. OpenCL promises it there once it was mapped. */
static cl_int map(const svo_i_call *call)
{
    cl_int error = CL_SUCCESS;
    cl_event is_mapped = NULL;
    cl_event is_unmapped = NULL;
    void *mapped = clEnqueueMapBuffer(call->queue, call->from, CL_FALSE, CL_MAP_READ, call->first_byte,
                                      call->read_bytes, 1, &call->done, &is_mapped, &error);
    if (error != CL_SUCCESS) {
        return error;
    }
    error = clEnqueueUnmapMemObject(call->queue, call->from, mapped, 1, &is_mapped, &is_unmapped);
    const cl_int ended = clWaitForEvents(1, error == CL_SUCCESS ? &is_unmapped : &is_mapped);
    clReleaseEvent(is_mapped);
    if (is_unmapped != NULL) {
        clReleaseEvent(is_unmapped);
    }
    return error == CL_SUCCESS ? ended : error;
}

/* Reads the result, or waits. */
static svo_status finish(svo_i_call *call)
{
    cl_int error = CL_SUCCESS;
    const char *name = "clWaitForEvents";
    if (call->to != NULL && call->is_mapped) {
        name = "clEnqueueMapBuffer";
        error = map(call);
    } else if (call->to != NULL) {
        name = "clEnqueueReadBuffer";
        error = svo_i_download(call->device,
                               &(svo_i_download_from){.queue = call->queue,
                                                      .buffer = call->from,
                                                      .offset = call->first_byte,
                                                      .bytes = call->read_bytes,
                                                      .wait = &call->done},
                               call->to);
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
