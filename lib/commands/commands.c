/* SPDX-License-Identifier: MIT */
/*
 * Buffers, copies and launches, in each of the three modes; the records of a build's allocations; the times of stages;
 * the public functions that all front ends share.
 */
#include "commands/commands.h"

#include "commands/frontend.h"
#include "core/staging.h"
#include "plan/accounts.h"
#include "plan/arrays.h"

/* ---- allocations ---- */

/*
 * Records allocations and places scratch buffers with known lifetimes in one block of memory. In order, each buffer
 * gets the lowest offset that overlaps no buffer with an overlapping lifetime (first fit: Knuth, "The Art of Computer
 * Programming", volume 1, section 2.5).
 */

/* Records an allocation; *index identifies it. Returns false when out of memory. */
static bool add_allocation(const svo_i_memory *memory, svo_i_allocations *list, const char *name, uint64_t bytes,
                           size_t *index)
{
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity * 2 + 32;
        svo_i_allocation *grown = svo_i_grow(memory, list->entries, capacity * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        list->entries = grown;
        list->capacity = capacity;
    }
    list->entries[list->count] =
        (svo_i_allocation){.name = name, .bytes = bytes > 0 ? bytes : 1, .born = list->clock++, .died = UINT64_MAX};
    *index = list->count++;
    return true;
}

/* Records the release of an allocation. */
static void release_allocation(svo_i_allocations *list, size_t index)
{
    list->entries[index].died = list->clock++;
}

static bool overlap_in_time(const svo_i_allocation *a, const svo_i_allocation *b)
{
    return a->born < b->died && b->born < a->died;
}

static uint64_t aligned(uint64_t bytes, uint64_t alignment)
{
    return (bytes + alignment - 1) / alignment * alignment;
}

/* The end of an earlier entry that overlaps this one in time and, at the given offset, in memory; 0 without one. */
static uint64_t blocked_until(const svo_i_allocations *list, size_t index, uint64_t offset)
{
    const svo_i_allocation *entry = &list->entries[index];
    for (size_t i = 0; i < index; ++i) {
        const svo_i_allocation *other = &list->entries[i];
        if (!other->persistent && overlap_in_time(entry, other) && offset < other->offset_bytes + other->bytes &&
            other->offset_bytes < offset + entry->bytes) {
            return other->offset_bytes + other->bytes;
        }
    }
    return 0;
}

void svo_i_allocations_place(svo_i_allocations *list, uint64_t alignment)
{
    list->scratch_bytes = 0;
    for (size_t i = 0; i < list->count; ++i) {
        svo_i_allocation *entry = &list->entries[i];
        if (entry->persistent) {
            continue;
        }
        uint64_t offset = 0;
        for (uint64_t end = blocked_until(list, i, 0); end != 0; end = blocked_until(list, i, offset)) {
            offset = aligned(end, alignment);
        }
        entry->offset_bytes = offset;
        const uint64_t end = offset + entry->bytes;
        list->scratch_bytes = end > list->scratch_bytes ? end : list->scratch_bytes;
    }
}

void svo_i_allocations_free(svo_i_allocations *list)
{
    for (size_t i = 0; i < list->count; ++i) {
        if (list->entries[i].memory != NULL) {
            clReleaseMemObject(list->entries[i].memory);
        }
    }
    svo_i_free(list->entries);
    *list = (svo_i_allocations){0};
}

/* ---- commands ---- */

svo_i_commands svo_i_commands_begin(svo_plan *plan, cl_command_queue queue, svo_build_report *report)
{
    cl_command_queue_properties properties = 0;
    clGetCommandQueueInfo(queue, CL_QUEUE_PROPERTIES, sizeof properties, &properties, NULL);
    return (svo_i_commands){.device = plan->device,
                            .plan = plan,
                            .queue = queue,
                            .profiling = (properties & CL_QUEUE_PROFILING_ENABLE) != 0,
                            .report = report};
}

void svo_i_commands_end(svo_i_commands *commands)
{
    if (commands->last != NULL) {
        (void)svo_i_event_settle(commands->last);
        clReleaseEvent(commands->last);
        commands->last = NULL;
    }
    if (commands->stage_first != NULL) {
        clReleaseEvent(commands->stage_first);
        commands->stage_first = NULL;
    }
}

