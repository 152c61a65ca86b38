/* SPDX-License-Identifier: MIT */
/* svocl convert IN.vox OUT.json: a file's scene as one of docs/scenes.md. */
#ifndef SVOCL_TOOLS_SVOCL_VOXEL_SCENE_H
#define SVOCL_TOOLS_SVOCL_VOXEL_SCENE_H

#include <stdbool.h>

#include "support/program.h"

/* Whether OUT is such a scene, by its suffix. */
bool voxel_scene_is_output(const program *state);

/* Writes the models into a folder beside OUT, and then OUT. Returns the exit code. */
int voxel_scene_convert(program *state);

#endif
