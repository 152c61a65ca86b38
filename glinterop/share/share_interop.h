/* SPDX-License-Identifier: MIT */
/* The share path `interop`. All expect the OpenGL context current and report failures in the device's message. */
#ifndef SVO_GLINTEROP_SHARE_SHARE_INTEROP_H
#define SVO_GLINTEROP_SHARE_SHARE_INTEROP_H

#include "share/shared_buffer.h"

/* Creates the OpenCL side of a buffer whose OpenGL side is allocated. */
svo_status svo_i_share_interop_create(svo_i_share_buffer *buffer);
/* Gives the buffer to OpenCL. After the return, commands of any queue may use it. */
svo_status svo_i_share_interop_acquire(svo_i_share_buffer *buffer, cl_command_queue queue);
/* Gives the buffer back to OpenGL. Does nothing for a buffer that is not acquired. */
svo_status svo_i_share_interop_release(svo_i_share_buffer *buffer);

#endif
