/* SPDX-License-Identifier: MIT */
/*
 * The builder's compute shaders in one context. builder.h creates and destroys it, program.h compiles shaders, buffer.h
 * and launch.h run them; stage.h and build.h make a tree with them.
 */
#ifndef SVO_GLINTEROP_COMPUTE_COMPUTE_H
#define SVO_GLINTEROP_COMPUTE_COMPUTE_H

#include "context/context.h"
#include "plan/plan_data.h"

/* The public function's name, for messages. */
#define SVO_I_GL_BUILD "svo_gl_build"

typedef struct svo_i_compute {
    svo_device *device;
    svo_gl_context *context;
    const svo_i_gl_functions *gl;
    bool has_timer; /* the context's timer queries are reliable */
    struct svo_i_compute_program *programs;
    char defines[SVO_I_DEFINES_BYTES]; /* of the plan being built */
    GLuint queries[2]; /* begin and end of a stage */
    double stage_start_ms;
    GLuint exhausted; /* one word: not 0 after a launch whose loops were cut short (shaders/compute.glsl) */
} svo_i_compute;

#endif
