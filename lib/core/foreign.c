/* SPDX-License-Identifier: MIT */
/* Compares the contexts of callers' objects with the one that they are used with. */
#include "core/foreign.h"

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
