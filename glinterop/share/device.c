/* SPDX-License-Identifier: MIT */
/* Device handles whose OpenCL context is created against an OpenGL context, so that both APIs can share buffers. */
#include "core/device.h"

#include "core/message.h"
#include "share/interop.h"

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
