/* SPDX-License-Identifier: MIT */
/*
 * What is edited: lights, moved by the mouse too; instances and their places; and what moves, played by the viewer's
 * clock, which in a script counts frames, or stepped through.
 */
#ifndef SVOCL_TOOLS_VIEW_EDIT_H
#define SVOCL_TOOLS_VIEW_EDIT_H

#include "view/state.h"

/* ---- lists ---- */

/* Lights. After a change of a source or the sky by hand, view_lights_changed. Adding one fails without memory. */
void view_lights_changed(view_state *state);
bool view_add_source(view_state *state, const svo_light_source *source);
void view_remove_source(view_state *state, size_t index);

/* Instances. After a change of a matrix by hand, view_instances_changed. Adding one fails without memory. */
void view_instances_changed(view_state *state);
bool view_add_instance(view_state *state, const svo_instance *instance);
void view_remove_instance(view_state *state, size_t index);
/* The motion of an instance; NULL: it has none. */
view_mover *view_mover_of(const view_state *state, size_t instance);
/* A key of it: as the file has it, but moved, turned and scaled as its first key is. */
scene_place view_mover_key(const view_mover *mover, size_t key);
/* Of an instance above those that move. Fails without memory. */
bool view_add_mover(view_state *state, const view_mover *mover);

/* Shows the tree as the first instance of a scene, or alone again. A scene from a file has no tree alone, but if it has
   motions the tree of what moves. */
void view_choose_scene(view_state *state, bool is_scene);
/* Lights of a scene, at most SVO_SCENE_LIGHTS_MAX. */
void view_add_scene_light(view_state *state);
void view_remove_scene_light(view_state *state, size_t index);

/* ---- lights ---- */

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

/* ---- instances ---- */

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

/* ---- motions ---- */

/* Plays or pauses; after the last frame from the first. Instances that are edited give way to what moves. */
void play_toggle(view_state *state);

/* Shows a frame, and pauses. */
void play_seek(view_state *state, uint64_t frame);
/* The frame after (1) or before (-1) the one that is shown. */
void play_step(view_state *state, int direction);

/* Clamped. */
void play_choose_speed(view_state *state, int speed_log2);

/* Lets so many seconds pass. */
void play_advance(view_state *state, double seconds);

#endif
