/* SPDX-License-Identifier: MIT */
/* Creates the projected areas of the leaves. */
#ifndef SVO_GLINTEROP_COMPUTE_AREA_H
#define SVO_GLINTEROP_COMPUTE_AREA_H

#include "compute/surface.h"

/* Sums up what the triangles of each leaf show, and rounds the sums. */
svo_status svo_i_gl_areas(svo_i_gl_build *gl_build, const svo_i_gl_surface *surface);

#endif
