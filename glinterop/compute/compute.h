/* SPDX-License-Identifier: MIT */
/*
 * Compute shaders of one context: programs compiled on first use, buffers, launches, and the time they take. What the
 * GL compute builder (build.h) stands on, as the OpenCL stages stand on lib/build.h.
 */
#ifndef SVO_GLINTEROP_COMPUTE_COMPUTE_H
#define SVO_GLINTEROP_COMPUTE_COMPUTE_H

#include "context/context.h"
#include "plan/plan_data.h"

/* svo_gl_build's name, for messages. */
#define SVO_I_GL_BUILD "svo_gl_build"

typedef struct svo_i_compute {
    svo_device *device;
    svo_gl_context *context;
    const svo_i_gl_functions *gl;
    bool int64; /* the shaders have 64-bit integers */
    bool has_timer; /* the context's timer queries can be believed */
    struct svo_i_compute_program *programs;
    char defines[SVO_I_DEFINES_BYTES]; /* of the plan being built */
    GLuint queries[2]; /* begin and end of a stage */
    double stage_start_ms;
    GLuint exhausted; /* one word */
} svo_i_compute;

#endif
