/* SPDX-License-Identifier: MIT */
/* The grid: accepts triangles, snaps vertices, sorts triangles into classes. */
#ifndef SVO_LIB_PLAN_GRID_H
#define SVO_LIB_PLAN_GRID_H

#include "plan/plan_data.h"

/* Fills the snapped mesh, the items and the fragment estimate from the mesh. */
svo_status svo_i_plan_grid(svo_plan *plan, const svo_mesh *mesh);
/* Twice the areas of a snapped triangle's projections along x, y, z, with sign: its normal. Exact: at most 2^61. */
void svo_i_plan_normal(const svo_plan *plan, const uint32_t corners[3], int64_t normal[3]);

#endif
