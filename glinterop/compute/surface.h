/* SPDX-License-Identifier: MIT */
/* The mesh's attributes in storage blocks. */
#ifndef SVO_GLINTEROP_COMPUTE_SURFACE_H
#define SVO_GLINTEROP_COMPUTE_SURFACE_H

#include "compute/stage.h"

/* 0 for an attribute that the plan does not have. */
typedef struct svo_i_gl_surface {
    GLuint vertices, indices, records, attributes, materials, texels;
} svo_i_gl_surface;

/* Call svo_i_gl_surface_free after a failure too. */
svo_status svo_i_gl_surface_upload(svo_i_gl_build *gl_build, svo_i_gl_surface *out);
void svo_i_gl_surface_free(svo_i_gl_build *gl_build, svo_i_gl_surface *surface);

#endif
