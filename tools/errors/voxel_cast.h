/* SPDX-License-Identifier: MIT */
/* Rays through the voxels of a tree alone, without its triangles: a kernel of the program's own around
   svo_trace_voxel. */
#ifndef SVOCL_TOOLS_ERRORS_VOXEL_CAST_H
#define SVOCL_TOOLS_ERRORS_VOXEL_CAST_H

#include "support/session.h"

typedef struct voxel_cast voxel_cast;

/* Builds the occupancy of the mesh at that depth, compiles the kernel, and uploads the rays. NULL on failure: the
   device's message says why, or memory is out. */
voxel_cast *voxel_cast_create(const session *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *grid,
                              const svo_ray *rays, size_t ray_count);
void voxel_cast_destroy(voxel_cast **made);

/* Returns the milliseconds it took, below 0 on failure. */
double voxel_cast_run(voxel_cast *made);
/* ts of the last run, infinity where nothing was met. */
bool voxel_cast_read(voxel_cast *made, float *ts);

#endif
