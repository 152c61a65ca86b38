/* SPDX-License-Identifier: MIT */
/* What a click finds: by exact rays against triangles, and by rays against voxels. */
#ifndef SVOCL_TOOLS_VIEW_PICK_H
#define SVOCL_TOOLS_VIEW_PICK_H

#include "view/subject.h"

/* Fills the selection with what is at a place of the window. Returns the exit code. */
int pick_at(subject *which, view_state *state, int x, int y);

#endif
