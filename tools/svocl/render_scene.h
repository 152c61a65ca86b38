/* SPDX-License-Identifier: MIT */
/* svocl render SCENE.json. */
#ifndef SVOCL_TOOLS_SVOCL_RENDER_SCENE_H
#define SVOCL_TOOLS_SVOCL_RENDER_SCENE_H

#include "support/program.h"

/* Builds or loads the trees of the scene that INPUT describes, places and draws them. Returns the exit code. */
int render_scene(program *state);

#endif
