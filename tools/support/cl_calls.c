/* SPDX-License-Identifier: MIT */
/* Stands between the program with its static libraries and the OpenCL loader: counts, and calls the real function. */
#include "support/cl_calls.h"

#ifdef SVOCL_COUNTS_CL_CALLS
#include <CL/cl.h>

#include "support/wrapped.h"

static cl_calls counted;

bool cl_calls_count(cl_calls *counts)
{
    *counts = counted;
    return true;
}

/* NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): names of the linker */
WRAPPED(cl_int, clEnqueueNDRangeKernel,
        (cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset, const size_t *global,
         const size_t *local, EVENTS),
        (queue, kernel, dimensions, offset, global, local, EVENTS_GIVEN), ++counted.launches)

WRAPPED(cl_int, clEnqueueWriteBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocks, size_t offset, size_t bytes, const void *from, EVENTS),
        (queue, buffer, blocks, offset, bytes, from, EVENTS_GIVEN),
        (++counted.uploads, counted.waits += blocks != CL_FALSE))

WRAPPED(cl_int, clEnqueueReadBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocks, size_t offset, size_t bytes, void *to, EVENTS),
        (queue, buffer, blocks, offset, bytes, to, EVENTS_GIVEN), counted.waits += blocks != CL_FALSE)

WRAPPED(void *, clEnqueueMapBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocks, cl_map_flags flags, size_t offset, size_t bytes, EVENTS,
         cl_int *error),
        (queue, buffer, blocks, flags, offset, bytes, EVENTS_GIVEN, error), counted.waits += blocks != CL_FALSE)

WRAPPED(cl_mem, clCreateBuffer, (cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error),
        (context, flags, bytes, host, error), counted.uploads += (flags & CL_MEM_COPY_HOST_PTR) != 0)

WRAPPED(cl_int, clWaitForEvents, (cl_uint count, const cl_event *events), (count, events), ++counted.waits)
WRAPPED(cl_int, clFinish, (cl_command_queue queue), (queue), ++counted.waits)
/* NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming) */

#else

bool cl_calls_count(cl_calls *counts)
{
    *counts = (cl_calls){0};
    return false;
}

#endif
