/* SPDX-License-Identifier: MIT */
/* svocl render --animate: the motions of a scene, a picture for each frame. */
#ifndef SVOCL_TOOLS_SVOCL_RENDER_ANIMATION_H
#define SVOCL_TOOLS_SVOCL_RENDER_ANIMATION_H

#include "support/program.h"

/* Refuses options of animations where none is asked for. Returns the exit code. */
int render_animation_check(program *state);
/* Renders the scene that INPUT names. Returns the exit code. */
int render_animation(program *state);

#endif
