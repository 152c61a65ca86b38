/* SPDX-License-Identifier: MIT */
/*
 * Voxelizes one mesh by every method: svocl's front ends, what they did until 0.1 (measure/nearest_lists.h), and common
 * float32 methods on the host (measure/float_methods.h). Each is compared with the exact set of voxels for its coverage
 * rule.
 */
#ifndef SVOCL_TOOLS_ERRORS_VOXEL_METHODS_H
#define SVOCL_TOOLS_ERRORS_VOXEL_METHODS_H

#include "errors/errors.h"
#include "measure/float_methods.h"

#define VOXEL_FRONTENDS_MAX 2u
#define VOXEL_METHODS_MAX   ((size_t)FLOAT_METHOD_COUNT + VOXEL_FRONTENDS_MAX + 1)

typedef struct voxel_method_result {
    const char *method; /* "exact integers, cl", "plain rasterization", ...: static */
    const char *coverage; /* of the reference: static */
    double ms; /* median, of making the list of pairs; not finite where it is not measured */
    uint64_t voxels; /* of the reference */
    uint64_t missed_voxels, surplus_voxels;
    uint64_t pairs, missed_pairs, surplus_pairs; /* of (voxel, triangle) pairs */
} voxel_method_result;

/* The method's name in tables. */
const char *voxel_method_name(float_method method);

/* mesh, depth: as for a plan. edge: of a grid at the origin; 0: the fitted grid. results: VOXEL_METHODS_MAX of them.
   Returns the exit code. */
int voxel_methods_measure(error_run *run, const svo_mesh *mesh, unsigned depth, double edge,
                          voxel_method_result *results, size_t *result_count);

/* Missed and surplus voxels, relative to the number in the reference. */
double voxel_method_error(const voxel_method_result *result);

#endif
