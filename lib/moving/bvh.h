/* SPDX-License-Identifier: MIT */
/* The BVH of a scene that moves, from those of its objects. */
#ifndef SVO_LIB_MOVING_BVH_H
#define SVO_LIB_MOVING_BVH_H

#include "moving/handle.h"

/* Releases the BVHs, if there are any. */
void svo_i_moving_free_bvhs(svo_moving *moving);

#endif
