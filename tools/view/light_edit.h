/* SPDX-License-Identifier: MIT */
/* Lights: added, and moved by the mouse. */
#ifndef SVOCL_TOOLS_VIEW_LIGHT_EDIT_H
#define SVOCL_TOOLS_VIEW_LIGHT_EDIT_H

#include "view/state.h"

/* Adds a source that suits where the camera looks, and chooses it. kind: SVO_SOURCE_*. False without memory. */
bool light_edit_add(view_state *state, uint32_t kind);

/* Moves the chosen source by pixels of the window, right and down: in the plane through it that faces the camera, so
   that it stays below the mouse. Parallel light turns instead, as if its origin were moved. */
void light_edit_drag(view_state *state, float right, float down);

/* Moves it away from the camera by steps of the wheel. Parallel light stays. */
void light_edit_push(view_state *state, float steps);

/* Degrees: around the world's up, and above the horizon, of where a direction comes from. */
void light_edit_angles(const view_state *state, const float direction[3], float angles[2]);
void light_edit_direction(const view_state *state, const float angles[2], float direction[3]);

#endif
