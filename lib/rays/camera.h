/* SPDX-License-Identifier: MIT */
/* A camera as directions in double. */
#ifndef SVO_LIB_RAYS_CAMERA_H
#define SVO_LIB_RAYS_CAMERA_H

#include <stdbool.h>

#include "svocl/device.h"
#include "svocl/trace.h"

/* An orthonormal camera frame. */
typedef struct svo_i_view {
    double forward[3], right[3], up[3];
} svo_i_view;

/* False for a camera without one: positions that are not finite, or up along the line of sight. */
bool svo_i_view_from_camera(const svo_camera *camera, svo_i_view *out);

/* Refuses sizes of pictures and angles of view that there are not. function: for the message. */
svo_status svo_i_camera_check(svo_device *device, const char *function, const svo_camera *camera, uint32_t width,
                              uint32_t height);

/* The rays of a picture's pixels, from the eye: corner + column * across + row * down. */
typedef struct svo_i_pinhole {
    float corner[3], across[3], down[3];
    double pixel; /* width of a pixel at distance 1 */
    double up[3]; /* the camera's, unit */
    svo_i_view view;
} svo_i_pinhole;

/* Refuses cameras without a frame. */
svo_status svo_i_pinhole_from_camera(svo_device *device, const char *function, const svo_camera *camera, uint32_t width,
                                     uint32_t height, svo_i_pinhole *out);

/* Refuses planes that are not finite. */
svo_status svo_i_clip_check(svo_device *device, const char *function, const float clip[4]);

/* False, and out untouched, for a vector without a direction. */
bool svo_i_normalize(const double a[3], double out[3]);

/* What a camera is fitted to. reach: the largest dot product of a point of it with a direction. */
typedef struct svo_i_fitted {
    const void *subject;
    double (*reach)(const void *subject, const double along[3]);
} svo_i_fitted;

/* The nodes of a tree on the host. */
typedef struct svo_i_framed {
    const void *subject;
    /* The mask of a node's children, which child receives by octant; 0: the node is a leaf. NULL: nodes are not known,
       so that the whole grid counts. node: 0 for the root, else from child. */
    uint32_t (*open)(const void *subject, uint32_t node, uint32_t level, uint32_t child[8]);
    uint32_t depth;
    double origin[3], edge; /* of the grid */
} svo_i_framed;
/* An svo_i_fitted.reach of svo_i_framed: cells down to SVO_FRAME_LEVEL_MAX are occupied or empty. */
double svo_i_framed_reach(const void *framed, const double along[3]);

/* Does what svo_camera_fit says; false, and the camera as it was, for one without a frame. */
bool svo_i_camera_fit(const svo_i_fitted *of, float aspect, svo_camera *camera);
/* svo_camera_fit of a tree. */
svo_status svo_i_tree_fit_camera(const void *subject, float aspect, svo_camera *camera);

/* Towards the light: high, and over the right shoulder of whoever looks along the view. up: unit. */
void svo_i_place_sun(const svo_i_view *looking, const double up[3], double sun[3]);

#endif
