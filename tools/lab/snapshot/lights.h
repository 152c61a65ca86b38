/* SPDX-License-Identifier: MIT */
/* Lights as lines. */
#ifndef SVOCL_TOOLS_SNAPSHOT_LIGHTS_H
#define SVOCL_TOOLS_SNAPSHOT_LIGHTS_H

#include "builds.h"

/* The opacity of each form and kind, and lit probes, of a finished tree on the device of the session. */
void describe_lights(const char *name, const opened *session, svo_tree *tree);

#endif
