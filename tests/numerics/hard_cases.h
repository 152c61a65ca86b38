/* SPDX-License-Identifier: MIT */
/* Triangles of doubles that are hard for an overlap test, on grids of the caller's: for the exact references, and for
   the library's test beside them. */
#ifndef SVOCL_TESTS_NUMERICS_HARD_CASES_H
#define SVOCL_TESTS_NUMERICS_HARD_CASES_H

#include "oracle_exact.h"

typedef enum hard_kind {
    HARD_BESIDE_PLANES, /* every vertex an ulp beside planes, or on them */
    HARD_LATTICE, /* halves of voxels: touches in corners, edges and faces, many of them degenerate */
    HARD_EDGE_THROUGH_CORNER, /* within ulps */
    HARD_GRAZING, /* a plane cuts a corner off, or misses it, by less than 2^-40 of the grid's edge */
    HARD_NEEDLE, /* a vertex within ulps of the segment between the others */
    HARD_DEGENERATE, /* a segment or a point */
    HARD_MIXED_EXPONENTS, /* tiny and huge numbers beside those of the grid */
    HARD_PLAIN, /* what any mesh has */
    HARD_KINDS
} hard_kind;
#define HARD_SPACES 9

typedef struct hard_case {
    oracle_space space;
    oracle_exact_triangle triangle;
    int32_t cell[3]; /* the case is about it and its neighbors */
} hard_case;

const char *hard_kind_name(hard_kind kind);
/* A case in space number index % HARD_SPACES, at a random depth and cell. */
void hard_case_make(hard_kind kind, size_t index, hard_case *out);
/* The triangle of a case whose space and cell are set. */
void hard_case_fill(hard_kind kind, hard_case *s);
/* Prints the triangle, the grid and a cell as an error of cmocka. */
void hard_case_print(const hard_case *s, const int32_t cell[3]);

/* The random numbers of the cases, which repeat after each seed: splitmix64 (Steele, Lea and Flood 2014). */
void hard_cases_seed(uint64_t seed);
uint64_t hard_random(void);
int hard_between(int low, int high); /* uniform, both inclusive */
double hard_move(double value, int ulps); /* up, or down */

#endif
