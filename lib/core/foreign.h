/* SPDX-License-Identifier: MIT */
/*
 * What callers bring of their own OpenCL: queues, buffers, kernels, events. Some drivers accept such an object of
 * another context and compute nonsense with it, so every entry that takes one asks here first.
 */
#ifndef SVO_LIB_CORE_FOREIGN_H
#define SVO_LIB_CORE_FOREIGN_H

#include "svocl/device.h"

/* Each returns why the object cannot be used with the context, or NULL if it can. A text of a queue or of a wait list
   is a whole sentence; the others follow the argument's name, as "is of another context" does. */
const char *svo_i_wrong_queue(cl_context context, cl_device_id device, cl_command_queue queue);
const char *svo_i_wrong_memory(cl_context context, cl_mem memory);
/* The same for memory that kernels write. */
const char *svo_i_wrong_output(cl_context context, cl_mem memory);
const char *svo_i_wrong_kernel(cl_context context, cl_kernel kernel);
const char *svo_i_wrong_wait(cl_context context, cl_uint num_wait, const cl_event *wait);

#endif
