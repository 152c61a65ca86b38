/* SPDX-License-Identifier: MIT */
/*
 * Meshes of closed parts for tests of solids, one after the other into one mesh. Coordinates are voxels of a grid of
 * the caller's from 0, 0, 0 on. Call inside a running cmocka test; the test fails when memory runs out.
 */
#ifndef SVOCL_TESTS_SOLID_MESHES_H
#define SVOCL_TESTS_SOLID_MESHES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/mesh.h"

typedef struct parts {
    double *positions;
    uint32_t *indices;
    size_t vertex_count, triangle_count;
} parts;

void parts_free(parts *made);
/* The parts as a mesh, which borrows their arrays. */
svo_mesh parts_mesh(const parts *made);

/* Triangles of an axis-aligned box that face outwards, or inwards. skip: a face that is left out, 2 axis + (0 low,
   1 high); -1: none. */
void parts_add_box(parts *made, const double low[3], const double high[3], bool inwards, int skip);
/* The same with each coordinate from first to last. */
void parts_add_cube(parts *made, double first, double last, bool inwards, int skip);
/* A tetrahedron that faces outwards or inwards, as its corners say. */
void parts_add_tetrahedron(parts *made, const double corners[4][3]);
/* A sphere of rings * 2 sectors quads and caps, inside the exact one, that faces outwards. */
void parts_add_sphere(parts *made, const double center[3], double radius, unsigned rings);

#endif
