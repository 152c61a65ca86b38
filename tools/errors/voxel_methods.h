/* SPDX-License-Identifier: MIT */
/*
 * One mesh voxelized by every way there is: the usual ones in float32 on the host (tools/stress/float_ways.h), and svocl's
 * front ends; each against the exact set of the voxels that it aims at.
 */
#ifndef SVOCL_VOXEL_WAYS_H
#define SVOCL_VOXEL_WAYS_H

#include "errors/errors.h"
#include "stress/float_methods.h"

#define VOXEL_FRONTENDS_MAX 2u
#define VOXEL_WAYS_MAX      ((size_t)FLOAT_WAY_COUNT + VOXEL_FRONTENDS_MAX)

typedef struct voxel_way_result {
    const char *way; /* "exact integers, cl", "pixel centres", ...: static */
    const char *target; /* coverage of the reference: static */
    double ms; /* median, of making the list of pairs */
    uint64_t voxels; /* of the reference */
    uint64_t missed_voxels, surplus_voxels;
    uint64_t pairs, missed_pairs, surplus_pairs; /* voxel-triangle pairs, in the same words */
} voxel_way_result;

/* What a way is called: the same words in every experiment. */
const char *voxel_way_name(float_way way);

/* mesh and depth as for a plan; edge 0: the fitted grid, else the grid from the origin. results: VOXEL_WAYS_MAX of them.
   Returns the exit code. */
int voxel_ways_measure(error_run *run, const svo_mesh *mesh, unsigned depth, double edge, voxel_way_result *results,
                       size_t *result_count);

/* Missed and surplus voxels over those of the reference. */
double voxel_way_error(const voxel_way_result *result);

#endif
