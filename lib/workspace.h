/* SPDX-License-Identifier: MIT */
/* A tree and the workspace whose builds go into it. */
#ifndef SVO_LIB_WORKSPACE_H
#define SVO_LIB_WORKSPACE_H

#include "svocl/build.h"
#include "tree.h"

/* Waits for the tree's build in flight, if there is one, and lets no other go into it. */
void svo_i_tree_leave_workspace(svo_tree *tree);

#endif
