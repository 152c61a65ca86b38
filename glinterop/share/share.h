/* SPDX-License-Identifier: MIT */
/*
 * Buffers of both APIs.
 *
 * The fragment list is written by OpenGL and read by OpenCL: svo_i_share_buffer_to_gl gives a buffer to OpenGL, the
 * rasterizer binds and fills it, and svo_i_share_buffer_to_cl gives its first bytes to OpenCL. Pictures go the other
 * way: svo_i_share_buffer_begin_cl, kernels, svo_i_share_buffer_end_cl. The share paths differ in how they do this,
 * never in the bytes.
 *
 * `interop` is one buffer for both APIs by cl_khr_gl_sharing, where probe.c has shown that it works. With `host`,
 * OpenCL uses the memory of a persistently mapped OpenGL buffer in place. `copy` keeps one buffer per API.
 *
 * The files of this room:
 *
 *   share       buffers of both APIs, by three paths
 *   probe       which of the paths work
 *   interop     cl_khr_gl_sharing, and device handles that have it
 *   candidates  the context that suits a device, and the one of a name
 *   buffer      callers' buffers: meshes in them, sharing, updates of plans
 */
#ifndef SVO_GLINTEROP_SHARE_SHARE_H
#define SVO_GLINTEROP_SHARE_SHARE_H

#include <stddef.h>

#include "core/device.h"
#include "share/interop.h"

typedef struct svo_i_share_buffer {
    svo_device *device;
    svo_gl_context *context;
    svo_gl_share share;
    size_t bytes;
    GLuint name; /* the OpenGL buffer */
    size_t offset_bytes; /* where the shared bytes begin in it: OpenCL may require a coarser alignment */
    cl_mem memory; /* the OpenCL buffer; its byte 0 is the OpenGL buffer's byte offset_bytes */

    /* host */
    unsigned char *pointer; /* the mapped shared bytes; NULL for other paths */
    cl_command_queue mapping_queue; /* not NULL while OpenCL has memory mapped: OpenGL may write */

    /* interop */
    svo_i_interop interop; /* the extension's functions */
    cl_command_queue acquiring_queue; /* not NULL while OpenCL has acquired memory: OpenGL must not write */
} svo_i_share_buffer;

/* The share path `host`, and what all paths need of OpenGL. Failures are in the device's message. */

/* svocl draws nothing from this binding point, and state.c restores it, so its use disturbs no state. */
#define SVO_I_SHARE_WORK_TARGET GL_COPY_READ_BUFFER

/* Gives the buffer to OpenGL, and waits. access: what OpenGL does with it, as clEnqueueMapBuffer has it. */
svo_status svo_i_share_host_map(svo_i_share_buffer *buffer, cl_map_flags access, cl_command_queue queue);

/* The largest shared buffer: the smaller of OpenGL's storage block limit and OpenCL's allocation limit. */
size_t svo_i_share_limit_bytes(const svo_device *device, const svo_gl_context *context);

/*
 * Creates a buffer that both APIs can use. It belongs to OpenCL at first; its content is undefined. This and the
 * functions below make the context current unless they say otherwise.
 *
 * share: INTEROP, HOST or COPY, a path that svo_i_share_probe has found to work; AUTO: an OpenGL buffer without OpenCL
 * memory. bytes: not 0. *out is written on success only.
 * Returns SVO_OUT_OF_DEVICE_MEMORY naming bytes and limit, SVO_UNSUPPORTED, SVO_CL_ERROR or SVO_GL_ERROR, with the
 * reason in the device's message.
 */
svo_status svo_i_share_buffer_create(svo_device *device, svo_gl_context *context, svo_gl_share share, size_t bytes,
                                     svo_i_share_buffer *out);
/* Releases both sides. Accepts a zeroed buffer. OpenCL's work on it must have completed. */
void svo_i_share_buffer_destroy(svo_i_share_buffer *buffer);

/* Binds the shared bytes as a shader storage block. Expects the context current. */
void svo_i_share_buffer_bind(const svo_i_share_buffer *buffer, GLuint binding);

/* Gives the buffer to OpenGL for writing and discards its content. OpenCL's work on it must have completed. */
svo_status svo_i_share_buffer_to_gl(svo_i_share_buffer *buffer, cl_command_queue queue);
/* Waits for OpenGL, then makes the first used_bytes visible to every OpenCL command enqueued after the return. Call
   svo_i_share_buffer_to_gl first. */
svo_status svo_i_share_buffer_to_cl(svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue);

/* Copies bytes to and from the host while the buffer is OpenGL's, after its commands. Expect the context current. */
svo_status svo_i_share_buffer_read_gl(const svo_i_share_buffer *buffer, size_t first, size_t bytes, void *to);
svo_status svo_i_share_buffer_write_gl(const svo_i_share_buffer *buffer, size_t first, size_t bytes, const void *from);

/* Gives the buffer to OpenCL for writing, after OpenGL's commands that read it. */
svo_status svo_i_share_buffer_begin_cl(svo_i_share_buffer *buffer, cl_command_queue queue);
/* Makes the first used_bytes visible to every OpenGL command after the return. OpenCL's work on it must have completed.
   Call svo_i_share_buffer_begin_cl first. */
svo_status svo_i_share_buffer_end_cl(svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue);

#endif
