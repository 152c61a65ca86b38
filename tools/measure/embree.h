/* SPDX-License-Identifier: MIT */
/* Embree (https://www.embree.org) beside svocl: the same triangles, rays and hits through rtcIntersect1. */
#ifndef SVOCL_TOOLS_MEASURE_EMBREE_H
#define SVOCL_TOOLS_MEASURE_EMBREE_H

#include <stdbool.h>

#include "svocl/svocl.h"

typedef struct embree embree;

/* Whether this program was built with Embree. */
bool embree_is_there(void);

/* vertices: three floats each; indices: three per triangle. robust: its slower mode, which promises fewer gaps. NULL
   when Embree cannot. */
embree *embree_create(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                      bool robust);
void embree_destroy(embree **rival);
/* Milliseconds that the hierarchy over the triangles took, on all cores, their copy left out. */
double embree_build_ms(const embree *rival);
/* "3.13.5" */
const char *embree_version(const embree *rival);

/* Fills t, triangle, u, v of the hits, on that many threads. Returns the milliseconds it took, below 0 on failure. */
double embree_trace(const embree *rival, const svo_ray *rays, svo_hit *hits, size_t ray_count, unsigned thread_count);

#endif
