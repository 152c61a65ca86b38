/* SPDX-License-Identifier: MIT */
/*
 * One mesh voxelized by every way there is: the usual ones in float32 on the host (tools/stress/float_methods.h), and
 * svocl's front ends; each against the exact set of the voxels that it aims at.
 */
#ifndef SVOCL_TOOLS_ERRORS_VOXEL_METHODS_H
#define SVOCL_TOOLS_ERRORS_VOXEL_METHODS_H

#include "errors/errors.h"
#include "stress/float_methods.h"

#define VOXEL_FRONTENDS_MAX 2u
#define VOXEL_METHODS_MAX   ((size_t)FLOAT_METHOD_COUNT + VOXEL_FRONTENDS_MAX)

typedef struct voxel_method_result {
    const char *method; /* "exact integers, cl", "pixel centers", ...: static */
    const char *target; /* coverage of the reference: static */
    double ms; /* median, of making the list of pairs */
    uint64_t voxels; /* of the reference */
    uint64_t missed_voxels, surplus_voxels;
    uint64_t pairs, missed_pairs, surplus_pairs; /* voxel-triangle pairs, in the same words */
} voxel_method_result;

/* What a way is called: the same words in every experiment. */
const char *voxel_method_name(float_method method);

/* mesh and depth as for a plan; edge 0: the fitted grid, else the grid from the origin. results: VOXEL_METHODS_MAX of
   them.
   Returns the exit code. */
int voxel_methods_measure(error_run *run, const svo_mesh *mesh, unsigned depth, double edge,
                          voxel_method_result *results, size_t *result_count);

/* Missed and surplus voxels over those of the reference. */
double voxel_method_error(const voxel_method_result *result);

#endif
