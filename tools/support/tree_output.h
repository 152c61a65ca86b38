/* SPDX-License-Identifier: MIT */
/* Trees and compact trees as files. */
#ifndef SVOCL_TOOLS_SUPPORT_TREE_OUTPUT_H
#define SVOCL_TOOLS_SUPPORT_TREE_OUTPUT_H

#include "support/program.h"
#include "svocl/compact.h"
#include "svocl/tree.h"

/* Writes compact, or tree where that is NULL, by --compress; both have host arrays. One step of the progress bar.
   Returns the exit code. */
int tree_output_write(program *state, const svo_tree *tree, const svo_compact *compact, const char *path);

#endif
