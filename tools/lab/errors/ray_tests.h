/* SPDX-License-Identifier: MIT */
/* Common ray-triangle tests in float32, and the exact test, for bvh.h. */
#ifndef SVOCL_TOOLS_ERRORS_RAY_TESTS_H
#define SVOCL_TOOLS_ERRORS_RAY_TESTS_H

#include "errors/bvh.h"
#include "reference/oracle_rays.h"

/* Triangles in world coordinates, rounded to float32. */
typedef struct float_triangles {
    const float *vertices; /* three per vertex */
    const uint32_t *indices; /* three per triangle */
} float_triangles;

/* Moller and Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997, two-sided, without an epsilon.
   triangles: a float_triangles. */
bvh_test ray_test_moller_trumbore;
/* Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", 2013: edge functions in ray space, again in double
   where one of them is 0. triangles: a float_triangles. */
bvh_test ray_test_watertight;
/* The triangles, and what is added to the rays' directions, in units of their longest component. */
typedef struct exact_triangles {
    const oracle_ray_scene *mesh;
    double perturbation[3];
} exact_triangles;

/* In long double. triangles: an exact_triangles. */
bvh_test ray_test_exact;

#endif
