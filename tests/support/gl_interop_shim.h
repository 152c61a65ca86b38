/* SPDX-License-Identifier: MIT */
/*
 * A fake driver with cl_khr_gl_sharing, for machines without a real one. Its objects are plain OpenCL buffers:
 * acquiring copies the OpenGL buffer into them and releasing copies them back. It replaces the OpenCL calls that the
 * interop of one OpenGL context uses, injects faults on demand, and counts violations of the specification.
 *
 * Only one can be installed at a time, since the calls have no user pointer.
 */
#ifndef SVOCL_TESTS_GL_INTEROP_SHIM_H
#define SVOCL_TESTS_GL_INTEROP_SHIM_H

#include <CL/cl_gl.h>

#include "context/context.h"

/* All zero: no fault, with cl_khr_gl_event. */
typedef struct shim_faults {
    const char *extensions; /* the device's list instead of "cl_khr_gl_sharing cl_khr_gl_event" */
    const char *missing_function; /* the platform lacks this function */
    cl_int info_error, context_error, create_error, acquire_error, release_error; /* CL_SUCCESS: none */
    unsigned spared_calls; /* create, acquire and release succeed this many times before they fail */
    bool is_glx; /* the context is of GLX; from shim_install on */
    bool lists_no_device; /* clGetGLContextInfoKHR lists none */
    bool corrupts; /* acquiring changes one word */
    bool acquires_nothing; /* later acquires keep the bytes of the first */
    bool releases_nothing; /* releasing leaves OpenGL the bytes that it had */
} shim_faults;

typedef struct shim_counts {
    unsigned created, acquired, released; /* objects of calls */
    unsigned finishes; /* of OpenGL */
    unsigned objects; /* alive */
    unsigned violations; /* calls with undefined behavior */
    const char *last_violation;
} shim_counts;

void shim_install(svo_gl_context *context, const shim_faults *faults);
void shim_set_faults(const shim_faults *faults); /* from now on */
void shim_get_counts(shim_counts *counts);
void shim_remove(svo_gl_context *context);
/* The same, after a check that no call violated the specification and that all objects are released. */
void shim_end(svo_gl_context *context);

#endif
