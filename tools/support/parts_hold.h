/* SPDX-License-Identifier: MIT */
/* The lease of a run on its folder of parts. */
#ifndef SVOCL_TOOLS_SUPPORT_PARTS_HOLD_H
#define SVOCL_TOOLS_SUPPORT_PARTS_HOLD_H

#include "support/program.h"

typedef struct parts_holder parts_holder;

/* Takes a lease of the folder and renews it until parts_release. Returns the exit code. */
int parts_hold(program *state, const char *folder, parts_holder **out);
void parts_release(parts_holder **holder);

#endif
