/* SPDX-License-Identifier: MIT */
/* Compares the grid and the snapped vertices of a tree with those that the reference computes from the same mesh. */
#ifndef SVOCL_TOOLS_SUPPORT_SNAP_CHECK_H
#define SVOCL_TOOLS_SUPPORT_SNAP_CHECK_H

#include <stdbool.h>
#include <stdint.h>

#include "support/options.h"
#include "svocl/mesh.h"
#include "svocl/tree.h"

typedef struct snap_differences {
    unsigned grid_values; /* of origin, edge and scale */
    uint64_t triangles; /* accepted by only one of the two, or with a different snapped vertex */
} snap_differences;

/* mesh: the input of the tree, built by the options given. The tree has its geometry (SVO_NEED_RAYS). Returns false
   if memory runs out. */
bool snap_check(const svo_mesh *mesh, const options *given, const svo_tree_info *info, const svo_tree_arrays *arrays,
                snap_differences *found);

#endif
