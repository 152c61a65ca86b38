/* SPDX-License-Identifier: MIT */
/* The mesh that a stored tree was made of. */
#ifndef SVOCL_TOOLS_SUPPORT_TREE_MESH_H
#define SVOCL_TOOLS_SUPPORT_TREE_MESH_H

#include "support/input.h"

/* Reads the mesh of --mesh, and fails unless each triangle of the tree has the mesh's own corners. tree: on the host,
   with leaf lists. Returns the exit code; on failure nothing stays open. */
int tree_mesh_open(program *state, const svo_tree *tree, input *opened);

#endif
