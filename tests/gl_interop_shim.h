/* SPDX-License-Identifier: MIT */
/*
 * A driver that offers cl_khr_gl_sharing, for machines where none does: objects are plain OpenCL buffers, acquiring
 * copies the OpenGL buffer into them and releasing copies them back. It takes the place of the OpenCL calls that one
 * OpenGL context's sharing depends on, fails where it is told to, and counts what callers do against the specification.
 *
 * One at a time: drivers have no user pointer either.
 */
#ifndef SVOCL_TESTS_GL_INTEROP_SHIM_H
#define SVOCL_TESTS_GL_INTEROP_SHIM_H

#include <CL/cl_gl.h>

#include "context/context.h"

/* All zero: works, with cl_khr_gl_event. */
typedef struct shim_faults {
    const char *extensions; /* what the device lists instead of "cl_khr_gl_sharing cl_khr_gl_event" */
    const char *missing_function; /* the platform has none of this name */
    cl_int info_error, context_error, create_error, acquire_error, release_error; /* CL_SUCCESS: none */
    unsigned spared_calls; /* so many of create, acquire and release succeed before theirs fails */
    bool lists_no_device; /* clGetGLContextInfoKHR finds none */
    bool corrupts; /* one word of what is acquired is wrong */
    bool acquires_nothing; /* what was acquired first stays */
} shim_faults;

typedef struct shim_counts {
    unsigned created, acquired, released; /* calls */
    unsigned objects; /* alive */
    unsigned violations; /* calls that the specification leaves undefined */
    const char *last_violation;
} shim_counts;

void shim_install(svo_gl_context *context, const shim_faults *faults);
void shim_set_faults(const shim_faults *faults); /* from now on */
void shim_get_counts(shim_counts *counts);
void shim_remove(svo_gl_context *context);

#endif
