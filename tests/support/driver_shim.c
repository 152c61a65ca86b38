/* SPDX-License-Identifier: MIT */
/*
 * For LD_PRELOAD: a driver of OpenCL whose names are long. Nothing that a driver says has a longest length.
 *
 *   SHIM_NAME_BYTES=N      names of devices, platforms, vendors, versions and drivers have N characters: as they are,
 *                          then dots, and SHIM_NAME_END at last
 */
#define _GNU_SOURCE
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#define SHIM_NAME_END "(end)"

/* A driver's function, of devices or of platforms. */
typedef cl_int query(const void *object, cl_uint what, size_t bytes, void *value, size_t *needed);

static query *driver(const char *name)
{
    query *real = NULL;
    *(void **)&real = dlsym(RTLD_NEXT, name);
    return real;
}

/* The honest text, padded to the length that is asked for. NULL: the driver fails, or there is no memory. */
static char *long_text(query *real, const void *object, cl_uint what, size_t length)
{
    size_t bytes = 0;
    char *text = calloc(1, length + sizeof SHIM_NAME_END + 4096);
    if (text == NULL || real(object, what, 4095, text, &bytes) != CL_SUCCESS) {
        free(text);
        return NULL;
    }
    const size_t honest = strlen(text);
    if (honest + sizeof SHIM_NAME_END <= length) {
        memset(text + honest, '.', length - honest);
        memcpy(text + length - (sizeof SHIM_NAME_END - 1), SHIM_NAME_END, sizeof SHIM_NAME_END);
    }
    return text;
}

static cl_int answer(query *real, const void *object, cl_uint what, size_t bytes, void *value, size_t *needed)
{
    const char *length = getenv("SHIM_NAME_BYTES");
    char *text = length != NULL ? long_text(real, object, what, strtoul(length, NULL, 10)) : NULL;
    if (text == NULL) {
        return real(object, what, bytes, value, needed);
    }
    const size_t text_bytes = strlen(text) + 1;
    const int fits = value == NULL || bytes >= text_bytes;
    if (needed != NULL) {
        *needed = text_bytes;
    }
    if (value != NULL && fits) {
        memcpy(value, text, text_bytes);
    }
    free(text);
    return fits ? CL_SUCCESS : CL_INVALID_VALUE;
}

/* OpenCL's headers name the parameters otherwise. */
/* NOLINTBEGIN(readability-inconsistent-declaration-parameter-name) */

CL_API_ENTRY cl_int CL_API_CALL clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t bytes, void *value,
                                                size_t *needed)
{
    query *real = driver("clGetDeviceInfo");
    const int is_name =
        what == CL_DEVICE_NAME || what == CL_DEVICE_VENDOR || what == CL_DEVICE_VERSION || what == CL_DRIVER_VERSION;
    return is_name ? answer(real, device, what, bytes, value, needed) : real(device, what, bytes, value, needed);
}

CL_API_ENTRY cl_int CL_API_CALL clGetPlatformInfo(cl_platform_id platform, cl_platform_info what, size_t bytes,
                                                  void *value, size_t *needed)
{
    query *real = driver("clGetPlatformInfo");
    return what == CL_PLATFORM_NAME || what == CL_PLATFORM_VENDOR || what == CL_PLATFORM_VERSION
               ? answer(real, platform, what, bytes, value, needed)
               : real(platform, what, bytes, value, needed);
}

/* NOLINTEND(readability-inconsistent-declaration-parameter-name) */
