/* SPDX-License-Identifier: MIT */
/* Whether a mesh is a closed manifold, and its measures. Call inside a running cmocka test. */
#ifndef SVOCL_TESTS_SURFACE_CHECK_H
#define SVOCL_TESTS_SURFACE_CHECK_H

#include "svocl/surface.h"

typedef struct surface_measures {
    long euler; /* vertices - edges + triangles: 2 a sphere, 0 a torus; of several parts the sum */
    double volume; /* enclosed, positive where triangles face outwards */
} surface_measures;

/* Fails unless every edge belongs to two triangles that pass it in opposite directions, the triangles around each
   vertex are one ring, every vertex has triangles, and no two have the same place. */
surface_measures surface_check(const svo_surface *surface);

/* Fails unless the bytes of two surfaces are the same. */
void surface_compare(const svo_surface *a, const svo_surface *b);

/* The surface of a field, which must succeed. */
svo_surface *surface_make(const svo_surface_field *field, const svo_surface_options *options);

#endif
