/* SPDX-License-Identifier: MIT */
/* Replaces the OpenCL calls that svocl_count_calls (CMakeLists.txt) wraps. Each wrapper calls the real function and
   records the call. */
#include "counting.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "svocl/device.h"

#define BUFFERS_MAX       1024
#define BUILDS_MAX        32
#define OPTIONS_BYTES     512
#define KERNEL_LIST_BYTES 4096

typedef struct noted_buffer {
    cl_mem handle; /* NULL: this slot is free */
    cl_mem parent; /* of a sub-buffer */
    uint64_t bytes; /* of its own */
    uint64_t references; /* the caller's and those of its sub-buffers */
} noted_buffer;

typedef struct noted_build {
    char options[OPTIONS_BYTES];
    char kernels[KERNEL_LIST_BYTES]; /* in the form of CL_PROGRAM_KERNEL_NAMES: "one;another" */
} noted_build;

static struct {
    counted figures;
    noted_buffer buffers[BUFFERS_MAX];
    noted_build builds[BUILDS_MAX];
    size_t launches_to_failure; /* 0: no launch fails; 1: the next one */
    bool full; /* a buffer found no place; most calls of a program of several groups are none that anybody counts */
} notes;

/* The linker's names for the real calls and for their wrappers. */
/* NOLINTBEGIN(readability-identifier-naming) */
cl_mem __real_clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error);
cl_mem __wrap_clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error);
cl_mem __real_clCreateSubBuffer(cl_mem parent, cl_mem_flags flags, cl_buffer_create_type type, const void *region,
                                cl_int *error);
cl_mem __wrap_clCreateSubBuffer(cl_mem parent, cl_mem_flags flags, cl_buffer_create_type type, const void *region,
                                cl_int *error);
cl_int __real_clRetainMemObject(cl_mem handle);
cl_int __wrap_clRetainMemObject(cl_mem handle);
cl_int __real_clReleaseMemObject(cl_mem handle);
cl_int __wrap_clReleaseMemObject(cl_mem handle);
cl_program __real_clCreateProgramWithSource(cl_context context, cl_uint count, const char **texts,
                                            const size_t *lengths, cl_int *error);
cl_program __wrap_clCreateProgramWithSource(cl_context context, cl_uint count, const char **texts,
                                            const size_t *lengths, cl_int *error);
typedef void(CL_CALLBACK *build_callback)(cl_program program, void *user);
cl_int __real_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user);
cl_int __wrap_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user);
cl_kernel __real_clCreateKernel(cl_program program, const char *name, cl_int *error);
cl_kernel __wrap_clCreateKernel(cl_program program, const char *name, cl_int *error);
cl_int __real_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                  void *to, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                  void *to, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __real_clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                   const void *from, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                   const void *from, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __real_clEnqueueFillBuffer(cl_command_queue queue, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                                  size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueFillBuffer(cl_command_queue queue, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                                  size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __real_clEnqueueCopyBuffer(cl_command_queue queue, cl_mem from, cl_mem to, size_t from_offset, size_t to_offset,
                                  size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueCopyBuffer(cl_command_queue queue, cl_mem from, cl_mem to, size_t from_offset, size_t to_offset,
                                  size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event);
void *__real_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags flags,
                                size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event,
                                cl_int *error);
void *__wrap_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags flags,
                                size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event,
                                cl_int *error);
cl_int __real_clWaitForEvents(cl_uint num_wait, const cl_event *wait);
cl_int __wrap_clWaitForEvents(cl_uint num_wait, const cl_event *wait);
cl_int __real_clFinish(cl_command_queue queue);
cl_int __wrap_clFinish(cl_command_queue queue);
cl_int __real_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event);
cl_int __wrap_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event);

void counting_begin(void)
{
    memset(&notes, 0, sizeof notes);
}

counted counting_read(void)
{
    assert_false(notes.full);
    return notes.figures;
}

const char *counting_options(size_t index)
{
    assert_true(index < notes.figures.builds && index < BUILDS_MAX);
    return notes.builds[index].options;
}

const char *counting_kernels(size_t index)
{
    assert_true(index < notes.figures.builds && index < BUILDS_MAX);
    return notes.builds[index].kernels;
}

/* ---- memory ---- */

/* NULL for an unknown handle: made earlier, or by another call. For NULL: a free slot. */
static noted_buffer *find_buffer(cl_mem handle)
{
    for (size_t i = 0; i < BUFFERS_MAX; ++i) {
        if (notes.buffers[i].handle == handle) {
            return &notes.buffers[i];
        }
    }
    return NULL;
}

static void note_buffer(cl_mem handle, cl_mem parent, uint64_t bytes)
{
    noted_buffer *place = find_buffer(NULL);
    counted *figures = &notes.figures;
    if (place == NULL) {
        notes.full = true;
        return;
    }
    *place = (noted_buffer){handle, parent, bytes, 1};
    figures->total_bytes += bytes;
    figures->live_bytes += bytes;
    figures->peak_bytes = figures->live_bytes > figures->peak_bytes ? figures->live_bytes : figures->peak_bytes;
    ++figures->live_buffers;
}

static void drop_reference(cl_mem handle)
{
    noted_buffer *buffer = handle != NULL ? find_buffer(handle) : NULL;
    while (buffer != NULL && --buffer->references == 0) {
        const cl_mem parent = buffer->parent;
        notes.figures.live_bytes -= buffer->bytes;
        --notes.figures.live_buffers;
        *buffer = (noted_buffer){0};
        buffer = parent != NULL ? find_buffer(parent) : NULL;
    }
}

static void add_reference(cl_mem handle)
{
    noted_buffer *buffer = handle != NULL ? find_buffer(handle) : NULL;
    if (buffer != NULL) {
        ++buffer->references;
    }
}

