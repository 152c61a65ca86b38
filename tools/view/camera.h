/* SPDX-License-Identifier: MIT */
/* The camera: around a point, or flying; and where it sees points of the world, rays and probes. */
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

/* The ray through a place of the window, as far as a clipping plane leaves it: t in world units. Where it leaves
   nothing t_min is above t_max. */
void camera_pick_ray(const view_state *state, float x, float y, svo_ray *ray);

/* Cuts a ray from the eye so. */
void camera_clip_ray(const view_state *state, svo_ray *ray);

/* Makes a direction, of any length, the world's up: orbits go around it. The camera turns with it, so that it looks at
   the world's sides as before. */
void camera_choose_up(view_state *state, const float up[3]);

/* The direction that is up in the world. */
void camera_up(const view_state *state, double up[3]);

/* Looks along an axis at the target, from its positive side and as far away as now; along the world's up with -z or y
   above. */
void camera_look_along(view_state *state, int axis);

/* From the eye to the target. */
float camera_distance(const view_state *state);

/* The camera's directions, unit: to the right and up in the picture, and of the line of sight. */
void camera_axes(const view_state *state, float right[3], float above[3], float sight[3]);

/* The direction of the ray through a place of the window, of length 1. */
void camera_ray(const view_state *state, float x, float y, float direction[3]);

/* ---- probes as spheres ---- */

typedef struct probe_sphere {
    uint32_t index; /* of the probe */
    float pixel[2]; /* of its center */
    float radius; /* pixels */
    float away; /* along the line of sight, world units */
} probe_sphere;

/* False where the probe is behind the eye. */
bool probe_sphere_project(const view_state *state, uint32_t index, probe_sphere *out);

/* The nearest sphere at a place of the window. False where none is, or none is shown. */
bool probe_sphere_at(const view_state *state, float x, float y, uint32_t *index);

#endif
