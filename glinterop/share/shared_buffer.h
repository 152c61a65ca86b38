/* SPDX-License-Identifier: MIT */
/* A buffer that OpenGL writes and OpenCL reads; share.h says what is done with it. */
#ifndef SVO_GLINTEROP_SHARE_SHARED_BUFFER_H
#define SVO_GLINTEROP_SHARE_SHARED_BUFFER_H

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

#endif
