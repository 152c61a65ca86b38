/* SPDX-License-Identifier: MIT */
/* The rays that `svocl bench rays` traces: the same bits on every machine. */
#ifndef SVOCL_TOOLS_MEASURE_RAY_SETS_H
#define SVOCL_TOOLS_MEASURE_RAY_SETS_H

#include <stdbool.h>
#include <stddef.h>

#include "svocl/svocl.h"

/* A pinhole camera's rays, row by row of a square picture. Rays after its last full row start again at the top. */
void ray_set_primary(const svo_camera *camera, size_t count, svo_ray *rays);

/* From random points on the sphere around the box towards random points inside the box. */
void ray_set_incoherent(const double low[3], const double high[3], size_t count, svo_ray *rays);

/* From the same points away from the box: all miss it. */
void ray_set_misses(const double low[3], const double high[3], size_t count, svo_ray *rays);

/* From where primary rays hit to a sun above and beside the camera, in the order of the hits, again and again until
   there are count. False: no ray hits. */
bool ray_set_shadow(const svo_camera *camera, const svo_ray *primary, const svo_hit *hits, size_t count, svo_ray *rays);

#endif
