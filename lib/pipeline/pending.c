/* SPDX-License-Identifier: MIT */
/* The end of enqueued builds: finished, failed, or with their tree destroyed. */
#include "pipeline/pending.h"

void svo_i_pending_release(svo_i_pending *pending)
{
    if (pending->done != NULL) {
        clReleaseEvent(pending->done);
    }
    svo_i_stage_collect(&pending->build.commands);
    if (pending->releases_list) {
        svo_frontend *frontend = pending->build.frontend;
        frontend->release(frontend->self, &pending->build.list);
    }
    svo_i_free(pending->build.list.chunks);
    svo_i_free(pending->build.cursors);
    svo_i_free(pending);
}

static bool is_done(cl_event event)
{
    cl_int status = CL_QUEUED;
    clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, NULL);
    return status <= CL_COMPLETE;
}

void svo_i_pending_release_given_up(svo_workspace *workspace, bool all)
{
    for (svo_i_pending **at = &workspace->given_up; *at != NULL;) {
        svo_i_pending *pending = *at;
        if (all || is_done(pending->done)) {
            *at = pending->next;
            svo_i_pending_release(pending);
        } else {
            at = &pending->next;
        }
    }
}

/* The commands of a failed build may still wait for the caller's events, and write to the pending build. */
void svo_i_pending_give_up(svo_workspace *workspace, svo_i_pending *pending)
{
    if (pending->done == NULL || is_done(pending->done)) {
        svo_i_pending_release(pending);
    } else {
        pending->next = workspace->given_up;
        workspace->given_up = pending;
    }
}

/* Removes the tree from its workspace's list. */
static void leave_workspace(svo_tree *tree)
{
    svo_tree **at = tree->workspace != NULL ? &tree->workspace->trees : NULL;
    while (at != NULL && *at != tree) {
        at = &(*at)->next;
    }
    if (at != NULL) {
        *at = tree->next;
    }
    tree->workspace = NULL;
    tree->next = NULL;
}

void svo_i_pending_end_workspace(svo_workspace *workspace)
{
    for (svo_tree *tree = workspace->trees; tree != NULL; tree = tree->next) {
        tree->workspace = NULL;
        if (tree->pending != NULL) {
            svo_i_pending_release(tree->pending);
            tree->pending = NULL;
            tree->content = SVO_I_TREE_ABANDONED;
        }
    }
}

void svo_i_pending_leave_workspace(svo_tree *tree)
{
    if (tree->pending != NULL) {
        (void)svo_i_event_settle(tree->pending->done);
        svo_i_pending_release(tree->pending);
        tree->pending = NULL;
    }
    leave_workspace(tree);
}
