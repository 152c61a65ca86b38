/* SPDX-License-Identifier: MIT */
/* The OpenCL calls by which cl_khr_gl_sharing is found: a table per OpenGL context, so that a test can replace them. */
#ifndef SVO_GLINTEROP_CONTEXT_OPENCL_H
#define SVO_GLINTEROP_CONTEXT_OPENCL_H

#include <CL/cl.h>

typedef struct svo_i_opencl {
    cl_int(CL_API_CALL *GetDeviceInfo)(cl_device_id device, cl_device_info what, size_t bytes, void *value,
                                       size_t *value_bytes);
    cl_int(CL_API_CALL *GetContextInfo)(cl_context context, cl_context_info what, size_t bytes, void *value,
                                        size_t *value_bytes);
    cl_context(CL_API_CALL *CreateContext)(const cl_context_properties *properties, cl_uint device_count,
                                           const cl_device_id *devices,
                                           void(CL_CALLBACK *notify)(const char *, const void *, size_t, void *),
                                           void *user, cl_int *error);
    void *(CL_API_CALL *GetExtensionFunctionAddressForPlatform)(cl_platform_id platform, const char *name);
} svo_i_opencl;
extern const svo_i_opencl svo_i_opencl_installed;

#endif
