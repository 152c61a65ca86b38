/* SPDX-License-Identifier: MIT */
/* Probes as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_PROBES_H
#define SVOCL_TOOLS_SNAPSHOT_PROBES_H

#include "builds.h"

/* Those of a finished tree: without light where they find places, and in their places with the light of the tree. */
void describe_probes(const char *name, const opened *session, svo_tree *tree, svo_light *light);

#endif
