/* SPDX-License-Identifier: MIT */
/* What the sky of a light sends. */
#ifndef SVOCL_TOOLS_PATH_OUTSIDE_H
#define SVOCL_TOOLS_PATH_OUTSIDE_H

#include "scenes/maths.h"
#include "svocl/light.h"

/* Radiance from outside along a direction away from a place, of any length above 0: setup->sky and its map. */
void path_outside(const svo_light_setup *setup, vector3 direction, double radiance[3]);

#endif
