/* SPDX-License-Identifier: MIT */
/* Compact trees as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_COMPACT_H
#define SVOCL_TOOLS_SNAPSHOT_COMPACT_H

#include <stddef.h>

#include "builds.h"

/* Every form of a finished tree on the device of the session, as it is and merged: its arrays, the tree that it expands
   to, and what the rays find. */
void describe_compact(const char *name, const opened *session, const svo_tree *tree, const svo_ray *rays,
                      size_t ray_count);

#endif
