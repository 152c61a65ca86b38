/* SPDX-License-Identifier: MIT */
/* The voxel nearest to a point, by a descent through a tree on the host that takes the nearest nodes first. */
#ifndef SVOCL_TOOLS_TUNE_NEAREST_LEAF_H
#define SVOCL_TOOLS_TUNE_NEAREST_LEAF_H

#include "svocl/svocl.h"

/* The distance, in voxels, from a point to the center of the nearest leaf; infinity without leaves. arrays: of the
   downloaded tree. */
double nearest_leaf(const svo_tree_info *info, const svo_tree_arrays *arrays, const double point[3]);

#endif
