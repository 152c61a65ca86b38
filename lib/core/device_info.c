/* SPDX-License-Identifier: MIT */
/* Reads properties of OpenCL devices and platforms. */
#include "core/device_info.h"

#include <stdio.h>
#include <string.h>

#include "core/cl_error.h"

/* An object with string properties: a device, or without one a platform. */
typedef struct named {
    cl_device_id device;
    cl_platform_id platform;
} named;

static cl_int read_text(named object, cl_uint property, size_t bytes, char *text, size_t *needed)
{
    return object.device != NULL ? clGetDeviceInfo(object.device, property, bytes, text, needed)
                                 : clGetPlatformInfo(object.platform, property, bytes, text, needed);
}

static svo_status text_of(named object, cl_uint property, const char *function, const svo_i_memory *memory, char **out,
                          svo_message *message)
{
    size_t bytes = 0;
    cl_int error = read_text(object, property, 0, NULL, &bytes);
    char *text = error == CL_SUCCESS ? svo_i_alloc_zeroed(memory, bytes + 1, 1) : NULL;
    if (error == CL_SUCCESS && text == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu bytes of a name", function, bytes);
    }
    if (error == CL_SUCCESS && bytes > 0) {
        error = read_text(object, property, bytes, text, NULL);
    }
    if (error != CL_SUCCESS) {
        svo_i_free(text);
        return svo_i_fail_cl(message, function, object.device != NULL ? "clGetDeviceInfo" : "clGetPlatformInfo", error);
    }
    *out = text;
    return SVO_OK;
}

svo_status svo_i_device_text(cl_device_id device, cl_device_info property, const char *function,
                             const svo_i_memory *memory, char **out, svo_message *message)
{
    return text_of((named){.device = device}, property, function, memory, out, message);
}

svo_status svo_i_platform_text(cl_platform_id platform, cl_platform_info property, const char *function,
                               const svo_i_memory *memory, char **out, svo_message *message)
{
    return text_of((named){.platform = platform}, property, function, memory, out, message);
}

svo_status svo_i_device_property(cl_device_id device, cl_device_info property, size_t bytes, void *out,
                                 const char *function, svo_message *message)
{
    const cl_int error = clGetDeviceInfo(device, property, bytes, out, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_fail_cl(message, function, "clGetDeviceInfo", error);
}

svo_status svo_i_device_full_name(cl_device_id device, const char *function, const svo_i_memory *memory, char **out,
                                  svo_message *message)
{
    svo_status status = SVO_OK;
    cl_platform_id platform = NULL;
    char *platform_name = NULL;
    char *device_name = NULL;
    SVO_I_TRY_CLEANUP(
        svo_i_device_property(device, CL_DEVICE_PLATFORM, sizeof(cl_platform_id), &platform, function, message));
    SVO_I_TRY_CLEANUP(svo_i_platform_text(platform, CL_PLATFORM_NAME, function, memory, &platform_name, message));
    SVO_I_TRY_CLEANUP(svo_i_device_text(device, CL_DEVICE_NAME, function, memory, &device_name, message));
    const size_t bytes = strlen(platform_name) + strlen(device_name) + 3;
    char *name = svo_i_alloc(memory, bytes);
    if (name == NULL) {
        status = svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu bytes of a name", function, bytes);
        goto cleanup;
    }
    (void)snprintf(name, bytes, "%s: %s", platform_name, device_name);
    *out = name;
cleanup:
    svo_i_free(platform_name);
    svo_i_free(device_name);
    return status;
}
