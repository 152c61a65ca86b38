/* SPDX-License-Identifier: MIT */
/* Warm-up launches. The measuring build in pipeline/run.c passes every launch of a build with its size. */
#include "commands/warm_up.h"

#include <string.h>

#include "plan/accounts.h"
#include "shared/layout.h"

/* PoCL compiles kernels separately for launches below 65535 work-items and for larger ones. What it has for larger ones
   it uses for smaller ones, so that a launch of many spares one of few (core/proof.h). */
#define LARGE_ITEMS 131072u
/* Size of a buffer of zeros: kernels that read zero counts still write the sums, of which those of scans are the
   largest, a vector for each group. */
#define ZERO_BYTES (sizeof(cl_uint4) * (LARGE_ITEMS / SVO_GROUP_ITEMS))
/* Limits of a kernel's arguments: the size of a scalar or params struct, and their number. */
#define PARAMS_BYTES  256
#define ARGUMENTS_MAX (SVO_I_WARM_UP_BUFFERS + 8)

/* Rough times of a new program, for the progress: of all, of its source, and of a kernel at its first launch. */
#define PROGRAM_NS 400e6
#define SOURCE_NS  100e6
#define KERNEL_NS  50e6

svo_i_warm_up svo_i_warm_up_begin(svo_plan *plan, cl_command_queue queue)
{
    return (svo_i_warm_up){.device = plan->device, .plan = plan, .queue = queue};
}

/* The build exceeds a limit of the warm-up: a mistake in the library. */
static svo_status fail_limit(const svo_i_warm_up *warm_up, const char *what, size_t limit)
{
    return svo_i_device_fail(warm_up->device, SVO_INTERNAL, "%s: the warm-up has room for %zu %s", SVO_I_BUILD, limit,
                             what);
}

/* Waits for the launches and tells the plan's callback, if it has one. */
static svo_status advance(svo_i_warm_up *warm_up, double ns)
{
    if (!svo_i_progress_add(warm_up->plan, SVO_STAGE_COMPILE, ns)) {
        return SVO_OK;
    }
    if (warm_up->last != NULL) {
        clWaitForEvents(1, &warm_up->last);
    }
    return svo_i_progress_tell(warm_up->plan, SVO_STAGE_COMPILE);
}

svo_status svo_i_warm_up_add_program(svo_i_warm_up *warm_up, cl_program program)
{
    if (warm_up->program_count == SVO_I_WARM_UP_PROGRAMS) {
        return fail_limit(warm_up, "programs", SVO_I_WARM_UP_PROGRAMS);
    }
    warm_up->programs[warm_up->program_count++] = program;
    warm_up->plan->progress.expected_ns[SVO_STAGE_COMPILE] += PROGRAM_NS;
    return advance(warm_up, SOURCE_NS);
}

/* Makes event the newest command, or converts the error of its call into a status. */
static svo_status follow(svo_i_warm_up *warm_up, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(warm_up->device, SVO_I_BUILD, call, error);
    }
    if (warm_up->last != NULL) {
        clReleaseEvent(warm_up->last);
    }
    warm_up->last = event;
    return SVO_OK;
}

