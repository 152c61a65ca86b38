/* SPDX-License-Identifier: MIT */
/* Directions around a normal, and rays into the hemisphere above points. */
#ifndef SVOCL_TOOLS_ERRORS_HEMISPHERE_H
#define SVOCL_TOOLS_ERRORS_HEMISPHERE_H

#include <stddef.h>
#include <stdint.h>

#include "scenes/maths.h"
#include "svocl/light_types.h"
#include "svocl/ray_types.h"

/* Unit vectors at right angles. */
typedef struct turned_frame {
    vector3 side, other, normal;
} turned_frame;

/* normal: unit. */
turned_frame frame_around(vector3 normal);
/* At a sine from the normal and a turn around it, in circles. */
vector3 frame_direction(const turned_frame *frame, double sine, double turns);

/* Cosine-weighted rays, strata^2 a point, one in each cell of a square of strata. */
typedef struct hemisphere_set {
    unsigned strata;
    uint64_t seed;
    double lift; /* of origins above their surface, world units */
    double length; /* of the rays, world units; infinity allowed */
} hemisphere_set;

turned_frame hemisphere_frame(const svo_gather_point *point);
/* direction: unit. */
svo_ray hemisphere_ray(const hemisphere_set *set, const svo_gather_point *point, vector3 direction);
/* Fills point_count * strata^2 rays, point by point. */
void hemisphere_rays(const hemisphere_set *set, const svo_gather_point *points, size_t point_count, svo_ray *rays);

#endif
