/* SPDX-License-Identifier: MIT */
/* Whether the tree's grid and snapped vertices are what the reference makes of the same mesh. */
#ifndef SVOCL_TOOLS_SUPPORT_SNAP_CHECK_H
#define SVOCL_TOOLS_SUPPORT_SNAP_CHECK_H

#include <stdbool.h>
#include <stdint.h>

#include "support/options.h"
#include "svocl/mesh.h"
#include "svocl/tree.h"

typedef struct snap_differences {
    unsigned grid_values; /* of origin, edge and scale */
    uint64_t triangles; /* accepted on one side only, or with a vertex snapped otherwise */
} snap_differences;

/* mesh: what the tree was built of, by options given. The tree holds its geometry (SVO_NEED_RAYS). Returns false when
   memory runs out. */
bool snap_check(const svo_mesh *mesh, const options *given, const svo_tree_info *info, const svo_tree_arrays *arrays,
                snap_differences *found);

#endif
