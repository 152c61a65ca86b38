/* SPDX-License-Identifier: MIT */
/* Decides in OpenGL the fragments that rasterization leaves undecided: kernels/stages/decide.cl by a shader. */
#ifndef SVO_GLINTEROP_COMPUTE_DECIDE_H
#define SVO_GLINTEROP_COMPUTE_DECIDE_H

#include "compute/compute.h"
#include "raster/rasterize.h"

/* The mesh as it was given, in OpenGL from the first chunk on that needs it. */
typedef struct svo_i_gl_decider {
    svo_i_compute *compute;
    GLuint positions, indices;
} svo_i_gl_decider;

/* A svo_i_rasterizer.decider for one list, or one that leaves it to the host where the mesh exceeds a storage block.
   svo_i_gl_decider_end expects the context current. */
svo_i_decider svo_i_gl_decider_begin(svo_i_gl_decider *decider, svo_i_compute *compute, const svo_plan *plan);
void svo_i_gl_decider_end(svo_i_gl_decider *decider);

#endif
