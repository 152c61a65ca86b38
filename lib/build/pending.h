/* SPDX-License-Identifier: MIT */
/* Builds that were enqueued and are not finished, and the workspace that they run in. */
#ifndef SVO_LIB_BUILD_PENDING_H
#define SVO_LIB_BUILD_PENDING_H

#include "plan/tiles.h"
#include "stages/build_state.h"

typedef struct svo_i_pending svo_i_pending;

/* A build that was enqueued. */
struct svo_i_pending {
    svo_i_build build; /* without its events */
    bool owns_list; /* the front end has to release the list, else it is scratch */
    svo_build_report report;
    cl_event done;
    svo_build_state state; /* read back when it is done */
    cl_uint counter[2];
    svo_i_pending *next; /* given up likewise */
};

struct svo_workspace {
    svo_device *device;
    svo_plan *plan;
    svo_frontend *frontend;
    svo_i_chunking chunking; /* one chunk, or none for a plan without triangles */
    svo_i_tile_cache tile_cache;
    svo_i_allocations allocations;
    svo_workspace_info info;
    cl_mem scratch; /* owned, or the caller's retained */
    cl_program programs[SVO_I_PROGRAM_KINDS]; /* the device's */
    cl_event last; /* of the newest build; NULL at first */
    svo_i_pending *given_up; /* builds that failed half-way, with commands that have not ended */
    svo_tree *trees; /* made from it, and not trimmed or destroyed */
};

/* Releases a build that has ended. */
void svo_i_pending_release(svo_i_pending *pending);
/* Releases a build that failed half-way, at once or when its commands have ended. */
void svo_i_pending_give_up(svo_workspace *workspace, svo_i_pending *pending);
/* Releases builds that were given up: those that have ended or, after waiting for the last one, all. */
void svo_i_pending_release_given_up(svo_workspace *workspace, bool all);
/* Waits for the tree's pending build, if there is one, and lets no other go into the tree. */
void svo_i_pending_leave_workspace(svo_tree *tree);

#endif
