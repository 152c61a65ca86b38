/* SPDX-License-Identifier: MIT */
/* Buffers of both APIs, and how their content gets from one to the other. probe.c finds which path works. */
#include "share/share.h"

#include <string.h>

#include "core/message.h"
#include "core/staging.h"

/* ---- `host`, and what all paths need ---- */

/*
 * The share path `host`: OpenCL uses the memory of a persistently mapped OpenGL buffer in place.
 *
 * OpenCL 1.2, section 5.2.1 lets a device cache a CL_MEM_USE_HOST_PTR buffer. Others may use the memory only while it
 * is mapped, and unmapping makes their writes visible. On PoCL's CPU device both are nearly free.
 */

/* The first error of OpenGL since svo_i_gl_clear_errors. Expects the context current. */
static svo_status check_gl(const svo_i_share_buffer *buffer, const char *function, const char *step)
{
    return svo_i_gl_check(svo_i_gl_context_functions(buffer->context), function, step, &buffer->device->message);
}

/* Why glMapBufferRange returned NULL. Expects the context current. */
static svo_status fail_map(const svo_i_share_buffer *buffer, const char *function)
{
    SVO_I_TRY(check_gl(buffer, function, "glMapBufferRange"));
    return svo_i_device_fail(buffer->device, SVO_GL_ERROR, "%s: glMapBufferRange returned NULL", function);
}

/* The alignment that OpenCL requires of a buffer's first byte. The device property is in bits. */
static svo_status find_cl_alignment(svo_device *device, size_t *bytes)
{
    cl_uint bits = 0;
    const cl_int error = clGetDeviceInfo(device->device, CL_DEVICE_MEM_BASE_ADDR_ALIGN, sizeof bits, &bits, NULL);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, "svo_i_share_buffer_create", "clGetDeviceInfo", error);
    }
    *bytes = bits > 8 ? bits / 8 : 1;
    return SVO_OK;
}

/* Maps the whole OpenGL buffer persistently and finds the first byte that both APIs' alignments allow. */
static svo_status map_persistently(svo_i_share_buffer *buffer, size_t allocated_bytes, size_t alignment_bytes)
{
    static const GLbitfield access = GL_MAP_READ_BIT | GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    gl->BufferStorage(SVO_I_SHARE_WORK_TARGET, (GLsizeiptr)allocated_bytes, NULL, access);
    SVO_I_TRY(check_gl(buffer, "svo_i_share_buffer_create", "glBufferStorage"));
    unsigned char *mapped = gl->MapBufferRange(SVO_I_SHARE_WORK_TARGET, 0, (GLsizeiptr)allocated_bytes, access);
    if (mapped == NULL) {
        return fail_map(buffer, "svo_i_share_buffer_create");
    }
    size_t past_bytes = (size_t)((uintptr_t)mapped % alignment_bytes);
    buffer->offset_bytes = past_bytes == 0 ? 0 : alignment_bytes - past_bytes;
    buffer->pointer = mapped + buffer->offset_bytes;
    size_t gl_alignment_bytes = (size_t)gl->limits.storage_offset_alignment_bytes;
    if (gl_alignment_bytes > 1 && buffer->offset_bytes % gl_alignment_bytes != 0) {
        return svo_i_device_fail(buffer->device, SVO_UNSUPPORTED,
                                 "svo_i_share_buffer_create: offset %zu for OpenCL's alignment of %zu bytes is no "
                                 "multiple of OpenGL's %zu",
                                 buffer->offset_bytes, alignment_bytes, gl_alignment_bytes);
    }
    return SVO_OK;
}

