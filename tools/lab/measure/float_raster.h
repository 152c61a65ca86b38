/* SPDX-License-Identifier: MIT */
/* The float32 methods that rasterize, by the rules of drivers. */
#ifndef SVOCL_TOOLS_MEASURE_FLOAT_RASTER_H
#define SVOCL_TOOLS_MEASURE_FLOAT_RASTER_H

#include "measure/float_list.h"

/* Appends the voxels that the method finds for one triangle. */
void float_raster(float_method method, const float_triangle *triangle, float_list *list);

#endif
