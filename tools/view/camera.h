/* SPDX-License-Identifier: MIT */
/* The camera: around a point, or flying. */
#ifndef SVOCL_TOOLS_VIEW_CAMERA_H
#define SVOCL_TOOLS_VIEW_CAMERA_H

#include "view/state.h"

/* Turns by a drag of so many pixels: in VIEW_ORBIT the eye around the target, in VIEW_FLY the line of sight around the
   eye. Up stays up: neither passes the poles. */
void camera_turn(view_state *state, float right, float down);

/* Moves eye and target by a drag of so many pixels, so that the target stays below the mouse. */
void camera_pan(view_state *state, float right, float down);

/* Steps of the wheel: in VIEW_ORBIT nearer to the target, in VIEW_FLY faster. */
void camera_wheel(view_state *state, float steps);

/* Moves by the keys that are held. */
void camera_move(view_state *state, float seconds);

/* Moves a point of the world by so many pixels of the window, in the plane through it that faces the camera: it stays
   below the mouse that drags it. */
void camera_drag_point(const view_state *state, float right, float down, float point[3]);

/* Whether a key of it is held. */
bool camera_is_moving(const view_state *state);

/* Back to where it began. */
void camera_go_home(view_state *state);

/* Where a point of the world is in the window, pixels. False behind the eye. */
bool camera_project(const view_state *state, const float point[3], float pixel[2]);

/* The direction of the ray through a place of the window, of length 1. */
void camera_ray(const view_state *state, float x, float y, float direction[3]);

#endif