/* A measuring build has no buffers. Its handles are indices of allocations, plus one so that none is NULL. */
static cl_mem handle_of(size_t index)
{
    return (cl_mem)(uintptr_t)(index + 1);
}

static svo_status measure(svo_i_commands *commands, const char *name, uint64_t bytes, cl_mem *out)
{
    size_t index = 0;
    if (!add_allocation(&commands->device->memory, commands->allocations, name, bytes, &index)) {
        return svo_i_device_fail(commands->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the list of buffers",
                                 SVO_I_BUILD);
    }
    *out = handle_of(index);
    return SVO_OK;
}

/* Takes the next of the recorded allocations. */
static svo_status take(svo_i_commands *commands, const char *name, uint64_t bytes, cl_mem *out)
{
    const svo_i_allocations *list = commands->allocations;
    const svo_i_allocation *entry = &list->entries[commands->next_allocation];
    if (commands->next_allocation >= list->count || entry->bytes < bytes) {
        return svo_i_device_fail(commands->device, SVO_INTERNAL, "%s: buffer %s of %llu bytes is not in the plan",
                                 SVO_I_BUILD, name, (unsigned long long)bytes);
    }
    ++commands->next_allocation;
    *out = entry->memory;
    return SVO_OK;
}

/* Whether buffers are those of a workspace. */
static bool is_lent(const svo_i_commands *commands)
{
    return commands->mode == SVO_I_MODE_ENQUEUE && commands->allocations != NULL;
}

/* Waits for released memory that may still be in use, if it is much. */
static svo_status make_room(svo_i_commands *commands)
{
    return commands->released_bytes > SVO_I_RELEASED_BYTES_MAX ? svo_i_commands_wait(commands) : SVO_OK;
}

svo_status svo_i_commands_alloc(svo_i_commands *commands, const char *name, uint64_t bytes, cl_mem *out)
{
    if (is_lent(commands)) {
        return take(commands, name, bytes, out);
    }
    if (commands->mode == SVO_I_MODE_MEASURE) {
        SVO_I_TRY(measure(commands, name, bytes, out));
    } else {
        SVO_I_TRY(make_room(commands));
        SVO_I_TRY(svo_i_device_buffer(commands->device, SVO_I_BUILD, name, CL_MEM_READ_WRITE, (size_t)bytes, out));
    }
    return svo_i_plan_buffer_add(commands->plan, name, bytes > 0 ? bytes : 1);
}

svo_status svo_i_commands_alloc_all(svo_i_commands *commands, const svo_i_request *requests, size_t count)
{
    const bool makes = commands->mode != SVO_I_MODE_MEASURE && !is_lent(commands);
    if (makes) {
        SVO_I_TRY(make_room(commands));
        SVO_I_TRY(svo_i_device_buffers(commands->device, SVO_I_BUILD, requests, count));
    }
    for (size_t i = 0; i < count; ++i) {
        const uint64_t bytes = svo_i_device_slots(commands->device, requests[i].bytes);
        SVO_I_TRY(makes ? svo_i_plan_buffer_add(commands->plan, requests[i].name, bytes)
                        : svo_i_commands_alloc(commands, requests[i].name, bytes, requests[i].out));
    }
    return SVO_OK;
}

/* Makes event the newest command, or converts the error of its call into a status. */
static svo_status follow(svo_i_commands *commands, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(commands->device, SVO_I_BUILD, call, error);
    }
    if (commands->last != NULL) {
        clReleaseEvent(commands->last);
    }
    commands->last = event;
    if (commands->stage_first == NULL) {
        error = clRetainEvent(event);
        commands->stage_first = error == CL_SUCCESS ? event : NULL;
    }
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(commands->device, SVO_I_BUILD, "clRetainEvent", error);
}

static cl_uint wait_count(const svo_i_commands *commands)
{
    return commands->last != NULL ? 1 : 0;
}

static const cl_event *wait_list(const svo_i_commands *commands)
{
    return commands->last != NULL ? &commands->last : NULL;
}

svo_status svo_i_commands_upload(svo_i_commands *commands, const char *name, const void *data, uint64_t bytes,
                                 cl_mem *out)
{
    SVO_I_TRY(svo_i_commands_alloc(commands, name, bytes, out));
    return svo_i_commands_write(commands, *out, data, bytes);
}

