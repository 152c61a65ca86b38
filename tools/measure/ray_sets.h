/* SPDX-License-Identifier: MIT */
/* The rays that `svocl bench rays` traces. The same numbers everywhere. */
#ifndef SVOCL_TOOLS_MEASURE_RAY_SETS_H
#define SVOCL_TOOLS_MEASURE_RAY_SETS_H

#include <stddef.h>

#include "svocl/svocl.h"

/* A pinhole camera's rays, row by row of a square picture; rays beyond its last whole row go on from its top. */
void ray_set_primary(const svo_camera *camera, size_t count, svo_ray *rays);

/* From points of the sphere around the box towards points inside it, all of them random. */
void ray_set_incoherent(const double low[3], const double high[3], size_t count, svo_ray *rays);

#endif
