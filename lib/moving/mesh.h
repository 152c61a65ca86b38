/* SPDX-License-Identifier: MIT */
/* The meshes of objects: copies, transforms, and all of them in one. */
#ifndef SVO_LIB_MOVING_MESH_H
#define SVO_LIB_MOVING_MESH_H

#include "moving/state.h"

/* Refuses a transform that is not finite or is flat. object: its number, for the message. */
svo_status svo_i_moving_check_transform(svo_device *device, const char *function, uint32_t object,
                                        const double transform[12]);
/* Copies a mesh to an object, whose arrays are NULL. After a failure svo_i_moving_free_mesh releases what there is. */
svo_status svo_i_moving_copy_mesh(svo_device *device, const char *function, const svo_mesh *mesh,
                                  svo_i_moving_object *object);
/* Copies vertices of the same counts and kinds. */
void svo_i_moving_copy_vertices(const svo_mesh *mesh, svo_i_moving_object *object);
/* Makes the object's vertices in the world. */
void svo_i_moving_place(svo_i_moving_object *object);
void svo_i_moving_free_mesh(svo_i_moving_object *object);
/* Releases the arrays of the scene's mesh, which has changed. */
void svo_i_moving_forget_mesh(svo_moving *moving);

#endif
