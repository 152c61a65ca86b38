/* SPDX-License-Identifier: MIT */
/* The share path `sharing`, for share.c. All expect the OpenGL context current; words of failures are with the
   device. */
#ifndef SVO_GLINTEROP_SHARE_SHARE_INTEROP_H
#define SVO_GLINTEROP_SHARE_SHARE_INTEROP_H

#include "share/shared_buffer.h"

/* The OpenCL side of a buffer whose OpenGL side has its size. */
svo_status svo_i_share_interop_create(svo_i_share_buffer *buffer);
/* OpenCL may use the buffer when this has returned, in commands of any queue. */
svo_status svo_i_share_interop_acquire(svo_i_share_buffer *buffer, cl_command_queue queue);
/* OpenGL may use it when this has returned. Nothing to do for a buffer that is not acquired. */
svo_status svo_i_share_interop_release(svo_i_share_buffer *buffer);

#endif
