/* SPDX-License-Identifier: MIT */
/* Meshes of one class of triangles each, for the cases of svocl stress. The same seed gives the same numbers
   everywhere. */
#ifndef SVOCL_TOOLS_STRESS_STRESS_MESH_H
#define SVOCL_TOOLS_STRESS_STRESS_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "scenes/maths.h"
#include "svocl/mesh.h"

#define STRESS_UNITS 1048576 /* positions are whole numbers 0 .. STRESS_UNITS - 1, on which snapping changes nothing */

typedef enum stress_shape {
    STRESS_SMALL = 0, /* about one voxel of depth 6 and smaller */
    STRESS_HUGE, /* across the whole grid */
    STRESS_SLIVERS, /* aspect 1e2 .. 1e6 */
    STRESS_NEEDLES, /* thinner than a pixel, ends 1/1024 voxel off the lattice */
    STRESS_COPLANAR, /* in the plane of voxel faces */
    STRESS_LATTICE, /* corners on the corners of voxels */
    STRESS_DEGENERATE, /* segments and points */
    STRESS_SHAPE_COUNT
} stress_shape;
const char *stress_shape_name(stress_shape shape);

/* Positions and colors are allocated by malloc. Each triangle has three vertices of its own. */
typedef struct stress_mesh {
    svo_mesh mesh;
    double *positions;
    uint8_t *colors; /* NULL: none */
} stress_mesh;

/* Returns false if memory runs out. Release by stress_mesh_free. */
bool stress_mesh_empty(size_t triangle_count, stress_mesh *out); /* all positions 0 */
bool stress_mesh_create(stress_shape shape, uint64_t seed, size_t triangle_count, stress_mesh *out);
void stress_mesh_free(stress_mesh *made);

/* position * factor + offset for every coordinate */
void stress_mesh_move(stress_mesh *made, double factor, double offset);
/* Triangles in another order, with their colors. */
void stress_mesh_shuffle(stress_mesh *made, uint64_t seed);

uint32_t stress_random_below(random_stream *random, uint32_t limit); /* 0 .. limit - 1 */

#endif
