/* SPDX-License-Identifier: MIT */
/* shared/layout.h for signed distance fields. */
#ifndef SVO_KERNELS_SHARED_SDF_LAYOUT_H
#define SVO_KERNELS_SHARED_SDF_LAYOUT_H

#include "shared/layout.h"

/* A brick is the cell whose candidates the last launch takes: at most 2^this voxels wide. */
#define SVO_SDF_BRICK_LOG2_MAX 2

/* Arguments of the kernels of signed distance fields. 92 bytes. */
SVO_RECORD(svo_sdf_params)
{
    SVO_U32 origin[6]; /* 0: of the grid, three doubles */
    SVO_U32 voxel[2]; /* 24: width of a voxel, a double */
    SVO_U32 unit[2]; /* 32: width of a grid unit, a double; of rounded positions */
    SVO_U32 raise[2]; /* 40: a double, a power of two: times it, a voxel is 1 or more and less than 2 wide */
    SVO_U32 positions; /* 48: what they are, SVO_SOLID_* of shared/solid_layout.h */
    SVO_U32 depth; /* 52 */
    SVO_U32 level; /* 56: of the cells that a launch divides */
    SVO_U32 count; /* 60: of these cells, or of bricks */
    SVO_U32 first; /* 64: the first of these cells */
    SVO_U32 brick_log2; /* 68: width of a brick in voxels, 1 or 2 */
    SVO_U32 leaf_begin; /* 72: first leaf of the tree */
    SVO_U32 is_signed; /* 76: not 0: voxels inside have negative distances */
    SVO_U32 is_dense; /* 80: not 0: distances go to the places of their voxels */
    SVO_F32 reach; /* 84: voxels; what is farther from a voxel is of no interest. Infinite where all is */
    SVO_F32 band; /* 88: world units: voxels with less are in the band. Infinite for all */
};

#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_sdf_params, 92);
#endif

#endif
