/* SPDX-License-Identifier: MIT */
/* The device handle: how an OpenCL device is chosen, its limits, messages, buffers and own queue. */
#define _POSIX_C_SOURCE 200809L
#include "core/device.h"

#include <CL/cl_gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "core/struct_size.h"
#include "shared/layout.h"

/* The error codes of OpenCL 1.2 and cl_khr_gl_sharing. */
#define CL_ERROR_LIST(X)                            \
    X(CL_DEVICE_NOT_FOUND)                          \
    X(CL_DEVICE_NOT_AVAILABLE)                      \
    X(CL_COMPILER_NOT_AVAILABLE)                    \
    X(CL_MEM_OBJECT_ALLOCATION_FAILURE)             \
    X(CL_OUT_OF_RESOURCES)                          \
    X(CL_OUT_OF_HOST_MEMORY)                        \
    X(CL_PROFILING_INFO_NOT_AVAILABLE)              \
    X(CL_MEM_COPY_OVERLAP)                          \
    X(CL_BUILD_PROGRAM_FAILURE)                     \
    X(CL_MAP_FAILURE)                               \
    X(CL_MISALIGNED_SUB_BUFFER_OFFSET)              \
    X(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) \
    X(CL_INVALID_VALUE)                             \
    X(CL_INVALID_DEVICE_TYPE)                       \
    X(CL_INVALID_PLATFORM)                          \
    X(CL_INVALID_DEVICE)                            \
    X(CL_INVALID_CONTEXT)                           \
    X(CL_INVALID_QUEUE_PROPERTIES)                  \
    X(CL_INVALID_COMMAND_QUEUE)                     \
    X(CL_INVALID_HOST_PTR)                          \
    X(CL_INVALID_MEM_OBJECT)                        \
    X(CL_INVALID_BINARY)                            \
    X(CL_INVALID_BUILD_OPTIONS)                     \
    X(CL_INVALID_PROGRAM)                           \
    X(CL_INVALID_PROGRAM_EXECUTABLE)                \
    X(CL_INVALID_KERNEL_NAME)                       \
    X(CL_INVALID_KERNEL_DEFINITION)                 \
    X(CL_INVALID_KERNEL)                            \
    X(CL_INVALID_ARG_INDEX)                         \
    X(CL_INVALID_ARG_VALUE)                         \
    X(CL_INVALID_ARG_SIZE)                          \
    X(CL_INVALID_KERNEL_ARGS)                       \
    X(CL_INVALID_WORK_DIMENSION)                    \
    X(CL_INVALID_WORK_GROUP_SIZE)                   \
    X(CL_INVALID_WORK_ITEM_SIZE)                    \
    X(CL_INVALID_GLOBAL_OFFSET)                     \
    X(CL_INVALID_EVENT_WAIT_LIST)                   \
    X(CL_INVALID_EVENT)                             \
    X(CL_INVALID_OPERATION)                         \
    X(CL_INVALID_GL_OBJECT)                         \
    X(CL_INVALID_BUFFER_SIZE)                       \
    X(CL_INVALID_GLOBAL_WORK_SIZE)                  \
    X(CL_INVALID_PROPERTY)                          \
    X(CL_INVALID_GL_SHAREGROUP_REFERENCE_KHR)

const char *svo_i_cl_error_name(cl_int error)
{
    switch (error) {
#define CL_ERROR_CASE(name) \
    case name:              \
        return #name;
        CL_ERROR_LIST(CL_ERROR_CASE)
#undef CL_ERROR_CASE
    default:
        return "error";
    }
}

svo_message *svo_i_device_message(svo_device *device)
{
    return device != NULL ? &device->message : NULL;
}

svo_status svo_i_device_fail(svo_device *device, svo_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(svo_i_device_message(device), status, format, arguments);
    va_end(arguments);
    return status;
}