/* Creates both sides of a buffer. Expects the context current and buffer->name bound to the target above. */
static svo_status host_create(svo_i_share_buffer *buffer)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    if (gl->BufferStorage == NULL) {
        return svo_i_device_fail(buffer->device, SVO_UNSUPPORTED,
                                 "svo_i_share_buffer_create: the context has no glBufferStorage");
    }
    size_t alignment_bytes = 1, allocated_bytes = 0;
    SVO_I_TRY(find_cl_alignment(buffer->device, &alignment_bytes));
    if (!svo_i_add_size(buffer->bytes, alignment_bytes - 1, &allocated_bytes)) {
        return svo_i_device_fail(buffer->device, SVO_OUT_OF_HOST_MEMORY,
                                 "svo_i_share_buffer_create: %zu bytes do not fit the address space", buffer->bytes);
    }
    SVO_I_TRY(map_persistently(buffer, allocated_bytes, alignment_bytes));
    cl_int error = CL_SUCCESS;
    buffer->memory = clCreateBuffer(buffer->device->context, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, buffer->bytes,
                                    buffer->pointer, &error);
    if (error != CL_SUCCESS) {
        buffer->memory = NULL;
        return svo_i_device_fail_cl(buffer->device, "svo_i_share_buffer_create", "clCreateBuffer(CL_MEM_USE_HOST_PTR)",
                                    error);
    }
    return SVO_OK;
}

svo_status svo_i_share_host_map(svo_i_share_buffer *buffer, cl_map_flags access, cl_command_queue queue)
{
    cl_int error = CL_SUCCESS;
    void *mapped = clEnqueueMapBuffer(queue, buffer->memory, CL_TRUE, access, 0, buffer->bytes, 0, NULL, NULL, &error);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(buffer->device, "svo_i_share_buffer_to_gl", "clEnqueueMapBuffer", error);
    }
    if (mapped != buffer->pointer) {
        (void)clEnqueueUnmapMemObject(queue, buffer->memory, mapped, 0, NULL, NULL);
        return svo_i_device_fail(buffer->device, SVO_UNSUPPORTED,
                                 "svo_i_share_buffer_to_gl: OpenCL does not map the buffer in place");
    }
    error = clRetainCommandQueue(queue);
    if (error != CL_SUCCESS) {
        (void)clEnqueueUnmapMemObject(queue, buffer->memory, mapped, 0, NULL, NULL);
        return svo_i_device_fail_cl(buffer->device, "svo_i_share_buffer_to_gl", "clRetainCommandQueue", error);
    }
    buffer->mapping_queue = queue;
    return SVO_OK;
}

/* Gives a mapped buffer back to OpenCL, waits, and releases the queue. */
static svo_status host_unmap(svo_i_share_buffer *buffer)
{
    cl_event done = NULL;
    cl_int error = clEnqueueUnmapMemObject(buffer->mapping_queue, buffer->memory, buffer->pointer, 0, NULL, &done);
    if (error == CL_SUCCESS) {
        error = clWaitForEvents(1, &done);
        clReleaseEvent(done);
    }
    clReleaseCommandQueue(buffer->mapping_queue);
    buffer->mapping_queue = NULL;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(buffer->device, "svo_i_share_buffer_to_cl", "clEnqueueUnmapMemObject", error);
    }
    return SVO_OK;
}

/* ---- `interop` ---- */

/*
 * The share path `interop`: an OpenGL buffer that is an OpenCL buffer too. Acquire and release pass it between the
 * APIs.
 *
 * OpenCL may touch the buffer only while it is acquired, OpenGL only while it is not (The OpenCL Extension
 * Specification, version 1.2, section 9.7.6). The host waits for the event of either call, so the caller's queue may be
 * out-of-order.
 */

/* Creates the OpenCL side of a buffer whose OpenGL side is allocated. */
static svo_status interop_create(svo_i_share_buffer *buffer)
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

/* Gives the buffer to OpenCL. After the return, commands of any queue may use it. */
static svo_status interop_acquire(svo_i_share_buffer *buffer, cl_command_queue queue)
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

/* Gives the buffer back to OpenGL. Does nothing for a buffer that is not acquired. */
static svo_status interop_release(svo_i_share_buffer *buffer)
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

/* ---- all paths ---- */

#define WORK_TARGET SVO_I_SHARE_WORK_TARGET

size_t svo_i_share_limit_bytes(const svo_device *device, const svo_gl_context *context)
{
    GLint64 block_bytes = svo_i_gl_context_functions(context)->limits.storage_block_bytes;
    cl_ulong limit_bytes = device->max_allocation_bytes;
    if (block_bytes < 0) {
        block_bytes = 0;
    }
    return (cl_ulong)block_bytes < limit_bytes ? (size_t)block_bytes : (size_t)limit_bytes;
}

