/* SPDX-License-Identifier: MIT */
/* The corners of a tree's triangles as the leaves of its BVH hold them. */
#ifndef SVO_LIB_RAYS_CORNERS_H
#define SVO_LIB_RAYS_CORNERS_H

#include "core/tree.h"
#include "core/work.h"

/* Three coordinates per vertex; layout.h says in which units. */
typedef struct svo_i_corners {
    cl_mem floats;
    cl_mem doubles; /* NULL: leaves hold floats alone */
    cl_mem made[2]; /* those of them that are not the tree's; svo_i_corners_release releases them */
    bool in_world; /* the floats are in world units */
} svo_i_corners;

/* Finds the corners, or makes them and waits. queue: NULL for the device's own. */
svo_status svo_i_corners_find(const svo_tree *tree, const char *function, cl_command_queue queue, svo_i_corners *out);
void svo_i_corners_release(svo_i_corners *corners);

#endif
