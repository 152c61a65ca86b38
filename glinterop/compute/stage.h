/* SPDX-License-Identifier: MIT */
/*
 * One build by compute shaders: what its stages share. Each stage is the twin of the OpenCL stage of the same name in
 * lib/stages, shader by shader; build.c runs them in order.
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
    /* The tree in the making; 0 where it does not hold the array. */
    GLuint arrays[SVO_TREE_BUFFER_COUNT];
} svo_i_gl_build;

/* A chunk of the list. */
GLuint svo_i_gl_chunk(const svo_i_gl_build *gl_build, uint32_t chunk);

/* SVO_UNSUPPORTED when a launch since the last look was cut short by the driver. */
svo_status svo_i_gl_check_loops(svo_i_gl_build *gl_build, const char *what);

#endif
