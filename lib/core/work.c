/* SPDX-License-Identifier: MIT */
/*
 * Work on the device outside a build: scratch buffers, copies and launches; scans by kernels/stages/scan.cl; chains of
 * commands on any queues.
 */
#include "core/work.h"

#include <string.h>

#include "core/staging.h"
#include "shared/layout.h"

/* ---- commands in flight ---- */

/* Below 0: the command has failed. */
static cl_int status_of(cl_event event)
{
    cl_int status = CL_QUEUED;
    const cl_int error = clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, NULL);
    return error == CL_SUCCESS ? status : CL_QUEUED;
}

/* Forgets what has failed, and what completed before another one did. Waiting for the newest one that has completed
   costs nothing, and makes what it wrote visible, which its status alone does not. */
static void prune(svo_i_in_flight *commands)
{
    size_t kept = 0;
    for (size_t i = 0; i < commands->count; ++i) {
        cl_event event = commands->events[i];
        const cl_int status = status_of(event);
        if (status < CL_COMPLETE) {
            clReleaseEvent(event);
            continue;
        }
        if (status == CL_COMPLETE) { /* and so have all before it */
            for (size_t k = 0; k < kept; ++k) {
                clReleaseEvent(commands->events[k]);
            }
            kept = 0;
        }
        commands->events[kept++] = event;
    }
    commands->count = kept;
}

cl_event svo_i_in_flight_newest(svo_i_in_flight *commands)
{
    prune(commands);
    return commands->count > 0 ? commands->events[commands->count - 1] : NULL;
}

svo_status svo_i_in_flight_reserve(svo_i_in_flight *commands, svo_device *device, const char *function)
{
    enum { FIRST_CAPACITY = 8 };
    prune(commands);
    if (commands->count < commands->capacity) {
        return SVO_OK;
    }
    const size_t capacity = commands->capacity > 0 ? commands->capacity * 2 : FIRST_CAPACITY;
    cl_event *events = svo_i_grow(&device->memory, commands->events, capacity * sizeof(cl_event));
    if (events == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu events", function, capacity);
    }
    commands->events = events;
    commands->capacity = capacity;
    return SVO_OK;
}

svo_status svo_i_in_flight_add(svo_i_in_flight *commands, svo_device *device, const char *function, cl_event event)
{
    const cl_int error = clRetainEvent(event);
    if (error != CL_SUCCESS) {
        (void)svo_i_event_settle(event); /* so that nothing need wait for it */
        return svo_i_device_fail_cl(device, function, "clRetainEvent", error);
    }
    commands->events[commands->count++] = event;
    return SVO_OK;
}

void svo_i_in_flight_end(svo_i_in_flight *commands)
{
    for (size_t i = 0; i < commands->count; ++i) {
        (void)svo_i_event_settle(commands->events[i]);
        clReleaseEvent(commands->events[i]);
    }
    svo_i_free(commands->events);
    *commands = (svo_i_in_flight){.events = NULL};
}

/* ---- works ---- */

svo_status svo_i_work_begin(svo_device *device, const char *function, cl_command_queue queue, svo_i_device_work *out)
{
    *out = (svo_i_device_work){.device = device, .function = function};
    return svo_i_device_queue(device, function, queue, &out->queue);
}

svo_status svo_i_work_begin_after(svo_device *device, const char *function, cl_command_queue queue, cl_uint num_wait,
                                  const cl_event *wait, svo_i_device_work *out)
{
    cl_event begun = NULL;
    SVO_I_TRY(svo_i_work_begin(device, function, queue, out));
    if (num_wait > 0) {
        const cl_int error = clEnqueueMarkerWithWaitList(out->queue, num_wait, wait, &begun);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(device, function, "clEnqueueMarkerWithWaitList", error);
        }
    }
    out->last = begun;
    return SVO_OK;
}

void svo_i_work_end(svo_i_device_work *work)
{
    if (work->last != NULL) {
        (void)svo_i_event_settle(work->last);
    }
    svo_i_work_leave(work, NULL);
}

void svo_i_work_leave(svo_i_device_work *work, cl_event *event)
{
    if (event != NULL) {
        *event = work->last;
    } else if (work->last != NULL) {
        clReleaseEvent(work->last);
    }
    for (size_t i = 0; i < work->buffer_count; ++i) {
        if (work->buffers[i] != NULL) {
            clReleaseMemObject(work->buffers[i]);
        }
    }
    *work = (svo_i_device_work){.device = NULL};
}

svo_status svo_i_work_wait(svo_i_device_work *work)
{
    const cl_int error = work->last != NULL ? clWaitForEvents(1, &work->last) : CL_SUCCESS;
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(work->device, work->function, "clWaitForEvents", error);
}

svo_status svo_i_work_use(svo_i_device_work *work, const svo_i_program *program, const char *defines)
{
    return svo_i_program_get(work->device, work->function, program, defines, &work->program, NULL);
}

/* ---- buffers ---- */

