/* SPDX-License-Identifier: MIT */
/*
 * Between host memory and buffers. A device with memory of its own copies by DMA, which needs pages that stay where
 * they are. For an array anywhere the driver copies to or from such pages, piece by piece, and waits for each; so
 * here, but a device handle has two halves of staging memory, and while one is on its way the other is filled or
 * emptied.
 */
#ifndef SVO_LIB_CORE_STAGING_H
#define SVO_LIB_CORE_STAGING_H

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

typedef struct svo_i_download_from {
    cl_command_queue queue;
    cl_mem buffer;
    size_t offset, bytes; /* above 0 */
    const cl_event *wait;
} svo_i_download_from;

/* clEnqueueWriteBuffer, through staging memory where it helps. event: of all bytes. */
cl_int svo_i_upload_enqueue(svo_device *device, const svo_i_upload *upload, cl_event *event);

/* A blocking clEnqueueReadBuffer after an event, likewise. */
cl_int svo_i_download(svo_device *device, const svo_i_download_from *from, void *to);

SVO_I_SHARED_BEGIN

/* Writes to a buffer and waits until the bytes are there; none: does nothing. A blocking write alone returns when the
   memory that it reads is free again, maybe before other queues, or later commands of an out-of-order queue, find what
   it writes. */
svo_status svo_i_device_write(svo_device *device, const char *function, cl_command_queue queue, cl_mem buffer,
                              size_t offset, const void *from, size_t bytes);

SVO_I_SHARED_END

#endif
