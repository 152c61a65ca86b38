/* SPDX-License-Identifier: MIT */
/* Embree (https://www.embree.org): the same triangles, rays and hits as for svocl. */
#ifndef SVOCL_TOOLS_MEASURE_EMBREE_H
#define SVOCL_TOOLS_MEASURE_EMBREE_H

#include <stdbool.h>

#include "svocl/svocl.h"

typedef struct embree embree;

typedef enum embree_quality { EMBREE_MEDIUM = 0, EMBREE_LOW, EMBREE_HIGH } embree_quality;

typedef struct embree_options {
    embree_quality quality; /* of the BVH */
    bool robust; /* the slower mode with fewer gaps */
    const char *isa; /* "avx2": the widest instruction set that it may use; NULL: the processor's */
} embree_options;

/* A function of Embree: rtcIntersect1, rtcIntersect8, rtcOccluded1, ... */
typedef struct embree_call {
    unsigned width; /* 1, 8 or 16 rays at once */
    bool any; /* rtcOccluded: any hit ends a ray, and a hit's triangle is 0 */
    bool coherent; /* the rays are declared coherent */
} embree_call;

#define EMBREE_INTERSECT1 ((embree_call){.width = 1})
#define EMBREE_OCCLUDED1  ((embree_call){.width = 1, .any = true})

/* Whether this program was built for Embree, and its library can be opened. */
bool embree_is_there(void);
/* Why it is not there, for people; "" if it is. */
const char *embree_lack(void);

/* vertices: three floats each; indices: three per triangle. asked: NULL means defaults. NULL on failure. */
embree *embree_create(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                      const embree_options *asked);
/* The same triangles placed by so many 3 x 4 matrices, row by row, as instances under one BVH. */
embree *embree_create_placed(const float *vertices, size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                             const float (*matrices)[12], size_t matrix_count);
void embree_destroy(embree **peer);
/* Milliseconds to build the BVH on all cores, without copying the triangles; of placed ones that over the instances. */
double embree_build_ms(const embree *peer);
/* "3.13.5" */
const char *embree_version(const embree *peer);
/* Whether Embree has packets of that width in the instruction set. Others it divides. */
bool embree_is_native(const embree *peer, unsigned width);

/* Fills t, triangle, u and v of the hits on that many threads, at most THREADS_MAX. Embree works in place on packets
   that are laid out beforehand, and hits are taken out of them afterwards; neither counts. Rays that Embree refuses,
   with numbers that are not finite or beyond 2^60, miss. Returns the milliseconds, below 0 on failure. */
double embree_trace(const embree *peer, embree_call call, const svo_ray *rays, svo_hit *hits, size_t ray_count,
                    unsigned thread_count);

#endif
