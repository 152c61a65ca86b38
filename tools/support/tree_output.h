/* SPDX-License-Identifier: MIT */
/* Trees as .svo files. */
#ifndef SVOCL_TOOLS_SUPPORT_TREE_OUTPUT_H
#define SVOCL_TOOLS_SUPPORT_TREE_OUTPUT_H

#include "support/program.h"
#include "svocl/tree.h"

/* Writes a tree, which has host arrays, by --compress; one step of the progress bar. Returns the exit code. */
int tree_output_write(program *state, const svo_tree *tree, const char *path);

#endif
