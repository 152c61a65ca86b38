/* SPDX-License-Identifier: MIT */
/* The fields of a list of voxels. */
#ifndef SVO_LIB_VOXELS_VOXELS_H
#define SVO_LIB_VOXELS_VOXELS_H

#include "core/message.h"
#include "svocl/voxels.h"

struct svo_voxels {
    svo_voxels_info info;
    svo_voxel *voxels; /* each place once, in Morton order; owned */
    svo_voxel_property *properties; /* sorted; owned */
    char *texts; /* of all properties; owned */
};

/* Makes a list that takes over voxels, which came from malloc; they are freed on failure too. spare: the same number of
   voxels, from malloc, freed in any case; NULL: the voxels are sorted and in different places. */
svo_status svo_i_voxels_take(const svo_voxels_source *source, svo_voxel *voxels, svo_voxel *spare, svo_voxels **out,
                             svo_message *message);

#endif
