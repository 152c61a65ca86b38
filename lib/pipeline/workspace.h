/* SPDX-License-Identifier: MIT */
/* Enqueued builds that are not finished, and the workspace that they run in. */
#ifndef SVO_LIB_PIPELINE_WORKSPACE_H
#define SVO_LIB_PIPELINE_WORKSPACE_H

#include "plan/chunking.h"
#include "plan/update.h"
#include "stages/build_state.h"

typedef struct svo_i_pending svo_i_pending;

struct svo_i_pending {
    svo_i_build build;
    bool releases_list; /* the front end releases the list; else the list is scratch */
    svo_build_report report;
    cl_event done;
    svo_build_state state; /* read back by the last command */
    svo_i_mesh_totals totals; /* of an updatable plan's mesh; read back too */
    cl_uint counters[SVO_COUNTER_WORDS]; /* of the list, where pairs are dropped; read back too */
    svo_i_pending *next; /* in workspace->given_up */
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
    svo_i_made_program programs[SVO_I_STAGE_PROGRAMS_MAX]; /* of its builds */
    svo_i_in_flight builds; /* the last command of each */
    svo_i_pending *given_up; /* builds that failed after some of their commands were enqueued */
    svo_tree *trees; /* trees of the workspace that were neither trimmed nor destroyed */
};

/* Releases a build whose commands have ended. */
void svo_i_pending_release(svo_i_pending *pending);
/* Takes a build that failed. Releases it as soon as its commands have ended. */
void svo_i_pending_give_up(svo_workspace *workspace, svo_i_pending *pending);
/* Releases failed builds: those whose commands have ended, or all, after the caller has waited for the workspace's
   builds. */
void svo_i_pending_release_given_up(svo_workspace *workspace, bool all);
/* Waits for the tree's pending build, if there is one, and removes the tree from its workspace. */
void svo_i_pending_leave_workspace(svo_tree *tree);

#endif
