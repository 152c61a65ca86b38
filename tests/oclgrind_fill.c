/* SPDX-License-Identifier: MIT */
/*
 * Linked into the tests that run under oclgrind, in front of the loader's function of this name: its check for values that
 * were never written (21.10) does not see clEnqueueFillBuffer, and takes every filled buffer for an unwritten one. A write
 * of the same bytes it does see.
 */
#include <stdlib.h>
#include <string.h>

#include "svocl/device.h"

CL_API_ENTRY cl_int CL_API_CALL clEnqueueFillBuffer(cl_command_queue queue, cl_mem buffer, const void *pattern,
                                                    size_t pattern_bytes, size_t offset_bytes, size_t bytes,
                                                    cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    unsigned char *filled = malloc(bytes + 1);
    if (filled == NULL) {
        return CL_OUT_OF_HOST_MEMORY;
    }
    for (size_t i = 0; i + pattern_bytes <= bytes; i += pattern_bytes) {
        memcpy(filled + i, pattern, pattern_bytes);
    }
    const cl_int error =
        clEnqueueWriteBuffer(queue, buffer, CL_TRUE, offset_bytes, bytes, filled, num_wait, wait, event);
    free(filled);
    return error;
}
