/* SPDX-License-Identifier: MIT */
/* Placed trees: a scene's file, or the one tree that is looked at, and its instances as they are edited; and the tree
   of what moves in it, at the frame that the state asks for, which svocl render --animate draws. */
#ifndef SVOCL_TOOLS_VIEW_PLACED_H
#define SVOCL_TOOLS_VIEW_PLACED_H

#include "support/animation.h"
#include "support/scene_trees.h"
#include "view/state.h"

typedef struct placed placed;

/* Reads a scene's file and makes its trees. Returns the exit code; on failure nothing stays open. */
int placed_open(program *running, const char *path, placed **out);

/* For the tree of INPUT in place of a file: nothing is placed until placed_use_tree. depth: of a tree that is built
   from a mesh, else 0. NULL without memory. */
placed *placed_of_input(program *running, unsigned depth);
void placed_close(placed **which);

/* Puts into the state what the file has: trees, instances, camera, lights. False without memory; the state is then as
   it was. */
bool placed_describe(placed *which, view_state *state);

/* The file that now has the tree of INPUT, for scenes that are saved. */
void placed_name_tree(placed *which, const char *path);

/* The tree, which stays the caller's, and where it is. What was made of another one is gone. */
void placed_use_tree(placed *which, svo_device *device, cl_command_queue queue, svo_tree *tree);

/* Places the trees as the state has the instances. What the library refuses is undone in the state, and the log says
   why. Returns the exit code. */
int placed_update(placed *which, view_state *state);
/* Whether that has nothing to do. */
bool placed_is_current(const placed *which, const view_state *state);
/* How often a scene was made or moved. */
unsigned placed_changes(const placed *which);

/* Draws what svocl render would of the scene as it is. Returns the exit code. */
int placed_draw(placed *which, const view_state *state, unsigned width, unsigned height, cl_mem pixels,
                cl_event *drawn);

/* The bytes of that scene beforehand. */
svo_status placed_plan(placed *which, const view_state *state, svo_scene_info *info);

/* NULL before placed_update. */
svo_scene *placed_scene(const placed *which);
/* A tree of the scene, with host arrays; NULL where it is held in a compact form. */
const svo_tree *placed_tree(const placed *which, uint32_t index);
/* Closed without a file. */
const scene_file *placed_file(const placed *which);
svo_device *placed_device(const placed *which);
cl_command_queue placed_queue(const placed *which);

/* ---- what moves ---- */

typedef struct film {
    program *running;
    animation moving;
    bool is_open;
    scene_motion *motions; /* of the animation, as they were edited; motion_count */
    size_t motion_count;
    unsigned revision; /* of the state's instances */
    uint64_t frame; /* of the tree */
} film;

/* Makes the tree of a scene's file with the state's instances and motions, anew after they were edited, and moves it
   to the state's frame. Where that fails the log says so: the frame before is shown, or without one the instances.
   Returns the exit code. */
int film_update(film *which, const placed *from, view_state *state);
void film_close(film *which);

/* NULL: there is none. */
svo_tree *film_tree(const film *which);

#endif
