/* SPDX-License-Identifier: MIT */
/* The lists that svocl made until 0.1: exact for vertices rounded to the nearest of 2^20 steps of the grid. Beside the
   exact lists of the mesh as given, they show what that rounding cost. */
#ifndef SVOCL_TOOLS_MEASURE_NEAREST_LISTS_H
#define SVOCL_TOOLS_MEASURE_NEAREST_LISTS_H

#include <stdbool.h>

#include "reference/oracle.h"
#include "svocl/mesh.h"
#include "svocl/tree.h"

/* The pairs of a mesh on a tree's grid, sorted. Release them by oracle_pairs_free. Returns false if memory runs out. */
bool nearest_list_pairs(const svo_mesh *mesh, const svo_tree_info *info, oracle_coverage coverage, oracle_pairs *out);

#endif
