/* SPDX-License-Identifier: MIT */
#include "support/cl_calls.h"

#include <CL/cl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/input.h"
#include "support/json.h"
#include "support/wrapped.h"

#ifdef SVOCL_COUNTS_CL_CALLS

static cl_calls counted;

/* ---- kernels ---- */

#define KERNELS_MAX   256
#define NAME_BYTES    64
#define VERBOSE       " -cl-nv-verbose"
#define OPTIONS_BYTES 1024

/* A kernel of a program. Its local memory is known once its arguments are set, at its first launch. */
typedef struct kept_kernel {
    cl_program compiled;
    char name[NAME_BYTES];
    cl_kernel waiting; /* for its first launch; NULL: none, or launched */
    bool is_launched;
    cl_ulong local_bytes, private_bytes;
    size_t multiple;
    unsigned registers; /* 0: not known */
} kept_kernel;

static kept_kernel kept[KERNELS_MAX];
static size_t kept_count;
static bool keeps_kernels;

void cl_calls_keep_kernels(void)
{
    keeps_kernels = true;
}

/* The registers by the program's log. */
static unsigned registers_of(cl_program compiled, cl_device_id device, const char *name)
{
    size_t bytes = 0;
    clGetProgramBuildInfo(compiled, device, CL_PROGRAM_BUILD_LOG, 0, NULL, &bytes);
    char *log = calloc(bytes + 1, 1);
    if (log == NULL) {
        return 0;
    }
    clGetProgramBuildInfo(compiled, device, CL_PROGRAM_BUILD_LOG, bytes, log, NULL);
    const unsigned registers = log_registers(log, name);
    free(log);
    return registers;
}

static void describe_kernel(cl_kernel kernel, kept_kernel *out)
{
    cl_device_id device = NULL;
    /* The library's programs are of one device. */
    clGetProgramInfo(out->compiled, CL_PROGRAM_DEVICES, sizeof device, &device, NULL);
    clGetKernelWorkGroupInfo(kernel, device, CL_KERNEL_LOCAL_MEM_SIZE, sizeof out->local_bytes, &out->local_bytes,
                             NULL);
    clGetKernelWorkGroupInfo(kernel, device, CL_KERNEL_PRIVATE_MEM_SIZE, sizeof out->private_bytes, &out->private_bytes,
                             NULL);
    clGetKernelWorkGroupInfo(kernel, device, CL_KERNEL_PREFERRED_WORK_GROUP_SIZE_MULTIPLE, sizeof out->multiple,
                             &out->multiple, NULL);
    out->registers = registers_of(out->compiled, device, out->name);
    out->waiting = NULL;
    out->is_launched = true;
}

/* Keeps a new kernel, unless the program's kernel of that name was launched. */
static void keep_kernel(cl_program compiled, const char *name, cl_kernel kernel)
{
    size_t found = kept_count;
    for (size_t i = 0; i < kept_count; ++i) {
        if (kept[i].waiting == kernel) { /* another one, which was released */
            kept[i].waiting = NULL;
        }
        if (kept[i].compiled == compiled && strcmp(kept[i].name, name) == 0) {
            found = i;
        }
    }
    if (found == kept_count && found < KERNELS_MAX && strlen(name) < NAME_BYTES) {
        kept[found] = (kept_kernel){.compiled = compiled};
        memcpy(kept[found].name, name, strlen(name) + 1);
        ++kept_count;
    }
    if (found < kept_count && !kept[found].is_launched) {
        kept[found].waiting = kernel;
    }
}

static void note_launch(cl_kernel kernel)
{
    for (size_t i = 0; i < kept_count; ++i) {
        if (kept[i].waiting == kernel) {
            describe_kernel(kernel, &kept[i]);
        }
    }
    ++counted.launches;
}

void cl_calls_add_kernels(cJSON *document)
{
    cJSON *array = cJSON_AddArrayToObject(document, "compiled_kernels");
    for (size_t i = 0; i < kept_count; ++i) {
        if (!kept[i].is_launched) {
            continue;
        }
        cJSON *kernel = cJSON_CreateObject();
        json_add_text(kernel, "name", kept[i].name);
        json_add_count(kernel, "local_bytes", kept[i].local_bytes);
        json_add_count(kernel, "private_bytes", kept[i].private_bytes);
        json_add_count(kernel, "group_multiple", kept[i].multiple);
        if (kept[i].registers > 0) {
            json_add_count(kernel, "registers", kept[i].registers);
        }
        cJSON_AddItemToArray(array, kernel);
    }
}

/* Whether the device's compiler knows NVIDIA's options. */
static bool has_nv_options(cl_device_id device)
{
    size_t bytes = 0;
    clGetDeviceInfo(device, CL_DEVICE_EXTENSIONS, 0, NULL, &bytes);
    char *text = calloc(bytes + 1, 1);
    bool has = false;
    if (text != NULL) {
        clGetDeviceInfo(device, CL_DEVICE_EXTENSIONS, bytes, text, NULL);
        has = strstr(text, "cl_nv_compiler_options") != NULL;
        free(text);
    }
    return has;
}

/* ---- calls ---- */

bool cl_calls_count(cl_calls *counts)
{
    *counts = counted;
    return true;
}

