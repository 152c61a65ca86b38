/* SPDX-License-Identifier: MIT */
/* Embree (https://www.embree.org): the same triangles, rays and hits as for svocl, through rtcIntersect1. */
#ifndef SVOCL_TOOLS_MEASURE_EMBREE_H
#define SVOCL_TOOLS_MEASURE_EMBREE_H

#include <stdbool.h>

#include "svocl/svocl.h"

typedef struct embree embree;

/* Whether this program was built with Embree. */
bool embree_is_there(void);

/* vertices: three floats each; indices: three per triangle. robust: the slower mode with fewer gaps. NULL on
   failure. */
embree *embree_create(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                      bool robust);
/* The same triangles placed by so many 3 x 4 matrices, row by row, as instances under one BVH. */
embree *embree_create_placed(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                             const float (*matrices)[12], size_t matrix_count);
void embree_destroy(embree **peer);
/* Milliseconds to build the BVH on all cores, without copying the triangles; of placed ones that over the instances. */
double embree_build_ms(const embree *peer);
/* "3.13.5" */
const char *embree_version(const embree *peer);

/* Fills t, triangle, u and v of the hits on that many threads, at most THREADS_MAX. Returns the milliseconds, below 0
   on failure. */
double embree_trace(const embree *peer, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count);
/* The same through rtcOccluded1: any hit ends a ray, and a hit's triangle is 0. */
double embree_occluded(const embree *peer, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count);

#endif