static svo_status check_size(svo_device *device, const svo_gl_context *context, size_t bytes)
{
    unsigned long long block_bytes =
        (unsigned long long)svo_i_gl_context_functions(context)->limits.storage_block_bytes;
    unsigned long long allocation_bytes = device->max_allocation_bytes;
    if (bytes == 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_i_share_buffer_create: bytes is 0");
    }
    if (bytes > block_bytes) {
        return svo_i_device_fail(device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_i_share_buffer_create: %zu bytes are above OpenGL's storage block limit of %llu",
                                 bytes, block_bytes);
    }
    if (bytes > allocation_bytes) {
        return svo_i_device_fail(device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "svo_i_share_buffer_create: %zu bytes are above OpenCL's allocation limit of %llu",
                                 bytes, allocation_bytes);
    }
    return SVO_OK;
}

/* `copy`: one buffer per API. `interop`: one buffer for both. AUTO: an OpenGL buffer only. */
static svo_status create_allocated(svo_i_share_buffer *buffer)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    /* The GPU writes and reads it. Drivers put buffers for the host to read into system memory. */
    gl->BufferData(WORK_TARGET, (GLsizeiptr)buffer->bytes, NULL, GL_STATIC_COPY);
    SVO_I_TRY(check_gl(buffer, "svo_i_share_buffer_create", "glBufferData"));
    if (buffer->share == SVO_GL_SHARE_AUTO) {
        return SVO_OK;
    }
    if (buffer->share == SVO_GL_SHARE_INTEROP) {
        return interop_create(buffer);
    }
    return svo_i_device_buffer(buffer->device, "svo_i_share_buffer_create", "shared copy", CL_MEM_READ_WRITE,
                               buffer->bytes, &buffer->memory);
}

/* Creates both sides of a buffer whose device, context, share and bytes are set. Expects the context current. */
static svo_status create_current(svo_i_share_buffer *buffer)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    svo_i_gl_clear_errors(gl);
    gl->GenBuffers(1, &buffer->name);
    gl->BindBuffer(WORK_TARGET, buffer->name);
    svo_status status = buffer->share == SVO_GL_SHARE_HOST ? host_create(buffer) : create_allocated(buffer);
    gl->BindBuffer(WORK_TARGET, 0);
    return status;
}

svo_status svo_i_share_buffer_create(svo_device *device, svo_gl_context *context, svo_gl_share share, size_t bytes,
                                     svo_i_share_buffer *out)
{
    if (share < SVO_GL_SHARE_AUTO || share > SVO_GL_SHARE_COPY) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED, "svo_i_share_buffer_create: share %d is not a share path",
                                 (int)share);
    }
    SVO_I_TRY(check_size(device, context, bytes));
    SVO_I_TRY(svo_i_gl_context_make_current(context, &device->message));
    svo_i_share_buffer buffer = {.device = device, .context = context, .share = share, .bytes = bytes};
    const svo_status status = create_current(&buffer);
    if (status != SVO_OK) {
        svo_i_share_buffer_destroy(&buffer);
    } else {
        *out = buffer;
    }
    svo_i_gl_context_release_current(context);
    return status;
}

void svo_i_share_buffer_destroy(svo_i_share_buffer *buffer)
{
    if (buffer->mapping_queue != NULL) {
        (void)host_unmap(buffer);
    }
    const bool is_current = buffer->name != 0 && svo_i_gl_context_make_current_to_delete(buffer->context);
    (void)interop_release(buffer);
    if (buffer->memory != NULL) {
        clReleaseMemObject(buffer->memory);
    }
    if (is_current) {
        /* Deleting a mapped buffer also unmaps it. */
        svo_i_gl_context_functions(buffer->context)->DeleteBuffers(1, &buffer->name);
        svo_i_gl_context_release_current(buffer->context);
    }
    *buffer = (svo_i_share_buffer){0};
}

void svo_i_share_buffer_bind(const svo_i_share_buffer *buffer, GLuint binding)
{
    svo_i_gl_context_functions(buffer->context)
        ->BindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, buffer->name, (GLintptr)buffer->offset_bytes,
                          (GLsizeiptr)buffer->bytes);
}

