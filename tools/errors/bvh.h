/* SPDX-License-Identifier: MIT */
/*
 * A bounding volume hierarchy on the host, the same for every ray-triangle test that is compared, so that nothing but
 * the test decides what a ray meets: boxes are tested in double and widened, they never lose a triangle.
 */
#ifndef SVOCL_TOOLS_ERRORS_BVH_H
#define SVOCL_TOOLS_ERRORS_BVH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/ray_types.h"

typedef struct bvh bvh;

/* Whether the ray meets the triangle between its t_min and hit->t; if so t, u, v are set. */
typedef bool bvh_test(const void *triangles, size_t triangle, const svo_ray *ray, svo_hit *hit);

/* vertices: three doubles each; the boxes are grown by slack, a length. NULL when out of memory. */
bvh *bvh_create(const double *vertices, const uint32_t *indices, size_t triangle_count, double slack);
void bvh_destroy(bvh **tree);

/* The first triangle along each ray, of equal ts the first by position, on that many threads. Returns the milliseconds
   it took, below 0 on failure. */
double bvh_trace(const bvh *tree, bvh_test *test, const void *triangles, const svo_ray *rays, svo_hit *hits,
                 size_t ray_count, unsigned thread_count);

#endif
