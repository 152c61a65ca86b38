/* SPDX-License-Identifier: MIT */
/* The indirect light of a page: what cones gather in the nodes of an upper level, for surfaces of any direction. */
#ifndef SVOCL_TOOLS_WEB_BAKE_H
#define SVOCL_TOOLS_WEB_BAKE_H

#include "support/lighting.h"
#include "web/pack.h"

/* Gathers by --cones, --range and --lambda; one step of the progress bar. Each node of the deepest level of at most
   65,536 nodes has a point for each of the six directions that its leaves face; nodes above it have the means of their
   children. Returns the exit code. */
int web_bake(program *state, const web_tree *tree, const lighting *lit, const session *opened, web_light *out);

#endif
