/* SPDX-License-Identifier: MIT */
/* Device memory of what is looked at, by buffer, beside what plans said of it. */
#ifndef SVOCL_TOOLS_VIEW_MEMORY_H
#define SVOCL_TOOLS_VIEW_MEMORY_H

#include "view/subject.h"

/* Lists the buffers of tree, light and scene in the state. What no plan lists has no planned bytes. Returns the exit
   code. */
int memory_list(const subject *which, view_state *state);

#endif
