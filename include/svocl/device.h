/* SPDX-License-Identifier: MIT */
/** \file
 * The device handle: the caller's OpenCL context and device, their limits, and the compiled kernels. It is the parent
 * of all other handles and keeps their error messages.
 *
 * Thread-safety: one thread at a time may use a device handle and what was made from it. Different device handles are
 * independent, also when they share a context.
 */
#ifndef SVOCL_DEVICE_H
#define SVOCL_DEVICE_H

/** svocl uses OpenCL 1.2. Define a later version before this header to see more of the OpenCL headers. */
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

/** An OpenCL device as svocl uses it. */
typedef struct svo_device svo_device;

/** Options of a device handle. */
typedef struct svo_device_options {
    size_t struct_size; /**< sizeof(svo_device_options) */
    svo_log_callback log; /**< NULL: nothing is logged */
    void *log_user; /**< passed to log */
    /** For svo_device_create_default: a part of "platform: device" in letters of either case, or indices as in "0.1"
     *  (platform.device). NULL: the first GPU, else the first device. */
    const char *device_name;
} svo_device_options;

/** All defaults. */
#define SVO_DEVICE_OPTIONS_INIT SVO_STRUCT_INIT(svo_device_options)

/** Makes a handle for the caller's context and one of its devices. Compiles nothing.
 *
 * Several handles may share a context, one per thread for example. Where the context was made against an OpenGL context
 * (CL_GL_CONTEXT_KHR), svocl::gl shares buffers through it if the driver can.
 *
 * \param context retained until svo_device_destroy
 * \param device one of the context's devices, with OpenCL 1.2 or later and little-endian; retained
 * \param options NULL means all defaults
 * \param out receives the handle
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED, SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_device_create(cl_context context, cl_device_id device, const svo_device_options *options,
                                     svo_device **out, svo_message *message);

/** Chooses a device and makes a context for it. For programs without OpenCL of their own.
 *
 * \param options NULL means all defaults; device_name chooses the device
 * \param out receives the handle
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_NO_DEVICE when there is no platform or no device of that name; else as svo_device_create. */
SVO_API svo_status svo_device_create_default(const svo_device_options *options, svo_device **out, svo_message *message);

/** Destroys a handle. Destroy the plans, trees and front ends that were made from it first.
 *
 * \param device set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_device_destroy(svo_device **device);

/** The OpenCL context.
 *
 * \param device not NULL
 * \returns the context, not retained for the caller. */
SVO_API cl_context svo_device_cl_context(const svo_device *device);

/** The OpenCL device.
 *
 * \param device not NULL
 * \returns the device, not retained for the caller. */
SVO_API cl_device_id svo_device_cl_device(const svo_device *device);

/** The device's name.
 *
 * \param device not NULL
 * \returns "platform: device"; lives as long as the handle. */
SVO_API const char *svo_device_name(const svo_device *device);

/** The message of the last failure of this handle or of one made from it.
 *
 * \param device not NULL
 * \returns "" if nothing failed yet; valid until the next failure. */
SVO_API const char *svo_device_message(const svo_device *device);

/** Time spent on compiling kernels so far, or on loading them from the driver's cache.
 *
 * \param device not NULL
 * \returns milliseconds of wall clock. */
SVO_API double svo_device_compile_ms(const svo_device *device);

#ifdef __cplusplus
}
#endif

#endif
