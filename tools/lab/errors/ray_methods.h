/* SPDX-License-Identifier: MIT */
/*
 * Traces the same rays against the same triangles by every method: svocl, its voxels alone, Embree's two modes where
 * Embree is installed, and float32 tests in a BVH on the host. Each is compared with the exact first hit.
 */
#ifndef SVOCL_TOOLS_ERRORS_RAY_METHODS_H
#define SVOCL_TOOLS_ERRORS_RAY_METHODS_H

#include "errors/errors.h"

#define RAY_METHODS_MAX 12u
#define RAY_LEVELS_MAX  3u

typedef struct ray_method_result {
    const char *method; /* static */
    double ms; /* median, of all rays */
    size_t rays;
    size_t missed; /* the exact result is a hit, the method's is none */
    size_t wrong; /* another triangle at another t, or a false hit */
    size_t compared; /* rays with a correct hit */
    double t_error_mean, t_error_max; /* |t - exact| / exact, over those */
    size_t named; /* hits that name a triangle */
    size_t beyond; /* of those, with an exact t of that triangle more than an ulp of float beyond the nearest one */
    size_t rounded; /* of those, whose t is the exact one of their triangle, correctly rounded */
    double ulps_max; /* the largest error of t against it, in ulps of float */
} ray_method_result;

typedef struct ray_case {
    const svo_mesh *mesh;
    double edge; /* of the grid at the origin; 0: fitted */
    double origin[3];
    const svo_ray *rays;
    size_t ray_count;
    unsigned levels[RAY_LEVELS_MAX]; /* depths at which voxels alone are cast; 0: no more */
} ray_case;

/* results: RAY_METHODS_MAX of them. Returns the exit code. */
int ray_methods_measure(error_run *run, const ray_case *given, ray_method_result *results, size_t *result_count);

/* The fraction of missed and wrong rays. */
double ray_method_error(const ray_method_result *result);

#endif
