/* SPDX-License-Identifier: MIT */
/* Lists of voxels for rooms that make them. */
#ifndef SVO_LIB_VOXELS_VOXELS_H
#define SVO_LIB_VOXELS_VOXELS_H

#include "core/device.h"
#include "core/voxel_list.h"
#include "svocl/plan.h"

/*
 * Makes a list of an array of its own. One in Morton order is not sorted, and then needs no second array.
 *
 * source: checked by the caller; its voxels are not read. voxels: source->voxel_count, by svo_i_alloc; the list's from
 * now on, on failure too.
 */
svo_status svo_i_voxels_take(const svo_i_memory *memory, const svo_voxels_source *source, svo_voxel *voxels,
                             svo_voxels **out, svo_message *message);

/* Checks what of a plan's options concerns voxels, and sets what follows from them. What else a plan checks is left.
   Messages begin with svo_voxels_plan. */
svo_status svo_i_voxels_options(svo_device *device, const svo_voxels_info *info, unsigned *depth,
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
