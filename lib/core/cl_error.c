/* SPDX-License-Identifier: MIT */
/* The names of OpenCL's errors, and the status of each. */
#include "core/cl_error.h"

#include <CL/cl_ext.h>
#include <CL/cl_gl.h>

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
    return svo_i_fail(message, status, "%s: %s failed with %s (%d)", function, call, svo_i_cl_error_name(error), error);
}