/* The buffer of zeros for the buffer argument with this index, created on first use. */
static svo_status get_zeros(svo_i_warm_up *warm_up, cl_uint index, const cl_mem **out)
{
    static const cl_uint zero = 0;
    if (index >= SVO_I_WARM_UP_BUFFERS) {
        return fail_limit(warm_up, "buffer arguments", SVO_I_WARM_UP_BUFFERS);
    }
    cl_mem *buffer = &warm_up->zeros[index];
    if (*buffer == NULL) {
        SVO_I_TRY(svo_i_device_buffer(warm_up->device, SVO_I_BUILD, "zeros", CL_MEM_READ_WRITE, ZERO_BYTES, buffer));
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

static bool is_made(const svo_i_warm_up *warm_up, const svo_i_warm_launch *launch)
{
    for (size_t i = 0; i < warm_up->launch_count; ++i) {
        const svo_i_warm_launch *made = &warm_up->launches[i];
        if (made->program == launch->program && (made->is_large || !launch->is_large) &&
            strcmp(made->name, launch->name) == 0) {
            return true;
        }
    }
    return false;
}

/* Records the launch. *skip: whether it is not needed. */
static svo_status record_launch(svo_i_warm_up *warm_up, cl_kernel kernel, bool is_large, bool *skip)
{
    svo_i_warm_launch launch = {.is_large = is_large};
    cl_int error = clGetKernelInfo(kernel, CL_KERNEL_PROGRAM, sizeof launch.program, &launch.program, NULL);
    if (error == CL_SUCCESS) {
        error = clGetKernelInfo(kernel, CL_KERNEL_FUNCTION_NAME, sizeof launch.name, launch.name, NULL);
    }
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(warm_up->device, SVO_I_BUILD, "clGetKernelInfo", error);
    }
    *skip = !is_fresh(warm_up, launch.program) || is_made(warm_up, &launch);
    if (!*skip && warm_up->launch_count == SVO_I_WARM_UP_LAUNCHES) {
        return fail_limit(warm_up, "launches", SVO_I_WARM_UP_LAUNCHES);
    }
    if (!*skip) {
        warm_up->launches[warm_up->launch_count++] = launch;
    }
    return SVO_OK;
}

/* Sets the kernel's arguments to zero, buffers included. Local memory keeps its size. */
static svo_status set_zeros(svo_i_warm_up *warm_up, cl_kernel kernel, const svo_i_argument *arguments,
                            cl_uint argument_count)
{
    static const unsigned char no_params[PARAMS_BYTES] = {0};
    svo_i_argument zeroed[ARGUMENTS_MAX];
    cl_uint buffers = 0;
    if (argument_count > ARGUMENTS_MAX) {
        return fail_limit(warm_up, "arguments", ARGUMENTS_MAX);
    }
    for (cl_uint i = 0; i < argument_count; ++i) {
        zeroed[i] = arguments[i];
        if (arguments[i].is_buffer) {
            const cl_mem *zeros = NULL;
            SVO_I_TRY(get_zeros(warm_up, buffers++, &zeros));
            zeroed[i].value = zeros;
        } else if (arguments[i].value != NULL) {
            if (arguments[i].bytes > PARAMS_BYTES) {
                return fail_limit(warm_up, "bytes of an argument", PARAMS_BYTES);
            }
            zeroed[i].value = no_params;
        }
    }
    return svo_i_kernel_set(warm_up->device, SVO_I_BUILD, kernel, zeroed, argument_count);
}

svo_status svo_i_warm_up_launch(svo_i_warm_up *warm_up, cl_kernel kernel, const svo_i_argument *arguments,
                                cl_uint argument_count, uint64_t items, size_t group_items)
{
    const bool is_large = items >= LARGE_ITEMS / 2;
    bool skip = false;
    SVO_I_TRY(record_launch(warm_up, kernel, is_large, &skip));
    if (skip) {
        return SVO_OK;
    }
    SVO_I_TRY(set_zeros(warm_up, kernel, arguments, argument_count));
    const size_t global = is_large ? LARGE_ITEMS : group_items;
    cl_event event = NULL;
    const cl_uint wait_count = warm_up->last != NULL ? 1 : 0;
    const cl_int error = clEnqueueNDRangeKernel(warm_up->queue, kernel, 1, NULL, &global, &group_items, wait_count,
                                                wait_count > 0 ? &warm_up->last : NULL, &event);
    SVO_I_TRY(follow(warm_up, "clEnqueueNDRangeKernel", error, event));
    return advance(warm_up, KERNEL_NS);
}

void svo_i_warm_up_end(svo_i_warm_up *warm_up)
{
    if (warm_up->last != NULL) {
        (void)svo_i_event_settle(warm_up->last);
        clReleaseEvent(warm_up->last);
    }
    for (cl_uint i = 0; i < SVO_I_WARM_UP_BUFFERS; ++i) {
        if (warm_up->zeros[i] != NULL) {
            clReleaseMemObject(warm_up->zeros[i]);
        }
    }
}
