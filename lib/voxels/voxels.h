/* SPDX-License-Identifier: MIT */
/* Making lists of voxels. */
#ifndef SVO_LIB_VOXELS_VOXELS_H
#define SVO_LIB_VOXELS_VOXELS_H

#include "core/message.h"
#include "core/voxel_list.h"

/* Makes a list in memory that takes over voxels, which came from svo_i_alloc; they are freed on failure too. source:
   without its memory. spare: the same number of voxels, from svo_i_alloc, freed in any case; NULL: it is
   allocated if the voxels are not sorted. */
svo_status svo_i_voxels_take(const svo_i_memory *memory, const svo_voxels_source *source, svo_voxel *voxels,
                             svo_voxel *spare, svo_voxels **out, svo_message *message);

#endif
