/* SPDX-License-Identifier: MIT */
/* Meshes of triangles of one shape each, for `svocl stress` and `svocl bench errors`. The same seed gives the same bits
   on every machine. */
#ifndef SVOCL_TOOLS_MEASURE_TRIANGLE_SETS_H
#define SVOCL_TOOLS_MEASURE_TRIANGLE_SETS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "scenes/maths.h"
#include "svocl/mesh.h"

/* Positions are whole numbers 0 .. TRIANGLE_SET_UNITS - 1, which snapping does not change. */
#define TRIANGLE_SET_UNITS 1048576

typedef enum triangle_shape {
    TRIANGLES_SMALL = 0, /* about one voxel of depth 6 and smaller */
    TRIANGLES_HUGE, /* across the whole grid */
    TRIANGLES_SLIVERS, /* aspect 1e2 .. 1e6 */
    TRIANGLES_NEEDLES, /* thinner than a pixel, ends 1/1024 voxel off the lattice */
    TRIANGLES_COPLANAR, /* in the plane of voxel faces */
    TRIANGLES_LATTICE, /* corners on the corners of voxels */
    TRIANGLES_DEGENERATE, /* segments and points */
    TRIANGLE_SHAPE_COUNT
} triangle_shape;
const char *triangle_shape_name(triangle_shape shape);

/* Positions and colors are allocated by malloc. Each triangle has three vertices of its own. */
typedef struct triangle_set {
    svo_mesh mesh;
    double *positions;
    uint8_t *colors; /* NULL: none */
} triangle_set;

/* Returns false if memory runs out. Release by triangle_set_free. */
bool triangle_set_empty(size_t triangle_count, triangle_set *out); /* all positions 0 */
bool triangle_set_create(triangle_shape shape, uint64_t seed, size_t triangle_count, triangle_set *out);
void triangle_set_free(triangle_set *made);

/* position * factor + offset for every coordinate */
void triangle_set_move(triangle_set *made, double factor, double offset);
/* Triangles in another order, with their colors. */
void triangle_set_shuffle(triangle_set *made, uint64_t seed);

#endif