svo_status svo_i_device_fail_cl(svo_device *device, const char *function, const char *call, cl_int error)
{
    svo_status status = SVO_CL_ERROR;
    if (error == CL_MEM_OBJECT_ALLOCATION_FAILURE || error == CL_OUT_OF_RESOURCES) {
        status = SVO_OUT_OF_DEVICE_MEMORY;
    } else if (error == CL_OUT_OF_HOST_MEMORY) {
        status = SVO_OUT_OF_HOST_MEMORY;
    }
    return svo_i_device_fail(device, status, "%s: %s failed with %s (%d)", function, call, svo_i_cl_error_name(error),
                             error);
}

svo_status svo_i_device_buffer(svo_device *device, const char *function, const char *name, cl_mem_flags flags,
                               size_t bytes, cl_mem *out)
{
    if (bytes > device->max_allocation_bytes) {
        return svo_i_device_fail(device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "%s: buffer %s needs %zu bytes, above the device's limit of %llu", function, name,
                                 bytes, (unsigned long long)device->max_allocation_bytes);
    }
    cl_int error = CL_SUCCESS;
    cl_mem buffer = clCreateBuffer(device->context, flags, bytes > 0 ? bytes : 1, NULL, &error);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail(device, SVO_OUT_OF_DEVICE_MEMORY, "%s: buffer %s of %zu bytes: %s (%d)", function,
                                 name, bytes, svo_i_cl_error_name(error), error);
    }
    *out = buffer;
    return SVO_OK;
}

/* The device's own queue, attached to it. */
typedef struct own_queue {
    svo_i_attachment attachment;
    cl_command_queue queue;
} own_queue;

static void release_queue(svo_i_attachment *attachment)
{
    clReleaseCommandQueue(((own_queue *)attachment)->queue);
    free(attachment);
}

svo_status svo_i_device_queue(svo_device *device, const char *function, cl_command_queue given, cl_command_queue *out)
{
    const svo_i_attachment *known = svo_i_attachment_find(device->attachments, release_queue);
    if (given != NULL || known != NULL) {
        *out = given != NULL ? given : ((const own_queue *)known)->queue;
        return SVO_OK;
    }
    own_queue *own = calloc(1, sizeof *own);
    if (own == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a queue", function);
    }
    cl_int error = CL_SUCCESS;
    own->queue = clCreateCommandQueue(device->context, device->device, 0, &error);
    if (error != CL_SUCCESS) {
        free(own);
        return svo_i_device_fail_cl(device, function, "clCreateCommandQueue", error);
    }
    own->attachment.destroy = release_queue;
    svo_i_attachment_add(&device->attachments, &own->attachment);
    *out = own->queue;
    return SVO_OK;
}

void svo_i_device_log(const svo_device *device, svo_log_level level, const char *text)
{
    if (device->log != NULL) {
        device->log(device->log_user, level, text);
    }
}

/* A string property of a device, by malloc; NULL on failure. */
static char *device_text(cl_device_id device, cl_device_info property)
{
    size_t bytes = 0;
    if (clGetDeviceInfo(device, property, 0, NULL, &bytes) != CL_SUCCESS) {
        return NULL;
    }
    char *text = calloc(bytes + 1, 1);
    if (text != NULL && bytes > 0) {
        clGetDeviceInfo(device, property, bytes, text, NULL);
    }
    return text;
}

static char *platform_text(cl_platform_id platform)
{
    size_t bytes = 0;
    if (clGetPlatformInfo(platform, CL_PLATFORM_NAME, 0, NULL, &bytes) != CL_SUCCESS) {
        return NULL;
    }
    char *text = calloc(bytes + 1, 1);
    if (text != NULL && bytes > 0) {
        clGetPlatformInfo(platform, CL_PLATFORM_NAME, bytes, text, NULL);
    }
    return text;
}

/* "platform: device", by malloc; NULL on failure. */
static char *full_name(cl_device_id device)
{
    cl_platform_id platform = NULL;
    clGetDeviceInfo(device, CL_DEVICE_PLATFORM, sizeof platform, &platform, NULL);
    char *platform_name = platform_text(platform);
    char *device_name = device_text(device, CL_DEVICE_NAME);
    char *name = NULL;
    if (platform_name != NULL && device_name != NULL) {
        const size_t bytes = strlen(platform_name) + strlen(device_name) + 3;
        name = malloc(bytes);
        if (name != NULL) {
            (void)snprintf(name, bytes, "%s: %s", platform_name, device_name);
        }
    }
    free(platform_name);
    free(device_name);
    return name;
}

