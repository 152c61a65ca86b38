/* SPDX-License-Identifier: MIT */
/* Wraps the OpenCL calls that CMakeLists.txt lists: each takes notes and calls the real function. */
#include "count_calls.h"

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <string.h>

#include "support/wrapped.h"

#define KERNEL_NAME_BYTES 128

static call_counts notes;

call_counts count_calls_take(void)
{
    const call_counts taken = notes;
    notes = (call_counts){0};
    return taken;
}

const char *counted_call_name(counted_call call)
{
    static const char *const names[] = {
#define COUNTED_CALL_NAME(name) #name,
        COUNTED_CALLS(COUNTED_CALL_NAME)
#undef COUNTED_CALL_NAME
    };
    return names[call];
}

static void chain(uint64_t *digest, const void *bytes, size_t byte_count)
{
    *digest = XXH3_64bits_withSeed(bytes, byte_count, *digest);
}

static void chain_words(uint64_t *digest, uint64_t first, uint64_t second, uint64_t third)
{
    const uint64_t words[] = {first, second, third};
    chain(digest, words, sizeof words);
}

static void note_transfer(counted_call call, size_t offset, size_t bytes)
{
    ++notes.calls[call];
    chain_words(&notes.transfers, (uint64_t)call, offset, bytes);
}

static void note_launch(cl_kernel kernel, cl_uint dimensions, const size_t *global, const size_t *local)
{
    char name[KERNEL_NAME_BYTES] = "";
    ++notes.calls[COUNTED_clEnqueueNDRangeKernel];
    clGetKernelInfo(kernel, CL_KERNEL_FUNCTION_NAME, sizeof name, name, NULL);
    chain(&notes.launches, name, strlen(name));
    for (cl_uint i = 0; i < dimensions; ++i) {
        chain_words(&notes.launches, i, global[i], local != NULL ? local[i] : 0);
    }
}

/* Handles differ between runs, so their values are left out. */
static void note_argument(cl_uint index, size_t bytes, const void *value)
{
    ++notes.calls[COUNTED_clSetKernelArg];
    chain_words(&notes.arguments, index, bytes, value == NULL);
    if (value != NULL && bytes != sizeof(cl_mem)) {
        chain(&notes.arguments, value, bytes);
    }
}

typedef void(CL_CALLBACK *build_callback)(cl_program program, void *user);

static void note_buffer(cl_mem_flags flags, size_t bytes)
{
    ++notes.calls[COUNTED_clCreateBuffer];
    notes.created_bytes += bytes;
    chain_words(&notes.buffers, COUNTED_clCreateBuffer, flags, bytes);
}

static void note_sub_buffer(cl_buffer_create_type type, const void *region)
{
    const cl_buffer_region *part = region;
    ++notes.calls[COUNTED_clCreateSubBuffer];
    if (type == CL_BUFFER_CREATE_TYPE_REGION) {
        chain_words(&notes.buffers, COUNTED_clCreateSubBuffer, part->origin, part->size);
    }
}

static void note_program_text(counted_call call, const char *text)
{
    ++notes.calls[call];
    chain(&notes.programs, text != NULL ? text : "", text != NULL ? strlen(text) : 0);
}

/* NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): names of the linker */
WRAPPED(cl_mem, clCreateBuffer, (cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error),
        (context, flags, bytes, host, error), note_buffer(flags, bytes))
WRAPPED(cl_mem, clCreateSubBuffer,
        (cl_mem parent, cl_mem_flags flags, cl_buffer_create_type type, const void *region, cl_int *error),
        (parent, flags, type, region, error), note_sub_buffer(type, region))
WRAPPED(cl_int, clRetainMemObject, (cl_mem handle), (handle), ++notes.calls[COUNTED_clRetainMemObject])
WRAPPED(cl_int, clReleaseMemObject, (cl_mem handle), (handle), ++notes.calls[COUNTED_clReleaseMemObject])
WRAPPED(cl_program, clCreateProgramWithSource,
        (cl_context context, cl_uint count, const char **texts, const size_t *lengths, cl_int *error),
        (context, count, texts, lengths, error), ++notes.calls[COUNTED_clCreateProgramWithSource])
