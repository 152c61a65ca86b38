/* SPDX-License-Identifier: MIT */
/* The methods that rasterize, in float32, as drivers do. */
#ifndef SVOCL_TOOLS_STRESS_FLOAT_RASTER_H
#define SVOCL_TOOLS_STRESS_FLOAT_RASTER_H

#include "stress/float_list.h"

/* Appends the voxels that the method finds for one triangle. */
void float_raster(float_method method, const float_triangle *triangle, float_list *list);

#endif
