/* SPDX-License-Identifier: MIT */
/*
 * Buffers of callers: meshes that are read from them; kernels of theirs or of svocl write them, and OpenGL reads; or
 * the other way, updates of plans from vertices that OpenGL has written.
 */
#include "context/context.h"
#include "core/device.h"
#include "core/mesh.h"
#include "core/message.h"
#include "core/struct_size.h"
#include "core/submit.h"
#include "core/work.h"
#include "plan/plan_data.h"
#include "share/probe.h"
#include "share/share.h"

/* ---- meshes ---- */

#define MESH_READ "svo_gl_mesh_read"

static bool has_name(const svo_mesh_view *view)
{
    return view->gl_buffer != 0;
}

/* For a name that is no buffer, glBindBuffer fails in a core profile and creates one in other profiles. */
static svo_status bind_view(const svo_i_gl_functions *gl, const svo_mesh_view *view, svo_message *message)
{
    const bool is_buffer = gl->IsBuffer(view->gl_buffer) == GL_TRUE;
    SVO_I_TRY(svo_i_gl_check(gl, MESH_READ, "glIsBuffer", message));
    if (!is_buffer) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, MESH_READ ": %u is no buffer of the context", view->gl_buffer);
    }
    gl->BindBuffer(SVO_I_SHARE_WORK_TARGET, view->gl_buffer);
    return svo_i_gl_check(gl, MESH_READ, "glBindBuffer", message);
}

static svo_status buffer_size(void *self, const char *name, const svo_mesh_view *view, size_t *bytes,
                              svo_message *message)
{
    (void)name;
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(self);
    GLint64 held_bytes = 0;
    SVO_I_TRY(bind_view(gl, view, message));
    gl->GetBufferParameteri64v(SVO_I_SHARE_WORK_TARGET, GL_BUFFER_SIZE, &held_bytes);
    *bytes = held_bytes > 0 ? (size_t)held_bytes : 0;
    return svo_i_gl_check(gl, MESH_READ, "glGetBufferParameteri64v", message);
}

static svo_status read_buffer(void *self, const svo_mesh_view *view, size_t offset_bytes, size_t bytes, void *to,
                              svo_message *message)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(self);
    SVO_I_TRY(bind_view(gl, view, message));
    gl->GetBufferSubData(SVO_I_SHARE_WORK_TARGET, (GLintptr)offset_bytes, (GLsizeiptr)bytes, to);
    return svo_i_gl_check(gl, MESH_READ, "glGetBufferSubData", message);
}

/* One by one: the host waits, so the events may be of different contexts. */
static svo_status wait_for(cl_uint num_wait, const cl_event *wait, svo_message *message)
{
    cl_int error = CL_SUCCESS;
    if ((num_wait > 0) != (wait != NULL)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, MESH_READ ": num_wait and wait disagree");
    }
    for (cl_uint i = 0; i < num_wait && error == CL_SUCCESS; ++i) {
        error = clWaitForEvents(1, &wait[i]);
    }
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_fail(message, SVO_CL_ERROR, MESH_READ ": clWaitForEvents failed with %s (%d)",
                                            svo_i_cl_error_name(error), error);
}

static svo_status read_current(const svo_mesh_buffers *buffers, svo_gl_context *context, svo_mesh_copy **out,
                               svo_message *message)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    const svo_i_mesh_reader reader = {
        .function = MESH_READ, .self = context, .has = has_name, .size = buffer_size, .read = read_buffer};
    svo_i_gl_clear_errors(gl);
    /* Makes writes by shaders visible. */
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    return svo_i_mesh_read(buffers, &reader, out, message);
}

svo_status svo_gl_mesh_read(const svo_mesh_buffers *buffers, svo_gl_context *context, cl_uint num_wait,
                            const cl_event *wait, svo_mesh_copy **out, svo_message *message)
{
    if (buffers == NULL || context == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, MESH_READ ": %s is NULL",
                          buffers == NULL   ? "buffers"
                          : context == NULL ? "context"
                                            : "out");
    }
    SVO_I_TRY(wait_for(num_wait, wait, message));
    SVO_I_TRY(svo_i_gl_context_make_current(context, message));
    const svo_status status = read_current(buffers, context, out, message);
    svo_i_gl_context_release_current(context);
    return status;
}

