/* SPDX-License-Identifier: MIT */
/* Where updates change the tree: bounds of the objects that change, before and after. */
#ifndef SVO_LIB_MOVING_CHANGES_H
#define SVO_LIB_MOVING_CHANGES_H

#include "moving/state.h"

/* Notes what an update changes, before it marks the objects as listed. */
void svo_i_moving_note_changes(svo_moving *moving);
/* An update changes nothing. */
void svo_i_moving_forget_changes(svo_moving *moving);

#endif
