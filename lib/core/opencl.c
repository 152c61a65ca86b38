/* SPDX-License-Identifier: MIT */
/*
 * What the library asks of OpenCL: the names of its errors and the status of each, properties of devices and platforms,
 * and whether a caller's object is of the context that it is used with.
 */
#include "core/opencl.h"

#include <CL/cl_ext.h>
#include <CL/cl_gl.h>
#include <stdio.h>
#include <string.h>

#include "core/limits.h"

/* ---- errors ---- */

/* The error codes of OpenCL 1.2 and cl_khr_gl_sharing. */
#define CL_ERROR_LIST(X)                            \
    X(CL_DEVICE_NOT_FOUND)                          \
    X(CL_DEVICE_NOT_AVAILABLE)                      \
    X(CL_COMPILER_NOT_AVAILABLE)                    \
    X(CL_MEM_OBJECT_ALLOCATION_FAILURE)             \
    X(CL_OUT_OF_RESOURCES)                          \
    X(CL_OUT_OF_HOST_MEMORY)                        \
    X(CL_PROFILING_INFO_NOT_AVAILABLE)              \
    X(CL_MEM_COPY_OVERLAP)                          \
    X(CL_BUILD_PROGRAM_FAILURE)                     \
    X(CL_MAP_FAILURE)                               \
    X(CL_MISALIGNED_SUB_BUFFER_OFFSET)              \
    X(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) \
    X(CL_INVALID_VALUE)                             \
    X(CL_INVALID_DEVICE_TYPE)                       \
    X(CL_INVALID_PLATFORM)                          \
    X(CL_INVALID_DEVICE)                            \
    X(CL_INVALID_CONTEXT)                           \
    X(CL_INVALID_QUEUE_PROPERTIES)                  \
    X(CL_INVALID_COMMAND_QUEUE)                     \
    X(CL_INVALID_HOST_PTR)                          \
    X(CL_INVALID_MEM_OBJECT)                        \
    X(CL_INVALID_BINARY)                            \
    X(CL_INVALID_BUILD_OPTIONS)                     \
    X(CL_INVALID_PROGRAM)                           \
    X(CL_INVALID_PROGRAM_EXECUTABLE)                \
    X(CL_INVALID_KERNEL_NAME)                       \
    X(CL_INVALID_KERNEL_DEFINITION)                 \
    X(CL_INVALID_KERNEL)                            \
    X(CL_INVALID_ARG_INDEX)                         \
    X(CL_INVALID_ARG_VALUE)                         \
    X(CL_INVALID_ARG_SIZE)                          \
    X(CL_INVALID_KERNEL_ARGS)                       \
    X(CL_INVALID_WORK_DIMENSION)                    \
    X(CL_INVALID_WORK_GROUP_SIZE)                   \
    X(CL_INVALID_WORK_ITEM_SIZE)                    \
    X(CL_INVALID_GLOBAL_OFFSET)                     \
    X(CL_INVALID_EVENT_WAIT_LIST)                   \
    X(CL_INVALID_EVENT)                             \
    X(CL_INVALID_OPERATION)                         \
    X(CL_INVALID_GL_OBJECT)                         \
    X(CL_INVALID_BUFFER_SIZE)                       \
    X(CL_INVALID_GLOBAL_WORK_SIZE)                  \
    X(CL_INVALID_PROPERTY)                          \
    X(CL_DEVICE_PARTITION_FAILED)                   \
    X(CL_INVALID_DEVICE_PARTITION_COUNT)            \
    X(CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR)

const char *svo_i_cl_error_name(cl_int error)
{
    switch (error) {
#define CL_ERROR_CASE(name) \
    case name:              \
        return #name;
        CL_ERROR_LIST(CL_ERROR_CASE)
#undef CL_ERROR_CASE
    default:
        return "error";
    }
}

svo_status svo_i_fail_cl(svo_message *message, const char *function, const char *call, cl_int error)
{
    svo_status status = SVO_CL_ERROR;
    if (error == CL_MEM_OBJECT_ALLOCATION_FAILURE || error == CL_OUT_OF_RESOURCES) {
        status = SVO_OUT_OF_DEVICE_MEMORY;
    } else if (error == CL_OUT_OF_HOST_MEMORY) {
        status = SVO_OUT_OF_HOST_MEMORY;
    }
    (void)svo_i_fail(message, status, "%s: %s failed with %s (%d)", function, call, svo_i_cl_error_name(error), error);
    if (status == SVO_OUT_OF_DEVICE_MEMORY) {
        svo_i_limit_explain(message);
    }
    return status;
}

/* ---- properties ---- */

/* An object with string properties: a device, or without one a platform. */
typedef struct named {
    cl_device_id device;
    cl_platform_id platform;
} named;

static cl_int read_text(named object, cl_uint property, size_t bytes, char *text, size_t *needed)
{
    return object.device != NULL ? clGetDeviceInfo(object.device, property, bytes, text, needed)
                                 : clGetPlatformInfo(object.platform, property, bytes, text, needed);
}

