/* SPDX-License-Identifier: MIT */
/*
 * What the stages of a build ask of OpenCL: buffers, copies and launches, one waiting for the other, and the time that
 * a stage's launches take.
 */
#include "build/build.h"

/* Measuring, a buffer is known by a handle that is no object but its allocation's index, plus one. */
static cl_mem handle_of(size_t index)
{
    return (cl_mem)(uintptr_t)(index + 1);
}

static svo_status measure(svo_i_build *build, const char *name, uint64_t bytes, cl_mem *out)
{
    size_t index = 0;
    if (!svo_i_allocations_add(build->allocations, name, bytes, &index)) {
        return svo_i_device_fail(build->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the list of buffers",
                                 SVO_I_BUILD);
    }
    *out = handle_of(index);
    return SVO_OK;
}

/* The next of the allocations that were measured. */
static svo_status take(svo_i_build *build, const char *name, uint64_t bytes, cl_mem *out)
{
    const svo_i_allocations *list = build->allocations;
    const svo_i_allocation *entry = &list->entries[build->next_allocation];
    if (build->next_allocation >= list->count || entry->bytes < bytes) {
        return svo_i_device_fail(build->device, SVO_INTERNAL, "%s: buffer %s of %llu bytes is not in the plan",
                                 SVO_I_BUILD, name, (unsigned long long)bytes);
    }
    ++build->next_allocation;
    *out = entry->memory;
    return SVO_OK;
}

svo_status svo_i_build_alloc(svo_i_build *build, const char *name, uint64_t bytes, cl_mem *out)
{
    if (build->mode == SVO_I_BUILD_ENQUEUES) {
        return take(build, name, bytes, out);
    }
    const svo_status status =
        build->mode == SVO_I_BUILD_MEASURES
            ? measure(build, name, bytes, out)
            : svo_i_device_buffer(build->device, SVO_I_BUILD, name, CL_MEM_READ_WRITE, (size_t)bytes, out);
    if (status == SVO_OK) {
        svo_i_plan_buffer_add(build->plan, name, bytes > 0 ? bytes : 1);
    }
    return status;
}

/* Makes event the newest; on failure turns the error into a status. */
static svo_status follow(svo_i_build *build, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(build->device, SVO_I_BUILD, call, error);
    }
    if (build->stage_first == NULL) {
        clRetainEvent(event);
        build->stage_first = event;
    }
    if (build->last != NULL) {
        clReleaseEvent(build->last);
    }
    build->last = event;
    return SVO_OK;
}

static cl_uint wait_count(const svo_i_build *build)
{
    return build->last != NULL ? 1 : 0;
}

static const cl_event *wait_list(const svo_i_build *build)
{
    return build->last != NULL ? &build->last : NULL;
}

svo_status svo_i_build_upload(svo_i_build *build, const char *name, const void *data, uint64_t bytes, cl_mem *out)
{
    const svo_status status = svo_i_build_alloc(build, name, bytes, out);
    return status == SVO_OK ? svo_i_build_write(build, *out, data, bytes) : status;
}

/* Nothing to do: no bytes, no work-items, or the build only measures. */
static bool is_idle(const svo_i_build *build, uint64_t amount)
{
    return amount == 0 || build->mode == SVO_I_BUILD_MEASURES;
}

svo_status svo_i_build_write(svo_i_build *build, cl_mem buffer, const void *data, uint64_t bytes)
{
    if (is_idle(build, bytes)) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_bool blocking = build->mode == SVO_I_BUILD_RUNS ? CL_TRUE : CL_FALSE;
    const cl_int error = clEnqueueWriteBuffer(build->queue, buffer, blocking, 0, (size_t)bytes, data, wait_count(build),
                                              wait_list(build), &event);
    return follow(build, "clEnqueueWriteBuffer", error, event);
}