/* Whether the device can run the kernels: OpenCL 1.2, little-endian, work-groups of SVO_GROUP_ITEMS. */
static svo_status check_device(cl_device_id device, const char *name, svo_message *message)
{
    cl_bool little = CL_FALSE;
    size_t group_items = 0;
    unsigned major = 0;
    unsigned minor = 0;
    char *version = device_text(device, CL_DEVICE_VERSION);
    const bool known = version != NULL && sscanf(version, "OpenCL %u.%u", &major, &minor) == 2;
    free(version);
    if (!known || major * 10 + minor < 12) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "svo_device_create: %s has OpenCL %u.%u, below 1.2", name, major,
                          minor);
    }
    clGetDeviceInfo(device, CL_DEVICE_ENDIAN_LITTLE, sizeof little, &little, NULL);
    if (!little) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "svo_device_create: %s is big-endian", name);
    }
    clGetDeviceInfo(device, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof group_items, &group_items, NULL);
    if (group_items < SVO_GROUP_ITEMS) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "svo_device_create: %s has work-groups of %zu items, below %d",
                          name, group_items, SVO_GROUP_ITEMS);
    }
    return SVO_OK;
}

/* Whether the context has the device; and the limits that the builder depends on. */
static svo_status query_limits(svo_device *handle, cl_context context, cl_device_id device, svo_message *message)
{
    cl_device_id devices[64];
    size_t bytes = 0;
    cl_int error = clGetContextInfo(context, CL_CONTEXT_DEVICES, sizeof devices, devices, &bytes);
    bool found = false;
    for (size_t i = 0; error == CL_SUCCESS && i < bytes / sizeof devices[0]; ++i) {
        found = found || devices[i] == device;
    }
    if (!found) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_device_create: device does not belong to context");
    }
    cl_device_type type = 0;
    error = clGetDeviceInfo(device, CL_DEVICE_TYPE, sizeof type, &type, NULL);
    if (error == CL_SUCCESS) {
        error = clGetDeviceInfo(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof(cl_ulong), &handle->max_allocation_bytes,
                                NULL);
    }
    if (error == CL_SUCCESS) {
        error = clGetDeviceInfo(device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof(cl_ulong), &handle->global_bytes, NULL);
    }
    if (error != CL_SUCCESS) {
        return svo_i_fail(message, SVO_CL_ERROR, "svo_device_create: clGetDeviceInfo failed with %s (%d)",
                          svo_i_cl_error_name(error), error);
    }
    handle->is_cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
    return SVO_OK;
}

svo_status svo_device_create(cl_context context, cl_device_id device, const svo_device_options *options,
                             svo_device **out, svo_message *message)
{
    if (context == NULL || device == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_device_create: context, device or out is NULL");
    }
    svo_device_options asked;
    SVO_I_TRY(svo_i_struct_read(message, "svo_device_create", "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_device_options, log_user)));
    svo_device *handle = calloc(1, sizeof *handle);
    char *name = full_name(device);
    if (handle == NULL || name == NULL) {
        free(handle);
        free(name);
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_device_create: no memory for the handle");
    }
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(check_device(device, name, message));
    SVO_I_TRY_CLEANUP(query_limits(handle, context, device, message));
    handle->name = name;
    handle->log = asked.log;
    handle->log_user = asked.log_user;
    handle->context = context;
    handle->device = device;
    clRetainContext(context);
    clRetainDevice(device);
    *out = handle;
    return SVO_OK;

cleanup:
    free(handle);
    free(name);
    return status;
}

/* Whether part occurs in text, ignoring the case of letters. */
static bool contains(const char *text, const char *part)
{
    const size_t length = strlen(part);
    for (; *text != '\0'; ++text) {
        if (strncasecmp(text, part, length) == 0) {
            return true;
        }
    }
    return length == 0;
}

/* What svo_device_create_default searches for, and the best device so far. */
typedef struct device_search {
    const char *wanted; /* NULL: anything */
    bool by_index;
    unsigned platform_index, device_index;
    cl_device_id found;
    bool found_gpu;
} device_search;

static void search_platform(device_search *search, cl_platform_id platform, unsigned platform_index)
{
    cl_uint count = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, NULL, &count) != CL_SUCCESS || count == 0) {
        return;
    }
    cl_device_id *devices = calloc(count, sizeof(cl_device_id));
    if (devices == NULL || clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, devices, NULL) != CL_SUCCESS) {
        free(devices);
        return;
    }
    for (unsigned i = 0; i < count; ++i) {
        if (search->by_index) {
            if (platform_index == search->platform_index && i == search->device_index) {
                search->found = devices[i];
            }
            continue;
        }
        char *name = full_name(devices[i]);
        const bool matches = name != NULL && (search->wanted == NULL || contains(name, search->wanted));
        free(name);
        cl_device_type type = 0;
        clGetDeviceInfo(devices[i], CL_DEVICE_TYPE, sizeof type, &type, NULL);
        const bool gpu = (type & CL_DEVICE_TYPE_GPU) != 0;
        if (matches && (search->found == NULL || (gpu && !search->found_gpu))) {
            search->found = devices[i];
            search->found_gpu = gpu;
        }
    }
    free(devices);
}