svo_status svo_i_share_buffer_read_gl(const svo_i_share_buffer *buffer, size_t first, size_t bytes, void *to)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    if (buffer->pointer != NULL) {
        memcpy(to, buffer->pointer + first, bytes);
        return SVO_OK;
    }
    gl->BindBuffer(SVO_I_SHARE_WORK_TARGET, buffer->name);
    gl->GetBufferSubData(SVO_I_SHARE_WORK_TARGET, (GLintptr)(buffer->offset_bytes + first), (GLsizeiptr)bytes, to);
    return check_gl(buffer, "svo_i_share_buffer_read_gl", "glGetBufferSubData");
}

svo_status svo_i_share_buffer_write_gl(const svo_i_share_buffer *buffer, size_t first, size_t bytes, const void *from)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    if (buffer->pointer != NULL) {
        memcpy(buffer->pointer + first, from, bytes);
        return SVO_OK;
    }
    gl->BindBuffer(SVO_I_SHARE_WORK_TARGET, buffer->name);
    gl->BufferSubData(SVO_I_SHARE_WORK_TARGET, (GLintptr)(buffer->offset_bytes + first), (GLsizeiptr)bytes, from);
    return check_gl(buffer, "svo_i_share_buffer_write_gl", "glBufferSubData");
}

static svo_status release_to_gl(svo_i_share_buffer *buffer)
{
    SVO_I_TRY(svo_i_gl_context_make_current(buffer->context, &buffer->device->message));
    const svo_status status = interop_release(buffer);
    svo_i_gl_context_release_current(buffer->context);
    return status;
}

svo_status svo_i_share_buffer_to_gl(svo_i_share_buffer *buffer, cl_command_queue queue)
{
    if (buffer->share == SVO_GL_SHARE_INTEROP) {
        return release_to_gl(buffer);
    }
    if (buffer->share != SVO_GL_SHARE_HOST || buffer->mapping_queue != NULL) {
        return SVO_OK;
    }
    return svo_i_share_host_map(buffer, CL_MAP_WRITE_INVALIDATE_REGION, queue);
}

/* Expects buffer->name bound to WORK_TARGET. */
static svo_status copy_bound_to_cl(const svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    const void *mapped = gl->MapBufferRange(WORK_TARGET, 0, (GLsizeiptr)used_bytes, GL_MAP_READ_BIT);
    if (mapped == NULL) {
        return fail_map(buffer, "svo_i_share_buffer_to_cl");
    }
    const svo_status status =
        svo_i_device_write(buffer->device, "svo_i_share_buffer_to_cl", queue, buffer->memory, 0, mapped, used_bytes);
    bool intact = gl->UnmapBuffer(WORK_TARGET) == GL_TRUE;
    SVO_I_TRY(status);
    if (!intact) {
        return svo_i_device_fail(buffer->device, SVO_GL_ERROR,
                                 "svo_i_share_buffer_to_cl: glUnmapBuffer reports that the content was lost");
    }
    return SVO_OK;
}

static svo_status copy_to_cl(const svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    gl->BindBuffer(WORK_TARGET, buffer->name);
    svo_status status = copy_bound_to_cl(buffer, used_bytes, queue);
    gl->BindBuffer(WORK_TARGET, 0);
    return status;
}

