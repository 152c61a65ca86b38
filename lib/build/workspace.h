/* SPDX-License-Identifier: MIT */
/* A plan's memory for builds that do not wait, and the trees that they go into. */
#ifndef SVO_LIB_BUILD_WORKSPACE_H
#define SVO_LIB_BUILD_WORKSPACE_H

#include "build/build.h"

typedef struct svo_i_pending svo_i_pending; /* a build that was enqueued: enqueue.c */

struct svo_workspace {
    svo_device *device;
    svo_plan *plan;
    svo_frontend *frontend;
    svo_i_layout layout; /* one chunk, or none for a plan without triangles */
    svo_i_kept_tiles kept;
    svo_i_allocations allocations;
    svo_workspace_info info;
    cl_mem scratch; /* owned, or the caller's retained */
    cl_program program; /* the device's */
    cl_event last; /* of the newest build; NULL at first */
    svo_i_pending *given_up; /* builds that failed half-way, with commands that have not ended */
    svo_tree *trees; /* made from it, and not trimmed or destroyed */
};

/* enqueue.c: releases builds that were given up, those that have ended or, after waiting for the last one, all. */
void svo_i_workspace_release_given_up(svo_workspace *workspace, bool all);
/* enqueue.c: waits for the tree's build in flight, if there is one, and lets no other go into it. */
void svo_i_tree_leave_workspace(svo_tree *tree);

#endif
