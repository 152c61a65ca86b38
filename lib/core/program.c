/* SPDX-License-Identifier: MIT */
/* Compiles the embedded kernels; a device handle keeps the programs. */
#include "core/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEFINES_BYTES 512

/* A program that was compiled, attached to its device. */
typedef struct compiled_program {
    svo_i_attachment attachment;
    svo_i_program_kind kind;
    char defines[DEFINES_BYTES];
    cl_program program;
} compiled_program;

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_build[];
extern const char svo_i_source_cast[];
extern const char svo_i_source_voxelize[];
extern const char svo_i_source_sort[];
extern const char svo_i_source_trace[];
extern const char svo_i_source_view[];

static void release_program(svo_i_attachment *attachment)
{
    compiled_program *entry = (compiled_program *)attachment;
    clReleaseProgram(entry->program);
    free(entry);
}

static const compiled_program *find_program(const svo_device *device, svo_i_program_kind kind, const char *defines)
{
    svo_i_attachment *at = svo_i_attachment_find(device->attachments, release_program);
    while (at != NULL) {
        const compiled_program *entry = (const compiled_program *)at;
        if (entry->kind == kind && strcmp(entry->defines, defines) == 0) {
            return entry;
        }
        at = svo_i_attachment_find(at->next, release_program);
    }
    return NULL;
}

/* Reports a failed build: one line in the message, all of the log to the callback. */
static svo_status fail_build(svo_device *device, const char *function, cl_program program, const char *options)
{
    size_t bytes = 0;
    clGetProgramBuildInfo(program, device->device, CL_PROGRAM_BUILD_LOG, 0, NULL, &bytes);
    char *log = calloc(bytes + 1, 1);
    if (log != NULL && bytes > 0) {
        clGetProgramBuildInfo(program, device->device, CL_PROGRAM_BUILD_LOG, bytes, log, NULL);
        svo_i_device_log(device, SVO_LOG_ERROR, log);
    }
    const char *error = log != NULL ? strstr(log, "error") : NULL;
    const int length = error != NULL ? (int)strcspn(error, "\n") : 0;
    svo_i_device_fail(device, SVO_COMPILE_FAILED, "%s: kernels do not compile on %s with %s: %.*s", function,
                      device->name, options, length, error != NULL ? error : "");
    free(log);
    return SVO_COMPILE_FAILED;
}

static svo_status compile(svo_device *device, const char *function, svo_i_program_kind kind, const char *defines,
                          cl_program *out)
{
    const char *const sources[SVO_I_PROGRAM_KINDS] = {
        [SVO_I_PROGRAM_BUILD] = svo_i_source_build,       [SVO_I_PROGRAM_CAST] = svo_i_source_cast,
        [SVO_I_PROGRAM_VOXELIZE] = svo_i_source_voxelize, [SVO_I_PROGRAM_SORT] = svo_i_source_sort,
        [SVO_I_PROGRAM_TRACE] = svo_i_source_trace,       [SVO_I_PROGRAM_VIEW] = svo_i_source_view};
    const char *source = sources[kind];
    char options[DEFINES_BYTES + 32];
    (void)snprintf(options, sizeof options, "-cl-std=CL1.2%s", defines);
    cl_int error = CL_SUCCESS;
    cl_program program = clCreateProgramWithSource(device->context, 1, &source, NULL, &error);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, function, "clCreateProgramWithSource", error);
    }
    error = clBuildProgram(program, 1, &device->device, options, NULL, NULL);
    if (error != CL_SUCCESS) {
        const svo_status status = error == CL_BUILD_PROGRAM_FAILURE
                                      ? fail_build(device, function, program, options)
                                      : svo_i_device_fail_cl(device, function, "clBuildProgram", error);
        clReleaseProgram(program);
        return status;
    }
    *out = program;
    return SVO_OK;
}

svo_status svo_i_program_get(svo_device *device, const char *function, svo_i_program_kind kind, const char *defines,
                             cl_program *out, bool *fresh)
{
    if (fresh != NULL) {
        *fresh = false;
    }
    const compiled_program *known = find_program(device, kind, defines);
    if (known != NULL) {
        *out = known->program;
        return SVO_OK;
    }
    compiled_program *entry = calloc(1, sizeof *entry);
    if (entry == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a program", function);
    }
    if (strlen(defines) >= sizeof entry->defines) {
        free(entry);
        return svo_i_device_fail(device, SVO_INTERNAL, "%s: defines take %zu bytes, above %d", function,
                                 strlen(defines), DEFINES_BYTES - 1);
    }
    const double start_ms = svo_i_now_ms();
    const svo_status status = compile(device, function, kind, defines, &entry->program);
    device->compile_ms += svo_i_now_ms() - start_ms;
    if (status != SVO_OK) {
        free(entry);
        return status;
    }
    memcpy(entry->defines, defines, strlen(defines) + 1);
    entry->kind = kind;
    entry->attachment.destroy = release_program;
    svo_i_attachment_add(&device->attachments, &entry->attachment);
    *out = entry->program;
    if (fresh != NULL) {
        *fresh = true;
    }
    return SVO_OK;
}

svo_status svo_i_kernel_create(svo_device *device, const char *function, cl_program program, const char *name,
                               cl_kernel *out)
{
    cl_int error = CL_SUCCESS;
    cl_kernel kernel = clCreateKernel(program, name, &error);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, function, name, error);
    }
    *out = kernel;
    return SVO_OK;
}

svo_status svo_i_kernel_set(svo_device *device, const char *function, cl_kernel kernel, const svo_i_argument *arguments,
                            cl_uint argument_count)
{
    for (cl_uint i = 0; i < argument_count; ++i) {
        const cl_int error = clSetKernelArg(kernel, i, arguments[i].bytes, arguments[i].value);
        if (error != CL_SUCCESS) {
            return svo_i_device_fail_cl(device, function, "clSetKernelArg", error);
        }
    }
    return SVO_OK;
}
