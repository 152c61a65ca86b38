/* SPDX-License-Identifier: MIT */
/*
 * Sharing the fragment list between OpenGL, which writes it, and OpenCL, which builds the tree of it.
 *
 * A shared buffer goes back and forth: svo_i_share_buffer_to_gl gives it to OpenGL, the front end binds and fills it,
 * and svo_i_share_buffer_to_cl gives its first bytes to OpenCL. What lies between differs per share path, the bytes
 * never do.
 *
 * The paths: `host` lets OpenCL use the memory of a persistently mapped OpenGL buffer in place; `copy` keeps a buffer
 * on either side; `sharing` is one buffer of both by cl_khr_gl_sharing, where the probe has proven it (sharing.h).
 */
#ifndef SVO_GLINTEROP_SHARE_SHARE_H
#define SVO_GLINTEROP_SHARE_SHARE_H

#include "share/shared_buffer.h"

/* The most bytes a shared buffer can have: the smaller of OpenGL's storage block and OpenCL's largest allocation. */
size_t svo_i_share_limit_bytes(const svo_device *device, const svo_gl_context *context);

/*
 * Makes a buffer of bytes (not 0) that both sides can use; it belongs to OpenCL at first and its content is undefined.
 *
 * share: SHARING, HOST or COPY, as chosen by svo_i_share_probe; AUTO: a buffer of OpenGL alone, which never goes to
 * OpenCL and has no memory there. *out is written on success only.
 * Returns SVO_OUT_OF_DEVICE_MEMORY naming bytes and limit, SVO_UNSUPPORTED, SVO_CL_ERROR or SVO_GL_ERROR, with the
 * words in the device's message. This and the functions below make the context current by themselves.
 */
svo_status svo_i_share_buffer_create(svo_device *device, svo_gl_context *context, svo_gl_share share, size_t bytes,
                                     svo_i_share_buffer *out);
/* Releases both sides; a zeroed buffer is allowed. OpenCL's work on it must have completed. */
void svo_i_share_buffer_destroy(svo_i_share_buffer *buffer);

/* Binds the shared bytes as a shader storage block. Expects the context current, unlike the others. */
void svo_i_share_buffer_bind(const svo_i_share_buffer *buffer, GLuint binding);

/* Gives the buffer to OpenGL to write; what it held is lost. OpenCL's work on it must have completed. */
svo_status svo_i_share_buffer_to_gl(svo_i_share_buffer *buffer, cl_command_queue queue);
/* Waits for OpenGL, then makes the first used_bytes visible in memory for every command enqueued after the return.
   Expects a svo_i_share_buffer_to_gl before. */
svo_status svo_i_share_buffer_to_cl(svo_i_share_buffer *buffer, size_t used_bytes, cl_command_queue queue);

#endif
