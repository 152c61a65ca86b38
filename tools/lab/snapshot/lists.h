/* SPDX-License-Identifier: MIT */
/* Lists of voxels as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_LISTS_H
#define SVOCL_TOOLS_SNAPSHOT_LISTS_H

#include "builds.h"

/* Lists that are made here: what they hold, their trees, also compact, and their files in the folder, written and
   read. */
svo_status describe_lists(const opened *session, const char *folder, svo_message *message);

#endif
