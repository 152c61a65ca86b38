/* SPDX-License-Identifier: MIT */
/* The share path `host`, and what all paths need of OpenGL. Failures are in the device's message. */
#ifndef SVO_GLINTEROP_SHARE_SHARE_HOST_H
#define SVO_GLINTEROP_SHARE_SHARE_HOST_H

#include "share/shared_buffer.h"

/* svocl draws nothing from this binding point, so its use disturbs no state. */
#define SVO_I_SHARE_WORK_TARGET GL_COPY_READ_BUFFER

/* The first error of OpenGL since svo_i_gl_clear_errors. Expects the context current. */
svo_status svo_i_share_check_gl(const svo_i_share_buffer *buffer, const char *function, const char *step);
/* Why glMapBufferRange returned NULL. Expects the context current. */
svo_status svo_i_share_fail_map(const svo_i_share_buffer *buffer, const char *function);

/* Creates both sides of a buffer. Expects the context current and buffer->name bound to the target above. */
svo_status svo_i_share_host_create(svo_i_share_buffer *buffer);
/* Gives the buffer to OpenGL, and waits. access: what OpenGL does with it, as clEnqueueMapBuffer has it. */
svo_status svo_i_share_host_map(svo_i_share_buffer *buffer, cl_map_flags access, cl_command_queue queue);
/* Gives a mapped buffer back to OpenCL, waits, and releases the queue. */
svo_status svo_i_share_host_unmap(svo_i_share_buffer *buffer);

#endif
