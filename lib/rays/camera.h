/* SPDX-License-Identifier: MIT */
/* Cameras of pictures, of a tree's and of a scene's. */
#ifndef SVO_LIB_RAYS_CAMERA_H
#define SVO_LIB_RAYS_CAMERA_H

#include <stdbool.h>

#include "svocl/trace.h"

/* An orthonormal camera frame. */
typedef struct svo_i_view {
    double forward[3], right[3], up[3];
} svo_i_view;

/* False, and out untouched, for a vector without a direction. */
bool svo_i_normalize(const double a[3], double out[3]);

/* False for a camera that is not finite or without a direction, or whose up is along it. */
bool svo_i_view_from_camera(const svo_camera *camera, svo_i_view *out);

/* Frames a box from the front, a little from the right and from above. aspect: width / height; what is not above 0
   counts as 1. */
void svo_i_camera_frame(const double low[3], const double high[3], float aspect, svo_camera *camera);

/* Towards the light: high, and over the right shoulder of whoever looks along the view. up: unit. */
void svo_i_place_sun(const svo_i_view *looking, const double up[3], double sun[3]);

#endif
