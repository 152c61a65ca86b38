/* SPDX-License-Identifier: MIT */
/* Batches: records in, records out, against a built tree or a compact one. */
#ifndef SVO_LIB_RAYS_BATCH_H
#define SVO_LIB_RAYS_BATCH_H

#include "rays/rays.h"
#include "svocl/trace.h"

typedef struct svo_i_batch {
    svo_device *device;
    const char *function; /* for messages */
    svo_i_ray_target target;
    const svo_i_program *program;
    const char *kernel_name, *defines; /* of the program */
    const char *input_name, *output_name; /* of the arguments */
    size_t input_bytes, output_bytes; /* of a record */
    size_t count;
    size_t per_item; /* records a work-item takes; above 1: in groups of one work-item */
    svo_i_argument last_argument; /* after the count; its value NULL: none */
} svo_i_batch;

/* Fills in what batches of rays against voxels have in common (kernels/rays/trace_voxels.cl), or says that the
   footprint is out of range. footprint: lives as long as the batch. */
svo_status svo_i_batch_of_voxels(svo_i_batch *batch, size_t ray_count, const cl_float *footprint);
/* Launches a batch for buffers; see svo_tree_trace_enqueue. */
svo_status svo_i_batch_enqueue(const svo_i_batch *asked, cl_mem input, cl_mem output, cl_command_queue queue,
                               cl_uint num_wait, const cl_event *wait, cl_event *event);
/* Launches a batch for host arrays and waits. */
svo_status svo_i_batch_run(const svo_i_batch *asked, const void *input, void *output, cl_command_queue queue);

#endif
