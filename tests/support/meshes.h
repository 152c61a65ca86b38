/* SPDX-License-Identifier: MIT */
/*
 * Generates meshes for tests: random ones with every kind of triangle, and patterns that violate the builder's
 * estimates. Call inside a running cmocka test; the test fails when memory runs out.
 */
#ifndef SVOCL_TESTS_MESHES_H
#define SVOCL_TESTS_MESHES_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/mesh.h"

/* The numbers are the same on every machine. Any state is a good seed. */
uint32_t random_word(uint64_t *state);
uint32_t random_below(uint64_t *state, uint32_t limit); /* 0 .. limit - 1 */
double random_unit(uint64_t *state); /* [0, 1), a multiple of 2^-32 */

/* Positions in double and indices; every triangle has three vertices of its own. Released by owned_mesh_free. */
typedef struct owned_mesh {
    svo_mesh mesh;
    double *positions;
    uint32_t *indices;
} owned_mesh;

void owned_mesh_free(owned_mesh *owned);

/*
 * Triangles of all kinds around the unit cube: from much smaller to much larger than a voxel, slivers, needles, flat
 * and axis-aligned ones with corners on voxel faces, segments and points. Some have common corners.
 *
 * reach: how far outside the cube corners may lie; 0: all inside.
 */
void random_mesh(uint64_t seed, size_t triangle_count, double reach, owned_mesh *out);

/* Small random triangles inside the box from corner to corner + width. */
void random_dust(uint64_t seed, size_t triangle_count, const double corner[3], double width, owned_mesh *out);

/* Long triangles in the unit cube, from a tenth down to a millionth wide, with the third corner anywhere along the
   longest edge. */
void random_needles(uint64_t seed, size_t triangle_count, owned_mesh *out);

/* A tiny triangle around every inner corner of a lattice of cells^3 cells in the unit cube. Each meets many voxels at
   any depth, where triangles of that size usually meet only one. */
void corner_mesh(unsigned cells, owned_mesh *out);

#endif
