/* SPDX-License-Identifier: MIT */
/* Buffers, copies and launches of the plan's kernels. Those of builds are in commands/commands.c, after this room. */
#include "plan/launch.h"

#include <string.h>

#include "shared/layout.h"

bool svo_i_launcher_is_ready(const svo_device *device)
{
    return svo_i_program_known(device, SVO_I_PROGRAM_PLAN, "");
}

svo_status svo_i_launcher_begin(svo_i_launcher *launcher, svo_device *device, const char *function)
{
    launcher->device = device;
    launcher->function = function;
    return svo_i_program_get(device, function, SVO_I_PROGRAM_PLAN, "", &launcher->program, NULL);
}

void svo_i_launcher_end(svo_i_launcher *launcher)
{
    if (launcher->last != NULL) {
        (void)svo_i_event_settle(launcher->last);
        clReleaseEvent(launcher->last);
        launcher->last = NULL;
    }
}

/* Makes event the newest command, or converts the error of its call into a status. */
static svo_status follow(svo_i_launcher *launcher, const char *call, cl_int error, cl_event event)
{
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(launcher->device, launcher->function, call, error);
    }
    if (launcher->last != NULL) {
        clReleaseEvent(launcher->last);
    }
    launcher->last = event;
    return SVO_OK;
}

static cl_uint wait_count(const svo_i_launcher *launcher)
{
    return launcher->last != NULL ? 1 : launcher->wait_count;
}

static const cl_event *wait_list(const svo_i_launcher *launcher)
{
    return launcher->last != NULL ? &launcher->last : launcher->wait;
}

svo_status svo_i_launcher_buffer(svo_i_launcher *launcher, const char *name, uint64_t bytes, cl_mem *out)
{
    return svo_i_device_buffer(launcher->device, launcher->function, name, CL_MEM_READ_WRITE, (size_t)bytes, out);
}

/* The host's memory as a buffer, without a copy: the kernels only read it. */
static svo_status borrow(svo_i_launcher *launcher, const void *data, uint64_t bytes, cl_mem *out)
{
    cl_int error = CL_SUCCESS;
    void *memory = NULL;
    memcpy(&memory, &data, sizeof memory); /* clCreateBuffer takes no pointer to const */
    *out = clCreateBuffer(launcher->device->context, CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR, (size_t)bytes, memory,
                          &error);
    return error == CL_SUCCESS ? SVO_OK
                               : svo_i_device_fail_cl(launcher->device, launcher->function, "clCreateBuffer", error);
}

svo_status svo_i_launcher_input(svo_i_launcher *launcher, const char *name, const void *data, uint64_t bytes,
                                cl_mem *out)
{
    if (launcher->device->cpu_path && bytes > 0) {
        return borrow(launcher, data, bytes, out);
    }
    cl_event event = NULL;
    SVO_I_TRY(svo_i_launcher_buffer(launcher, name, bytes, out));
    if (bytes == 0) {
        return SVO_OK;
    }
    const cl_int error = clEnqueueWriteBuffer(launcher->queue, *out, CL_TRUE, 0, (size_t)bytes, data,
                                              wait_count(launcher), wait_list(launcher), &event);
    return follow(launcher, "clEnqueueWriteBuffer", error, event);
}

void svo_i_launcher_free(cl_mem *buffer)
{
    if (*buffer != NULL) {
        clReleaseMemObject(*buffer);
        *buffer = NULL;
    }
}

svo_status svo_i_launcher_fill(svo_i_launcher *launcher, cl_mem buffer, const void *pattern, size_t pattern_bytes,
                               uint64_t bytes)
{
    cl_event event = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    const cl_int error = clEnqueueFillBuffer(launcher->queue, buffer, pattern, pattern_bytes, 0, (size_t)bytes,
                                             wait_count(launcher), wait_list(launcher), &event);
    return follow(launcher, "clEnqueueFillBuffer", error, event);
}

svo_status svo_i_launcher_zero(svo_i_launcher *launcher, cl_mem buffer, uint64_t bytes)
{
    const cl_uchar zero = 0;
    return svo_i_launcher_fill(launcher, buffer, &zero, sizeof zero, bytes);
}

svo_status svo_i_launcher_copy(svo_i_launcher *launcher, cl_mem from, cl_mem to, uint64_t bytes)
{
    cl_event event = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    const cl_int error = clEnqueueCopyBuffer(launcher->queue, from, to, 0, 0, (size_t)bytes, wait_count(launcher),
                                             wait_list(launcher), &event);
    return follow(launcher, "clEnqueueCopyBuffer", error, event);
}

svo_status svo_i_launcher_write(svo_i_launcher *launcher, cl_mem buffer, const void *data, uint64_t bytes)
{
    cl_event event = NULL;
    const cl_int error = clEnqueueWriteBuffer(launcher->queue, buffer, CL_FALSE, 0, (size_t)bytes, data,
                                              wait_count(launcher), wait_list(launcher), &event);
    return follow(launcher, "clEnqueueWriteBuffer", error, event);
}

svo_status svo_i_launcher_read(svo_i_launcher *launcher, cl_mem buffer, uint64_t offset, void *to, uint64_t bytes)
{
    cl_event event = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    const cl_int error = clEnqueueReadBuffer(launcher->queue, buffer, CL_TRUE, (size_t)offset, (size_t)bytes, to,
                                             wait_count(launcher), wait_list(launcher), &event);
    return follow(launcher, "clEnqueueReadBuffer", error, event);
}

static svo_status launch(svo_i_launcher *launcher, cl_kernel kernel, const svo_i_argument *arguments,
                         cl_uint argument_count, uint64_t items)
{
    SVO_I_TRY(svo_i_kernel_set(launcher->device, launcher->function, kernel, arguments, argument_count));
    const size_t local = SVO_GROUP_ITEMS;
    const size_t global = (size_t)((items + local - 1) / local) * local;
    cl_event event = NULL;
    const cl_int error = clEnqueueNDRangeKernel(launcher->queue, kernel, 1, NULL, &global, &local, wait_count(launcher),
                                                wait_list(launcher), &event);
    return follow(launcher, "clEnqueueNDRangeKernel", error, event);
}

svo_status svo_i_launcher_run(svo_i_launcher *launcher, const char *kernel, const svo_i_argument *arguments,
                              cl_uint argument_count, uint64_t items)
{
    cl_kernel created = NULL;
    if (items == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_kernel_create(launcher->device, launcher->function, launcher->program, kernel, &created));
    const svo_status status = launch(launcher, created, arguments, argument_count, items);
    clReleaseKernel(created);
    return status;
}