static svo_status text_of(named object, cl_uint property, const char *function, const svo_i_memory *memory, char **out,
                          svo_message *message)
{
    size_t bytes = 0;
    cl_int error = read_text(object, property, 0, NULL, &bytes);
    char *text = error == CL_SUCCESS ? svo_i_alloc_zeroed(memory, bytes + 1, 1) : NULL;
    if (error == CL_SUCCESS && text == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu bytes of a name", function, bytes);
    }
    if (error == CL_SUCCESS && bytes > 0) {
        error = read_text(object, property, bytes, text, NULL);
    }
    if (error != CL_SUCCESS) {
        svo_i_free(text);
        return svo_i_fail_cl(message, function, object.device != NULL ? "clGetDeviceInfo" : "clGetPlatformInfo", error);
    }
    *out = text;
    return SVO_OK;
}

svo_status svo_i_device_text(cl_device_id device, cl_device_info property, const char *function,
                             const svo_i_memory *memory, char **out, svo_message *message)
{
    return text_of((named){.device = device}, property, function, memory, out, message);
}

svo_status svo_i_platform_text(cl_platform_id platform, cl_platform_info property, const char *function,
                               const svo_i_memory *memory, char **out, svo_message *message)
{
    return text_of((named){.platform = platform}, property, function, memory, out, message);
}

svo_status svo_i_device_property(cl_device_id device, cl_device_info property, size_t bytes, void *out,
                                 const char *function, svo_message *message)
{
    const cl_int error = clGetDeviceInfo(device, property, bytes, out, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_fail_cl(message, function, "clGetDeviceInfo", error);
}

svo_status svo_i_device_full_name(cl_device_id device, const char *function, const svo_i_memory *memory, char **out,
                                  svo_message *message)
{
    svo_status status = SVO_OK;
    cl_platform_id platform = NULL;
    char *platform_name = NULL;
    char *device_name = NULL;
    SVO_I_TRY_CLEANUP(
        svo_i_device_property(device, CL_DEVICE_PLATFORM, sizeof(cl_platform_id), &platform, function, message));
    SVO_I_TRY_CLEANUP(svo_i_platform_text(platform, CL_PLATFORM_NAME, function, memory, &platform_name, message));
    SVO_I_TRY_CLEANUP(svo_i_device_text(device, CL_DEVICE_NAME, function, memory, &device_name, message));
    const size_t bytes = strlen(platform_name) + strlen(device_name) + 3;
    char *name = svo_i_alloc(memory, bytes);
    if (name == NULL) {
        status = svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu bytes of a name", function, bytes);
        goto cleanup;
    }
    (void)snprintf(name, bytes, "%s: %s", platform_name, device_name);
    *out = name;
cleanup:
    svo_i_free(platform_name);
    svo_i_free(device_name);
    return status;
}

/* ---- objects of callers ---- */

const char *svo_i_wrong_queue(cl_context context, cl_device_id device, cl_command_queue queue)
{
    cl_context own_context = NULL;
    cl_device_id own_device = NULL;

    if (clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof(cl_context), &own_context, NULL) != CL_SUCCESS ||
        clGetCommandQueueInfo(queue, CL_QUEUE_DEVICE, sizeof(cl_device_id), &own_device, NULL) != CL_SUCCESS) {
        return "queue is no command queue: clGetCommandQueueInfo failed";
    }
    if (own_context != context) {
        return "queue is of another context than the device";
    }
    return own_device != device ? "queue is of another device of the context" : NULL;
}

const char *svo_i_wrong_memory(cl_context context, cl_mem memory)
{
    cl_context own_context = NULL;
    cl_mem_object_type type = 0;
    if (clGetMemObjectInfo(memory, CL_MEM_CONTEXT, sizeof(cl_context), &own_context, NULL) != CL_SUCCESS ||
        clGetMemObjectInfo(memory, CL_MEM_TYPE, sizeof type, &type, NULL) != CL_SUCCESS) {
        return "is no buffer: clGetMemObjectInfo failed";
    }
    if (type != CL_MEM_OBJECT_BUFFER) {
        return "is no buffer";
    }
    return own_context != context ? "is of another context" : NULL;
}

const char *svo_i_wrong_output(cl_context context, cl_mem memory)
{
    const char *wrong = svo_i_wrong_memory(context, memory);
    cl_mem_flags flags = 0;
    if (wrong != NULL) {
        return wrong;
    }
    if (clGetMemObjectInfo(memory, CL_MEM_FLAGS, sizeof flags, &flags, NULL) != CL_SUCCESS) {
        return "is no buffer: clGetMemObjectInfo failed";
    }
    return (flags & CL_MEM_READ_ONLY) != 0 ? "is of CL_MEM_READ_ONLY, and kernels write it" : NULL;
}

const char *svo_i_wrong_kernel(cl_context context, cl_kernel kernel)
{
    cl_context own_context = NULL;
    if (clGetKernelInfo(kernel, CL_KERNEL_CONTEXT, sizeof(cl_context), &own_context, NULL) != CL_SUCCESS) {
        return "is no kernel: clGetKernelInfo failed";
    }
    return own_context != context ? "is of another context" : NULL;
}

const char *svo_i_wrong_wait(cl_context context, cl_uint num_wait, const cl_event *wait)
{
    if ((num_wait > 0) != (wait != NULL)) {
        return "num_wait and wait disagree";
    }
    for (cl_uint i = 0; i < num_wait; ++i) {
        cl_context own_context = NULL;
        if (wait[i] == NULL ||
            clGetEventInfo(wait[i], CL_EVENT_CONTEXT, sizeof(cl_context), &own_context, NULL) != CL_SUCCESS) {
            return "wait holds what is no event: clGetEventInfo failed";
        }
        if (own_context != context) {
            return "wait holds an event of another context";
        }
    }
    return NULL;
}
