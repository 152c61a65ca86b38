/* SPDX-License-Identifier: MIT */
/* What trees of voxels have in common, whichever way they are made. */
#ifndef SVO_LIB_VOXELS_BUILD_H
#define SVO_LIB_VOXELS_BUILD_H

#include "core/device.h"
#include "svocl/voxels.h"

/* Checks what of a plan's options concerns voxels, and sets what follows from them. What else a plan checks is left.
   Messages begin with svo_voxels_plan. */
svo_status svo_i_voxels_options(svo_device *device, const svo_voxels_info *info, bool has_normals, unsigned *depth,
                                svo_plan_options *options);

/* The grid of a tree of voxels, as svo_tree_info has it. */
typedef struct svo_i_voxel_grid {
    double origin[3];
    double edge;
    double scale;
    uint32_t snap_bits;
} svo_i_voxel_grid;

svo_status svo_i_voxels_grid(svo_device *device, const svo_voxels_info *list, unsigned depth, svo_i_voxel_grid *out);

#endif
