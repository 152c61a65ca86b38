/* SPDX-License-Identifier: MIT */
/* Compares a rasterizer with a walk over all voxels, on needles, slivers and sub-pixel triangles, in small, large and
   several viewports. */
#ifndef SVO_GLINTEROP_RASTER_SELFTEST_H
#define SVO_GLINTEROP_RASTER_SELFTEST_H

#include "raster/raster.h"

/* Writes "" to reason when the rasterizer creates exactly the fragments of the test mesh, else what differs. Makes the
   context current. */
void svo_i_raster_selftest(svo_device *device, svo_gl_context *context, svo_i_raster *raster, char *reason,
                           size_t reason_bytes);

/* The fragments of a plan's triangles, ordered by triangle and then by voxel, found by testing every voxel of each
   triangle's bounding box. *out: words as in the list, which the caller frees. For small scenes on the default grid. */
svo_status svo_i_walk(const svo_plan *plan, uint32_t **out, uint64_t *fragment_count);

#endif
