/* SPDX-License-Identifier: MIT */
/* Files of the viewer: settings from one run to the next, in $XDG_CONFIG_HOME/svocl/view.json or
   ~/.config/svocl/view.json; scenes and lights, which svocl render and svocl view read (docs/scenes.md). */
#ifndef SVOCL_TOOLS_VIEW_FILES_H
#define SVOCL_TOOLS_VIEW_FILES_H

#include "view/state.h"

/* ---- settings ---- */

#define SETTINGS_PATH_BYTES 4096

typedef struct settings_file {
    char path[SETTINGS_PATH_BYTES]; /* "": there is no place for it */
} settings_file;

/* Finds the place of the file, by the environment. */
void settings_find(settings_file *out);

/* Reads the file into state->settings. Where it is missing they stay; where it is damaged they stay too, the last line
   of the log says what is wrong, and this returns false. */
bool settings_load(const settings_file *file, view_state *state);

/* Writes the file whole or not at all, and its folders where they are missing. False on failure, with the last line of
   the log. */
bool settings_save(const settings_file *file, view_state *state);

/* ---- scenes and lights ---- */

/* Writes trees, instances, camera, lights and the range of occlusion, whole or not at all. Read again, instances
   and motions are the same bit for bit. Returns 0 or an errno. */
int scene_save(const view_state *state, const char *path);

/* The same for the lights of a tree alone, its sky and the camera, as --lights reads them (docs/light.md). */
int lights_save(const view_state *state, const char *path);

#endif
