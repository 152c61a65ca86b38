/* SPDX-License-Identifier: MIT */
/* The distances of a field's voxels. */
#ifndef SVO_LIB_SDF_DISTANCES_H
#define SVO_LIB_SDF_DISTANCES_H

#include "sdf/handle.h"

/* Which voxels are inside; all NULL: no distance is negative. Scratch of the work. */
typedef struct svo_i_sdf_signs {
    cl_mem cells; /* a byte per inner node: bit o for an empty child in octant o that is inside */
    cl_mem leaves; /* a byte per leaf: not 0 if its center is inside */
} svo_i_sdf_signs;

/* Makes the field's buffers and sets info.voxel_count. batch_bytes: what candidates and distances of a batch of cells
   may take. sdf->info: complete but for counts and bytes. */
svo_status svo_i_sdf_find(svo_i_device_work *work, const svo_tree *tree, const svo_i_sdf_signs *signs,
                          uint64_t batch_bytes, svo_sdf *sdf);

#endif
