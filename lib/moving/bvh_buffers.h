/* SPDX-License-Identifier: MIT */
/* Places in the common buffers of the objects' BVHs. */
#ifndef SVO_LIB_MOVING_BVH_BUFFERS_H
#define SVO_LIB_MOVING_BVH_BUFFERS_H

#include "moving/handle.h"

/* Finds places for all objects of the newest tree whose BVHs have none, in larger buffers if need be; the records of
   some may have to be written again then. Waits. */
svo_status svo_i_moving_place_bvhs(svo_moving *moving, const char *function, cl_command_queue queue);

#endif
