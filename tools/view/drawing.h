/* SPDX-License-Identifier: MIT */
/*
 * When what is drawn: coarse pictures while something moves, then finer ones until the full picture is there. Rows go
 * to the pixel buffer; the picture that they are part of is the canvas's. And what a click finds: by exact rays against
 * triangles, and by rays against voxels.
 */
#ifndef SVOCL_TOOLS_VIEW_DRAWING_H
#define SVOCL_TOOLS_VIEW_DRAWING_H

#include "view/canvas.h"
#include "view/subject.h"

/* What measures pictures: milliseconds. */
typedef struct drawing_clock {
    double (*now_ms)(void *user);
    void *user;
} drawing_clock;

typedef struct drawing {
    pixel_buffer pixels; /* rows that were drawn last, at their place in the picture */
    unsigned width, height; /* of the last picture; 0: none yet */
    unsigned coarse; /* of the last picture: the window's pixels along a side of its pixels */
    unsigned rows_done; /* of it, from the top; below them are those of the coarser picture before */
    unsigned row_count; /* of those, the ones that were drawn last */
    bool is_enlarged; /* they are the first that go over the picture before, of twice the width */
    /* What the last picture shows. */
    view_shown shown;
    bool is_exposed; /* and its exposure is the one to be shown */
    bool is_scene, shows_brush;
    view_revisions revisions;
    svo_camera camera;
    unsigned window_width, window_height;
    double pixel_ms[VIEW_PICTURES][2]; /* time of a pixel, of the tree and through probes; 0: not known */
    uint64_t rays; /* from the camera, of the last picture */
} drawing;

void drawing_end(drawing *which);

/* Draws the next picture, if one is due: a coarse one where something changed, else a finer one. Pictures that cones
   light get finer band by band, since each takes long: so what happens meanwhile is seen soon. is_new: whether there is
   a picture or a band. Returns the exit code. */
int drawing_next(drawing *which, subject *shown, view_state *state, const drawing_clock *clock, bool *is_new);

/* ---- clicks ---- */

/* Fills the selection with what is at a place of the window. Returns the exit code. */
int pick_at(subject *which, view_state *state, int x, int y);

#endif
