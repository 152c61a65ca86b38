/* SPDX-License-Identifier: MIT */
/** \file
 * The device handle: the caller's OpenCL context and device, their limits, and the compiled kernels. It is the parent
 * of all other handles and keeps their error messages.
 *
 * Queues, buffers, kernels and events that callers pass are of the handle's context, and queues of its device. Others
 * are refused with SVO_INVALID_ARGUMENT.
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
#include <stdint.h>

#include "svocl/export.h"
#include "svocl/memory.h"
#include "svocl/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An OpenCL device as svocl uses it. */
typedef struct svo_device svo_device;

/** Which of the library's kernels run, where CPUs and GPUs have different ones, and in which shapes of launches. Both
 *  are right on every device and give the same trees, hits and pictures; the other one is slower. */
typedef enum svo_path {
    SVO_PATH_AUTO = 0, /**< the CPU's path on CL_DEVICE_TYPE_CPU, else the GPU's */
    SVO_PATH_CPU = 1, /**< "cpu": a work-item does the work of a group, with vectors */
    SVO_PATH_GPU = 2 /**< "gpu": work-items do equal parts */
} svo_path;

/** Options of a device handle. */
typedef struct svo_device_options {
    size_t struct_size; /**< sizeof(svo_device_options) */
    svo_log_callback log; /**< NULL: nothing is logged */
    void *log_user; /**< passed to log */
    /** For svo_device_create_default: a part of "platform: device" in letters of either case, or indices as in "0.1"
     *  (platform.device). NULL matches every device. Of those that match, available ones go before others, then GPUs,
     *  then those with memory of their own, then those of more compute units, then the first. */
    const char *device_name;
    /** Upper limit in bytes for the OpenCL buffers of this handle and of what is made from it that live at the same
     *  time: trees, scratch, BVHs, batches of rays. A buffer counts until the driver destroys it. OpenGL's memory, a
     *  caller's buffers and the driver's own memory do not count. svo_build and svo_workspace_create refuse a plan
     *  whose predicted bytes do not fit, before they compile or allocate, and any buffer that would exceed the limit is
     *  SVO_OUT_OF_DEVICE_MEMORY. Copies then go without the 8 MiB of pinned memory that they use on devices with
     *  memory of their own. 0: no limit but the device's.
     *
     *  On devices without memory of their own, such as CPUs, buffers are the process's memory. There the same is
     *  refused above what the process may have: RLIMIT_AS (ulimit -v) and the limits of its control group and of those
     *  above it, less what is in use and 192 MiB for the driver's compiler, 96 MiB once it has compiled. A driver that
     *  runs out of memory may end the process. Where not even a compiler has room, the status is
     *  SVO_OUT_OF_HOST_MEMORY. Messages name the limit and its value. The limits that there are when the handle is
     *  made count; what they are and what is in use is read again. */
    uint64_t max_device_bytes;
    /** For svo_device_create_default: the most compute units, on a CPU threads, that kernels run on. A device with
     *  more is divided (clCreateSubDevices). The handle's device is then the part, which later handles of this limit
     *  share and which stays until the process ends. 0: all of them. svo_device_create, whose caller chooses the
     *  device, refuses it. */
    uint32_t max_threads;
    /** Host memory of the handle and of all that is made from it: plans, front ends, trees, workspaces. NULL: malloc
     *  and free. */
    const svo_memory_callbacks *memory;
    /** Which kernels run; others than the default are for tests and comparisons. */
    svo_path path;
    /** Not 0: kernels are used without a test. Else programs whose results are stored are tested by known answers
     *  before their first use: their kernels run on small inputs, and the host computes what they must give. Where a
     *  kernel gives anything else, the driver has compiled it wrongly, and what needs its program is
     *  SVO_DEVICE_UNRELIABLE, with kernel, device and driver in the message. Plans that may be made on the host are
     *  made there instead, and the log callback is told (SVO_LOG_WARNING). A test takes some milliseconds; the handle
     *  remembers its outcome. */
    uint64_t trust_driver;
} svo_device_options;

/** All defaults. */
#define SVO_DEVICE_OPTIONS_INIT SVO_STRUCT_INIT(svo_device_options)

