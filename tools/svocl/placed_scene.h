/* SPDX-License-Identifier: MIT */
/* The scene of a file on the device, for commands that draw it. */
#ifndef SVOCL_TOOLS_SVOCL_PLACED_SCENE_H
#define SVOCL_TOOLS_SVOCL_PLACED_SCENE_H

#include "support/scene_file.h"
#include "support/scene_trees.h"

typedef struct placed_scene {
    scene_file file;
    scene_trees trees;
    svo_scene *scene;
} placed_scene;

/* Builds or loads the trees of INPUT and places them; begins the progress bar. Returns the exit code; on failure
   nothing stays open. */
int placed_scene_open(program *state, unsigned further_steps, placed_scene *out);
void placed_scene_close(placed_scene *which);

/* Where a picture of --size is taken from: the file's camera, or one that frames the scene, moved by the options.
   Returns the exit code. */
int placed_scene_camera(program *state, const placed_scene *which, svo_camera *camera);

#endif
