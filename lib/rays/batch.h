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
    bool streams; /* a work-item takes many records, in groups of one, by a program with SVO_RAY_STREAMS: for CPUs */
    svo_i_argument last_argument; /* after the count; its value NULL: none */
} svo_i_batch;

/* Fills in what batches of rays against voxels have in common (kernels/rays/trace_voxels.cl), or says that the
   footprint is out of range, or that there are flags. footprint: lives as long as the batch. */
svo_status svo_i_batch_of_voxels(svo_i_batch *batch, size_t ray_count, const cl_float *footprint, uint32_t flags);
/* Launches a batch; see svo_trace_triangles. */
svo_status svo_i_batch_run(const svo_i_batch *asked, const svo_array *input, const svo_array *output,
                           const svo_submit *submit);

/* Of the class of trees; see rays/target.h. */
svo_status svo_i_tree_trace_triangles(void *tree, const svo_array *rays, const svo_array *hits, size_t ray_count,
                                      uint32_t flags, const svo_submit *submit);
svo_status svo_i_tree_trace_voxels(void *tree, const svo_array *rays, const svo_array *hits, size_t ray_count,
                                   float footprint, uint32_t flags, const svo_submit *submit);

#endif
