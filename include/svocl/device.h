/* SPDX-License-Identifier: MIT */
/*
 * An OpenCL device as svocl sees it: the caller's context and device, what svocl found out about them, and the compiled
 * kernels. It is the parent of every other handle and keeps their error messages.
 *
 * Thread-safety: one device handle may be used by one thread at a time; different handles are independent.
 */
#ifndef SVOCL_DEVICE_H
#define SVOCL_DEVICE_H

/* svocl uses OpenCL 1.2; define this before to see more of the OpenCL headers. */
#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>
#include <stddef.h>

#include "svocl/export.h"
#include "svocl/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct svo_device svo_device;

typedef struct svo_device_options {
    size_t struct_size; /* sizeof(svo_device_options) */
    svo_log_callback log; /* NULL: nothing is logged */
    void *log_user;
    const char *device_name; /* svo_device_create_default: part of "platform: device", any case, or "P.D" indices;
                                NULL: the first GPU, else the first device */
} svo_device_options;
#define SVO_DEVICE_OPTIONS_INIT SVO_STRUCT_INIT(svo_device_options)

/*
 * Wraps the caller's context and one of its devices; both are retained until svo_device_destroy. Compiles nothing.
 * Several handles may share a context, one per thread for example. A context that was made against an OpenGL context
 * (with CL_GL_CONTEXT_KHR) is shared with it by svocl::gl where that works.
 *
 * context, device: not NULL; device must belong to context, support OpenCL 1.2 and be little-endian.
 * options: NULL means all defaults. message: receives the reason on failure; NULL allowed.
 * Returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY.
 */
SVO_API svo_status svo_device_create(cl_context context, cl_device_id device, const svo_device_options *options,
                                     svo_device **out, svo_message *message);

/*
 * Picks a device by options->device_name and makes a context of its own for it. For programs without OpenCL of their
 * own. Returns SVO_NO_DEVICE when there is no platform or nothing matches the name, else as svo_device_create.
 */
SVO_API svo_status svo_device_create_default(const svo_device_options *options, svo_device **out, svo_message *message);

/* Releases the handle and sets *device to NULL; NULL and a pointer to NULL are allowed. Plans, trees and front ends
   made from it must have been destroyed before. */
SVO_API void svo_device_destroy(svo_device **device);

SVO_API cl_context svo_device_cl_context(const svo_device *device); /* not retained for the caller */
SVO_API cl_device_id svo_device_cl_device(const svo_device *device);
SVO_API const char *svo_device_name(const svo_device *device); /* "platform: device"; lives as long as the handle */
/* The words of the last failure of this handle or of one made from it; "" if there was none. Lives until the next. */
SVO_API const char *svo_device_message(const svo_device *device);
/* Milliseconds of wall clock spent in compiling or loading kernels so far. */
SVO_API double svo_device_compile_ms(const svo_device *device);

#ifdef __cplusplus
}
#endif

#endif
