/* SPDX-License-Identifier: MIT */
/* Rays through a scene that moves: the BVH of its objects beside one of the whole mesh. */
#ifndef SVOCL_TOOLS_BENCH_MOVING_RAYS_H
#define SVOCL_TOOLS_BENCH_MOVING_RAYS_H

#include "measure/suite.h"

/* Adds the table. */
void moving_rays_begin(suite *all);
/* Measures a scene of which a share of the area moves, and adds its row. */
int moving_rays_run(suite *all, const input *source, unsigned depth, double share);

#endif
