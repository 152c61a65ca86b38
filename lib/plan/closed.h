/* SPDX-License-Identifier: MIT */
/* Whether a mesh is closed, for projected areas. */
#ifndef SVO_LIB_PLAN_CLOSED_H
#define SVO_LIB_PLAN_CLOSED_H

#include "plan/plan_data.h"

/* Whether the accepted triangles use each edge as often in one direction as in the other; vertices whose coordinates in
   the mesh are equal are one. Reads the plan's indices: those of kept triangles from the front, those of triangles
   outside the grid from the end on. */
svo_status svo_i_plan_is_closed(const svo_plan *plan, const svo_mesh *mesh, bool *closed);

#endif
