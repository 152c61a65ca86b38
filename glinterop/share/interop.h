/* SPDX-License-Identifier: MIT */
/*
 * cl_khr_gl_sharing: whether a device and a context support it, and its functions. share.c creates buffers with
 * it; probe.c runs a self-test of it.
 *
 * Specification: The OpenCL Extension Specification, version 1.2, sections 9.7 (cl_khr_gl_sharing) and 9.8
 * (cl_khr_gl_event). svocl calls only what the device promises: some drivers export functions that abort the process,
 * and some loaders return functions that jump to address 0.
 */
#ifndef SVO_GLINTEROP_SHARE_INTEROP_H
#define SVO_GLINTEROP_SHARE_INTEROP_H

#include <CL/cl.h>
#include <CL/cl_gl.h>
#include <stdbool.h>

#include "context/context.h"

/* X(member): the extension's functions that svocl uses, looked up as "cl" + member. */
#define SVO_I_INTEROP_FUNCTION_LIST(X) \
    X(GetGLContextInfoKHR)             \
    X(CreateFromGLBuffer)              \
    X(EnqueueAcquireGLObjects)         \
    X(EnqueueReleaseGLObjects)

typedef struct svo_i_interop {
    cl_int(CL_API_CALL *GetGLContextInfoKHR)(const cl_context_properties *properties, cl_gl_context_info what,
                                             size_t bytes, void *value, size_t *value_bytes);
    cl_mem(CL_API_CALL *CreateFromGLBuffer)(cl_context context, cl_mem_flags flags, cl_GLuint name, cl_int *error);
    cl_int(CL_API_CALL *EnqueueAcquireGLObjects)(cl_command_queue queue, cl_uint count, const cl_mem *objects,
                                                 cl_uint wait_count, const cl_event *wait, cl_event *event);
    cl_int(CL_API_CALL *EnqueueReleaseGLObjects)(cl_command_queue queue, cl_uint count, const cl_mem *objects,
                                                 cl_uint wait_count, const cl_event *wait, cl_event *event);
    bool has_gl_event; /* cl_khr_gl_event: acquiring waits for OpenGL */
} svo_i_interop;

/* Whether the device lists the extension, as a whole word. Does not call OpenGL. */
bool svo_i_interop_is_listed(const svo_device *device, const svo_i_opencl *opencl);
/*
 * Checks step by step whether the device could share with the context: the device lists the extension, all functions
 * exist, OpenCL can name the context, and clGetGLContextInfoKHR lists the device. Does not check the device's own
 * OpenCL context. Expects the OpenGL context current.
 *
 * Returns SVO_UNSUPPORTED with the failed step in the message, or SVO_OUT_OF_HOST_MEMORY.
 */
svo_status svo_i_interop_find(const svo_device *device, const svo_gl_context *context, svo_i_interop *out,
                              svo_message *message);

/* Creates an OpenCL context of the device against the OpenGL context. Call svo_i_interop_find first. The caller
   releases the result. Expects the OpenGL context current. Returns SVO_UNSUPPORTED. */
svo_status svo_i_interop_create_context(const svo_device *device, const svo_gl_context *context, cl_context *out,
                                        svo_message *message);
/* Whether the device's own OpenCL context was created against the OpenGL context. */
bool svo_i_interop_is_joined(const svo_device *device, const svo_gl_context *context);

#endif
