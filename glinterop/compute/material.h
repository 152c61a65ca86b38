/* SPDX-License-Identifier: MIT */
/* The materials of the nodes. */
#ifndef SVO_GLINTEROP_COMPUTE_MATERIAL_H
#define SVO_GLINTEROP_COMPUTE_MATERIAL_H

#include "compute/surface.h"

/* The nodes' materials. Needs list_begin, and materials that vary. */
svo_status svo_i_gl_material(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);

#endif
