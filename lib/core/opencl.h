/* SPDX-License-Identifier: MIT */
/* Errors, properties and objects of OpenCL, for handles and for the choice of a device. */
#ifndef SVO_LIB_CORE_OPENCL_H
#define SVO_LIB_CORE_OPENCL_H

#include "core/memory.h"
#include "core/message.h"
#include "svocl/device.h"

SVO_I_SHARED_BEGIN

/* "function: clCall failed with CL_NAME (-n)"; out-of-memory errors become SVO_OUT_OF_DEVICE_MEMORY. message: NULL
   allowed. */
svo_status svo_i_fail_cl(svo_message *message, const char *function, const char *call, cl_int error);
/* "CL_OUT_OF_RESOURCES", ...; static string. */
const char *svo_i_cl_error_name(cl_int error);

SVO_I_SHARED_END

/* Properties of OpenCL devices and platforms, for handles and for their choice. function: for the message. */

/* A string property, by malloc. */
svo_status svo_i_device_text(cl_device_id device, cl_device_info property, const char *function,
                             const svo_i_memory *memory, char **out, svo_message *message);
svo_status svo_i_platform_text(cl_platform_id platform, cl_platform_info property, const char *function,
                               const svo_i_memory *memory, char **out, svo_message *message);
/* A property of fixed size. */
svo_status svo_i_device_property(cl_device_id device, cl_device_info property, size_t bytes, void *out,
                                 const char *function, svo_message *message);
/* "platform: device"; the caller frees it. */
svo_status svo_i_device_full_name(cl_device_id device, const char *function, const svo_i_memory *memory, char **out,
                                  svo_message *message);

/*
 * What callers bring of their own OpenCL: queues, buffers, kernels, events. Some drivers accept such an object of
 * another context and compute nonsense with it, so every entry that takes one asks here first.
 */

/* Each returns why the object cannot be used with the context, or NULL if it can. A text of a queue or of a wait list
   is a whole sentence; the others follow the argument's name, as "is of another context" does. */
const char *svo_i_wrong_queue(cl_context context, cl_device_id device, cl_command_queue queue);
const char *svo_i_wrong_memory(cl_context context, cl_mem memory);
/* The same for memory that kernels write. */
const char *svo_i_wrong_output(cl_context context, cl_mem memory);
const char *svo_i_wrong_kernel(cl_context context, cl_kernel kernel);
const char *svo_i_wrong_wait(cl_context context, cl_uint num_wait, const cl_event *wait);

#endif
