/* SPDX-License-Identifier: MIT */
/* Lines over the picture: what is selected, and where the chosen light is. */
#ifndef SVOCL_TOOLS_VIEW_MARKS_H
#define SVOCL_TOOLS_VIEW_MARKS_H

#include "view/canvas.h"
#include "view/state.h"

typedef struct marks {
    canvas_vertex *vertices;
    size_t count, capacity;
    bool failed; /* out of memory: marks are missing */
} marks;

/* Makes the marks of a frame anew. */
void marks_make(marks *which, const view_state *state);
void marks_end(marks *which);

#endif
