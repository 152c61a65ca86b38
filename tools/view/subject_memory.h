/* SPDX-License-Identifier: MIT */
/* The bytes of what is looked at. */
#ifndef SVOCL_TOOLS_VIEW_SUBJECT_MEMORY_H
#define SVOCL_TOOLS_VIEW_SUBJECT_MEMORY_H

#include "view/subject.h"

/* Lists the buffers of tree, light and scene in the state, beside what plans said of them. What no plan lists has no
   planned bytes. Returns the exit code. */
int subject_list_memory(const subject *which, view_state *state);

#endif
