/* SPDX-License-Identifier: MIT */
/*
 * One build in progress: what its stages share. build/build.c and build/enqueue.c begin one and run the table of stages
 * over it.
 */
#ifndef SVO_LIB_STAGES_BUILD_STATE_H
#define SVO_LIB_STAGES_BUILD_STATE_H

#include "commands/commands.h"
#include "commands/frontend.h"
#include "commands/timing.h"
#include "core/tree.h"

/* The mesh's attributes on the device; NULL where the plan does not have them. */
typedef struct svo_i_surface {
    cl_mem vertices, indices;
    bool is_borrowed; /* those two are the tree's */
    cl_mem records, colors, normals, uvs, materials, texels;
} svo_i_surface;

typedef struct svo_i_build {
    svo_i_commands commands;
    cl_program programs[SVO_I_PROGRAM_KINDS]; /* the device's; those that the plan needs */
    svo_frontend *frontend; /* NULL: the build only measures */

    svo_i_fragment_list list;
    bool owns_list; /* its buffers are the build's own, else the front end's */
    uint64_t fragment_count; /* in all chunks */

    /* Scratch. */
    cl_mem *cursors; /* of the fragments, one buffer per chunk */
    cl_mem state, partials;
    svo_build_state host_state; /* what state was filled from */
    uint64_t inner_capacity;
    bool in_place; /* nodes stay where they were made, in arrays as large as the capacities */
    svo_i_surface surface;

    /* The tree in the making. */
    svo_tree *tree;
} svo_i_build;

SVO_I_SHARED_BEGIN

/* Puts levels into the state on the device, which is made if there is none. */
svo_status svo_i_build_put_state(svo_i_build *build, const uint32_t level_begin[SVO_LEVELS_MAX]);
/* What the device's counts say at the end of the subdivision: *fits, and then the tree's counts. */
svo_status svo_i_build_take_state(svo_i_build *build, const svo_build_state *state, bool *fits);
/* Cursors for the list's fragments. */
svo_status svo_i_build_alloc_cursors(svo_i_build *build);
/* Releases the list, whosever it is. */
void svo_i_build_release_list(svo_i_build *build);
/* The status and the message for a list with fragments that none can be. */
svo_status svo_i_build_fail_damaged(svo_i_build *build);
/* What the plan says of a tree; and capacities in place of its counts. */
void svo_i_build_fill_info(svo_i_build *build);
void svo_i_build_assume_counts(svo_i_build *build);

SVO_I_SHARED_END

#endif
