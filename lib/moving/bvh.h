/* SPDX-License-Identifier: MIT */
/* The BVH of a scene that moves, from those of its objects. */
#ifndef SVO_LIB_MOVING_BVH_H
#define SVO_LIB_MOVING_BVH_H

#include "moving/state.h"

/* Notes what of each object is in the newest tree. */
void svo_i_moving_note_parts(svo_moving *moving);
void svo_i_moving_free_bvhs(svo_moving *moving);

#endif
