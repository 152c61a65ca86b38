/* SPDX-License-Identifier: MIT */
/* Scenes that move as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_MOVING_H
#define SVOCL_TOOLS_SNAPSHOT_MOVING_H

#include "builds.h"

/* The mesh as the static mesh, and smaller copies of it that come, move, hide and go: the tree after each step. The
   request has a grid of its own. */
void describe_moving(const char *name, const opened *session, const svo_mesh *mesh, const request *wanted);

#endif