svo_status svo_i_work_result(svo_i_device_work *work, const char *name, uint64_t bytes, cl_mem *out)
{
    return svo_i_device_buffer(work->device, work->function, name, CL_MEM_READ_WRITE, (size_t)bytes, out);
}

/* The place of a new scratch buffer: one that was released early, else the end. */
static size_t find_slot(const svo_i_device_work *work)
{
    size_t slot = 0;
    while (slot < work->buffer_count && work->buffers[slot] != NULL) {
        ++slot;
    }
    return slot;
}

static svo_status check_slot(const svo_i_device_work *work)
{
    return find_slot(work) < SVO_I_WORK_BUFFERS_MAX
               ? SVO_OK
               : svo_i_device_fail(work->device, SVO_INTERNAL, "%s: more than %d scratch buffers", work->function,
                                   SVO_I_WORK_BUFFERS_MAX);
}

/* Takes a new scratch buffer into the work. */
static void own(svo_i_device_work *work, cl_mem buffer, uint64_t bytes)
{
    const size_t slot = find_slot(work);
    work->buffers[slot] = buffer;
    work->buffer_bytes[slot] = bytes;
    work->live_bytes += bytes;
    work->peak_bytes = work->live_bytes > work->peak_bytes ? work->live_bytes : work->peak_bytes;
    work->buffer_count = slot == work->buffer_count ? slot + 1 : work->buffer_count;
}

svo_status svo_i_work_alloc(svo_i_device_work *work, const char *name, uint64_t bytes, cl_mem *out)
{
    SVO_I_TRY(check_slot(work));
    SVO_I_TRY(svo_i_work_result(work, name, bytes, out));
    own(work, *out, bytes);
    return SVO_OK;
}

svo_status svo_i_work_constants(svo_i_device_work *work, const char *name, const void *content, uint64_t bytes,
                                cl_mem *out)
{
    SVO_I_TRY(check_slot(work));
    SVO_I_TRY(svo_i_device_constants(work->device, work->function, name, content, (size_t)bytes, out));
    own(work, *out, bytes);
    return SVO_OK;
}

void svo_i_work_free(svo_i_device_work *work, cl_mem *buffer)
{
    for (size_t i = 0; i < work->buffer_count; ++i) {
        if (*buffer != NULL && work->buffers[i] == *buffer) {
            clReleaseMemObject(*buffer);
            work->buffers[i] = NULL;
            work->live_bytes -= work->buffer_bytes[i];
        }
    }
    *buffer = NULL;
}

/* ---- commands ---- */

void svo_i_work_follow(svo_i_device_work *work, cl_event event)
{
    if (work->last != NULL) {
        clReleaseEvent(work->last);
    }
    work->last = event;
}

/* Makes event the newest command, or converts the error of its call into a status. */
static svo_status follow(svo_i_device_work *work, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(work->device, work->function, call, error);
    }
    svo_i_work_follow(work, event);
    return SVO_OK;
}

static cl_uint wait_count(const svo_i_device_work *work)
{
    return work->last != NULL ? 1 : work->wait_count;
}

static const cl_event *wait_list(const svo_i_device_work *work)
{
    return work->last != NULL ? &work->last : work->wait;
}

static svo_status write(svo_i_device_work *work, cl_mem buffer, const void *data, uint64_t bytes, cl_bool waits)
{
    cl_event event = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    const svo_i_upload upload = {.queue = work->queue,
                                 .buffer = buffer,
                                 .bytes = (size_t)bytes,
                                 .from = data,
                                 .blocks = waits,
                                 .num_wait = wait_count(work),
                                 .wait = wait_list(work)};
    const cl_int error = svo_i_upload_enqueue(work->device, &upload, &event);
    return follow(work, "clEnqueueWriteBuffer", error, event);
}

svo_status svo_i_work_write(svo_i_device_work *work, cl_mem buffer, const void *data, uint64_t bytes)
{
    return write(work, buffer, data, bytes, CL_TRUE);
}

svo_status svo_i_work_write_later(svo_i_device_work *work, cl_mem buffer, const void *data, uint64_t bytes)
{
    return write(work, buffer, data, bytes, CL_FALSE);
}

/* The host's memory as a buffer, without a copy. */
static svo_status borrow(svo_i_device_work *work, const void *data, uint64_t bytes, cl_mem *out)
{
    cl_int error = CL_SUCCESS;
    void *memory = NULL;
    memcpy(&memory, &data, sizeof memory); /* clCreateBuffer takes no pointer to const */
    *out = clCreateBuffer(work->device->context, CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR, (size_t)bytes, memory, &error);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(work->device, work->function, "clCreateBuffer", error);
}

svo_status svo_i_work_input(svo_i_device_work *work, const char *name, const void *data, uint64_t bytes, cl_mem *out)
{
    if (work->device->cpu_path && bytes > 0) {
        return borrow(work, data, bytes, out);
    }
    SVO_I_TRY(svo_i_work_result(work, name, bytes, out));
    return svo_i_work_write_later(work, *out, data, bytes);
}

