/* SPDX-License-Identifier: MIT */
/* Compares a solid with the exact reference, voxel by voxel. */
#ifndef SVOCL_TOOLS_MEASURE_SOLID_CHECK_H
#define SVOCL_TOOLS_MEASURE_SOLID_CHECK_H

#include "reference/oracle_solid.h"
#include "svocl/solid.h"

/* The largest depth: the reference is a dense grid. */
#define SOLID_CHECK_DEPTH_MAX 10

typedef struct solid_differences {
    oracle_solid_difference voxels;
    uint64_t open_columns[3]; /* of the reference */
    bool counts_differ; /* the counts of svo_solid_info are not those of the reference */
} solid_differences;

/*
 * tree, arrays: of the built tree, downloaded, with SVO_NEED_RAYS and a depth up to SOLID_CHECK_DEPTH_MAX. solid: made
 * from it by the rule, downloaded. Returns false if memory runs out or the solid is malformed.
 */
bool solid_check(const svo_tree_info *tree, const svo_tree_arrays *arrays, const svo_compact *solid,
                 const svo_solid_info *info, svo_solid_rule rule, solid_differences *found);
/* Whether each voxel is as the reference says: where the surface is closed, each by itself; else by cells. */
bool solid_check_is_exact(const solid_differences *found);

#endif
