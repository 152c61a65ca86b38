/* SPDX-License-Identifier: MIT */
/* Paged trees as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_PAGED_H
#define SVOCL_TOOLS_SNAPSHOT_PAGED_H

#include "builds.h"

/* The tree's file, which it makes and removes in the folder, drawn with room for all of it and for less: the last
   picture of each stop of the camera, and what was missed and read. */
void describe_paged(const char *name, const opened *session, svo_tree *tree, const char *folder);

#endif
