/* SPDX-License-Identifier: MIT */
/* Finds cl_khr_gl_sharing on a pair of device and context, and makes OpenCL contexts against OpenGL ones. */
#include "share/interop.h"

#include <stdlib.h>
#include <string.h>

#include "context/context.h"
#include "core/device.h"
#include "core/message.h"

/* Devices that one OpenGL context may have, and properties that one OpenCL context may have: far above what there
   is. */
enum { DEVICES_MAX = 64, PROPERTIES_MAX = 64 };

/* The device's extensions in memory of their own, or NULL. */
static char *extension_list(const svo_device *device, const svo_i_opencl *opencl)
{
    size_t bytes = 0;
    if (opencl->GetDeviceInfo(device->device, CL_DEVICE_EXTENSIONS, 0, NULL, &bytes) != CL_SUCCESS) {
        return NULL;
    }
    char *list = calloc(bytes + 1, 1);
    if (list != NULL && opencl->GetDeviceInfo(device->device, CL_DEVICE_EXTENSIONS, bytes, list, NULL) != CL_SUCCESS) {
        free(list);
        return NULL;
    }
    return list;
}

static bool lists_extension(const svo_device *device, const svo_i_opencl *opencl, const char *extension)
{
    char *list = extension_list(device, opencl);
    const bool listed = svo_i_list_has_token(list, extension);
    free(list);
    return listed;
}

bool svo_i_interop_is_listed(const svo_device *device, const svo_i_opencl *opencl)
{
    return lists_extension(device, opencl, "cl_khr_gl_sharing");
}

static svo_status find_extension(const svo_device *device, const svo_i_opencl *opencl, svo_i_interop *out,
                                 svo_message *message)
{
    if (!svo_i_interop_is_listed(device, opencl)) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "%s does not list cl_khr_gl_sharing", device->name);
    }
    out->has_gl_event = lists_extension(device, opencl, "cl_khr_gl_event");
    return SVO_OK;
}

static svo_status find_platform(const svo_device *device, cl_platform_id *out, svo_message *message)
{
    const cl_int error = clGetDeviceInfo(device->device, CL_DEVICE_PLATFORM, sizeof(cl_platform_id), out, NULL);
    if (error != CL_SUCCESS) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "clGetDeviceInfo(CL_DEVICE_PLATFORM) failed with %s (%d)",
                          svo_i_cl_error_name(error), error);
    }
    return SVO_OK;
}

static svo_status load_functions(const svo_device *device, const svo_i_opencl *opencl, svo_i_interop *out,
                                 svo_message *message)
{
    cl_platform_id platform = NULL;
    const svo_status status = find_platform(device, &platform, message);
    if (status != SVO_OK) {
        return status;
    }
    const char *missing = NULL;
    void *address = NULL;
    /* ISO C has no cast from an object pointer to a function; the bytes are copied, as POSIX does for dlsym. */
#define LOAD_FUNCTION(member)                                                              \
    address = opencl->GetExtensionFunctionAddressForPlatform(platform, "cl" #member);      \
    _Static_assert(sizeof address == sizeof out->member, "functions are as wide as data"); \
    memcpy(&out->member, &address, sizeof address);                                        \
    missing = address == NULL && missing == NULL ? "cl" #member : missing;
    SVO_I_SHARING_FUNCTION_LIST(LOAD_FUNCTION)
#undef LOAD_FUNCTION
    if (missing != NULL) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "%s lists cl_khr_gl_sharing but has no function %s", device->name,
                          missing);
    }
    return SVO_OK;
}

typedef struct context_properties {
    cl_context_properties list[7];
} context_properties;

