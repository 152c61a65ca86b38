/* SPDX-License-Identifier: MIT */
/* The materials of a tree by compute shaders. */
#ifndef SVO_GLINTEROP_COMPUTE_MATERIAL_H
#define SVO_GLINTEROP_COMPUTE_MATERIAL_H

#include "compute/surface.h"

/* Needs list_begin, at least one leaf, and materials that are not constant. */
svo_status svo_i_gl_materials(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);

#endif
