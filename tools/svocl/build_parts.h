/* SPDX-License-Identifier: MIT */
/* build --max-memory. */
#ifndef SVOCL_TOOLS_SVOCL_BUILD_PARTS_H
#define SVOCL_TOOLS_SVOCL_BUILD_PARTS_H

#include "support/program.h"

/* Builds INPUT in parts and writes the .svo file. Returns the exit code. */
int build_parts(program *state);

#endif
