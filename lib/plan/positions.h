/* SPDX-License-Identifier: MIT */
/* The mesh's own vertices, which rays meet. */
#ifndef SVO_LIB_PLAN_POSITIONS_H
#define SVO_LIB_PLAN_POSITIONS_H

#include "plan/plan_data.h"

/* Copies the positions of the vertices that kept triangles use, as floats or doubles like the mesh's, if rays are
   asked for that meet triangles. */
svo_status svo_i_plan_positions(svo_plan *plan, const svo_mesh *mesh);

#endif
