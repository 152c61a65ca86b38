/* SPDX-License-Identifier: MIT */
/* A square in the plane y = 0.5 of the unit cube, and two of its corners, so that the grid is the cube. */
#ifndef SVOCL_TESTS_WALL_MESH_H
#define SVOCL_TESTS_WALL_MESH_H

#include "svocl/plan.h"

#define WALL_DEPTH 5
#define WALL_EDGE  (1.0 / 32) /* of a leaf */

/* The arrays are static. */
svo_mesh wall_mesh(void);
/* The options of its plan: the grid, and what light reads. */
svo_plan_options wall_grid(void);

#endif
