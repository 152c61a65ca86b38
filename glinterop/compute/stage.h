/* SPDX-License-Identifier: MIT */
/*
 * What the stages of one build by compute shaders share. Each stage is the twin of the OpenCL stage of the same name in
 * lib/stages. build.c runs them in order.
 */
#ifndef SVO_GLINTEROP_COMPUTE_STAGE_H
#define SVO_GLINTEROP_COMPUTE_STAGE_H

#include "compute/launch.h"

typedef struct svo_i_gl_build {
    svo_i_build *build;
    svo_i_compute *compute;
    /* Scratch. */
    GLuint *cursors; /* one per chunk */
    GLuint state, partials;
    /* The tree being built; 0 for an array that it does not have. */
    GLuint arrays[SVO_TREE_BUFFER_COUNT];
} svo_i_gl_build;

/* The OpenGL buffer of a chunk of the list. */
GLuint svo_i_gl_chunk(const svo_i_gl_build *gl_build, uint32_t chunk);

/* SVO_UNSUPPORTED when the driver has cut a loop short since the last check. what: the work, for the message. */
svo_status svo_i_gl_check_loops(svo_i_gl_build *gl_build, const char *what);

#endif
