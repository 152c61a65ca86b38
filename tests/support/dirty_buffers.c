/* SPDX-License-Identifier: MIT */
/*
 * Linked into test_kernels, where it overrides the OpenCL loader's function of the same name. New buffers are filled
 * with garbage, as on a device that has been in use, so that no kernel can rely on zeroed memory.
 */
#define _GNU_SOURCE /* RTLD_NEXT */
#include <dlfcn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/device.h"

#define GARBAGE 0xa5

typedef cl_mem(CL_API_CALL *create_buffer)(cl_context, cl_mem_flags, size_t, void *, cl_int *);

/* The loader's function, which this file overrides. */
static create_buffer real_create_buffer(void)
{
    /* POSIX allows dlsym to return a function; ISO C has no cast for it, so the bytes are copied. */
    void *symbol = dlsym(RTLD_NEXT, "clCreateBuffer");
    create_buffer function = NULL;
    memcpy(&function, &symbol, sizeof function);
    return function;
}

CL_API_ENTRY cl_mem CL_API_CALL clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void *host_ptr,
                                               cl_int *errcode_ret)
{
    const create_buffer create = real_create_buffer();
    unsigned char *garbage = host_ptr == NULL && size > 0 ? malloc(size) : NULL;
    if (garbage == NULL) {
        return create(context, flags, size, host_ptr, errcode_ret);
    }
    memset(garbage, GARBAGE, size);
    const cl_mem buffer = create(context, flags | CL_MEM_COPY_HOST_PTR, size, garbage, errcode_ret);
    free(garbage);
    return buffer;
}
