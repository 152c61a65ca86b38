/* SPDX-License-Identifier: MIT */
/* The mesh's attributes in storage blocks. */
#ifndef SVO_GLINTEROP_COMPUTE_SURFACE_H
#define SVO_GLINTEROP_COMPUTE_SURFACE_H

#include "compute/stage.h"

/* The mesh's attributes; 0 where the plan does not have them. */
typedef struct svo_i_gl_surface {
    GLuint vertices, indices, records, attributes, materials, texels;
} svo_i_gl_surface;

/* Free also after a failure. */
svo_status svo_i_gl_surface_upload(svo_i_gl_build *gl_build, svo_i_gl_surface *out);
void svo_i_gl_surface_free(svo_i_gl_build *gl_build, svo_i_gl_surface *surface);

#endif