static svo_status to_cl_current(svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    bool is_host = buffer->share == SVO_GL_SHARE_HOST;
    if (buffer->share == SVO_GL_SHARE_INTEROP) {
        gl->MemoryBarrier(GL_ALL_BARRIER_BITS);
        svo_status status = interop_acquire(buffer, queue);
        svo_status written = check_gl(buffer, "svo_i_share_buffer_to_cl", "OpenGL's work on the buffer");
        return written != SVO_OK ? written : status;
    }
    gl->MemoryBarrier(is_host ? GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT : GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->Finish();
    svo_status drawn = check_gl(buffer, "svo_i_share_buffer_to_cl", "OpenGL's work on the buffer");
    if (is_host) {
        svo_status status = host_unmap(buffer);
        return drawn != SVO_OK ? drawn : status;
    }
    SVO_I_TRY(drawn);
    return used_bytes > 0 ? copy_to_cl(buffer, used_bytes, queue) : SVO_OK;
}

svo_status svo_i_share_buffer_to_cl(svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue)
{
    if (used_bytes > buffer->bytes) {
        return svo_i_device_fail(buffer->device, SVO_INTERNAL,
                                 "svo_i_share_buffer_to_cl: used_bytes %zu is above the buffer's %zu", used_bytes,
                                 buffer->bytes);
    }
    if (buffer->share == SVO_GL_SHARE_HOST && buffer->mapping_queue == NULL) {
        return svo_i_device_fail(buffer->device, SVO_INTERNAL,
                                 "svo_i_share_buffer_to_cl: the buffer was not given to OpenGL first");
    }
    SVO_I_TRY(svo_i_gl_context_make_current(buffer->context, &buffer->device->message));
    const svo_status status = to_cl_current(buffer, used_bytes, queue);
    svo_i_gl_context_release_current(buffer->context);
    return status;
}

/* ---- from OpenCL to OpenGL ---- */

static svo_status begin_cl_current(svo_i_share_buffer *buffer, cl_command_queue queue)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    if (buffer->share == SVO_GL_SHARE_INTEROP) {
        return buffer->acquiring_queue == NULL ? interop_acquire(buffer, queue) : SVO_OK;
    }
    if (buffer->mapping_queue != NULL) { /* OpenGL may still read what is about to be overwritten */
        gl->Finish();
        return host_unmap(buffer);
    }
    return SVO_OK;
}

svo_status svo_i_share_buffer_begin_cl(svo_i_share_buffer *buffer, cl_command_queue queue)
{
    SVO_I_TRY(svo_i_gl_context_make_current(buffer->context, &buffer->device->message));
    const svo_status status = begin_cl_current(buffer, queue);
    svo_i_gl_context_release_current(buffer->context);
    return status;
}

/* The device writes into OpenGL's memory, as the driver maps it. Expects buffer->name bound to WORK_TARGET. */
static svo_status copy_bound_to_gl(const svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue)
{
    static const char function[] = "svo_i_share_buffer_end_cl";
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    void *mapped =
        gl->MapBufferRange(WORK_TARGET, 0, (GLsizeiptr)used_bytes, GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
    if (mapped == NULL) {
        return fail_map(buffer, function);
    }
    const cl_int error = clEnqueueReadBuffer(queue, buffer->memory, CL_TRUE, 0, used_bytes, mapped, 0, NULL, NULL);
    const bool intact = gl->UnmapBuffer(WORK_TARGET) == GL_TRUE;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(buffer->device, function, "clEnqueueReadBuffer", error);
    }
    return intact ? SVO_OK
                  : svo_i_device_fail(buffer->device, SVO_GL_ERROR,
                                      "%s: glUnmapBuffer reports that the content was lost", function);
}

static svo_status end_cl_current(svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(buffer->context);
    if (buffer->share == SVO_GL_SHARE_INTEROP) {
        return interop_release(buffer);
    }
    if (buffer->share == SVO_GL_SHARE_HOST) {
        return buffer->mapping_queue == NULL ? svo_i_share_host_map(buffer, CL_MAP_READ | CL_MAP_WRITE, queue) : SVO_OK;
    }
    if (used_bytes == 0) {
        return SVO_OK;
    }
    svo_i_gl_clear_errors(gl);
    gl->BindBuffer(WORK_TARGET, buffer->name);
    const svo_status status = copy_bound_to_gl(buffer, used_bytes, queue);
    gl->BindBuffer(WORK_TARGET, 0);
    return status;
}

svo_status svo_i_share_buffer_end_cl(svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue)
{
    if (used_bytes > buffer->bytes) {
        return svo_i_device_fail(buffer->device, SVO_INVALID_ARGUMENT,
                                 "svo_i_share_buffer_end_cl: used_bytes %zu is above the buffer's %zu", used_bytes,
                                 buffer->bytes);
    }
    SVO_I_TRY(svo_i_gl_context_make_current(buffer->context, &buffer->device->message));
    const svo_status status = end_cl_current(buffer, used_bytes, queue);
    svo_i_gl_context_release_current(buffer->context);
    return status;
}
