/* SPDX-License-Identifier: MIT */
/*
 * cl_khr_gl_sharing: whether a device and a context offer it, and its functions. share.c makes buffers by it,
 * probe.c puts it to a self-test.
 *
 * Specification: The OpenCL Extension Specification, version 1.2, sections 9.7 (cl_khr_gl_sharing) and 9.8
 * (cl_khr_gl_event). Nothing is called that the device does not promise: some drivers abort the process in functions
 * that they export but do not have, and some loaders hand out functions that jump to address 0.
 */
#ifndef SVO_GLINTEROP_SHARE_INTEROP_H
#define SVO_GLINTEROP_SHARE_INTEROP_H

#include <CL/cl.h>
#include <CL/cl_gl.h>
#include <stdbool.h>

#include "context/context.h"

/* X(member): the extension's functions that svocl uses, looked up as "cl" + member. */
#define SVO_I_SHARING_FUNCTION_LIST(X) \
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
    bool has_gl_event; /* cl_khr_gl_event: acquiring waits for OpenGL by itself */
} svo_i_interop;

/* Whether the device lists the extension, as a whole word. Asks nothing of OpenGL. */
bool svo_i_interop_is_listed(const svo_device *device, const svo_i_opencl *opencl);
/*
 * Whether the device could share with the context, step by step: the device lists the extension as a whole word, all
 * functions are there, OpenCL can name the context, and clGetGLContextInfoKHR lists the device. Expects the context
 * current. Says nothing about the device's own OpenCL context.
 *
 * Returns SVO_UNSUPPORTED with the step that failed in the message, or SVO_OUT_OF_HOST_MEMORY.
 */
svo_status svo_i_interop_find(const svo_device *device, const svo_gl_context *context, svo_i_interop *out,
                              svo_message *message);

/* An OpenCL context of the device made against the OpenGL context, after svo_i_interop_find; released by the caller.
   Expects the context current. Returns SVO_UNSUPPORTED. */
svo_status svo_i_interop_create_context(const svo_device *device, const svo_gl_context *context, cl_context *out,
                                        svo_message *message);
/* Whether the device's own OpenCL context was made against the OpenGL context. */
bool svo_i_interop_is_joined(const svo_device *device, const svo_gl_context *context);

#endif
