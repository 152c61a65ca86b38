/* SPDX-License-Identifier: MIT */
/*
 * A bounding volume hierarchy (BVH) on the host, the same for all ray-triangle tests, so that only the test decides
 * what a ray hits. Bounds are tested in double, conservatively: they never lose a triangle.
 */
#ifndef SVOCL_TOOLS_ERRORS_BVH_H
#define SVOCL_TOOLS_ERRORS_BVH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/ray_types.h"

typedef struct bvh bvh;

/* Whether the ray hits the triangle between its t_min and hit->t; sets t, u and v of a hit. */
typedef bool bvh_test(const void *triangles, size_t triangle, const svo_ray *ray, svo_hit *hit);

/* vertices: three doubles each. slack: a length by which the bounds grow. NULL when out of memory. */
bvh *bvh_create(const double *vertices, const uint32_t *indices, size_t triangle_count, double slack);
void bvh_destroy(bvh **tree);

/* The first triangle along each ray, on that many threads; of equal ts the one with the lowest index. Returns the
   milliseconds, below 0 on failure. */
double bvh_trace(const bvh *tree, bvh_test *test, const void *triangles, const svo_ray *rays, svo_hit *hits,
                 size_t ray_count, unsigned thread_count);

#endif
