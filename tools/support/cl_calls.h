/* SPDX-License-Identifier: MIT */
/*
 * Counts the OpenCL calls of the program and of its static libraries, whose calls the linker routes through cl_calls.c
 * (ld --wrap). Calls within drivers are not seen. For one thread.
 */
#ifndef SVOCL_TOOLS_SUPPORT_CL_CALLS_H
#define SVOCL_TOOLS_SUPPORT_CL_CALLS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct cl_calls {
    uint64_t launches; /* of kernels */
    uint64_t uploads; /* writes of buffers, and buffers that are made with content */
    uint64_t waits; /* calls that return when the device has finished something: waits, blocking reads and writes */
} cl_calls;

/* The calls since the start. Returns false, and zeros, with shared libraries, whose calls are not seen. */
bool cl_calls_count(cl_calls *counts);

#endif
