/* SPDX-License-Identifier: MIT */
/* Device memory of what is looked at, by buffer. */
#ifndef SVOCL_TOOLS_VIEW_MEMORY_H
#define SVOCL_TOOLS_VIEW_MEMORY_H

#include "view/subject.h"

/* Lists the buffers in the state, beside what the plans said. */
void memory_list(const subject *which, view_state *state);

#endif
