/* SPDX-License-Identifier: MIT */
/* The fields of a list of voxels, which lib/voxels makes and lib/io writes to files. */
#ifndef SVO_LIB_CORE_VOXEL_LIST_H
#define SVO_LIB_CORE_VOXEL_LIST_H

#include "core/memory.h"
#include "svocl/voxels.h"

struct svo_voxels {
    svo_i_memory memory; /* of the list and its arrays, and of what is made from it */
    svo_voxels_info info;
    svo_voxel *voxels; /* each place once, in Morton order; owned */
    svo_voxel_property *properties; /* sorted; owned */
    char *texts; /* of all properties; owned */
    svo_axes axes; /* of files that it is written to */
};

#endif
