/* SPDX-License-Identifier: MIT */
/*
 * Updates of plans from vertices that OpenGL has written. With `interop` acquire, update and release are commands like
 * any other; cl_khr_gl_event orders them with OpenGL's (The OpenCL Extension Specification, version 1.2, section 9.8),
 * and without it the host does. The other ways wait for OpenGL before and for OpenCL after, since the memory is
 * OpenGL's again when the call returns.
 */
#include "core/message.h"
#include "plan/plan_data.h"
#include "share/buffer.h"
#include "share/share_host.h"
#include "share/share_interop.h"

#define FUNCTION     "svo_gl_plan_update_enqueue"
#define VERTEX_BYTES 12
#define SOURCES_MAX  2

/* The buffers of one update, and its commands. */
typedef struct update {
    svo_plan *plan;
    svo_gl_buffer *from[SOURCES_MAX]; /* positions, normals */
    unsigned count;
    cl_command_queue queue;
    cl_uint wait_count;
    const cl_event *wait;
    cl_event last; /* the newest command; NULL at first */
} update;

static svo_status check_buffer(const update *u, const char *name, const svo_gl_buffer *buffer)
{
    svo_device *device = u->plan->device;
    const uint64_t needed = (uint64_t)u->plan->vertex_count * VERTEX_BYTES;
    if (buffer->shared.device != device || buffer->shared.context != u->from[0]->shared.context) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, FUNCTION ": %s is of another device or context", name);
    }
    if (buffer->shared.share != u->from[0]->shared.share) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, FUNCTION ": %s is shared by %s, positions by %s", name,
                                 svo_gl_share_name(buffer->shared.share), svo_gl_share_name(u->from[0]->shared.share));
    }
    if (buffer->is_in_cl) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, FUNCTION ": %s is OpenCL's; see svo_gl_buffer_to_gl",
                                 name);
    }
    if (buffer->shared.bytes < needed) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, FUNCTION ": %s has %zu bytes, the plan's vertices %llu",
                                 name, buffer->shared.bytes, (unsigned long long)needed);
    }
    return SVO_OK;
}

/* Makes event the newest command, or converts the error of its call into a status. */
static svo_status follow(update *u, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(u->plan->device, FUNCTION, call, error);
    }
    if (u->last != NULL) {
        clReleaseEvent(u->last);
    }
    u->last = event;
    return SVO_OK;
}

static cl_uint wait_count(const update *u)
{
    return u->last != NULL ? 1 : u->wait_count;
}

static const cl_event *wait_list(const update *u)
{
    return u->last != NULL ? &u->last : u->wait;
}

static svo_status run(update *u)
{
    cl_event updated = NULL;
    const svo_mesh_buffers given = {.struct_size = sizeof given,
                                    .vertex_count = u->plan->vertex_count,
                                    .triangle_count = u->plan->triangle_count,
                                    .positions = {.memory = u->from[0]->shared.memory},
                                    .normals = {.memory = u->count > 1 ? u->from[1]->shared.memory : NULL}};
    SVO_I_TRY(svo_plan_update_from_buffers_enqueue(u->plan, &given, u->queue, wait_count(u), wait_list(u), &updated));
    return follow(u, "", CL_SUCCESS, updated);
}

/* ---- by interop ---- */

/* Waits for the caller's events and for the last updates from the buffers, which may be of other queues. Makes room for
   keep_released. */
static svo_status wait_first(update *u)
{
    cl_event all[SOURCES_MAX + 1];
    cl_uint count = 0;
    for (unsigned i = 0; i < u->count; ++i) {
        SVO_I_TRY(svo_i_in_flight_reserve(&u->from[i]->released, u->plan->device, FUNCTION));
        const cl_event released = svo_i_in_flight_newest(&u->from[i]->released);
        if (released != NULL) {
            all[count++] = released;
        }
    }
    if (count == 0) {
        return SVO_OK; /* the first acquire has the caller's list */
    }
    cl_event event = NULL;
    if (u->wait_count > 0) {
        const cl_int error = clEnqueueMarkerWithWaitList(u->queue, u->wait_count, u->wait, &event);
        SVO_I_TRY(follow(u, "clEnqueueMarkerWithWaitList", error, event));
        all[count++] = u->last;
    }
    const cl_int error = clEnqueueMarkerWithWaitList(u->queue, count, all, &event);
    return follow(u, "clEnqueueMarkerWithWaitList", error, event);
}

/* Keeps the release for what comes next. */
static svo_status keep_released(const update *u)
{
    for (unsigned i = 0; i < u->count; ++i) {
        SVO_I_TRY(svo_i_in_flight_add(&u->from[i]->released, u->plan->device, FUNCTION, u->last));
    }
    return SVO_OK;
}

