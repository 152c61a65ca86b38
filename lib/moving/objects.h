/* SPDX-License-Identifier: MIT */
/* Objects of a scene that moves, and where updates change the tree: bounds of the objects that change. */
#ifndef SVO_LIB_MOVING_OBJECTS_H
#define SVO_LIB_MOVING_OBJECTS_H

#include "moving/handle.h"

/* Makes an object with that index, which is free. object: its number, for the message. */
svo_status svo_i_moving_make_object(svo_moving *moving, const char *function, uint32_t index, const svo_mesh *mesh,
                                    const double transform[12]);
/* Releases all that an object holds. Its pairs stay in the scene's list until the next update. */
void svo_i_moving_release_object(svo_i_moving_object *object);
/* Releases the arrays of the scene's mesh, which has changed. */
void svo_i_moving_forget_mesh(svo_moving *moving);

/* Notes where an update changes the tree, before it marks the objects as listed. */
void svo_i_moving_note_changes(svo_moving *moving);
/* An update changes nothing. */
void svo_i_moving_forget_changes(svo_moving *moving);

#endif
