/* SPDX-License-Identifier: MIT */
/* The boxes of what the trees of a scene occupy. */
#ifndef SVO_LIB_SCENE_BOUNDS_H
#define SVO_LIB_SCENE_BOUNDS_H

#include "scene/source.h"

/* Of a tree, on the device. */
#define SVO_I_BOUNDS_BYTES (6 * sizeof(cl_int))

/* Fills scene->tree_boxes from the trees in the scene's buffers. Waits. */
svo_status svo_i_scene_find_bounds(svo_scene *scene, const char *function, cl_command_queue queue,
                                   const svo_i_scene_source *sources);

#endif
