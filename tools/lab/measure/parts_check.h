/* SPDX-License-Identifier: MIT */
/* Compares regions of a folder of parts with the exact reference of tools/lab/reference, for verify. */
#ifndef SVOCL_TOOLS_MEASURE_PARTS_CHECK_H
#define SVOCL_TOOLS_MEASURE_PARTS_CHECK_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/mesh.h"
#include "svocl/parts.h"
#include "svocl/parts_tree.h"

/* Voxels that differ, which must be 0, and how much was compared. */
typedef struct parts_differences {
    uint64_t regions;
    uint64_t expected_voxels, built_voxels, missed_voxels, surplus_voxels;
} parts_differences;

/* Compares the voxels of so many regions of up to 2^7 voxels along an axis. Every other one is that of a vertex of the
 * mesh, so that what the parts lack is found, too; the others are anywhere in a part. The same seed chooses the same.
 *
 * mesh: the input of the plan. Returns SVO_OUT_OF_HOST_MEMORY and what svo_parts_tree_load returns. */
svo_status parts_check(const svo_parts *parts, svo_parts_tree *tree, const svo_mesh *mesh, size_t count, uint64_t seed,
                       parts_differences *found, svo_message *message);

#endif