/* Gives the buffers to OpenCL, or back. */
static svo_status pass(update *u, const char *call,
                       cl_int(CL_API_CALL *enqueue)(cl_command_queue, cl_uint, const cl_mem *, cl_uint,
                                                    const cl_event *, cl_event *))
{
    cl_mem objects[SOURCES_MAX];
    cl_event event = NULL;
    for (unsigned i = 0; i < u->count; ++i) {
        objects[i] = u->from[i]->shared.memory;
    }
    const cl_int error = enqueue(u->queue, u->count, objects, wait_count(u), wait_list(u), &event);
    return follow(u, call, error, event);
}

/* What was acquired is released, whatever the update does. */
static svo_status run_acquired(update *u)
{
    const svo_i_interop *interop = &u->from[0]->shared.interop;
    SVO_I_TRY(wait_first(u));
    SVO_I_TRY(pass(u, "clEnqueueAcquireGLObjects", interop->EnqueueAcquireGLObjects));
    const svo_status status = run(u);
    const svo_status released = pass(u, "clEnqueueReleaseGLObjects", interop->EnqueueReleaseGLObjects);
    SVO_I_TRY(status);
    SVO_I_TRY(released);
    return keep_released(u);
}

static svo_status run_current(update *u)
{
    const svo_i_share_buffer *shared = &u->from[0]->shared;
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(shared->context);
    gl->MemoryBarrier(GL_ALL_BARRIER_BITS);
    if (!shared->interop.has_gl_event) {
        gl->Finish();
    }
    const svo_status status = run_acquired(u);
    if (status == SVO_OK && shared->interop.has_gl_event) {
        const cl_int error = clFlush(u->queue);
        return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(u->plan->device, FUNCTION, "clFlush", error);
    }
    if (u->last != NULL) {
        (void)svo_i_event_settle(u->last);
    }
    return status;
}

static svo_status run_by_interop(update *u)
{
    svo_gl_context *context = u->from[0]->shared.context;
    SVO_I_TRY(svo_i_gl_context_make_current(context, &u->plan->device->message));
    const svo_status status = run_current(u);
    svo_i_gl_context_release_current(context);
    return status;
}

/* ---- by the host's memory, or a copy ---- */

static svo_status bring(const update *u)
{
    for (unsigned i = 0; i < u->count; ++i) {
        SVO_I_TRY(
            svo_i_share_buffer_to_cl(&u->from[i]->shared, (size_t)u->plan->vertex_count * VERTEX_BYTES, u->queue));
    }
    return SVO_OK;
}

/* Maps what OpenCL has; a buffer that cannot be mapped stays OpenCL's, and the other is mapped all the same. */
static svo_status take_back(const update *u)
{
    svo_status status = SVO_OK;
    for (unsigned i = 0; i < u->count; ++i) {
        svo_i_share_buffer *shared = &u->from[i]->shared;
        if (shared->share == SVO_GL_SHARE_HOST && shared->mapping_queue == NULL) {
            const svo_status mapped = svo_i_share_host_map(shared, CL_MAP_READ | CL_MAP_WRITE, u->queue);
            u->from[i]->is_in_cl = mapped != SVO_OK;
            status = status != SVO_OK ? status : mapped;
        }
    }
    return status;
}

static svo_status run_brought(update *u)
{
    SVO_I_TRY(bring(u));
    SVO_I_TRY(run(u));
    const cl_int error = clWaitForEvents(1, &u->last);
    if (error != CL_SUCCESS) {
        (void)svo_i_event_settle(u->last);
        return svo_i_device_fail_cl(u->plan->device, FUNCTION, "clWaitForEvents", error);
    }
    return SVO_OK;
}

static svo_status run_and_wait(update *u)
{
    const svo_status status = run_brought(u);
    const svo_status taken = take_back(u);
    return status != SVO_OK ? status : taken;
}

svo_status svo_gl_plan_update_enqueue(svo_plan *plan, svo_gl_buffer *positions, svo_gl_buffer *normals,
                                      cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (positions == NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, FUNCTION ": positions is NULL");
    }
    if (normals == positions) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, FUNCTION ": normals is positions");
    }
    update u = {.plan = plan,
                .from = {positions, normals},
                .count = normals != NULL ? 2 : 1,
                .queue = queue,
                .wait_count = num_wait,
                .wait = wait};
    SVO_I_TRY(check_buffer(&u, "positions", positions));
    SVO_I_TRY(normals != NULL ? check_buffer(&u, "normals", normals) : SVO_OK);
    SVO_I_TRY(svo_i_device_queue(plan->device, FUNCTION, queue, &u.queue));
    SVO_I_TRY(svo_i_device_check_wait(plan->device, FUNCTION, num_wait, wait));
    const svo_status status = positions->shared.share == SVO_GL_SHARE_INTEROP ? run_by_interop(&u) : run_and_wait(&u);
    if (status == SVO_OK && event != NULL) {
        *event = u.last;
    } else if (u.last != NULL) {
        clReleaseEvent(u.last);
    }
    return svo_i_gl_buffer_named(plan->device, FUNCTION, status);
}