svo_status svo_i_commands_borrow(svo_i_commands *commands, const char *name, const void *host, cl_mem memory,
                                 uint64_t bytes, cl_mem *out)
{
    if (memory == NULL) {
        return svo_i_commands_upload(commands, name, host, bytes, out);
    }
    *out = memory;
    return SVO_OK;
}

svo_status svo_i_commands_take(svo_i_commands *commands, const char *name, const void *host, cl_mem memory,
                               uint64_t bytes, cl_mem *out)
{
    if (memory == NULL) {
        return svo_i_commands_upload(commands, name, host, bytes, out);
    }
    SVO_I_TRY(svo_i_commands_alloc(commands, name, bytes, out));
    return svo_i_commands_copy(commands, memory, *out, 0, bytes);
}

/* Whether a copy or fill is to be skipped: it has no bytes, or the build only measures. */
static bool skips(const svo_i_commands *commands, uint64_t bytes)
{
    return bytes == 0 || commands->mode == SVO_I_MODE_MEASURE;
}

svo_status svo_i_commands_write(svo_i_commands *commands, cl_mem buffer, const void *data, uint64_t bytes)
{
    if (skips(commands, bytes)) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const svo_i_upload upload = {.queue = commands->queue,
                                 .buffer = buffer,
                                 .bytes = (size_t)bytes,
                                 .from = data,
                                 .blocks = commands->blocks ? CL_TRUE : CL_FALSE,
                                 .num_wait = wait_count(commands),
                                 .wait = wait_list(commands)};
    /* Staging memory may have to be waited for. */
    const cl_int error = commands->mode == SVO_I_MODE_RUN
                             ? svo_i_upload_enqueue(commands->device, &upload, &event)
                             : clEnqueueWriteBuffer(commands->queue, buffer, CL_FALSE, 0, (size_t)bytes, data,
                                                    upload.num_wait, upload.wait, &event);
    return follow(commands, "clEnqueueWriteBuffer", error, event);
}

void svo_i_commands_free(svo_i_commands *commands, cl_mem *buffer)
{
    if (*buffer == NULL || is_lent(commands) || svo_i_plan_owns(commands->plan, *buffer)) {
        *buffer = NULL;
        return;
    }
    if (commands->mode == SVO_I_MODE_MEASURE) {
        const size_t index = (size_t)(uintptr_t)*buffer - 1;
        svo_i_plan_buffer_remove(commands->plan, commands->allocations->entries[index].bytes);
        release_allocation(commands->allocations, index);
        *buffer = NULL;
        return;
    }
    size_t bytes = 0;
    clGetMemObjectInfo(*buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    svo_i_plan_buffer_remove(commands->plan, bytes);
    commands->released_bytes += bytes;
    clReleaseMemObject(*buffer);
    *buffer = NULL;
}

svo_status svo_i_commands_fill(svo_i_commands *commands, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                               uint64_t bytes)
{
    if (skips(commands, bytes)) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_int error = clEnqueueFillBuffer(commands->queue, buffer, pattern, pattern_bytes, 0, (size_t)bytes,
                                             wait_count(commands), wait_list(commands), &event);
    return follow(commands, "clEnqueueFillBuffer", error, event);
}

svo_status svo_i_commands_fill_zero(svo_i_commands *commands, cl_mem buffer, uint64_t bytes)
{
    const cl_uint zero = 0;
    return svo_i_commands_fill(commands, buffer, &zero, bytes % sizeof zero == 0 ? sizeof zero : 1, bytes);
}

svo_status svo_i_commands_copy(svo_i_commands *commands, cl_mem from, cl_mem to, uint64_t to_offset, uint64_t bytes)
{
    if (skips(commands, bytes)) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_int error = clEnqueueCopyBuffer(commands->queue, from, to, 0, (size_t)to_offset, (size_t)bytes,
                                             wait_count(commands), wait_list(commands), &event);
    return follow(commands, "clEnqueueCopyBuffer", error, event);
}

svo_status svo_i_commands_wait(svo_i_commands *commands)
{
    const bool waits = commands->mode == SVO_I_MODE_RUN && commands->last != NULL;
    const cl_int error = waits ? clWaitForEvents(1, &commands->last) : CL_SUCCESS;
    commands->released_bytes = 0;
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(commands->device, SVO_I_BUILD, "clWaitForEvents", error);
}

svo_status svo_i_commands_read(svo_i_commands *commands, cl_mem buffer, void *to, size_t bytes)
{
    if (skips(commands, bytes)) {
        return SVO_OK;
    }
    cl_event event = NULL;
    const cl_bool blocking = commands->mode == SVO_I_MODE_RUN ? CL_TRUE : CL_FALSE;
    const cl_int error = clEnqueueReadBuffer(commands->queue, buffer, blocking, 0, bytes, to, wait_count(commands),
                                             wait_list(commands), &event);
    return follow(commands, "clEnqueueReadBuffer", error, event);
}

void svo_i_commands_stage(svo_i_commands *commands, svo_stage stage, double item_ns)
{
    commands->stage = stage;
    commands->item_ns = item_ns;
}

/* In SVO_I_MODE_RUN, tells the plan's callback what has been done; the caller has waited. */
static svo_status tell_progress(svo_i_commands *commands)
{
    return commands->mode == SVO_I_MODE_RUN ? svo_i_progress_tell(commands->plan, commands->stage) : SVO_OK;
}

uint64_t svo_i_commands_parts(const svo_i_commands *commands, uint64_t items)
{
    const bool reports = commands->mode == SVO_I_MODE_RUN && commands->plan->progress.callback != NULL;
    return reports && items >= 2 * (uint64_t)SVO_I_PART_ITEMS ? items / SVO_I_PART_ITEMS : 1;
}

/* Adds a launch to the predicted time of the stage. */
static void predict(svo_i_commands *commands, uint64_t items)
{
    if (commands->expected_ns != NULL) {
        commands->expected_ns[commands->stage] += (double)items * commands->item_ns;
    }
}

/* Adds a launch to what the build has done. Waits for it when the callback is to be told. */
static svo_status advance(svo_i_commands *commands, uint64_t items)
{
    if (commands->mode != SVO_I_MODE_RUN ||
        !svo_i_progress_add(commands->plan, commands->stage, (double)items * commands->item_ns)) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_commands_wait(commands));
    return tell_progress(commands);
}