/* What clCreateContext is told about the OpenGL context. */
static svo_status name_context(const svo_device *device, const svo_gl_context *context, context_properties *out,
                               svo_message *message)
{
    const svo_i_gl_handles handles = context->platform->handles(context->native);
    if (handles.system == SVO_I_GL_SYSTEM_OTHER) {
        return svo_i_fail(message, SVO_UNSUPPORTED,
                          "OpenCL can share with contexts of EGL and GLX, and this is neither");
    }
    cl_platform_id platform = NULL;
    const svo_status status = find_platform(device, &platform, message);
    if (status == SVO_OK) {
        *out = (context_properties){{CL_CONTEXT_PLATFORM, (cl_context_properties)platform, CL_GL_CONTEXT_KHR,
                                     (cl_context_properties)handles.context,
                                     handles.system == SVO_I_GL_SYSTEM_EGL ? CL_EGL_DISPLAY_KHR : CL_GLX_DISPLAY_KHR,
                                     (cl_context_properties)handles.display, 0}};
    }
    return status;
}

/* Whether the devices that can share with the context include the device. */
static svo_status find_in_context(const svo_device *device, const svo_gl_context *context, const svo_i_interop *sharing,
                                  svo_message *message)
{
    context_properties properties;
    const svo_status status = name_context(device, context, &properties, message);
    if (status != SVO_OK) {
        return status;
    }
    cl_device_id devices[DEVICES_MAX];
    size_t bytes = 0;
    const cl_int error =
        sharing->GetGLContextInfoKHR(properties.list, CL_DEVICES_FOR_GL_CONTEXT_KHR, sizeof devices, devices, &bytes);
    if (error != CL_SUCCESS) {
        return svo_i_fail(message, SVO_UNSUPPORTED, "clGetGLContextInfoKHR failed with %s (%d)",
                          svo_i_cl_error_name(error), error);
    }
    for (size_t i = 0; i < bytes / sizeof devices[0] && i < DEVICES_MAX; ++i) {
        if (devices[i] == device->device) {
            return SVO_OK;
        }
    }
    return svo_i_fail(message, SVO_UNSUPPORTED, "clGetGLContextInfoKHR does not list %s for the context of %s",
                      device->name, context->functions.renderer);
}

svo_status svo_i_interop_find(const svo_device *device, const svo_gl_context *context, svo_i_interop *out,
                              svo_message *message)
{
    svo_i_interop sharing = {0};
    svo_status status = find_extension(device, context->opencl, &sharing, message);
    if (status == SVO_OK) {
        status = load_functions(device, context->opencl, &sharing, message);
    }
    if (status == SVO_OK) {
        status = find_in_context(device, context, &sharing, message);
    }
    if (status == SVO_OK) {
        *out = sharing;
    }
    return status;
}

svo_status svo_i_interop_create_context(const svo_device *device, const svo_gl_context *context, cl_context *out,
                                        svo_message *message)
{
    context_properties properties;
    const svo_status status = name_context(device, context, &properties, message);
    if (status != SVO_OK) {
        return status;
    }
    cl_int error = CL_SUCCESS;
    cl_context created = context->opencl->CreateContext(properties.list, 1, &device->device, NULL, NULL, &error);
    if (created == NULL || error != CL_SUCCESS) {
        return svo_i_fail(message, SVO_UNSUPPORTED,
                          "clCreateContext against the OpenGL context of %s failed with %s (%d)",
                          context->functions.renderer, svo_i_cl_error_name(error), error);
    }
    *out = created;
    return SVO_OK;
}

bool svo_i_interop_is_joined(const svo_device *device, const svo_gl_context *context)
{
    const svo_i_gl_handles handles = context->platform->handles(context->native);
    cl_context_properties properties[PROPERTIES_MAX] = {0};
    size_t bytes = 0;
    if (handles.context == NULL ||
        context->opencl->GetContextInfo(device->context, CL_CONTEXT_PROPERTIES, sizeof properties, properties,
                                        &bytes) != CL_SUCCESS) {
        return false;
    }
    for (size_t i = 0; i + 1 < bytes / sizeof properties[0] && properties[i] != 0; i += 2) {
        if (properties[i] == CL_GL_CONTEXT_KHR) {
            return properties[i + 1] == (cl_context_properties)handles.context;
        }
    }
    return false;
}
