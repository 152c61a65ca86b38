/* SPDX-License-Identifier: MIT */
/*
 * Counts the OpenCL calls of svocl. The linker puts count_calls.c between the static libraries and the OpenCL loader
 * (ld --wrap, CMakeLists.txt); calls within drivers are not seen. For one thread.
 */
#ifndef SVOCL_TOOLS_SNAPSHOT_COUNT_CALLS_H
#define SVOCL_TOOLS_SNAPSHOT_COUNT_CALLS_H

#include <stdint.h>

/* The calls that are counted; CMakeLists.txt wraps the same ones. */
#define COUNTED_CALLS(X)           \
    X(clCreateBuffer)              \
    X(clCreateSubBuffer)           \
    X(clRetainMemObject)           \
    X(clReleaseMemObject)          \
    X(clCreateProgramWithSource)   \
    X(clBuildProgram)              \
    X(clCreateKernel)              \
    X(clReleaseKernel)             \
    X(clSetKernelArg)              \
    X(clCreateCommandQueue)        \
    X(clEnqueueNDRangeKernel)      \
    X(clEnqueueReadBuffer)         \
    X(clEnqueueWriteBuffer)        \
    X(clEnqueueCopyBuffer)         \
    X(clEnqueueFillBuffer)         \
    X(clEnqueueMapBuffer)          \
    X(clEnqueueUnmapMemObject)     \
    X(clEnqueueMarkerWithWaitList) \
    X(clWaitForEvents)             \
    X(clFlush)                     \
    X(clFinish)

typedef enum counted_call {
#define COUNTED_CALL_ENUM(name) COUNTED_##name,
    COUNTED_CALLS(COUNTED_CALL_ENUM)
#undef COUNTED_CALL_ENUM
        COUNTED_CALL_COUNT
} counted_call;

typedef struct call_counts {
    uint64_t calls[COUNTED_CALL_COUNT];
    uint64_t created_bytes; /* of all calls of clCreateBuffer */
    /* Digests of sequences, each call chained to the one before. */
    uint64_t buffers; /* bytes and flags of buffers */
    uint64_t programs; /* build options, names of kernels */
    uint64_t arguments; /* indices, sizes, and values where they are no handles */
    uint64_t launches; /* kernels' names, global and local sizes */
    uint64_t transfers; /* offsets and bytes of reads, writes, copies, fills and maps */
} call_counts;

/* The counts since the previous call of this function, or since the start. */
call_counts count_calls_take(void);
const char *counted_call_name(counted_call call); /* "clCreateBuffer"; static string */

#endif
