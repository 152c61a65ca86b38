/* SPDX-License-Identifier: MIT */
/* svocl render FILE.svo --paged BYTES. */
#ifndef SVOCL_TOOLS_SVOCL_RENDER_PAGED_H
#define SVOCL_TOOLS_SVOCL_RENDER_PAGED_H

#include "support/program.h"

/* Draws the file that INPUT names with as many bytes of it on the device as --paged allows. Returns the exit code. */
int render_paged(program *state);

#endif
