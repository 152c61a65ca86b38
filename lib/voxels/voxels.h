/* SPDX-License-Identifier: MIT */
/* Lists of voxels for rooms that make them. */
#ifndef SVO_LIB_VOXELS_VOXELS_H
#define SVO_LIB_VOXELS_VOXELS_H

#include "core/voxel_list.h"

/*
 * Makes a list of arrays of its own. Those in Morton order are not sorted, and then need no second ones.
 *
 * source: checked by the caller; its voxels and normals are not read. voxels, normals: source->voxel_count, by
 * svo_i_alloc; the list's from now on, on failure too. normals NULL: there are none.
 */
svo_status svo_i_voxels_take(const svo_i_memory *memory, const svo_voxels_source *source, svo_voxel *voxels,
                             int16_t *normals, svo_voxels **out, svo_message *message);

#endif
