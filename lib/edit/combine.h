/* SPDX-License-Identifier: MIT */
/* Steps on nodes: what a verb makes of two octrees, one of which may be a shape; octrees moved by whole voxels. */
#ifndef SVO_LIB_EDIT_COMBINE_H
#define SVO_LIB_EDIT_COMBINE_H

#include "edit/shape.h"
#include "edit/store.h"
#include "svocl/edit.h"

/* A step that runs. */
typedef struct svo_i_edit_run {
    svo_i_edit_store *store; /* receives the nodes */
    svo_edit_verb verb;
    svo_i_edit_solid solid; /* the shape, of svo_i_edit_combine with SVO_I_EDIT_SHAPE */
    svo_i_edit_ref fill; /* the shape's color and material, a uniform node */
    svo_edit_progress_callback progress; /* NULL: nothing is called */
    void *progress_user;
    double fraction; /* what was told last; below 0: nothing yet */
    double share; /* of the whole that the call at hand is, which begins at begin */
    double begin;
    uint64_t node_count; /* places that were decided about */
    bool canceled;
} svo_i_edit_run;

/* Tells the callback that a fraction is done, unless it knows. Returns whether to go on; run->canceled says so too. */
bool svo_i_edit_tell(svo_i_edit_run *run, double fraction);

/* In place of a node: the shape of the run, where it is not decided. */
#define SVO_I_EDIT_SHAPE UINT32_MAX

/*
 * Combines two roots: a is what there was, b the operand, both in run->store.
 *
 * Returns false where there is no memory (run->store->failure) or the callback stops it (run->canceled).
 */
bool svo_i_edit_combine(svo_i_edit_run *run, svo_i_edit_ref a, svo_i_edit_ref b, svo_i_edit_ref *out);

/* Moves the root of a store by an offset into run->store, which may be the same. What leaves the cube is cut off. */
bool svo_i_edit_move(svo_i_edit_run *run, const svo_i_edit_store *from, svo_i_edit_ref root, const int64_t offset[3],
                     svo_i_edit_ref *out);

#endif
