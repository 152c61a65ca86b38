/* SPDX-License-Identifier: MIT */
/* Pictures, rays and nearest points as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_QUERIES_H
#define SVOCL_TOOLS_SNAPSHOT_QUERIES_H

#include "builds.h"

/* Of a finished, downloaded tree on the device of the session. A query that the tree does not support prints its
   status. */
void describe_queries(const char *name, const opened *session, svo_tree *tree);

#endif
