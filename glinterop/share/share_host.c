/* SPDX-License-Identifier: MIT */
/*
 * The share path `host`: OpenCL uses the memory of a persistently mapped OpenGL buffer in place.
 *
 * OpenCL 1.2, section 5.2.1 lets a device cache a CL_MEM_USE_HOST_PTR buffer. Others may use the memory only while it
 * is mapped, and unmapping makes their writes visible. On PoCL's CPU device both are nearly free.
 */
#include "share/share_host.h"

#include "core/message.h"

svo_status svo_i_share_check_gl(const svo_i_share_buffer *buffer, const char *function, const char *step)
{
    return svo_i_gl_check(svo_i_gl_context_functions(buffer->context), function, step, &buffer->device->message);
}

svo_status svo_i_share_fail_map(const svo_i_share_buffer *buffer, const char *function)
{
    SVO_I_TRY(svo_i_share_check_gl(buffer, function, "glMapBufferRange"));
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
    SVO_I_TRY(svo_i_share_check_gl(buffer, "svo_i_share_buffer_create", "glBufferStorage"));
    unsigned char *mapped = gl->MapBufferRange(SVO_I_SHARE_WORK_TARGET, 0, (GLsizeiptr)allocated_bytes, access);
    if (mapped == NULL) {
        return svo_i_share_fail_map(buffer, "svo_i_share_buffer_create");
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

svo_status svo_i_share_host_create(svo_i_share_buffer *buffer)
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

svo_status svo_i_share_host_unmap(svo_i_share_buffer *buffer)
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
