/* SPDX-License-Identifier: MIT */
/* Scenes and lights to files that svocl render and svocl view read (docs/scenes.md). */
#ifndef SVOCL_TOOLS_VIEW_SCENE_SAVE_H
#define SVOCL_TOOLS_VIEW_SCENE_SAVE_H

#include "view/state.h"

/* Writes trees, instances, camera, lights and the range of occlusion, whole or not at all. Read again, instances
   and motions are the same bit for bit. Returns 0 or an errno. */
int scene_save(const view_state *state, const char *path);

/* The same for the lights of a tree alone, its sky and the camera, as --lights reads them (docs/light.md). */
int lights_save(const view_state *state, const char *path);

#endif