bool svo_i_commands_launch_kernels(const svo_i_commands *commands)
{
    return commands->mode != SVO_I_MODE_MEASURE || commands->warm_up != NULL;
}

svo_status svo_i_commands_kernel(svo_i_commands *commands, cl_program program, const char *name, cl_kernel *out)
{
    return svo_i_commands_launch_kernels(commands)
               ? svo_i_kernel_create(commands->device, SVO_I_BUILD, program, name, out)
               : SVO_OK;
}

svo_status svo_i_commands_run(svo_i_commands *commands, cl_program program, const char *name,
                              const svo_i_argument *arguments, cl_uint argument_count, uint64_t items)
{
    cl_kernel kernel = NULL;
    if (items == 0 || !svo_i_commands_launch_kernels(commands)) {
        predict(commands, items);
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_commands_kernel(commands, program, name, &kernel));
    const svo_status status = svo_i_commands_launch(commands, kernel, arguments, argument_count, items);
    clReleaseKernel(kernel);
    return status;
}

svo_status svo_i_commands_launch(svo_i_commands *commands, cl_kernel kernel, const svo_i_argument *arguments,
                                 cl_uint argument_count, uint64_t items)
{
    return svo_i_commands_launch_groups(commands, kernel, arguments, argument_count, items, SVO_GROUP_ITEMS);
}

svo_status svo_i_commands_launch_groups(svo_i_commands *commands, cl_kernel kernel, const svo_i_argument *arguments,
                                        cl_uint argument_count, uint64_t items, size_t group_items)
{
    if (items == 0 || !svo_i_commands_launch_kernels(commands)) {
        predict(commands, items);
        return SVO_OK;
    }
    if (commands->mode == SVO_I_MODE_MEASURE) {
        return svo_i_warm_up_launch(commands->warm_up, kernel, arguments, argument_count, items, group_items);
    }
    SVO_I_TRY(svo_i_kernel_set(commands->device, SVO_I_BUILD, kernel, arguments, argument_count));
    const size_t global = (size_t)((items + group_items - 1) / group_items) * group_items;
    cl_event event = NULL;
    const cl_int error = clEnqueueNDRangeKernel(commands->queue, kernel, 1, NULL, &global, &group_items,
                                                wait_count(commands), wait_list(commands), &event);
    SVO_I_TRY(follow(commands, "clEnqueueNDRangeKernel", error, event));
    return advance(commands, items);
}

