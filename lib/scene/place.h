/* SPDX-License-Identifier: MIT */
/* What the kernels know of an instance, from its matrix. */
#ifndef SVO_LIB_SCENE_PLACE_H
#define SVO_LIB_SCENE_PLACE_H

#include "scene/state.h"

/* Inverts the matrix, in double, and finds the world's box of an instance of a tree. Refuses a matrix that is not
   finite, flat, or too large, and names the instance. */
svo_status svo_i_scene_place(svo_device *device, const char *function, uint32_t instance, const float matrix[12],
                             const svo_i_scene_box *tree_box, svo_scene_instance *out);

#endif
