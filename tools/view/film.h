/* SPDX-License-Identifier: MIT */
/* The tree of what moves in a scene, at the frame that the state asks for: what svocl render --animate draws. */
#ifndef SVOCL_TOOLS_VIEW_FILM_H
#define SVOCL_TOOLS_VIEW_FILM_H

#include "support/animation.h"
#include "view/placed.h"
#include "view/state.h"

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
