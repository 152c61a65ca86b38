/* SPDX-License-Identifier: MIT */
/*
 * Meshes that tests make: random ones of every sort of triangle, and patterns that go against the builder's
 * expectations. Inside a running cmocka test, which fails when memory runs out.
 */
#ifndef SVOCL_TESTS_MESHES_H
#define SVOCL_TESTS_MESHES_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/mesh.h"

/* The numbers are the same everywhere. Any state is a good seed. */
uint32_t random_word(uint64_t *state);
uint32_t random_below(uint64_t *state, uint32_t limit); /* 0 .. limit - 1 */
double random_unit(uint64_t *state); /* [0, 1), a multiple of 2^-32 */

/* Positions in double and nothing else; indices: three vertices of its own per triangle. Released by
   owned_mesh_free. */
typedef struct owned_mesh {
    svo_mesh mesh;
    double *positions;
    uint32_t *indices;
} owned_mesh;

void owned_mesh_free(owned_mesh *owned);

/*
 * Triangles of all sorts around the unit cube: from far below to far above a voxel, slivers, needles, flat and aligned
 * ones with corners on voxel faces, segments and points, some sharing corners.
 *
 * reach: how far outside the cube corners may lie; 0: all inside.
 */
void random_mesh(uint64_t seed, size_t triangle_count, double reach, owned_mesh *out);

/* Small random triangles inside the box from corner to corner + width. */
void random_dust(uint64_t seed, size_t triangle_count, const double corner[3], double width, owned_mesh *out);

/* Long triangles in the unit cube, from a tenth of it down to a millionth wide, the third corner anywhere along
   them. */
void random_needles(uint64_t seed, size_t triangle_count, owned_mesh *out);

/* A tiny triangle around every corner of a lattice of cells^3 cells in the unit cube (not on its faces): each meets
   many voxels at any depth, where triangles of that size meet but one as a rule. */
void corner_mesh(unsigned cells, owned_mesh *out);

#endif
