/* SPDX-License-Identifier: MIT */
/* Editing of a scene's instances. */
#ifndef SVOCL_TOOLS_VIEW_SCENE_EDIT_H
#define SVOCL_TOOLS_VIEW_SCENE_EDIT_H

#include "support/scene_place.h"
#include "view/state.h"

/* The placement of an instance as it was edited last, else the one of its matrix. False: its matrix shears, and out has
   the translation alone. */
bool scene_edit_place(const view_state *state, size_t index, scene_place *out);

/* Places an instance; one that moves has its first key there, and the others follow. A scale of 0 and numbers that are
   not finite change nothing; false then. */
bool scene_edit_set(view_state *state, size_t index, const scene_place *place);

/* Moves an instance and leaves the rest of its matrix as it is. */
void scene_edit_move(view_state *state, size_t index, const float translate[3]);

/* Moves the chosen instance by pixels of the window, right and down, so that it stays below the mouse. */
void scene_edit_drag(view_state *state, float right, float down);

/* Adds a copy of the chosen instance beside it, or the first tree where it is. False without memory. */
bool scene_edit_add(view_state *state);

/* Removes the chosen instance; a scene keeps one. */
void scene_edit_remove(view_state *state);

#endif
