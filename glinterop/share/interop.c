/* SPDX-License-Identifier: MIT */
/*
 * Finds cl_khr_gl_sharing on a pair of device and context, and creates OpenCL contexts, and device handles on them,
 * against OpenGL contexts, so that both APIs can share buffers.
 */
#include "share/interop.h"

#include <string.h>

#include "context/context.h"
#include "core/device.h"
#include "core/message.h"

/* ---- the extension ---- */

/* Upper bounds on the devices of an OpenGL context and the properties of an OpenCL context, far above real ones. */
enum { DEVICES_MAX = 64, PROPERTIES_MAX = 64 };

/* The device's extensions, or NULL. The caller frees the list. */
static char *extension_list(const svo_device *device, const svo_i_opencl *opencl)
{
    size_t bytes = 0;
    if (opencl->GetDeviceInfo(device->device, CL_DEVICE_EXTENSIONS, 0, NULL, &bytes) != CL_SUCCESS) {
        return NULL;
    }
    char *list = svo_i_alloc_zeroed(&device->memory, bytes + 1, 1);
    if (list != NULL && opencl->GetDeviceInfo(device->device, CL_DEVICE_EXTENSIONS, bytes, list, NULL) != CL_SUCCESS) {
        svo_i_free(list);
        return NULL;
    }
    return list;
}

static bool lists_extension(const svo_device *device, const svo_i_opencl *opencl, const char *extension)
{
    char *list = extension_list(device, opencl);
    const bool listed = svo_i_list_has_token(list, extension);
    svo_i_free(list);
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
    SVO_I_TRY(find_platform(device, &platform, message));
    const char *missing = NULL;
    void *address = NULL;
    /* ISO C has no cast from an object pointer to a function pointer: copy the bytes. */
#define LOAD_FUNCTION(member)                                                              \
    address = opencl->GetExtensionFunctionAddressForPlatform(platform, "cl" #member);      \
    _Static_assert(sizeof address == sizeof out->member, "functions are as wide as data"); \
    memcpy(&out->member, &address, sizeof address);                                        \
    missing = address == NULL && missing == NULL ? "cl" #member : missing;
    SVO_I_INTEROP_FUNCTION_LIST(LOAD_FUNCTION)
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

/* The properties by which clCreateContext finds the OpenGL context. */
static svo_status name_context(const svo_device *device, const svo_gl_context *context, context_properties *out,
                               svo_message *message)
{
    const svo_i_gl_handles handles = context->platform->handles(context->native);
    if (handles.system == SVO_I_GL_SYSTEM_OTHER) {
        return svo_i_fail(message, SVO_UNSUPPORTED,
                          "OpenCL shares with contexts of EGL and GLX only, and this is neither");
    }
    cl_platform_id platform = NULL;
    SVO_I_TRY(find_platform(device, &platform, message));
    *out = (context_properties){{CL_CONTEXT_PLATFORM, (cl_context_properties)platform, CL_GL_CONTEXT_KHR,
                                 (cl_context_properties)handles.context,
                                 handles.system == SVO_I_GL_SYSTEM_EGL ? CL_EGL_DISPLAY_KHR : CL_GLX_DISPLAY_KHR,
                                 (cl_context_properties)handles.display, 0}};
    return SVO_OK;
}

/* SVO_OK if the device is among those that can share with the context. */
static svo_status find_in_context(const svo_device *device, const svo_gl_context *context, const svo_i_interop *interop,
                                  svo_message *message)
{
    context_properties properties;
    SVO_I_TRY(name_context(device, context, &properties, message));
    cl_device_id devices[DEVICES_MAX];
    size_t bytes = 0;
    const cl_int error =
        interop->GetGLContextInfoKHR(properties.list, CL_DEVICES_FOR_GL_CONTEXT_KHR, sizeof devices, devices, &bytes);
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
    svo_i_interop interop = {0};
    SVO_I_TRY(find_extension(device, context->opencl, &interop, message));
    SVO_I_TRY(load_functions(device, context->opencl, &interop, message));
    SVO_I_TRY(find_in_context(device, context, &interop, message));
    *out = interop;
    return SVO_OK;
}

svo_status svo_i_interop_create_context(const svo_device *device, const svo_gl_context *context, cl_context *out,
                                        svo_message *message)
{
    context_properties properties;
    SVO_I_TRY(name_context(device, context, &properties, message));
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

/* ---- device handles ---- */

int svo_gl_device_may_share(const svo_device *device)
{
    return device != NULL && svo_i_interop_is_listed(device, &svo_i_opencl_installed);
}

/* A second handle of the same device, on an OpenCL context created against the OpenGL context; NULL where the two
   cannot share. */
static svo_device *create_joined(const svo_device *plain, svo_gl_context *context, const svo_device_options *options)
{
    svo_i_interop interop;
    cl_context joined = NULL;
    svo_device *device = NULL;
    if (svo_i_gl_context_make_current(context, NULL) != SVO_OK) {
        return NULL;
    }
    if (svo_i_interop_find(plain, context, &interop, NULL) == SVO_OK &&
        svo_i_interop_create_context(plain, context, &joined, NULL) == SVO_OK) {
        (void)svo_device_create(joined, plain->device, options, &device, NULL);
        clReleaseContext(joined);
    }
    svo_i_gl_context_release_current(context);
    return device;
}

/* The device on an OpenCL context without OpenGL. id: NULL means the device that the options name. */
static svo_status create_plain(cl_device_id id, const svo_device_options *options, svo_device **out,
                               svo_message *message)
{
    if (id == NULL) {
        return svo_device_create_default(options, out, message);
    }
    cl_int error = CL_SUCCESS;
    cl_context alone = clCreateContext(NULL, 1, &id, NULL, NULL, &error);
    if (error != CL_SUCCESS) {
        (void)svo_i_fail(message, SVO_CL_ERROR, "svo_gl_device_create: clCreateContext failed with %s (%d)",
                         svo_i_cl_error_name(error), error);
        return SVO_CL_ERROR; /* as a constant, so that analyzers know that nothing was made */
    }
    const svo_status status = svo_device_create(alone, id, options, out, message);
    clReleaseContext(alone);
    return status;
}

svo_status svo_gl_device_create(svo_gl_context *context, cl_device_id device, const svo_device_options *options,
                                svo_device **out, svo_message *message)
{
    if (context == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_gl_device_create: %s is NULL",
                          context == NULL ? "context" : "out");
    }
    svo_device *plain = NULL;
    SVO_I_TRY(create_plain(device, options, &plain, message));
    svo_device *joined = create_joined(plain, context, options);
    if (joined != NULL) {
        svo_device_destroy(&plain);
    }
    *out = joined != NULL ? joined : plain;
    return SVO_OK;
}
