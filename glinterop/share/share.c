/* SPDX-License-Identifier: MIT */
/* Buffers of both APIs, and how their content gets from one to the other. probe.c finds which path works. */
#include "share/share.h"

#include "core/message.h"
#include "share/share_host.h"
#include "share/share_interop.h"

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
    SVO_I_TRY(svo_i_share_check_gl(buffer, "svo_i_share_buffer_create", "glBufferData"));
    if (buffer->share == SVO_GL_SHARE_AUTO) {
        return SVO_OK;
    }
    if (buffer->share == SVO_GL_SHARE_INTEROP) {
        return svo_i_share_interop_create(buffer);
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
    svo_status status = buffer->share == SVO_GL_SHARE_HOST ? svo_i_share_host_create(buffer) : create_allocated(buffer);
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
        (void)svo_i_share_host_unmap(buffer);
    }
    const bool is_current = buffer->name != 0 && svo_i_gl_context_make_current_to_delete(buffer->context);
    (void)svo_i_share_interop_release(buffer);
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

static svo_status release_to_gl(svo_i_share_buffer *buffer)
{
    SVO_I_TRY(svo_i_gl_context_make_current(buffer->context, &buffer->device->message));
    const svo_status status = svo_i_share_interop_release(buffer);
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
        return svo_i_share_fail_map(buffer, "svo_i_share_buffer_to_cl");
    }
    cl_int error = clEnqueueWriteBuffer(queue, buffer->memory, CL_TRUE, 0, used_bytes, mapped, 0, NULL, NULL);
    bool intact = gl->UnmapBuffer(WORK_TARGET) == GL_TRUE;
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(buffer->device, "svo_i_share_buffer_to_cl", "clEnqueueWriteBuffer", error);
    }
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
        svo_status status = svo_i_share_interop_acquire(buffer, queue);
        svo_status written = svo_i_share_check_gl(buffer, "svo_i_share_buffer_to_cl", "OpenGL's work on the buffer");
        return written != SVO_OK ? written : status;
    }
    gl->MemoryBarrier(is_host ? GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT : GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->Finish();
    svo_status drawn = svo_i_share_check_gl(buffer, "svo_i_share_buffer_to_cl", "OpenGL's work on the buffer");
    if (is_host) {
        svo_status status = svo_i_share_host_unmap(buffer);
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
        return buffer->acquiring_queue == NULL ? svo_i_share_interop_acquire(buffer, queue) : SVO_OK;
    }
    if (buffer->mapping_queue != NULL) { /* OpenGL may still read what is about to be overwritten */
        gl->Finish();
        return svo_i_share_host_unmap(buffer);
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
        return svo_i_share_fail_map(buffer, function);
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
        return svo_i_share_interop_release(buffer);
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