/* ---- shared buffers ---- */

struct svo_gl_buffer {
    svo_i_share_buffer shared;
    svo_i_share_reasons reasons;
    bool is_in_cl; /* between svo_gl_buffer_to_cl and svo_gl_buffer_to_gl */
    svo_i_in_flight released; /* by interop: the ends of updates from it */
};

/* Names the public function in the message of a failure inside. */
static svo_status named(svo_device *device, const char *function, svo_status status)
{
    if (status != SVO_OK) {
        svo_i_message_rename(&device->message, function);
    }
    return status;
}

/* Waits until no update from the buffer is in flight. */
static void settle(svo_gl_buffer *buffer)
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
    SVO_I_TRY_CLEANUP(
        named(device, function, svo_i_share_buffer_create(device, context, choice, bytes, &buffer->shared)));
    if (choice == SVO_GL_SHARE_HOST) {
        SVO_I_TRY_CLEANUP(named(device, function, give_to_gl(&buffer->shared, function)));
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
    settle(*buffer);
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
    settle(buffer);
    SVO_I_TRY(named(device, function, svo_i_share_buffer_begin_cl(&buffer->shared, queue)));
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
    SVO_I_TRY(named(device, function, svo_i_share_buffer_end_cl(&buffer->shared, used_bytes, queue)));
    buffer->is_in_cl = false;
    return SVO_OK;
}

/* ---- updates ---- */

/*
 * Updates of plans from vertices that OpenGL has written. With `interop` acquire, update and release are commands like
 * any other; cl_khr_gl_event orders them with OpenGL's (The OpenCL Extension Specification, version 1.2, section 9.8),
 * and without it the host does. The other ways wait for OpenGL before and for OpenCL after, since the memory is
 * OpenGL's again when the call returns.
 */

#define UPDATE       "svo_gl_plan_update"
#define VERTEX_BYTES 12
#define SOURCES_MAX  2

/* The buffers of one update, and its commands. */
typedef struct update {
    svo_plan *plan;
    svo_gl_buffer *from[SOURCES_MAX]; /* positions, normals */
    unsigned count;
    svo_i_call call;
    cl_event last; /* the newest command; NULL at first */
} update;

static svo_status check_buffer(const update *u, const char *name, const svo_gl_buffer *buffer)
{
    svo_device *device = u->plan->device;
    const uint64_t needed = (uint64_t)u->plan->vertex_count * VERTEX_BYTES;
    if (buffer->shared.device != device || buffer->shared.context != u->from[0]->shared.context) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, UPDATE ": %s is of another device or context", name);
    }
    if (buffer->shared.share != u->from[0]->shared.share) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, UPDATE ": %s is shared by %s, positions by %s", name,
                                 svo_name(SVO_NAME_GL_SHARE, buffer->shared.share),
                                 svo_name(SVO_NAME_GL_SHARE, u->from[0]->shared.share));
    }
    if (buffer->is_in_cl) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, UPDATE ": %s is OpenCL's; see svo_gl_buffer_to_gl",
                                 name);
    }
    if (buffer->shared.bytes < needed) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, UPDATE ": %s has %zu bytes, the plan's vertices %llu",
                                 name, buffer->shared.bytes, (unsigned long long)needed);
    }
    return SVO_OK;
}

/* Makes event the newest command, or converts the error of its call into a status. */
static svo_status follow(update *u, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(u->plan->device, UPDATE, call, error);
    }
    if (u->last != NULL) {
        clReleaseEvent(u->last);
    }
    u->last = event;
    return SVO_OK;
}

static cl_uint wait_count(const update *u)
{
    return u->last != NULL ? 1 : u->call.num_wait;
}

static const cl_event *wait_list(const update *u)
{
    return u->last != NULL ? &u->last : u->call.wait;
}

