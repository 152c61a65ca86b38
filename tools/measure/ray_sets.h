/* SPDX-License-Identifier: MIT */
/* The rays that `svocl bench rays` traces: the same bits on every machine. */
#ifndef SVOCL_TOOLS_MEASURE_RAY_SETS_H
#define SVOCL_TOOLS_MEASURE_RAY_SETS_H

#include <stddef.h>

#include "svocl/svocl.h"

/* A pinhole camera's rays, row by row of a square picture. Rays after its last full row start again at the top. */
void ray_set_primary(const svo_camera *camera, size_t count, svo_ray *rays);

/* From random points on the sphere around the box towards random points inside the box. */
void ray_set_incoherent(const double low[3], const double high[3], size_t count, svo_ray *rays);

#endif