svo_status svo_i_work_fill_pattern(svo_i_device_work *work, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                                   uint64_t bytes)
{
    cl_event event = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    const cl_int error = clEnqueueFillBuffer(work->queue, buffer, pattern, pattern_bytes, 0, (size_t)bytes,
                                             wait_count(work), wait_list(work), &event);
    return follow(work, "clEnqueueFillBuffer", error, event);
}

svo_status svo_i_work_fill_zero(svo_i_device_work *work, cl_mem buffer, uint64_t bytes)
{
    const cl_uint zero = 0;
    return svo_i_work_fill_pattern(work, buffer, &zero, bytes % sizeof zero == 0 ? sizeof zero : 1, bytes);
}

svo_status svo_i_work_fill(svo_i_device_work *work, cl_mem buffer, cl_uint word, uint64_t bytes)
{
    return svo_i_work_fill_pattern(work, buffer, &word, sizeof word, bytes);
}

svo_status svo_i_work_copy(svo_i_device_work *work, cl_mem from, uint64_t from_offset, cl_mem to, uint64_t to_offset,
                           uint64_t bytes)
{
    cl_event event = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    const cl_int error = clEnqueueCopyBuffer(work->queue, from, to, (size_t)from_offset, (size_t)to_offset,
                                             (size_t)bytes, wait_count(work), wait_list(work), &event);
    return follow(work, "clEnqueueCopyBuffer", error, event);
}

static svo_status read(svo_i_device_work *work, cl_mem buffer, uint64_t offset, void *to, size_t bytes, cl_bool waits)
{
    cl_event event = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    const cl_int error = clEnqueueReadBuffer(work->queue, buffer, waits, (size_t)offset, bytes, to, wait_count(work),
                                             wait_list(work), &event);
    return follow(work, "clEnqueueReadBuffer", error, event);
}

svo_status svo_i_work_read_later(svo_i_device_work *work, cl_mem buffer, void *to, size_t bytes)
{
    return read(work, buffer, 0, to, bytes, CL_FALSE);
}

svo_status svo_i_work_read(svo_i_device_work *work, cl_mem buffer, uint64_t offset, void *to, size_t bytes)
{
    return read(work, buffer, offset, to, bytes, CL_TRUE);
}

svo_status svo_i_work_launch_groups(svo_i_device_work *work, const char *name, const svo_i_argument *arguments,
                                    cl_uint argument_count, uint64_t items, size_t group_items)
{
    cl_kernel kernel = NULL;
    svo_status status = SVO_OK;
    if (items == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_kernel_create(work->device, work->function, work->program, name, &kernel));
    SVO_I_TRY_CLEANUP(svo_i_kernel_set(work->device, work->function, kernel, arguments, argument_count));
    const size_t global = (size_t)((items + group_items - 1) / group_items) * group_items;
    cl_event event = NULL;
    const cl_int error = clEnqueueNDRangeKernel(work->queue, kernel, 1, NULL, &global, &group_items, wait_count(work),
                                                wait_list(work), &event);
    SVO_I_TRY_CLEANUP(follow(work, "clEnqueueNDRangeKernel", error, event));

cleanup:
    clReleaseKernel(kernel);
    return status;
}

svo_status svo_i_work_launch(svo_i_device_work *work, const char *name, const svo_i_argument *arguments,
                             cl_uint argument_count, uint64_t items)
{
    return svo_i_work_launch_groups(work, name, arguments, argument_count, items, SVO_GROUP_ITEMS);
}

/* ---- scans ---- */

uint32_t svo_i_scan_groups(const svo_device *device, uint64_t numbers)
{
    const uint32_t tile = SVO_SCAN_TILE;
    const uint64_t tiles = (numbers + tile - 1) / tile;
    return (uint32_t)(tiles < 1 ? 1 : tiles > device->scan_groups ? device->scan_groups : tiles);
}

svo_status svo_i_work_scan(svo_i_device_work *work, cl_mem numbers, cl_mem sums, uint64_t count)
{
    const svo_filter_params params = {.leaf_count = (cl_uint)count};
    const uint64_t items = (uint64_t)svo_i_scan_groups(work->device, count) * SVO_GROUP_ITEMS;
    const cl_mem state = NULL; /* of a build; the kernels of this program do not read it */
    const svo_i_argument scratch = SVO_I_LOCAL(SVO_GROUP_ITEMS * sizeof(cl_uint));
    if (work->partials == NULL) {
        SVO_I_TRY(svo_i_work_alloc(work, "partials", work->device->scan_groups * sizeof(cl_uint), &work->partials));
    }
    const svo_i_argument reduce[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(work->partials), SVO_I_ARGUMENT(state),
                                     SVO_I_ARGUMENT(params), scratch};
    const svo_i_argument add[] = {SVO_I_ARGUMENT(numbers), SVO_I_ARGUMENT(work->partials), SVO_I_ARGUMENT(sums),
                                  SVO_I_ARGUMENT(state),   SVO_I_ARGUMENT(params),         scratch};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_scan_lists_reduce", SVO_I_ARGUMENTS(reduce), items));
    return svo_i_work_launch(work, "svo_k_scan_lists_add", SVO_I_ARGUMENTS(add), items);
}
