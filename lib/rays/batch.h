/* SPDX-License-Identifier: MIT */
/* Batches of rays or points: records of one buffer become records of another, by one kernel. */
#ifndef SVO_LIB_RAYS_BATCH_H
#define SVO_LIB_RAYS_BATCH_H

#include "core/device.h"

typedef struct svo_i_batch svo_i_batch;
struct svo_i_batch {
    const char *function; /* for messages */
    svo_device *device; /* NULL only until svo_i_batch_check */
    const char *input_name, *output_name; /* of the arguments */
    size_t input_bytes, output_bytes; /* of a record */
    size_t count;
    size_t per_item; /* records a work-item takes; divides SVO_GROUP_ITEMS */
    /* A new kernel with all arguments set, of groups of SVO_GROUP_ITEMS / per_item work-items. */
    svo_status (*make_kernel)(const svo_i_batch *batch, cl_mem input, cl_mem output, cl_kernel *out);
    void *user; /* for make_kernel */
};

/* Refuses missing buffers and too many records. */
svo_status svo_i_batch_check(const svo_i_batch *batch, const void *input, const void *output);
/* After svo_i_batch_check. Checks queue, events and buffers; an empty batch signals its event all the same. */
svo_status svo_i_batch_enqueue(const svo_i_batch *batch, cl_mem input, cl_mem output, cl_command_queue queue,
                               cl_uint num_wait, const cl_event *wait, cl_event *event);
/* After svo_i_batch_check. Host arrays, through buffers that live for this call. queue: NULL for the device's own. */
svo_status svo_i_batch_run(const svo_i_batch *batch, const void *input, void *output, cl_command_queue queue);

#endif
