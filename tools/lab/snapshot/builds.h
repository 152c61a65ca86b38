/* SPDX-License-Identifier: MIT */
/* Opens devices and builds trees by the table of methods. */
#ifndef SVOCL_TOOLS_SNAPSHOT_BUILDS_H
#define SVOCL_TOOLS_SNAPSHOT_BUILDS_H

#include "cases.h"
#include "count_calls.h"
#include "svocl/gl.h"

typedef struct opened {
    svo_device *device;
    cl_command_queue queue;
    svo_frontend *cl;
    svo_gl_context *context; /* NULL: no OpenGL */
    svo_gl *host, *copy; /* NULL: that share does not work */
} opened;

/* On failure the message says why, and nothing stays open. A machine without OpenGL is no failure: its cases report
   that. */
svo_status opened_create(opened *out, svo_message *message);
void opened_release(opened *released);

/* The parts of a build between which calls are counted. */
typedef enum build_part {
    PART_PLAN = 0, /* svo_plan_create, svo_plan_count */
    PART_WORKSPACE, /* svo_workspace_create, svo_workspace_make_tree */
    PART_ENQUEUE, /* svo_build_enqueue */
    PART_BUILD, /* svo_build, svo_gl_build, svo_tree_finish */
    PART_COUNT
} build_part;

typedef struct build {
    svo_plan *plan;
    svo_workspace *workspace;
    svo_tree *tree;
    cl_mem scratch;
    svo_build_report report;
    svo_workspace_info room; /* of the workspace */
    call_counts counts[PART_COUNT];
} build;

/* Release *out by build_release, also after a failure; its report tells which capacity was exceeded. */
svo_status build_run(const opened *session, const svo_mesh *mesh, const request *wanted, const method *by, build *out);
void build_release(build *finished);

#endif
