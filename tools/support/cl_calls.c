/* SPDX-License-Identifier: MIT */
/* Stands between the program with its static libraries and the OpenCL loader: counts, and calls the real function. */
#include "support/cl_calls.h"

#ifdef SVOCL_COUNTS_CL_CALLS
#include <CL/cl.h>

static cl_calls counted;

bool cl_calls_count(cl_calls *counts)
{
    *counts = counted;
    return true;
}

/* The linker's names, for the calls themselves and for what stands in for them. */
/* NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming,bugprone-macro-parentheses) */
#define COUNTED(type, name, parameters, arguments, count) \
    type __real_##name parameters;                        \
    type __wrap_##name parameters;                        \
    type __wrap_##name parameters                         \
    {                                                     \
        count;                                            \
        return __real_##name arguments;                   \
    }

COUNTED(cl_int, clEnqueueNDRangeKernel,
        (cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset, const size_t *global,
         const size_t *local, cl_uint wait_count, const cl_event *wait, cl_event *event),
        (queue, kernel, dimensions, offset, global, local, wait_count, wait, event), ++counted.launches)

COUNTED(cl_int, clEnqueueWriteBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocks, size_t offset, size_t bytes, const void *from,
         cl_uint wait_count, const cl_event *wait, cl_event *event),
        (queue, buffer, blocks, offset, bytes, from, wait_count, wait, event),
        (++counted.uploads, counted.waits += blocks != CL_FALSE))

COUNTED(cl_int, clEnqueueReadBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocks, size_t offset, size_t bytes, void *to,
         cl_uint wait_count, const cl_event *wait, cl_event *event),
        (queue, buffer, blocks, offset, bytes, to, wait_count, wait, event), counted.waits += blocks != CL_FALSE)

COUNTED(void *, clEnqueueMapBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocks, cl_map_flags flags, size_t offset, size_t bytes,
         cl_uint wait_count, const cl_event *wait, cl_event *event, cl_int *error),
        (queue, buffer, blocks, flags, offset, bytes, wait_count, wait, event, error),
        counted.waits += blocks != CL_FALSE)

COUNTED(cl_mem, clCreateBuffer, (cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error),
        (context, flags, bytes, host, error), counted.uploads += (flags & CL_MEM_COPY_HOST_PTR) != 0)

COUNTED(cl_int, clWaitForEvents, (cl_uint count, const cl_event *events), (count, events), ++counted.waits)
COUNTED(cl_int, clFinish, (cl_command_queue queue), (queue), ++counted.waits)
/* NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming,bugprone-macro-parentheses) */

#else

bool cl_calls_count(cl_calls *counts)
{
    *counts = (cl_calls){0};
    return false;
}

#endif
