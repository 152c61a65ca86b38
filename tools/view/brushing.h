/* SPDX-License-Identifier: MIT */
/* The brush: an edit of the tree's voxels, drawn from its own nodes, and the tree that is written of it. */
#ifndef SVOCL_TOOLS_VIEW_BRUSHING_H
#define SVOCL_TOOLS_VIEW_BRUSHING_H

#include "support/program.h"
#include "svocl/edit.h"
#include "view/state.h"

typedef struct brushing {
    program *running;
    svo_device *device;
    cl_command_queue queue;
    svo_edit *edit; /* NULL: nothing was drawn yet */
    svo_edit_mirror *mirror;
    svo_edit_info info; /* of the edit */
    svo_edit_mirror_info mirrored;
    uint64_t position; /* of the edit */
    uint64_t written; /* position that the tree has */
    uint64_t begun; /* position before the stroke that is under way */
    bool is_along; /* it goes on from last */
    double last[3]; /* voxels */
    float last_pixel[2];
    int32_t low[3], high[3]; /* no voxel is outside, nor at the rim */
} brushing;

/* Lets the strokes that the state has come by change the edit, makes it the one of state.brush.position, and tells the
   state what is under the mouse. tree: that the edit begins with; it is on the device and has host arrays. Failures
   that a hand can do something about are told in the log. Returns the exit code. */
int brushing_update(brushing *which, const svo_tree *tree, view_state *state);
void brushing_close(brushing *which);

/* Whether the tree lacks strokes. */
bool brushing_is_newer(const brushing *which, const view_state *state);
/* Writes the tree of the edit, which then has all strokes. Returns the exit code. */
int brushing_commit(brushing *which, view_state *state, svo_tree **out);

#endif
