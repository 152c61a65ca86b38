/* SPDX-License-Identifier: MIT */
/* The grid: accepts triangles, snaps vertices and classifies triangles, on the host. */
#ifndef SVO_LIB_PLAN_GRID_H
#define SVO_LIB_PLAN_GRID_H

#include "plan/plan_data.h"

/* Fills the plan's snapped mesh, draw items and fragment estimate from the mesh. */
svo_status svo_i_plan_grid(svo_plan *plan, const svo_mesh *mesh);
/* The bounds of the vertices that accepted triangles use. */
typedef struct svo_i_bounds {
    bool any; /* whether there are such vertices */
    double low[3], high[3];
} svo_i_bounds;

/* Makes the caller's grid, or a fitted one: plan.h has its edge. */
svo_status svo_i_plan_make_grid(svo_plan *plan, const svo_i_bounds *bounds);
/* The normal of a snapped triangle: the cross product of two edges. It is exact; components are at most 2^61. */
void svo_i_plan_normal(const svo_plan *plan, const uint32_t corners[3], int64_t normal[3]);

#endif
