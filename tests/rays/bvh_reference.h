/* SPDX-License-Identifier: MIT */
/* The reference of the BVH that rays traverse, made on the host. */
#ifndef SVOCL_TESTS_BVH_REFERENCE_H
#define SVOCL_TESTS_BVH_REFERENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "shared/bvh_layout.h"

/* The geometry, as the octree holds it. */
typedef struct bvh_source {
    const int32_t *vertices; /* three coordinates each, grid units */
    const float *floats; /* what leaves hold of the vertices */
    const double *doubles; /* NULL: floats alone */
    const uint32_t *indices; /* three per triangle */
    const uint32_t *triangle_ids;
    const uint32_t *list; /* the triangles to include, any number of times each; NULL: all */
    uint64_t list_count;
    uint32_t triangle_count;
    uint32_t snap_bits; /* the grid is 2^snap_bits units wide */
} bvh_source;

typedef struct bvh {
    svo_ray_node *nodes; /* the first is the root */
    size_t node_count, node_capacity;
    uint32_t *leaves; /* records as in layout.h, the empty leaf first; padded for reads beyond the last */
    size_t leaf_words, leaf_capacity;
} bvh;

/* Returns false when out of memory. The caller frees *out with bvh_reference_free in either case. */
bool bvh_reference_make(const bvh_source *source, bvh *out);
/* In a leaf of so many triangles: the words after the head at which the positions in the mesh begin, and all words. */
size_t bvh_reference_ids_begin(bool has_doubles, uint32_t count);
size_t bvh_reference_leaf_words(bool has_doubles, uint32_t count);
void bvh_reference_free(bvh *made);

#endif
