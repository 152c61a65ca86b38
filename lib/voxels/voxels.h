/* SPDX-License-Identifier: MIT */
/* Lists of voxels for rooms that make them. */
#ifndef SVO_LIB_VOXELS_VOXELS_H
#define SVO_LIB_VOXELS_VOXELS_H

#include "core/voxel_list.h"

/*
 * Makes a list of an array of its own. One in Morton order is not sorted, and then needs no second array.
 *
 * source: checked by the caller; its voxels are not read. voxels: source->voxel_count, by svo_i_alloc; the list's from
 * now on, on failure too.
 */
svo_status svo_i_voxels_take(const svo_i_memory *memory, const svo_voxels_source *source, svo_voxel *voxels,
                             svo_voxels **out, svo_message *message);

#endif
