/* SPDX-License-Identifier: MIT */
/* The boundary of a mesh: the directed edges that do not cancel, as closed loops. */
#ifndef SVO_LIB_SOLID_BOUNDARY_H
#define SVO_LIB_SOLID_BOUNDARY_H

#include <stddef.h>
#include <stdint.h>

#include "core/memory.h"
#include "shared/decide.clh"
#include "shared/solid_layout.h"

/* A mesh on the host, whose positions are what decides. */
typedef struct svo_i_solid_mesh {
    const uint32_t *indices; /* 3 * triangle_count */
    const void *positions; /* 3 * vertex_count numbers */
    uint32_t kind; /* SVO_SOLID_* */
    uint32_t triangle_count, vertex_count;
    svo_decide_params grid; /* of these positions; of snapped ones, which are whole numbers, that from 0 on */
} svo_i_solid_mesh;

/* A vertex of the boundary. From the origin of the grid it lies at half / 2 + rest voxels. */
typedef struct svo_i_boundary_point {
    int32_t half[3]; /* the nearest half voxel */
    double rest[3]; /* |rest| is at most 1/4; off by less than 2^-51 of itself */
    svo_short offset[2]; /* along x and y, in units of exact.clh */
} svo_i_boundary_point;

typedef struct svo_i_boundary_edge {
    uint32_t from, to; /* points */
} svo_i_boundary_edge;

/* Edges of one loop that follow each other. */
typedef struct svo_i_boundary_piece {
    uint64_t first;
    uint32_t count; /* 1 .. SVO_I_PIECE_EDGES */
    uint32_t of_long; /* 0, or the number of its loop, if that has more than SVO_I_LOOP_EDGES edges: 1 for the first */
    uint64_t loop_first, loop_end; /* edges of its loop */
} svo_i_boundary_piece;

#define SVO_I_PIECE_EDGES 8
#define SVO_I_LOOP_EDGES  64

typedef struct svo_i_boundary {
    svo_i_boundary_point *points;
    svo_i_boundary_edge *edges; /* loop by loop; one that several triangles have more of one way is there as often */
    svo_i_boundary_piece *pieces; /* in the order of edges */
    size_t point_count, edge_count, piece_count, long_count; /* long_count: of loops */
} svo_i_boundary;

SVO_I_SHARED_BEGIN

/* Finds the boundary. Returns SVO_OUT_OF_HOST_MEMORY, with nothing to release, or SVO_OK. */
svo_status svo_i_boundary_find(const svo_i_memory *memory, const svo_i_solid_mesh *mesh, svo_i_boundary *out);

void svo_i_boundary_release(svo_i_boundary *boundary);

SVO_I_SHARED_END

#endif