static svo_status find_device(const char *wanted, cl_device_id *out, svo_message *message)
{
    cl_uint count = 0;
    if (clGetPlatformIDs(0, NULL, &count) != CL_SUCCESS || count == 0) {
        return svo_i_fail(message, SVO_NO_DEVICE, "svo_device_create_default: no OpenCL platform is installed");
    }
    cl_platform_id *platforms = calloc(count, sizeof(cl_platform_id));
    if (platforms == NULL || clGetPlatformIDs(count, platforms, NULL) != CL_SUCCESS) {
        free(platforms);
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_device_create_default: cannot list %u platforms",
                          count);
    }
    device_search search = {.wanted = wanted};
    char rest = '\0';
    search.by_index =
        wanted != NULL && sscanf(wanted, "%u.%u%c", &search.platform_index, &search.device_index, &rest) == 2;
    for (unsigned i = 0; i < count; ++i) {
        search_platform(&search, platforms[i], i);
    }
    free(platforms);
    if (search.found == NULL) {
        return svo_i_fail(message, SVO_NO_DEVICE, "svo_device_create_default: no OpenCL device matches \"%s\"",
                          wanted != NULL ? wanted : "");
    }
    *out = search.found;
    return SVO_OK;
}

svo_status svo_device_create_default(const svo_device_options *options, svo_device **out, svo_message *message)
{
    cl_device_id device = NULL;
    svo_device_options asked;
    SVO_I_TRY(svo_i_struct_read(message, "svo_device_create_default", "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_device_options, log_user)));
    SVO_I_TRY(find_device(asked.device_name, &device, message));
    cl_int error = CL_SUCCESS;
    cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, &error);
    if (error != CL_SUCCESS) {
        return svo_i_fail(message, SVO_CL_ERROR, "svo_device_create_default: clCreateContext failed with %s (%d)",
                          svo_i_cl_error_name(error), error);
    }
    const svo_status created = svo_device_create(context, device, &asked, out, message);
    clReleaseContext(context);
    return created;
}

void svo_device_destroy(svo_device **device)
{
    if (device == NULL || *device == NULL) {
        return;
    }
    svo_i_attachments_clear(&(*device)->attachments);
    clReleaseContext((*device)->context);
    clReleaseDevice((*device)->device);
    free((*device)->name);
    free(*device);
    *device = NULL;
}

cl_context svo_device_cl_context(const svo_device *device)
{
    return device->context;
}

cl_device_id svo_device_cl_device(const svo_device *device)
{
    return device->device;
}

const char *svo_device_name(const svo_device *device)
{
    return device->name;
}

const char *svo_device_message(const svo_device *device)
{
    return device->message.text;
}

double svo_device_compile_ms(const svo_device *device)
{
    return device->compile_ms;
}
