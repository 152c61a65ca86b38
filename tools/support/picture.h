/* SPDX-License-Identifier: MIT */
/* Pictures as PNG files. */
#ifndef SVOCL_TOOLS_SUPPORT_PICTURE_H
#define SVOCL_TOOLS_SUPPORT_PICTURE_H

#include "support/program.h"

/* Writes a picture of --size to the path after -o; one step of the progress bar. Returns the exit code. */
int picture_write(program *state, const uint8_t *rgba);

#endif
