/* SPDX-License-Identifier: MIT */
/*
 * The separating axes of one triangle with its vertices turned into integers once: for oracle_exact_pairs.c, which asks
 * for single axes of many boxes.
 */
#ifndef SVOCL_TOOLS_REFERENCE_EXACT_AXES_H
#define SVOCL_TOOLS_REFERENCE_EXACT_AXES_H

#include <gmp.h>

#include "oracle_exact.h"

/* Axis indices: 0 .. 2 of the box, 3 the normal, EXACT_AXIS(edge, axis) an edge crossed with an axis of the box. The
   edge begins at the vertex of its index. */
#define EXACT_NORMAL           3
#define EXACT_AXIS(edge, axis) (4 + 3 * (edge) + (axis))
#define EXACT_AXES             13

/* Cells are clamped to this magnitude. */
#define EXACT_CELL_MAX (INT64_C(1) << 40)

typedef struct exact_triangle {
    mpz_t vertices[3][3]; /* v - origin, in units of a power of two */
    mpz_t edges[3][3];
    mpz_t normal[3];
    mpz_t width; /* of a voxel, in the same units */
    mpz_t direction[3], corner[3], low, high, above, below, value; /* scratch */
} exact_triangle;

/* A box of size^3 voxels. */
typedef struct exact_box {
    int64_t corner[3];
    int64_t size;
} exact_box;

void exact_triangle_init(exact_triangle *exact);
void exact_triangle_clear(exact_triangle *exact);
void exact_triangle_set(exact_triangle *exact, const oracle_exact_triangle *triangle, const oracle_space *space);

/* The cell of a vertex along an axis, and whether the vertex lies on the cell's first plane. */
int64_t exact_triangle_cell(exact_triangle *exact, int vertex, int axis, bool *on_plane);

/* Whether one axis separates the triangle from the box. */
bool exact_triangle_is_apart(exact_triangle *exact, int axis_index, const exact_box *box, oracle_coverage coverage);

#endif
