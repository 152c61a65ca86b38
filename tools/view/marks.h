/* SPDX-License-Identifier: MIT */
/* Lines over the picture: what is selected, where the chosen light is, probes; and the ground grid, lines on the lowest
   plane of what is shown, as far as nothing stands before them. */
#ifndef SVOCL_TOOLS_VIEW_MARKS_H
#define SVOCL_TOOLS_VIEW_MARKS_H

#include "view/canvas.h"
#include "view/state.h"
#include "view/subject.h"

typedef struct marks {
    canvas_vertex *vertices;
    size_t count, capacity;
    bool failed; /* out of memory: marks are missing */
} marks;

/* Makes the marks of a frame anew. */
void marks_make(marks *which, const view_state *state);
void marks_end(marks *which);

/* ---- the ground grid ---- */

/* What the pieces were made for. */
typedef struct ground_key {
    svo_camera camera;
    view_clip clip;
    view_revisions revisions;
    float low[3], high[3];
    unsigned width, height, level;
    bool is_scene, is_refined;
} ground_key;

typedef struct ground {
    view_piece *pieces;
    svo_ray *rays; /* from the eye to the middle of each */
    size_t count, capacity;
    bool failed; /* out of memory */
    ground_key made;
} ground;

/* Makes the pieces that state.ground shows, anew where something changed. Returns the exit code. */
int ground_update(ground *which, subject *shown, view_state *state);
void ground_end(ground *which);

#endif
