/* SPDX-License-Identifier: MIT */
/*
 * Lists of voxels, which lib/voxels makes and lib/io writes to files, and their order: of Morton codes for trees, of
 * rows for files.
 */
#ifndef SVO_LIB_CORE_VOXEL_LIST_H
#define SVO_LIB_CORE_VOXEL_LIST_H

#include "core/memory.h"
#include "core/message.h"
#include "svocl/voxels.h"

struct svo_voxels {
    svo_i_memory memory; /* of the list and its arrays, and of what is made from it */
    svo_voxels_info info;
    svo_voxel *voxels; /* each place once, in Morton order; owned */
    svo_voxel_property *properties; /* sorted; owned */
    char *texts; /* of all properties; owned */
    svo_axes axes; /* of files that it is written to */
    uint64_t *counts; /* of points, for each voxel; owned. NULL: it is not of points */
    int16_t *normals; /* x, y, z of each voxel; owned. NULL: they have none */
};

/* By what voxels are sorted. */
typedef enum svo_i_voxel_order {
    SVO_I_VOXEL_MORTON = 0, /* by Morton code */
    SVO_I_VOXEL_ROWS, /* by x, then z, then y, as .binvox files have them */
    SVO_I_VOXEL_SLICES /* by y, then z, then x, as .svx files have them */
} svo_i_voxel_order;

SVO_I_SHARED_BEGIN

/*
 * Sorts voxels; those with the same place stay in their order.
 *
 * voxels, spare: count elements each; the result is in voxels. low: the least coordinates. bits: coordinates less low
 * are below 2^bits; at most 21.
 */
void svo_i_voxel_sort(svo_voxel *voxels, svo_voxel *spare, size_t count, const int32_t low[3], uint32_t bits,
                      svo_i_voxel_order order);

/* The least number of bits that holds coordinates from low to below high, less low; 0 for a single voxel. */
uint32_t svo_i_voxel_bits(const int32_t low[3], const int32_t high[3]);

/* The Morton code of a voxel's place. */
uint64_t svo_i_voxel_code(const svo_voxel *voxel, const int32_t low[3]);

/* The greatest multiple of the width that, as a double, is at most value; NaN where there is none. */
double svo_i_voxel_plane(double value, double width);

SVO_I_SHARED_END

#endif
