/* SPDX-License-Identifier: MIT */
/*
 * An invented machine of GPUs, in place of the drivers that this one has: EGL devices, the renderers of their contexts,
 * an OpenCL device that may share with one of them. Handles of devices and contexts are made by wrappers of the
 * library's functions (LINKER:--wrap in CMakeLists.txt), which write down what is opened in which order. Whatever is
 * used after its end, or left open, fails the test.
 */
#ifndef SVOCL_TESTS_INVENTED_GPUS_H
#define SVOCL_TESTS_INVENTED_GPUS_H

#include <stdbool.h>

enum { INVENTED_EGL_MAX = 4, INVENTED_LOG_BYTES = 512 };

/* A place where OpenGL contexts come from. */
typedef struct invented_renderer {
    const char *name; /* GL_RENDERER; NULL: no context can be made */
    char gpu; /* which one draws; 0: a CPU */
    bool says_software; /* EGL says of the device, without a context, that a CPU draws */
} invented_renderer;

typedef struct invented_gpus {
    invented_renderer egl[INVENTED_EGL_MAX]; /* EGL devices; name and gpu NULL and 0: no more */
    unsigned egl_count;
    invented_renderer surfaceless, osmesa;
    const char *device; /* the OpenCL device's name, without its platform's */
    char gpu; /* that the OpenCL device is; 0: a CPU */
    bool lists_sharing; /* it lists cl_khr_gl_sharing */
    bool refuses_context; /* clCreateContext against OpenGL fails */
    bool refuses_front_end; /* no front end of OpenGL works */
} invented_gpus;

/* From now on the machine is this one, on which nothing is open. */
void invented_begin(const invented_gpus *machine);
/*
 * What was opened and closed since, in words between spaces. device: the OpenCL device's handle; device@egl1: one that
 * shares with the context of EGL device 1. egl1, surfaceless, osmesa: contexts. queue, cl, gl: a queue, front ends.
 * A word after a minus: it was closed.
 */
const char *invented_log(void);
void invented_forget_log(void);
/* Fails the test where something is open. */
void invented_check_closed(void);

#endif
