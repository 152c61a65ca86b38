/* SPDX-License-Identifier: MIT */
/* Plans, builds and calls as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_DESCRIBE_H
#define SVOCL_TOOLS_SNAPSHOT_DESCRIBE_H

#include "builds.h"

/* Everything a plan reports before a build. */
void describe_plan(const char *name, const svo_plan *plan);
/* The same of a workspace that does not exist yet. */
void describe_room(const char *name, svo_plan *plan, svo_frontend *frontend);

/* The tree, its file in the folder, the report, the plan's buffers afterwards. */
void describe_build(const char *name, const opened *session, build *finished, const char *folder);
/* The files alone: stored, compressed, and read back. */
void describe_files(const char *name, svo_tree *tree, const char *folder);

/* The calls of OpenCL in each part of a build. */
void describe_calls(const char *name, const build *finished);

#endif
