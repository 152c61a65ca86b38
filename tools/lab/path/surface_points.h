/* SPDX-License-Identifier: MIT */
/* Points on the triangles of a mesh, spread evenly over their area. */
#ifndef SVOCL_TOOLS_PATH_SURFACE_POINTS_H
#define SVOCL_TOOLS_PATH_SURFACE_POINTS_H

#include <stdbool.h>

#include "svocl/light_types.h"
#include "svocl/mesh.h"

/* Fills position and normal, unit, by the order of the corners. Point i lies in the i-th of point_count equal parts of
   the summed area, at a place by the seed. Returns false when memory runs out or there is no area. */
bool surface_points(const svo_mesh *mesh, size_t point_count, uint32_t seed, svo_gather_point *points);

#endif