static svo_status run(update *u)
{
    cl_event updated = NULL;
    const svo_mesh_buffers given = {.struct_size = sizeof given,
                                    .vertex_count = u->plan->vertex_count,
                                    .triangle_count = u->plan->triangle_count,
                                    .positions = {.memory = u->from[0]->shared.memory},
                                    .normals = {.memory = u->count > 1 ? u->from[1]->shared.memory : NULL}};
    const svo_submit submit = {
        .queue = u->call.queue, .num_wait = wait_count(u), .wait = wait_list(u), .event = &updated};
    SVO_I_TRY(svo_plan_update_from_buffers(u->plan, &given, &submit));
    return follow(u, "", CL_SUCCESS, updated);
}

/* ---- updates by interop ---- */

/* Waits for the caller's events and for the last updates from the buffers, which may be of other queues. Makes room for
   keep_released. */
static svo_status wait_first(update *u)
{
    cl_event all[SOURCES_MAX + 1];
    cl_uint count = 0;
    for (unsigned i = 0; i < u->count; ++i) {
        SVO_I_TRY(svo_i_in_flight_reserve(&u->from[i]->released, u->plan->device, UPDATE));
        const cl_event released = svo_i_in_flight_newest(&u->from[i]->released);
        if (released != NULL) {
            all[count++] = released;
        }
    }
    if (count == 0) {
        return SVO_OK; /* the first acquire has the caller's list */
    }
    cl_event event = NULL;
    if (u->call.num_wait > 0) {
        const cl_int error = clEnqueueMarkerWithWaitList(u->call.queue, u->call.num_wait, u->call.wait, &event);
        SVO_I_TRY(follow(u, "clEnqueueMarkerWithWaitList", error, event));
        all[count++] = u->last;
    }
    const cl_int error = clEnqueueMarkerWithWaitList(u->call.queue, count, all, &event);
    return follow(u, "clEnqueueMarkerWithWaitList", error, event);
}

/* Keeps the release for what comes next. */
static svo_status keep_released(const update *u)
{
    for (unsigned i = 0; i < u->count; ++i) {
        SVO_I_TRY(svo_i_in_flight_add(&u->from[i]->released, u->plan->device, UPDATE, u->last));
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
    const cl_int error = enqueue(u->call.queue, u->count, objects, wait_count(u), wait_list(u), &event);
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
        const cl_int error = clFlush(u->call.queue);
        return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(u->plan->device, UPDATE, "clFlush", error);
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

/* ---- updates by the host's memory, or a copy ---- */

static svo_status bring(const update *u)
{
    for (unsigned i = 0; i < u->count; ++i) {
        SVO_I_TRY(
            svo_i_share_buffer_to_cl(&u->from[i]->shared, (size_t)u->plan->vertex_count * VERTEX_BYTES, u->call.queue));
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
            const svo_status mapped = svo_i_share_host_map(shared, CL_MAP_READ | CL_MAP_WRITE, u->call.queue);
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
        return svo_i_device_fail_cl(u->plan->device, UPDATE, "clWaitForEvents", error);
    }
    return SVO_OK;
}

static svo_status run_and_wait(update *u)
{
    const svo_status status = run_brought(u);
    const svo_status taken = take_back(u);
    return status != SVO_OK ? status : taken;
}

svo_status svo_gl_plan_update(svo_plan *plan, svo_gl_buffer *positions, svo_gl_buffer *normals,
                              const svo_submit *submit)
{
    if (plan == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (positions == NULL) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, UPDATE ": positions is NULL");
    }
    if (normals == positions) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, UPDATE ": normals is positions");
    }
    update u = {.plan = plan, .from = {positions, normals}, .count = normals != NULL ? 2 : 1};
    SVO_I_TRY(check_buffer(&u, "positions", positions));
    SVO_I_TRY(normals != NULL ? check_buffer(&u, "normals", normals) : SVO_OK);
    SVO_I_TRY(svo_i_call_begin(plan->device, UPDATE, submit, &u.call));
    const svo_status status = positions->shared.share == SVO_GL_SHARE_INTEROP ? run_by_interop(&u) : run_and_wait(&u);
    if (status == SVO_OK && u.call.event != NULL) {
        *u.call.event = u.last;
    } else if (u.last != NULL) {
        clReleaseEvent(u.last);
    }
    return named(plan->device, UPDATE, svo_i_call_end(&u.call, status));
}
