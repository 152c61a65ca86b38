/* SPDX-License-Identifier: MIT */
/* Traces rays through a tree's voxels without its triangles: a kernel around svo_trace_voxel. */
#ifndef SVOCL_TOOLS_ERRORS_VOXEL_CAST_H
#define SVOCL_TOOLS_ERRORS_VOXEL_CAST_H

#include "support/session.h"

typedef struct voxel_cast voxel_cast;

/* Builds the mesh's occupancy at that depth, compiles the kernel and uploads the rays. NULL on failure: the device's
   message says why, or memory ran out. */
voxel_cast *voxel_cast_create(const session *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *grid,
                              const svo_ray *rays, size_t ray_count);
void voxel_cast_destroy(voxel_cast **made);

/* Returns the milliseconds, below 0 on failure. */
double voxel_cast_run(voxel_cast *made);
/* ts of the last run; infinity: no hit. */
bool voxel_cast_read(voxel_cast *made, float *ts);

#endif
