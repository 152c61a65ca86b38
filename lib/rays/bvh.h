/* SPDX-License-Identifier: MIT */
/* The 8-wide BVH that rays traverse, built on the host from a finished octree's geometry. */
#ifndef SVO_LIB_RAYS_BVH_H
#define SVO_LIB_RAYS_BVH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/memory.h"
#include "shared/layout.h"

/* What the corners of leaves hold: layout.h describes them. */
typedef enum svo_i_leaf_rows {
    SVO_I_ROWS_WORLD, /* the mesh's floats: with SVO_RAY_FLAG_WORLD */
    SVO_I_ROWS_GRID, /* grid units, for devices without fp64 */
    SVO_I_ROWS_DOUBLE /* grid units, and doubles in world units */
} svo_i_leaf_rows;

/* The geometry, as the octree holds it. */
typedef struct svo_i_bvh_source {
    const int32_t *vertices; /* three coordinates each, grid units; boxes are made from these */
    /* The mesh's vertices, in world units: three coordinates each in one of these arrays; both NULL: the snapped ones
       stand for them. */
    const float *positions;
    const double *positions_double;
    svo_i_leaf_rows rows;
    double origin[3], scale; /* of the grid: world units, and grid units per world unit */
    const uint32_t *indices; /* three per triangle */
    const uint32_t *triangle_ids;
    const uint32_t *list; /* the triangles to include, any number of times each; NULL: all */
    uint64_t list_count;
    uint32_t triangle_count;
    uint32_t snap_bits; /* the grid is 2^snap_bits units wide */
} svo_i_bvh_source;

typedef struct svo_i_bvh {
    svo_ray_node *nodes; /* the first is the root */
    size_t node_count, node_capacity;
    uint32_t *leaves; /* records as in layout.h, the empty leaf first; padded for reads beyond the last */
    size_t leaf_words, leaf_capacity;
} svo_i_bvh;

/* Returns false when out of memory, or with more nodes or leaves than references can address. The caller frees *out
   with svo_i_bvh_free in either case. */
bool svo_i_bvh_make(const svo_i_memory *memory, const svo_i_bvh_source *source, svo_i_bvh *out);
void svo_i_bvh_free(svo_i_bvh *bvh);

#endif
