/* SPDX-License-Identifier: MIT */
/*
 * From host memory to buffers. A device with memory of its own copies by DMA, which needs pages that stay where they
 * are. For an array anywhere the driver copies it to such pages first, piece by piece, and waits; so here, but without
 * the waits: a device handle has two halves of staging memory, and while one is on its way the next is filled.
 */
#ifndef SVO_LIB_CORE_UPLOAD_H
#define SVO_LIB_CORE_UPLOAD_H

#include "core/device.h"

typedef struct svo_i_upload {
    cl_command_queue queue;
    cl_mem buffer;
    size_t offset, bytes; /* above 0 */
    const void *from;
    cl_bool blocks; /* returns when the bytes are there; else from has to stay until then */
    cl_uint num_wait;
    const cl_event *wait;
} svo_i_upload;

/* clEnqueueWriteBuffer, through staging memory where it helps. event: of all bytes. */
cl_int svo_i_upload_enqueue(svo_device *device, const svo_i_upload *upload, cl_event *event);

SVO_I_SHARED_BEGIN

/* Writes to a buffer and waits until the bytes are there; none: does nothing. A blocking write alone returns when the
   memory that it reads is free again, maybe before other queues, or later commands of an out-of-order queue, find what
   it writes. */
svo_status svo_i_device_write(svo_device *device, const char *function, cl_command_queue queue, cl_mem buffer,
                              size_t offset, const void *from, size_t bytes);

SVO_I_SHARED_END

#endif
