/* SPDX-License-Identifier: MIT */
/*
 * A build in progress: the data that its stages share. pipeline/build.c and pipeline/enqueue.c create one and run the
 * table of stages on it.
 *
 * The files of this room:
 *
 *   build_state  a build in progress
 *   inputs       what stages get from the plan: parameters, mesh, attributes, constants
 *   voxelize     the fragment list, by the front end "cl"
 *   drop         pairs with too little alpha leave the list
 *   subdivide    nodes, from the top down
 *   sort         the sorted list, and prefix sums
 *   bottom_up    nodes from the sorted list
 *   pack         lists and ranges of leaves
 *   material     the material of each node
 *   filter       colors, normals and fills of all nodes, projected areas of leaves
 *   proof_*      known answers of the programs (core/proof.h): fragments, drop, nodes and lists, filter
 */
#ifndef SVO_LIB_STAGES_BUILD_STATE_H
#define SVO_LIB_STAGES_BUILD_STATE_H

#include "commands/commands.h"
#include "commands/frontend.h"
#include "core/tree.h"

/* The mesh's attributes on the device. Buffers that the plan does not need are NULL. */
typedef struct svo_i_surface {
    cl_mem vertices, indices; /* the tree's or those of commands.mesh */
    cl_mem remainders; /* of the vertices, for stages that read these */
    cl_mem records, colors, normals, uvs, materials, texels;
} svo_i_surface;

/* Pairs that are weighed already, in the order of the list: see kernels/moving. */
typedef struct svo_i_kept {
    cl_program program;
    cl_mem values, materials, areas; /* of each fragment; materials and areas NULL where none are needed */
    cl_mem edges; /* the sums of the mesh's edges; NULL without areas */
} svo_i_kept;

/* A program of a stage, compiled for the plan. */
typedef struct svo_i_made_program {
    const svo_i_program *program;
    cl_program made; /* owned by the device */
} svo_i_made_program;

typedef struct svo_i_build {
    svo_i_commands commands;
    svo_i_made_program programs[SVO_I_STAGE_PROGRAMS_MAX]; /* those of the plan's stages, then zeros */
    svo_frontend *frontend; /* NULL where a plan is measured before a front end is known */

    svo_i_fragment_list list;
    bool owns_list; /* the build owns the list's buffers, not the front end */
    uint64_t fragment_count; /* in all chunks */

    /* Scratch. */
    cl_mem *cursors; /* the current node of each fragment; one buffer per chunk */
    cl_mem order; /* of the fragments by leaves; of a list of one chunk, if the plan asks for it */
    cl_mem state; /* svo_build_state: counts that kernels read and write */
    cl_mem partials; /* partial sums of a scan */
    svo_build_state host_state; /* source of the write to state, which may not block */
    uint64_t inner_capacity; /* inner nodes that the tree's arrays can hold */
    bool in_place; /* nodes are made in the tree's own arrays, of the plan's capacities, and never trimmed */
    svo_i_surface surface;
    const svo_i_kept *kept; /* NULL: filter and material weigh the pairs themselves, with the surface */

    svo_tree *tree; /* incomplete until the last stage has run */
} svo_i_build;

SVO_I_SHARED_BEGIN

/* Checks the counts that subdivide left in the state. *fits: whether all inner nodes fit; if so, sets the tree's
   counts. Fails if the list has an invalid fragment or the tree has too many nodes. */
svo_status svo_i_build_take_state(svo_i_build *build, const svo_build_state *state, bool *fits);

SVO_I_SHARED_END

/* Compiles a program for the build's plan, unless the device has it. fresh: see svo_i_program_get. */
svo_status svo_i_build_get_program(svo_i_build *build, const char *function, const svo_i_program *program, bool *fresh);
/* What svo_i_build_get_program made; NULL where it was not called, as for programs that the plan does not need. */
cl_program svo_i_build_program(const svo_i_build *build, const svo_i_program *program);
/* Allocates build->state and build->partials, unless that has been done. */
svo_status svo_i_build_alloc_state(svo_i_build *build);
/* Writes level_begin to build->state, which is allocated on first use. */
svo_status svo_i_build_put_state(svo_i_build *build, const uint32_t level_begin[SVO_LEVELS_MAX]);
/* Allocates the tree's own copy of the state, for the caller's kernels. The first allocation of an enqueued build. */
svo_status svo_i_build_alloc_published(svo_i_build *build);
/* Allocates build->cursors for the list's fragments. */
svo_status svo_i_build_alloc_cursors(svo_i_build *build);
/* Releases the list, whether the build or the front end owns it. */
void svo_i_build_release_list(svo_i_build *build);
/* Fails with the message for a list that has a fragment outside the grid or of no triangle. */
svo_status svo_i_build_fail_damaged(svo_i_build *build);
/* Copies what the plan knows of the tree to the tree's info. */
void svo_i_build_fill_info(const svo_i_build *build);
/* Sets the tree's counts to the plan's capacities. */
void svo_i_build_assume_counts(svo_i_build *build);

#endif