cl_mem __wrap_clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error)
{
    const cl_mem handle = __real_clCreateBuffer(context, flags, bytes, host, error);
    if (handle != NULL) {
        ++notes.figures.buffers;
        note_buffer(handle, NULL, bytes);
    }
    return handle;
}

cl_mem __wrap_clCreateSubBuffer(cl_mem parent, cl_mem_flags flags, cl_buffer_create_type type, const void *region,
                                cl_int *error)
{
    const cl_mem handle = __real_clCreateSubBuffer(parent, flags, type, region, error);
    if (handle != NULL) {
        ++notes.figures.sub_buffers;
        note_buffer(handle, parent, 0);
        add_reference(parent);
    }
    return handle;
}

cl_int __wrap_clRetainMemObject(cl_mem handle)
{
    const cl_int error = __real_clRetainMemObject(handle);
    if (error == CL_SUCCESS) {
        add_reference(handle);
    }
    return error;
}

/* Recorded before the call: afterwards the handle may already belong to another buffer. */
cl_int __wrap_clReleaseMemObject(cl_mem handle)
{
    drop_reference(handle);
    return __real_clReleaseMemObject(handle);
}

/* ---- programs ---- */

cl_program __wrap_clCreateProgramWithSource(cl_context context, cl_uint count, const char **texts,
                                            const size_t *lengths, cl_int *error)
{
    const cl_program program = __real_clCreateProgramWithSource(context, count, texts, lengths, error);
    notes.figures.programs += program != NULL ? 1 : 0;
    return program;
}

cl_int __wrap_clBuildProgram(cl_program program, cl_uint count, const cl_device_id *devices, const char *options,
                             build_callback done, void *user)
{
    const cl_int error = __real_clBuildProgram(program, count, devices, options, done, user);
    if (error != CL_SUCCESS) {
        return error;
    }
    size_t kernel_count = 0;
    assert_int_equal(clGetProgramInfo(program, CL_PROGRAM_NUM_KERNELS, sizeof kernel_count, &kernel_count, NULL),
                     CL_SUCCESS);
    notes.figures.built_kernels += kernel_count;
    if (notes.figures.builds < BUILDS_MAX) {
        noted_build *build = &notes.builds[notes.figures.builds];
        snprintf(build->options, sizeof build->options, "%s", options != NULL ? options : "");
        assert_int_equal(
            clGetProgramInfo(program, CL_PROGRAM_KERNEL_NAMES, sizeof build->kernels, build->kernels, NULL),
            CL_SUCCESS);
    }
    ++notes.figures.builds;
    return error;
}

cl_kernel __wrap_clCreateKernel(cl_program program, const char *name, cl_int *error)
{
    const cl_kernel kernel = __real_clCreateKernel(program, name, error);
    notes.figures.kernels += kernel != NULL ? 1 : 0;
    return kernel;
}

/* ---- launches ---- */

void counting_fail_launch(size_t index)
{
    notes.launches_to_failure = index + 1;
}

cl_int __wrap_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                  void *to, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    notes.figures.read_bytes += bytes;
    notes.figures.reads += blocking != CL_FALSE ? 1 : 0;
    notes.figures.waits += blocking != CL_FALSE ? 1 : 0;
    return __real_clEnqueueReadBuffer(queue, buffer, blocking, offset, bytes, to, num_wait, wait, event);
}

cl_int __wrap_clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                   const void *from, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    ++notes.figures.writes;
    notes.figures.written_bytes += bytes;
    notes.figures.waits += blocking != CL_FALSE ? 1 : 0;
    return __real_clEnqueueWriteBuffer(queue, buffer, blocking, offset, bytes, from, num_wait, wait, event);
}

cl_int __wrap_clEnqueueFillBuffer(cl_command_queue queue, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                                  size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    ++notes.figures.fills;
    notes.figures.filled_bytes += bytes;
    return __real_clEnqueueFillBuffer(queue, buffer, pattern, pattern_bytes, offset, bytes, num_wait, wait, event);
}

cl_int __wrap_clEnqueueCopyBuffer(cl_command_queue queue, cl_mem from, cl_mem to, size_t from_offset, size_t to_offset,
                                  size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    ++notes.figures.copies;
    return __real_clEnqueueCopyBuffer(queue, from, to, from_offset, to_offset, bytes, num_wait, wait, event);
}

void *__wrap_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags flags,
                                size_t offset, size_t bytes, cl_uint num_wait, const cl_event *wait, cl_event *event,
                                cl_int *error)
{
    notes.figures.reads += blocking != CL_FALSE ? 1 : 0;
    notes.figures.waits += blocking != CL_FALSE ? 1 : 0;
    return __real_clEnqueueMapBuffer(queue, buffer, blocking, flags, offset, bytes, num_wait, wait, event, error);
}

cl_int __wrap_clWaitForEvents(cl_uint num_wait, const cl_event *wait)
{
    ++notes.figures.waits;
    return __real_clWaitForEvents(num_wait, wait);
}

cl_int __wrap_clFinish(cl_command_queue queue)
{
    ++notes.figures.waits;
    return __real_clFinish(queue);
}

cl_int __wrap_clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                                     const size_t *global, const size_t *local, cl_uint num_wait, const cl_event *wait,
                                     cl_event *event)
{
    if (notes.launches_to_failure > 0 && --notes.launches_to_failure == 0) {
        ++notes.figures.failed_launches;
        return CL_INVALID_KERNEL_ARGS;
    }
    ++notes.figures.launches;
    notes.figures.launched_items += dimensions == 1 ? global[0] : 0;
    return __real_clEnqueueNDRangeKernel(queue, kernel, dimensions, offset, global, local, num_wait, wait, event);
}
/* NOLINTEND(readability-identifier-naming) */
