/* SPDX-License-Identifier: MIT */
/* Wraps the calls of OpenCL. */
#include <CL/cl.h>

#include "faults.h"

/* The linker's names for the real calls and for their wrappers. */
/* NOLINTBEGIN(readability-identifier-naming) */
#define DECLARE(type, name, parameters) \
    type __real_##name parameters;      \
    type __wrap_##name parameters;      \
    type __wrap_##name parameters

/* A call that returns an error and changes no count. */
#define PLAIN(name, parameters, arguments)      \
    DECLARE(cl_int, name, parameters)           \
    {                                           \
        if (faults_turn(FAULT_OPENCL, #name)) { \
            return FAULT_CL_ERROR;              \
        }                                       \
        return __real_##name arguments;         \
    }

/* A call that makes an object; its last parameter is error. */
#define CREATE(member, type, name, parameters, arguments) \
    DECLARE(type, name, parameters)                       \
    {                                                     \
        if (faults_turn(FAULT_OPENCL, #name)) {           \
            if (error != NULL) {                          \
                *error = FAULT_CL_ERROR;                  \
            }                                             \
            return NULL;                                  \
        }                                                 \
        const type made = __real_##name arguments;        \
        faults_live.member += made != NULL ? 1 : 0;       \
        return made;                                      \
    }

#define RETAIN(member, type, name)                         \
    DECLARE(cl_int, name, (type object))                   \
    {                                                      \
        if (faults_turn(FAULT_OPENCL, #name)) {            \
            return FAULT_CL_ERROR;                         \
        }                                                  \
        const cl_int error = __real_##name(object);        \
        faults_live.member += error == CL_SUCCESS ? 1 : 0; \
        return error;                                      \
    }

#define RELEASE(member, type, name)                          \
    DECLARE(cl_int, name, (type object))                     \
    {                                                        \
        const bool fails = faults_turn(FAULT_OPENCL, #name); \
        const cl_int error = __real_##name(object);          \
        faults_live.member -= error == CL_SUCCESS ? 1 : 0;   \
        return fails ? FAULT_CL_ERROR : error;               \
    }

/* A command; its last parameter is event. */
#define COMMAND(name, parameters, arguments)                                \
    DECLARE(cl_int, name, parameters)                                       \
    {                                                                       \
        if (faults_turn(FAULT_OPENCL, #name)) {                             \
            return FAULT_CL_ERROR;                                          \
        }                                                                   \
        const cl_int error = __real_##name arguments;                       \
        faults_live.events += error == CL_SUCCESS && event != NULL ? 1 : 0; \
        return error;                                                       \
    }

typedef void(CL_CALLBACK *build_callback)(cl_program program, void *user);
typedef void(CL_CALLBACK *context_callback)(const char *text, const void *data, size_t bytes, void *user);
typedef void(CL_CALLBACK *memory_callback)(cl_mem memory, void *user);
typedef void(CL_CALLBACK *event_callback)(cl_event event, cl_int status, void *user);

PLAIN(clGetPlatformIDs, (cl_uint room, cl_platform_id *platforms, cl_uint *count), (room, platforms, count))
PLAIN(clGetPlatformInfo, (cl_platform_id platform, cl_platform_info name, size_t bytes, void *value, size_t *needed),
      (platform, name, bytes, value, needed))
PLAIN(clGetDeviceIDs,
      (cl_platform_id platform, cl_device_type type, cl_uint room, cl_device_id *devices, cl_uint *count),
      (platform, type, room, devices, count))
PLAIN(clGetDeviceInfo, (cl_device_id device, cl_device_info name, size_t bytes, void *value, size_t *needed),
      (device, name, bytes, value, needed))
PLAIN(clRetainDevice, (cl_device_id device), (device))
PLAIN(clCreateSubDevices,
      (cl_device_id device, const cl_device_partition_property *properties, cl_uint room, cl_device_id *devices,
       cl_uint *count),
      (device, properties, room, devices, count))
PLAIN(clGetContextInfo, (cl_context context, cl_context_info name, size_t bytes, void *value, size_t *needed),
      (context, name, bytes, value, needed))
PLAIN(clGetCommandQueueInfo,
      (cl_command_queue queue, cl_command_queue_info name, size_t bytes, void *value, size_t *needed),
      (queue, name, bytes, value, needed))
PLAIN(clGetMemObjectInfo, (cl_mem memory, cl_mem_info name, size_t bytes, void *value, size_t *needed),
      (memory, name, bytes, value, needed))
PLAIN(clGetProgramInfo, (cl_program program, cl_program_info name, size_t bytes, void *value, size_t *needed),
      (program, name, bytes, value, needed))
PLAIN(clGetProgramBuildInfo,
      (cl_program program, cl_device_id device, cl_program_build_info name, size_t bytes, void *value, size_t *needed),
      (program, device, name, bytes, value, needed))
PLAIN(clGetKernelInfo, (cl_kernel kernel, cl_kernel_info name, size_t bytes, void *value, size_t *needed),
      (kernel, name, bytes, value, needed))
PLAIN(clGetEventInfo, (cl_event event, cl_event_info name, size_t bytes, void *value, size_t *needed),
      (event, name, bytes, value, needed))
PLAIN(clGetEventProfilingInfo, (cl_event event, cl_profiling_info name, size_t bytes, void *value, size_t *needed),
      (event, name, bytes, value, needed))
PLAIN(clBuildProgram,
      (cl_program program, cl_uint count, const cl_device_id *devices, const char *options, build_callback done,
       void *user),
      (program, count, devices, options, done, user))
PLAIN(clSetKernelArg, (cl_kernel kernel, cl_uint index, size_t bytes, const void *value), (kernel, index, bytes, value))
PLAIN(clFlush, (cl_command_queue queue), (queue))
PLAIN(clFinish, (cl_command_queue queue), (queue))
PLAIN(clWaitForEvents, (cl_uint count, const cl_event *events), (count, events))
PLAIN(clSetUserEventStatus, (cl_event event, cl_int status), (event, status))
PLAIN(clSetMemObjectDestructorCallback, (cl_mem memory, memory_callback done, void *user), (memory, done, user))
PLAIN(clSetEventCallback, (cl_event event, cl_int status, event_callback done, void *user), (event, status, done, user))

CREATE(contexts, cl_context, clCreateContext,
       (const cl_context_properties *properties, cl_uint count, const cl_device_id *devices, context_callback notify,
        void *user, cl_int *error),
       (properties, count, devices, notify, user, error))
CREATE(queues, cl_command_queue, clCreateCommandQueue,
       (cl_context context, cl_device_id device, cl_command_queue_properties properties, cl_int *error),
       (context, device, properties, error))
CREATE(buffers, cl_mem, clCreateBuffer,
       (cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error),
       (context, flags, bytes, host, error))
CREATE(buffers, cl_mem, clCreateSubBuffer,
       (cl_mem parent, cl_mem_flags flags, cl_buffer_create_type type, const void *region, cl_int *error),
       (parent, flags, type, region, error))
CREATE(programs, cl_program, clCreateProgramWithSource,
       (cl_context context, cl_uint count, const char **texts, const size_t *lengths, cl_int *error),
       (context, count, texts, lengths, error))
CREATE(programs, cl_program, clCreateProgramWithBinary,
       (cl_context context, cl_uint count, const cl_device_id *devices, const size_t *lengths,
        const unsigned char **binaries, cl_int *statuses, cl_int *error),
       (context, count, devices, lengths, binaries, statuses, error))
CREATE(kernels, cl_kernel, clCreateKernel, (cl_program program, const char *name, cl_int *error),
       (program, name, error))
CREATE(events, cl_event, clCreateUserEvent, (cl_context context, cl_int *error), (context, error))

RETAIN(contexts, cl_context, clRetainContext)
RETAIN(queues, cl_command_queue, clRetainCommandQueue)
RETAIN(buffers, cl_mem, clRetainMemObject)
RETAIN(programs, cl_program, clRetainProgram)
RETAIN(kernels, cl_kernel, clRetainKernel)
RETAIN(events, cl_event, clRetainEvent)

RELEASE(contexts, cl_context, clReleaseContext)
RELEASE(queues, cl_command_queue, clReleaseCommandQueue)
RELEASE(buffers, cl_mem, clReleaseMemObject)
RELEASE(programs, cl_program, clReleaseProgram)
RELEASE(kernels, cl_kernel, clReleaseKernel)
RELEASE(events, cl_event, clReleaseEvent)

DECLARE(cl_int, clReleaseDevice, (cl_device_id device))
{
    const bool fails = faults_turn(FAULT_OPENCL, "clReleaseDevice");
    const cl_int error = __real_clReleaseDevice(device);
    return fails ? FAULT_CL_ERROR : error;
}

COMMAND(clEnqueueReadBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes, void *to,
         cl_uint num_wait, const cl_event *wait, cl_event *event),
        (queue, buffer, blocking, offset, bytes, to, num_wait, wait, event))
COMMAND(clEnqueueWriteBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes, const void *from,
         cl_uint num_wait, const cl_event *wait, cl_event *event),
        (queue, buffer, blocking, offset, bytes, from, num_wait, wait, event))
COMMAND(clEnqueueCopyBuffer,
        (cl_command_queue queue, cl_mem from, cl_mem to, size_t from_offset, size_t to_offset, size_t bytes,
         cl_uint num_wait, const cl_event *wait, cl_event *event),
        (queue, from, to, from_offset, to_offset, bytes, num_wait, wait, event))
COMMAND(clEnqueueFillBuffer,
        (cl_command_queue queue, cl_mem buffer, const void *pattern, size_t pattern_bytes, size_t offset, size_t bytes,
         cl_uint num_wait, const cl_event *wait, cl_event *event),
        (queue, buffer, pattern, pattern_bytes, offset, bytes, num_wait, wait, event))
COMMAND(clEnqueueNDRangeKernel,
        (cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset, const size_t *global,
         const size_t *local, cl_uint num_wait, const cl_event *wait, cl_event *event),
        (queue, kernel, dimensions, offset, global, local, num_wait, wait, event))
COMMAND(clEnqueueMarkerWithWaitList, (cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event),
        (queue, num_wait, wait, event))
COMMAND(clEnqueueBarrierWithWaitList, (cl_command_queue queue, cl_uint num_wait, const cl_event *wait, cl_event *event),
        (queue, num_wait, wait, event))

DECLARE(void *, clEnqueueMapBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags flags, size_t offset, size_t bytes,
         cl_uint num_wait, const cl_event *wait, cl_event *event, cl_int *error))
{
    if (faults_turn(FAULT_OPENCL, "clEnqueueMapBuffer")) {
        if (error != NULL) {
            *error = FAULT_CL_ERROR;
        }
        return NULL;
    }
    void *mapped =
        __real_clEnqueueMapBuffer(queue, buffer, blocking, flags, offset, bytes, num_wait, wait, event, error);
    faults_live.mappings += mapped != NULL ? 1 : 0;
    faults_live.events += mapped != NULL && event != NULL ? 1 : 0;
    return mapped;
}

/* Unmaps, and reports an error. */
DECLARE(cl_int, clEnqueueUnmapMemObject,
        (cl_command_queue queue, cl_mem buffer, void *mapped, cl_uint num_wait, const cl_event *wait, cl_event *event))
{
    const bool fails = faults_turn(FAULT_OPENCL, "clEnqueueUnmapMemObject");
    const cl_int error = __real_clEnqueueUnmapMemObject(queue, buffer, mapped, num_wait, wait, fails ? NULL : event);
    faults_live.mappings -= error == CL_SUCCESS ? 1 : 0;
    faults_live.events += error == CL_SUCCESS && event != NULL && !fails ? 1 : 0;
    return fails ? FAULT_CL_ERROR : error;
}

DECLARE(void *, clGetExtensionFunctionAddressForPlatform, (cl_platform_id platform, const char *name))
{
    return faults_turn(FAULT_OPENCL, "clGetExtensionFunctionAddressForPlatform")
               ? NULL
               : __real_clGetExtensionFunctionAddressForPlatform(platform, name);
}
/* NOLINTEND(readability-identifier-naming) */
