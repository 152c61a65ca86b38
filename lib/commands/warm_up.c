/* SPDX-License-Identifier: MIT */
/* Warm-up launches. The measuring build in build/measure.c passes every launch of a build with its size. */
#include "commands/warm_up.h"

#include <string.h>

#include "shared/layout.h"

/* PoCL compiles kernels separately for launches of at most 65535 work-items and for larger ones. */
#define LARGE_ITEMS 131072u
/* Size of a buffer of zeros: kernels that read zero counts still write the sums. The radix sort's are the largest. */
#define ZERO_BYTES (sizeof(cl_uint) * SVO_SORT_DIGITS * SVO_SORT_BLOCKS)
/* At least the largest params struct. */
#define PARAMS_BYTES  256
#define ARGUMENTS_MAX (SVO_I_WARM_UP_BUFFERS + 8)

static const char function[] = "svo_build";

svo_i_warm_up svo_i_warm_up_begin(svo_device *device, cl_command_queue queue)
{
    return (svo_i_warm_up){.device = device, .queue = queue};
}

void svo_i_warm_up_add_program(svo_i_warm_up *warm_up, cl_program program)
{
    if (warm_up->program_count < SVO_I_WARM_UP_PROGRAMS) {
        warm_up->programs[warm_up->program_count++] = program;
    }
}

/* Makes event the newest command, or converts the error of its call into a status. */
static svo_status follow(svo_i_warm_up *warm_up, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(warm_up->device, function, call, error);
    }
    if (warm_up->last != NULL) {
        clReleaseEvent(warm_up->last);
    }
    warm_up->last = event;
    return SVO_OK;
}

/* The buffer of zeros for the buffer argument with this index, created on first use. */
static svo_status get_zeros(svo_i_warm_up *warm_up, cl_uint index, cl_mem **out)
{
    static const cl_uint zero = 0;
    cl_mem *buffer = &warm_up->zeros[index];
    if (*buffer == NULL) {
        SVO_I_TRY(svo_i_device_buffer(warm_up->device, function, "zeros", CL_MEM_READ_WRITE, ZERO_BYTES, buffer));
        cl_event event = NULL;
        const cl_uint wait_count = warm_up->last != NULL ? 1 : 0;
        const cl_int error = clEnqueueFillBuffer(warm_up->queue, *buffer, &zero, sizeof zero, 0, ZERO_BYTES, wait_count,
                                                 wait_count > 0 ? &warm_up->last : NULL, &event);
        SVO_I_TRY(follow(warm_up, "clEnqueueFillBuffer", error, event));
    }
    *out = buffer;
    return SVO_OK;
}

static bool is_fresh(const svo_i_warm_up *warm_up, cl_program program)
{
    for (size_t i = 0; i < warm_up->program_count; ++i) {
        if (warm_up->programs[i] == program) {
            return true;
        }
    }
    return false;
}

/* Records the launch. Returns false if it is to be skipped. */
static bool record_launch(svo_i_warm_up *warm_up, cl_kernel kernel, bool is_large)
{
    svo_i_warm_launch launch = {.is_large = is_large};
    clGetKernelInfo(kernel, CL_KERNEL_PROGRAM, sizeof launch.program, &launch.program, NULL);
    clGetKernelInfo(kernel, CL_KERNEL_FUNCTION_NAME, sizeof launch.name, launch.name, NULL);
    if (!is_fresh(warm_up, launch.program) || warm_up->launch_count == SVO_I_WARM_UP_LAUNCHES) {
        return false;
    }
    for (size_t i = 0; i < warm_up->launch_count; ++i) {
        const svo_i_warm_launch *made = &warm_up->launches[i];
        if (made->program == launch.program && made->is_large == is_large && strcmp(made->name, launch.name) == 0) {
            return false;
        }
    }
    warm_up->launches[warm_up->launch_count++] = launch;
    return true;
}

svo_status svo_i_warm_up_launch(svo_i_warm_up *warm_up, cl_kernel kernel, const svo_i_argument *arguments,
                                cl_uint argument_count, uint64_t items)
{
    static const unsigned char no_params[PARAMS_BYTES] = {0};
    svo_i_argument zeroed[ARGUMENTS_MAX];
    const bool is_large = items >= LARGE_ITEMS / 2;
    if (argument_count > ARGUMENTS_MAX || !record_launch(warm_up, kernel, is_large)) {
        return SVO_OK;
    }
    cl_uint buffers = 0;
    for (cl_uint i = 0; i < argument_count; ++i) {
        zeroed[i] = arguments[i];
        if (arguments[i].is_buffer) {
            cl_mem *zeros = NULL;
            SVO_I_TRY(get_zeros(warm_up, buffers++, &zeros));
            zeroed[i].value = zeros;
        } else if (arguments[i].value != NULL) {
            zeroed[i].value = no_params;
        }
    }
    SVO_I_TRY(svo_i_kernel_set(warm_up->device, function, kernel, zeroed, argument_count));
    const size_t local = SVO_GROUP_ITEMS;
    const size_t global = is_large ? LARGE_ITEMS : SVO_GROUP_ITEMS;
    cl_event event = NULL;
    const cl_uint wait_count = warm_up->last != NULL ? 1 : 0;
    const cl_int error = clEnqueueNDRangeKernel(warm_up->queue, kernel, 1, NULL, &global, &local, wait_count,
                                                wait_count > 0 ? &warm_up->last : NULL, &event);
    return follow(warm_up, "clEnqueueNDRangeKernel", error, event);
}

void svo_i_warm_up_end(svo_i_warm_up *warm_up)
{
    if (warm_up->last != NULL) {
        clWaitForEvents(1, &warm_up->last);
        clReleaseEvent(warm_up->last);
    }
    for (cl_uint i = 0; i < SVO_I_WARM_UP_BUFFERS; ++i) {
        if (warm_up->zeros[i] != NULL) {
            clReleaseMemObject(warm_up->zeros[i]);
        }
    }
}
