/* SPDX-License-Identifier: MIT */
/* Creates colors, normals and fills of the nodes. */
#ifndef SVO_GLINTEROP_COMPUTE_FILTER_H
#define SVO_GLINTEROP_COMPUTE_FILTER_H

#include "compute/surface.h"

/* Links the leaves' fragments and sums up their contributions, level by level. */
svo_status svo_i_gl_filter(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);

#endif
