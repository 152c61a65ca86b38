/* SPDX-License-Identifier: MIT */
/* A camera as directions in double. */
#ifndef SVO_LIB_RAYS_CAMERA_H
#define SVO_LIB_RAYS_CAMERA_H

#include <stdbool.h>

#include "svocl/trace.h"

/* An orthonormal camera frame. */
typedef struct svo_i_view {
    double forward[3], right[3], up[3];
} svo_i_view;

/* False for a camera without one: positions that are not finite, or up along the line of sight. */
bool svo_i_view_from_camera(const svo_camera *camera, svo_i_view *out);

/* False, and out untouched, for a vector without a direction. */
bool svo_i_normalize(const double a[3], double out[3]);

#endif
