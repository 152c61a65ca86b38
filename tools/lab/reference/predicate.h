/* SPDX-License-Identifier: MIT */
/*
 * The two predicates with their per-triangle work done once: for oracle_pairs.c, which tests many boxes against one
 * triangle. oracle_sat.c and oracle_clip.c see only their own half.
 */
#ifndef SVOCL_TOOLS_REFERENCE_PREDICATE_H
#define SVOCL_TOOLS_REFERENCE_PREDICATE_H

#include "oracle.h"

__extension__ typedef __int128 oracle_wide;

/* A direction, the triangle's extent along it, and the sums of its positive and of its negative components. */
typedef struct oracle_sat_axis {
    int64_t direction[3];
    oracle_wide minimum, maximum;
    oracle_wide positive, negative; /* both >= 0 */
} oracle_sat_axis;

#define ORACLE_SAT_AXES 13
typedef struct oracle_sat_triangle {
    oracle_sat_axis axes[ORACLE_SAT_AXES];
} oracle_sat_triangle;

void oracle_sat_prepare(const oracle_triangle *triangle, oracle_sat_triangle *prepared);
bool oracle_sat_test(const oracle_sat_triangle *prepared, const oracle_box *box, oracle_coverage coverage);

typedef struct oracle_clip_triangle {
    int64_t vertex[3][3];
    int64_t normal[3]; /* zero for segments and points */
    oracle_wide constant; /* normal . x, the same for all points of the triangle's plane */
} oracle_clip_triangle;

void oracle_clip_prepare(const oracle_triangle *triangle, oracle_clip_triangle *prepared);
bool oracle_clip_test(const oracle_clip_triangle *prepared, const oracle_box *box, oracle_coverage coverage);

/* Thin coverage, tested by two methods. */
bool oracle_thin_by_extents(const oracle_triangle *triangle, const oracle_box *box);
bool oracle_thin_by_vertices(const oracle_triangle *triangle, const oracle_box *box);

#endif
