/* SPDX-License-Identifier: MIT */
/* The surface of a tree's voxels as a mesh: two triangles for each face that is not between two voxels. */
#ifndef SVOCL_TOOLS_SUPPORT_VOXEL_FACES_H
#define SVOCL_TOOLS_SUPPORT_VOXEL_FACES_H

#include "support/placed_mesh.h"
#include "svocl/tree.h"

/* tree: with host arrays. Vertices have the colors and normals of their voxels, as far as the tree has them. name: of
   the tree, for messages. Returns the exit code; on failure nothing is left to free. */
int voxel_faces_make(program *state, const char *name, const svo_tree *tree, placed_mesh *out);

#endif
