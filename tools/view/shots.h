/* SPDX-License-Identifier: MIT */
/* Pictures of the window as PNG files. */
#ifndef SVOCL_TOOLS_VIEW_SHOTS_H
#define SVOCL_TOOLS_VIEW_SHOTS_H

#include "view/viewer.h"

/* Writes what was drawn of the frame. Returns the exit code. */
int shots_take(viewer *which, const char *path, unsigned width, unsigned height);
/* The same under a name that no file has, if the state asks for this kind and the picture is there in full; a box says
   why it failed. */
void shots_save(viewer *which, view_shot shot);

#endif
