/* SPDX-License-Identifier: MIT */
/* Objects of a scene that moves. */
#ifndef SVO_LIB_MOVING_OBJECTS_H
#define SVO_LIB_MOVING_OBJECTS_H

#include "moving/state.h"

/* Makes an object with that index, which is free. object: its number, for the message. */
svo_status svo_i_moving_make_object(svo_moving *moving, const char *function, uint32_t index, const svo_mesh *mesh,
                                    const double transform[12]);
/* Refuses to touch the scene while an update is in flight. */
svo_status svo_i_moving_check_still(const svo_moving *moving, const char *function);
/* Releases all that an object holds. Its pairs stay in the scene's list until the next update. */
void svo_i_moving_release_object(svo_i_moving_object *object);

#endif
