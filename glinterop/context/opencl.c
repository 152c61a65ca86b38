/* SPDX-License-Identifier: MIT */
/* The calls of the installed OpenCL loader. */
#include "context/opencl.h"

const svo_i_opencl svo_i_opencl_installed = {
    .GetDeviceInfo = clGetDeviceInfo,
    .GetContextInfo = clGetContextInfo,
    .CreateContext = clCreateContext,
    .GetExtensionFunctionAddressForPlatform = clGetExtensionFunctionAddressForPlatform,
};