/* ---- the times of stages ---- */

/*
 * Times of stages. Where the queue takes them, their events are kept, and svo_i_stage_collect reads them after the
 * build. A blocking build on another queue waits at the end of each stage, if someone asks for its time, and any
 * blocking build does so that has a callback to tell.
 */

void svo_i_report_add(svo_build_report *report, svo_stage stage, double ms, const char *clock)
{
    report->stage_times[stage].ms += ms;
    report->stage_times[stage].clock = clock;
}

void svo_i_stage_begin(svo_i_commands *commands)
{
    if (commands->stage_first != NULL) {
        clReleaseEvent(commands->stage_first);
        commands->stage_first = NULL;
    }
    commands->stage_start_ms = svo_i_now_ms();
}

/* Milliseconds from the start of the first to the end of the last command; negative if profiling has no figures. */
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

/* Keeps the current stage's events for svo_i_stage_collect. Where that cannot be, its time is not reported. */
static void keep_span(svo_i_commands *commands, svo_stage stage)
{
    if (commands->span_count < SVO_I_SPANS_MAX && commands->profiling && !commands->untimed &&
        clRetainEvent(commands->last) == CL_SUCCESS) {
        commands->spans[commands->span_count++] = (svo_i_span){stage, commands->stage_first, commands->last};
    } else {
        clReleaseEvent(commands->stage_first);
    }
    commands->stage_first = NULL;
}

void svo_i_stage_collect(svo_i_commands *commands)
{
    for (size_t i = 0; i < commands->span_count; ++i) {
        const svo_i_span *span = &commands->spans[i];
        const double ms = event_span_ms(span->first, span->last);
        if (ms >= 0.0) {
            svo_i_report_add(commands->report, span->stage, ms, "cl-event");
        }
        clReleaseEvent(span->first);
        clReleaseEvent(span->last);
    }
    commands->span_count = 0;
}

/* Takes the time of a stage that has ended now. */
static svo_status end_and_wait(svo_i_commands *commands, svo_stage stage)
{
    SVO_I_TRY(svo_i_commands_wait(commands));
    const double span = commands->profiling ? event_span_ms(commands->stage_first, commands->last) : -1.0;
    if (span >= 0.0) {
        svo_i_report_add(commands->report, stage, span, "cl-event");
    } else {
        svo_i_report_add(commands->report, stage, svo_i_now_ms() - commands->stage_start_ms, "wall");
    }
    clReleaseEvent(commands->stage_first);
    commands->stage_first = NULL;
    return tell_progress(commands);
}

svo_status svo_i_stage_end(svo_i_commands *commands, svo_stage stage)
{
    if (commands->stage_first == NULL) {
        return SVO_OK;
    }
    if (commands->mode == SVO_I_MODE_ENQUEUE) {
        keep_span(commands, stage);
        return SVO_OK;
    }
    if (commands->plan->progress.callback != NULL || !(commands->profiling || commands->untimed)) {
        return end_and_wait(commands, stage);
    }
    if (commands->span_count == SVO_I_SPANS_MAX) {
        SVO_I_TRY(svo_i_commands_wait(commands));
        svo_i_stage_collect(commands);
    }
    keep_span(commands, stage);
    return SVO_OK;
}

/* ---- front ends ---- */

void svo_frontend_destroy(svo_frontend **frontend)
{
    if (frontend == NULL || *frontend == NULL) {
        return;
    }
    if ((*frontend)->destroy != NULL) {
        (*frontend)->destroy((*frontend)->self);
    }
    *frontend = NULL;
}

const char *svo_frontend_name(const svo_frontend *frontend)
{
    return frontend->name;
}

const char *svo_frontend_share(const svo_frontend *frontend)
{
    return frontend->share;
}

svo_status svo_i_frontend_voxelize(svo_frontend *frontend, svo_i_commands *commands, const svo_i_chunking *chunking,
                                   svo_i_fragment_list *list)
{
    if (!frontend->on_device) {
        SVO_I_TRY(svo_i_plan_copy_to_host(commands->plan));
    }
    return frontend->voxelize(frontend->self, commands, chunking, list);
}
