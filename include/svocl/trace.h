/* SPDX-License-Identifier: MIT */
/*
 * Casting rays through the tree's voxels on the device: for now pictures, every pixel one ray that stops at the first
 * leaf (or at the first node that is smaller than a pixel).
 */
#ifndef SVOCL_TRACE_H
#define SVOCL_TRACE_H

#include <stdint.h>

#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A pinhole camera in world coordinates. */
typedef struct svo_camera {
    float eye[3];
    float target[3];
    float up[3]; /* not parallel to target - eye */
    float vertical_fov; /* radians, above 0 and below pi */
} svo_camera;

/* A camera that looks at the occupied part of the tree from the front, a little to the right and above, and frames it.
   aspect: width / height, above 0; anything else counts as 1. Needs the host arrays (svo_tree_download). */
SVO_API void svo_camera_frame(const svo_tree *tree, float aspect, svo_camera *camera);

typedef struct svo_render_options {
    size_t struct_size; /* sizeof(svo_render_options) */
    uint32_t width, height; /* pixels, 1 .. 16384 */
    svo_camera camera;
} svo_render_options;

/*
 * Draws the tree and waits for it: voxels shaded by normal (their own, else the face the ray entered by) and colour
 * (their own, else light grey), with soft shadowing from a second ray towards the light.
 *
 * tree: uploaded or built on device. rgba: height * width * 4 bytes, rows top to bottom, written whole on SVO_OK.
 * Returns SVO_INVALID_ARGUMENT, SVO_COMPILE_FAILED, SVO_CL_ERROR, SVO_OUT_OF_DEVICE_MEMORY.
 */
SVO_API svo_status svo_tree_render(svo_device *device, const svo_tree *tree, const svo_render_options *options,
                                   cl_command_queue queue, uint8_t *rgba);

#ifdef __cplusplus
}
#endif

#endif
