/* SPDX-License-Identifier: MIT */
/* Scenes of instances as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_INSTANCES_H
#define SVOCL_TOOLS_SNAPSHOT_INSTANCES_H

#include "builds.h"

/* A scene of instances of finished trees on the device of the session, which hold colors, normals and leaf lists: its
   sizes, hits and picture; the same after instances have moved, and after the hierarchy is made anew. */
void describe_instances(const char *name, const opened *session, svo_tree *const *trees, uint32_t tree_count);

#endif
