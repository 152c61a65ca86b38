/* SPDX-License-Identifier: MIT */
/*
 * What the program asks of OpenCL: calls that a GPU waits for, and the kernels that it compiles. The linker puts these
 * functions between the program with its static libraries and the loader; with shared libraries nothing is seen.
 */
#ifndef SVOCL_TOOLS_SUPPORT_CL_CALLS_H
#define SVOCL_TOOLS_SUPPORT_CL_CALLS_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct cl_calls {
    uint64_t launches; /* of kernels */
    uint64_t uploads; /* writes of buffers, and buffers that are made with content */
    uint64_t waits; /* calls that return when the device has finished something: waits, blocking reads and writes */
    uint64_t buffers, reads; /* buffers that are made; blocking reads and maps */
    double buffers_ms, reads_ms; /* in these calls */
} cl_calls;

/* The calls since the start. Returns false, and zeros, where they are not seen. */
bool cl_calls_count(cl_calls *counts);
/* Those since a count. */
cl_calls cl_calls_since(const cl_calls *before);

/* From now on kernels are kept, and drivers that can are told to say how many registers they have given to each. */
void cl_calls_keep_kernels(void);
/* Adds "compiled_kernels": of each that was launched name, local_bytes of a group at its first launch, private_bytes
   of a work-item, group_multiple, and, where the driver has said it, registers. A kernel that was compiled in several
   ways is there as often. */
void cl_calls_add_kernels(cJSON *document);

#endif