void svo_i_build_free(svo_i_build *build, cl_mem *buffer)
{
    if (*buffer == NULL || build->mode == SVO_I_BUILD_ENQUEUES) {
        *buffer = NULL;
        return;
    }
    size_t bytes = 0;
    if (build->mode == SVO_I_BUILD_MEASURES) {
        const size_t index = (size_t)(uintptr_t)*buffer - 1;
        svo_i_plan_buffer_remove(build->plan, build->allocations->entries[index].bytes);
        svo_i_allocations_release(build->allocations, index);
        *buffer = NULL;
        return;
    }
    clGetMemObjectInfo(*buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    svo_i_plan_buffer_remove(build->plan, bytes);
    clReleaseMemObject(*buffer);
    *buffer = NULL;
}

svo_status svo_i_build_fill(svo_i_build *build, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                            uint64_t bytes)
{
    if (is_idle(build, bytes)) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_int error = clEnqueueFillBuffer(build->queue, buffer, pattern, pattern_bytes, 0, (size_t)bytes,
                                             wait_count(build), wait_list(build), &event);
    return follow(build, "clEnqueueFillBuffer", error, event);
}

svo_status svo_i_build_fill_zero(svo_i_build *build, cl_mem buffer, uint64_t bytes)
{
    const cl_uint zero = 0;
    return svo_i_build_fill(build, buffer, &zero, bytes % sizeof zero == 0 ? sizeof zero : 1, bytes);
}

svo_status svo_i_build_copy(svo_i_build *build, cl_mem from, cl_mem to, uint64_t to_offset, uint64_t bytes)
{
    if (is_idle(build, bytes)) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_int error = clEnqueueCopyBuffer(build->queue, from, to, 0, (size_t)to_offset, (size_t)bytes,
                                             wait_count(build), wait_list(build), &event);
    return follow(build, "clEnqueueCopyBuffer", error, event);
}

svo_status svo_i_build_wait(svo_i_build *build)
{
    const bool waits = build->mode == SVO_I_BUILD_RUNS && build->last != NULL;
    const cl_int error = waits ? clWaitForEvents(1, &build->last) : CL_SUCCESS;
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(build->device, SVO_I_BUILD, "clWaitForEvents", error);
}

svo_status svo_i_build_read(svo_i_build *build, cl_mem buffer, void *to, size_t bytes)
{
    if (is_idle(build, bytes)) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_bool blocking = build->mode == SVO_I_BUILD_RUNS ? CL_TRUE : CL_FALSE;
    const cl_int error =
        clEnqueueReadBuffer(build->queue, buffer, blocking, 0, bytes, to, wait_count(build), wait_list(build), &event);
    return follow(build, "clEnqueueReadBuffer", error, event);
}

svo_status svo_i_build_kernel(svo_i_build *build, const char *name, cl_kernel *out)
{
    return build->mode != SVO_I_BUILD_MEASURES
               ? svo_i_kernel_create(build->device, SVO_I_BUILD, build->program, name, out)
               : SVO_OK;
}

svo_status svo_i_build_run(svo_i_build *build, const char *name, const svo_i_argument *arguments,
                           cl_uint argument_count, uint64_t items)
{
    cl_kernel kernel = NULL;
    if (is_idle(build, items)) {
        return SVO_OK;
    }
    svo_status status = svo_i_build_kernel(build, name, &kernel);
    if (status == SVO_OK) {
        status = svo_i_build_launch(build, kernel, arguments, argument_count, items);
        clReleaseKernel(kernel);
    }
    return status;
}

svo_status svo_i_build_launch(svo_i_build *build, cl_kernel kernel, const svo_i_argument *arguments,
                              cl_uint argument_count, uint64_t items)
{
    if (is_idle(build, items)) {
        return SVO_OK;
    }
    const svo_status status = svo_i_kernel_set(build->device, SVO_I_BUILD, kernel, arguments, argument_count);
    if (status != SVO_OK) {
        return status;
    }
    const size_t local = SVO_GROUP_ITEMS;
    const size_t global = (size_t)((items + local - 1) / local) * local;
    cl_event event = NULL;
    const cl_int error = clEnqueueNDRangeKernel(build->queue, kernel, 1, NULL, &global, &local, wait_count(build),
                                                wait_list(build), &event);
    return follow(build, "clEnqueueNDRangeKernel", error, event);
}

void svo_i_build_stage_begin(svo_i_build *build)
{
    if (build->stage_first != NULL) {
        clReleaseEvent(build->stage_first);
        build->stage_first = NULL;
    }
    build->stage_start_ms = svo_i_now_ms();
}

/* From the start of the first to the end of the last launch; negative where the queue does not say. */
static double event_span_ms(cl_event first, cl_event last)
{
    cl_ulong start = 0;
    cl_ulong end = 0;
    if (clGetEventProfilingInfo(first, CL_PROFILING_COMMAND_START, sizeof start, &start, NULL) != CL_SUCCESS ||
        clGetEventProfilingInfo(last, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL) != CL_SUCCESS || end < start) {
        return -1.0;
    }
    return (double)(end - start) * 1e-6;
}

/* Keeps the open stage's events, for svo_i_build_take_spans; without room for them its time is not told. */
static void keep_span(svo_i_build *build, svo_stage stage)
{
    if (build->span_count < SVO_I_SPANS_MAX && build->profiling) {
        clRetainEvent(build->last);
        build->spans[build->span_count++] = (svo_i_span){stage, build->stage_first, build->last};
    } else {
        clReleaseEvent(build->stage_first);
    }
    build->stage_first = NULL;
}

void svo_i_build_take_spans(svo_i_build *build)
{
    for (size_t i = 0; i < build->span_count; ++i) {
        const svo_i_span *span = &build->spans[i];
        const double ms = event_span_ms(span->first, span->last);
        if (ms >= 0.0) {
            svo_i_report_add(build->report, span->stage, ms, "cl-event");
        }
        clReleaseEvent(span->first);
        clReleaseEvent(span->last);
    }
    build->span_count = 0;
}

svo_status svo_i_build_stage_end(svo_i_build *build, svo_stage stage)
{
    if (build->stage_first == NULL) {
        return SVO_OK;
    }
    if (build->mode == SVO_I_BUILD_ENQUEUES) {
        keep_span(build, stage);
        return SVO_OK;
    }
    const cl_int error = clWaitForEvents(1, &build->last);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(build->device, SVO_I_BUILD, svo_stage_name(stage), error);
    }
    const double span = build->profiling ? event_span_ms(build->stage_first, build->last) : -1.0;
    if (span >= 0.0) {
        svo_i_report_add(build->report, stage, span, "cl-event");
    } else {
        svo_i_report_add(build->report, stage, svo_i_now_ms() - build->stage_start_ms, "wall");
    }
    clReleaseEvent(build->stage_first);
    build->stage_first = NULL;
    return SVO_OK;
}