WRAPPED(cl_int, clBuildProgram,
        (cl_program program, cl_uint count, const cl_device_id *devices, const char *options, build_callback done,
         void *user),
        (program, count, devices, options, done, user), note_program_text(COUNTED_clBuildProgram, options))
WRAPPED(cl_kernel, clCreateKernel, (cl_program program, const char *name, cl_int *error), (program, name, error),
        note_program_text(COUNTED_clCreateKernel, name))
WRAPPED(cl_int, clReleaseKernel, (cl_kernel kernel), (kernel), ++notes.calls[COUNTED_clReleaseKernel])
WRAPPED(cl_int, clSetKernelArg, (cl_kernel kernel, cl_uint index, size_t bytes, const void *value),
        (kernel, index, bytes, value), note_argument(index, bytes, value))
WRAPPED(cl_command_queue, clCreateCommandQueue,
        (cl_context context, cl_device_id device, cl_command_queue_properties properties, cl_int *error),
        (context, device, properties, error), ++notes.calls[COUNTED_clCreateCommandQueue])
WRAPPED(cl_int, clEnqueueNDRangeKernel,
        (cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset, const size_t *global,
         const size_t *local, EVENTS),
        (queue, kernel, dimensions, offset, global, local, EVENTS_GIVEN),
        note_launch(kernel, dimensions, global, local))
WRAPPED(cl_int, clEnqueueReadBuffer,
        (cl_command_queue queue, cl_mem memory, cl_bool blocking, size_t offset, size_t bytes, void *host, EVENTS),
        (queue, memory, blocking, offset, bytes, host, EVENTS_GIVEN),
        note_transfer(COUNTED_clEnqueueReadBuffer, offset, bytes))
WRAPPED(cl_int, clEnqueueWriteBuffer,
        (cl_command_queue queue, cl_mem memory, cl_bool blocking, size_t offset, size_t bytes, const void *host,
         EVENTS),
        (queue, memory, blocking, offset, bytes, host, EVENTS_GIVEN),
        note_transfer(COUNTED_clEnqueueWriteBuffer, offset, bytes))
WRAPPED(cl_int, clEnqueueCopyBuffer,
        (cl_command_queue queue, cl_mem from, cl_mem to, size_t from_offset, size_t to_offset, size_t bytes, EVENTS),
        (queue, from, to, from_offset, to_offset, bytes, EVENTS_GIVEN),
        note_transfer(COUNTED_clEnqueueCopyBuffer, to_offset, bytes))
WRAPPED(cl_int, clEnqueueFillBuffer,
        (cl_command_queue queue, cl_mem memory, const void *pattern, size_t pattern_bytes, size_t offset, size_t bytes,
         EVENTS),
        (queue, memory, pattern, pattern_bytes, offset, bytes, EVENTS_GIVEN),
        note_transfer(COUNTED_clEnqueueFillBuffer, offset, bytes))
WRAPPED(void *, clEnqueueMapBuffer,
        (cl_command_queue queue, cl_mem memory, cl_bool blocking, cl_map_flags flags, size_t offset, size_t bytes,
         EVENTS, cl_int *error),
        (queue, memory, blocking, flags, offset, bytes, EVENTS_GIVEN, error),
        note_transfer(COUNTED_clEnqueueMapBuffer, offset, bytes))
WRAPPED(cl_int, clEnqueueUnmapMemObject, (cl_command_queue queue, cl_mem memory, void *host, EVENTS),
        (queue, memory, host, EVENTS_GIVEN), ++notes.calls[COUNTED_clEnqueueUnmapMemObject])
WRAPPED(cl_int, clEnqueueMarkerWithWaitList, (cl_command_queue queue, EVENTS), (queue, EVENTS_GIVEN),
        ++notes.calls[COUNTED_clEnqueueMarkerWithWaitList])
WRAPPED(cl_int, clWaitForEvents, (cl_uint count, const cl_event *events), (count, events),
        ++notes.calls[COUNTED_clWaitForEvents])
WRAPPED(cl_int, clFlush, (cl_command_queue queue), (queue), ++notes.calls[COUNTED_clFlush])
WRAPPED(cl_int, clFinish, (cl_command_queue queue), (queue), ++notes.calls[COUNTED_clFinish])
/* NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming) */
