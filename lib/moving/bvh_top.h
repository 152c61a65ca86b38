/* SPDX-License-Identifier: MIT */
/* The nodes above the BVHs of the objects. */
#ifndef SVO_LIB_MOVING_BVH_TOP_H
#define SVO_LIB_MOVING_BVH_TOP_H

#include "moving/bvh_state.h"

/* Makes the common nodes, from the extents of the objects of the newest tree. Waits. */
svo_status svo_i_moving_make_top(svo_moving *moving, const char *function, cl_command_queue queue);

#endif
