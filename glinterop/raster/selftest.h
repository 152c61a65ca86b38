/* SPDX-License-Identifier: MIT */
/* Whether a way of rasterizing misses voxels: needles, slivers and sub-pixel triangles against a walk over all
   voxels. */
#ifndef SVO_GLINTEROP_RASTER_SELFTEST_H
#define SVO_GLINTEROP_RASTER_SELFTEST_H

#include "raster/raster.h"

/* "" in reason if every fragment of the test mesh came out, else what went wrong. Makes the context current by
   itself. */
void svo_i_raster_selftest(svo_device *device, svo_gl_context *context, svo_i_raster *raster, char *reason,
                           size_t reason_bytes);

/* The fragments of a plan's kept triangles, in order of triangle, then of voxels, by testing every voxel of each
   triangle's bounding box. Words as in the list; *out by malloc. For small scenes on the default grid. */
svo_status svo_i_walk(const svo_plan *plan, uint32_t **out, uint64_t *fragment_count);

#endif
