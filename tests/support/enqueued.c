/* SPDX-License-Identifier: MIT */
/* Plans, workspaces and their trees, for tests of enqueued builds. A failure fails the test with its words. */
#include "enqueued.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

svo_plan *make_plan(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_plan_options options)
{
    svo_plan *plan = NULL;
    options.struct_size = sizeof options;
    succeed(opened, svo_plan_create(opened->device, mesh, depth, &options, &plan));
    return plan;
}

svo_workspace *make_workspace(const fixture *opened, svo_plan *plan)
{
    svo_workspace *workspace = NULL;
    succeed(opened, svo_workspace_create(plan, opened->frontend, opened->queue, NULL, &workspace));
    return workspace;
}

svo_tree *make_tree(const fixture *opened, svo_workspace *workspace)
{
    svo_tree *tree = NULL;
    succeed(opened, svo_workspace_make_tree(workspace, &tree));
    return tree;
}