/** Makes a handle for the caller's context and one of its devices. Compiles nothing.
 *
 * Several handles may share a context, one per thread for example. Where the context was made against an OpenGL context
 * (CL_GL_CONTEXT_KHR), svocl::gl shares buffers through it if the driver can.
 *
 * \param context retained until svo_device_destroy
 * \param device one of the context's devices; retained. It must be little-endian and have OpenCL 1.2 or later and
 *        work-groups of 64 items
 * \param options NULL means all defaults
 * \param out receives the handle
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (the device), SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_device_create(cl_context context, cl_device_id device, const svo_device_options *options,
                                     svo_device **out, svo_message *message);

/** Chooses a device and makes a context for it. For programs without OpenCL of their own.
 *
 * \param options NULL means all defaults; device_name chooses the device
 * \param out receives the handle
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_NO_DEVICE when there is no platform or no device of that name; the message names platforms without any
 *          device. SVO_OUT_OF_HOST_MEMORY when there is none and RLIMIT_AS leaves too little to load a driver, 448 MiB.
 *          SVO_UNSUPPORTED when it cannot be divided for max_threads. Else as svo_device_create. */
SVO_API svo_status svo_device_create_default(const svo_device_options *options, svo_device **out, svo_message *message);

/** Destroys a handle. Destroy the plans, trees and front ends that were made from it first.
 *
 * \param device set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_device_destroy(svo_device **device);

/** What a device handle is. */
typedef struct svo_device_info {
    size_t struct_size; /**< sizeof(svo_device_info) */
    cl_context context; /**< not retained for the caller */
    cl_device_id device; /**< not retained for the caller */
    const char *name; /**< "platform: device"; lives as long as the handle */
    svo_path path; /**< that kernels take: SVO_PATH_CPU or SVO_PATH_GPU */
    double compile_ms; /**< spent on compiling, loading from the driver's cache and testing kernels; wall clock */
} svo_device_info;

/** An empty output. */
#define SVO_DEVICE_INFO_INIT SVO_STRUCT_INIT(svo_device_info)

/** Describes a device handle.
 *
 * \param device not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_device_get_info(const svo_device *device, svo_device_info *info);

/** The message of the last failure of this handle or of one made from it.
 *
 * \param device not NULL
 * \returns "" if nothing failed yet; valid until the next failure. */
SVO_API const char *svo_device_message(const svo_device *device);

/** Saves the kernels that the handle has compiled, for svo_device_load_kernels: one file per program, keyed by
 *  platform, device, driver, source and options, with a checksum. Programs that the folder has are left as they are;
 *  others are replaced at once and whole.
 *
 * Asking a driver for its binaries may take long: PoCL takes 0.7 to 7 s for each program. So the library does it here
 * alone, and never in a build.
 *
 * \param device not NULL
 * \param folder made if there is none, for the user alone to write to, but not the folders above it
 * \param saved receives the number of files that were written; NULL allowed
 * \returns SVO_INVALID_ARGUMENT, SVO_FILE_ERROR (with the path), SVO_CL_ERROR, SVO_UNSUPPORTED (a context of more than
 *          64 devices) or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_device_save_kernels(svo_device *device, const char *folder, size_t *saved);

/** Loads what svo_device_save_kernels saved for the same device, driver and version of the library. Builds use it in
 *  place of compiling. Files of others are passed over; one that is damaged, or that the driver refuses, is passed over
 *  with a warning to the log callback. A folder that does not exist has no kernels.
 *
 * Binaries are code: load none that others may write to. The checksum finds damage, not malice.
 *
 * \param device not NULL
 * \param folder may be shared by several devices and versions
 * \param loaded receives the number of programs that were loaded; NULL allowed. Those of another version count, but no
 *        build uses them
 * \returns SVO_INVALID_ARGUMENT, SVO_FILE_ERROR (the folder cannot be read), SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on
 *          failure. */
SVO_API svo_status svo_device_load_kernels(svo_device *device, const char *folder, size_t *loaded);

#ifdef __cplusplus
}
#endif

#endif
