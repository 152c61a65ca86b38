/* SPDX-License-Identifier: MIT */
/*
 * Compares a built tree with the exact references: grid, snapped vertices, and nodes and leaf lists of the mesh as it
 * was given, element by element. Call inside a running cmocka test; a difference fails the test with both values.
 */
#ifndef SVOCL_TESTS_COMPARE_TREE_H
#define SVOCL_TESTS_COMPARE_TREE_H

#include "fixture.h"
#include "oracle.h"

/* The references' result for a mesh. The arrays are allocated by malloc and released by exact_destroy. */
typedef struct exact {
    oracle_coverage coverage;
    oracle_grid grid;
    double *positions; /* of the mesh */
    int32_t *vertices; /* snapped, vertex_count * 3; undefined for vertices that no accepted triangle uses */
    int64_t *fine; /* the same in sub-units, 2^24 to a voxel: rounded to the nearest, ties to the even one */
    uint32_t *indices; /* of the accepted triangles */
    uint32_t *triangle_ids;
    size_t triangle_count;
    oracle_pairs pairs;
    oracle_tree tree;
} exact;

/* grid_options: coverage, origin and edge as for the build; NULL: half-open; NULL or edge 0: the default grid. */
void exact_create(const svo_mesh *mesh, unsigned depth, const svo_plan_options *grid_options, exact *out);
void exact_destroy(exact *made);

/* Checks that the second reference finds the same of a sample of the pairs, and of voxels around them. */
void assert_references_agree(const exact *made);

/* Compares nodes and, where the tree has them, lists and geometry. */
void assert_tree_is_exact(const built *actual, const exact *expected);

/* Makes the reference for the build's mesh, compares, and releases it. */
void assert_build_is_exact(const svo_mesh *mesh, const svo_plan_options *grid_options, const built *actual);

#endif
