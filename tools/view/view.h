/* SPDX-License-Identifier: MIT */
/* The viewer: a window, and frame after frame until it closes. */
#ifndef SVOCL_TOOLS_VIEW_VIEW_H
#define SVOCL_TOOLS_VIEW_VIEW_H

#include "support/program.h"

/* Shows INPUT by the options until the window closes or the script ends. Returns the exit code. */
int view_run(program *running);

#endif
