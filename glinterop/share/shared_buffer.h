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
    size_t offset_bytes; /* where the shared bytes begin in it: OpenCL may want a coarser alignment */
    cl_mem memory; /* the OpenCL buffer; its byte 0 is the OpenGL buffer's byte offset_bytes */
    unsigned char *pointer; /* host: where OpenGL's mapping holds the shared bytes; NULL otherwise */
    cl_command_queue mapping_queue; /* host: set while OpenCL has memory mapped, that is while OpenGL may write */
    svo_i_interop sharing; /* sharing: the extension's functions */
    cl_command_queue
        acquiring_queue; /* sharing: set while OpenCL has acquired memory, that is while OpenGL may not write */
} svo_i_share_buffer;

#endif