/* NOLINTBEGIN(readability-identifier-naming): names of the linker */
WRAPPED(cl_int, clEnqueueNDRangeKernel,
        (cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset, const size_t *global,
         const size_t *local, EVENTS),
        (queue, kernel, dimensions, offset, global, local, EVENTS_GIVEN), note_launch(kernel))

WRAPPED(cl_int, clEnqueueWriteBuffer,
        (cl_command_queue queue, cl_mem buffer, cl_bool blocks, size_t offset, size_t bytes, const void *from, EVENTS),
        (queue, buffer, blocks, offset, bytes, from, EVENTS_GIVEN),
        (++counted.uploads, counted.waits += blocks != CL_FALSE))

WRAPPED(cl_int, clWaitForEvents, (cl_uint count, const cl_event *events), (count, events), ++counted.waits)
WRAPPED(cl_int, clFinish, (cl_command_queue queue), (queue), ++counted.waits)

/* Counts a read or a map, and adds the time of one that blocks. */
static void count_read(cl_bool blocks, double begun_ms)
{
    if (blocks != CL_FALSE) {
        ++counted.waits;
        ++counted.reads;
        counted.reads_ms += input_now_ms() - begun_ms;
    }
}

cl_int __real_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocks, size_t offset, size_t bytes,
                                  void *to, EVENTS);
cl_int __wrap_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocks, size_t offset, size_t bytes,
                                  void *to, EVENTS);
cl_int __wrap_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocks, size_t offset, size_t bytes,
                                  void *to, EVENTS)
{
    const double begun_ms = input_now_ms();
    const cl_int error = __real_clEnqueueReadBuffer(queue, buffer, blocks, offset, bytes, to, EVENTS_GIVEN);
    count_read(blocks, begun_ms);
    return error;
}

void *__real_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocks, cl_map_flags flags,
                                size_t offset, size_t bytes, EVENTS, cl_int *error);
void *__wrap_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocks, cl_map_flags flags,
                                size_t offset, size_t bytes, EVENTS, cl_int *error);
void *__wrap_clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocks, cl_map_flags flags,
                                size_t offset, size_t bytes, EVENTS, cl_int *error)
{
    const double begun_ms = input_now_ms();
    void *mapped = __real_clEnqueueMapBuffer(queue, buffer, blocks, flags, offset, bytes, EVENTS_GIVEN, error);
    count_read(blocks, begun_ms);
    return mapped;
}

cl_mem __real_clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error);
cl_mem __wrap_clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error);
cl_mem __wrap_clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *host, cl_int *error)
{
    const double begun_ms = input_now_ms();
    cl_mem made = __real_clCreateBuffer(context, flags, bytes, host, error);
    counted.uploads += (flags & CL_MEM_COPY_HOST_PTR) != 0;
    ++counted.buffers;
    counted.buffers_ms += input_now_ms() - begun_ms;
    return made;
}

cl_kernel __real_clCreateKernel(cl_program compiled, const char *name, cl_int *error);
cl_kernel __wrap_clCreateKernel(cl_program compiled, const char *name, cl_int *error);
cl_kernel __wrap_clCreateKernel(cl_program compiled, const char *name, cl_int *error)
{
    cl_kernel made = __real_clCreateKernel(compiled, name, error);
    if (keeps_kernels && made != NULL) {
        keep_kernel(compiled, name, made);
    }
    return made;
}

typedef void CL_CALLBACK build_callback(cl_program compiled, void *user);
cl_int __real_clBuildProgram(cl_program compiled, cl_uint count, const cl_device_id *devices, const char *given,
                             build_callback *callback, void *user);
cl_int __wrap_clBuildProgram(cl_program compiled, cl_uint count, const cl_device_id *devices, const char *given,
                             build_callback *callback, void *user);
cl_int __wrap_clBuildProgram(cl_program compiled, cl_uint count, const cl_device_id *devices, const char *given,
                             build_callback *callback, void *user)
{
    char verbose[OPTIONS_BYTES];
    if (keeps_kernels && given != NULL && strlen(given) + sizeof VERBOSE <= sizeof verbose && count > 0 &&
        has_nv_options(devices[0])) {
        (void)snprintf(verbose, sizeof verbose, "%s" VERBOSE, given);
        given = verbose;
    }
    return __real_clBuildProgram(compiled, count, devices, given, callback, user);
}
/* NOLINTEND(readability-identifier-naming) */

#else

void cl_calls_keep_kernels(void)
{
}

void cl_calls_add_kernels(cJSON *document)
{
    (void)cJSON_AddArrayToObject(document, "compiled_kernels");
}

bool cl_calls_count(cl_calls *counts)
{
    *counts = (cl_calls){0};
    return false;
}

#endif

cl_calls cl_calls_since(const cl_calls *before)
{
    cl_calls now;
    (void)cl_calls_count(&now);
    return (cl_calls){.launches = now.launches - before->launches,
                      .uploads = now.uploads - before->uploads,
                      .waits = now.waits - before->waits,
                      .buffers = now.buffers - before->buffers,
                      .reads = now.reads - before->reads,
                      .buffers_ms = now.buffers_ms - before->buffers_ms,
                      .reads_ms = now.reads_ms - before->reads_ms};
}
