/* SPDX-License-Identifier: MIT */
/* Generalized winding numbers of a mesh that is not closed, at the centers of voxels. */
#ifndef SVO_LIB_SOLID_WINDING_H
#define SVO_LIB_SOLID_WINDING_H

#include "core/tree.h"
#include "core/work.h"
#include "solid/clusters.h"

/* The cube of a node, with what is far from all of it as one linear function. */
typedef struct svo_i_winding_box {
    uint64_t code; /* of the node */
    double center[3], width; /* in voxels */
    double angle, slope[3]; /* of walls far away: half their solid angles at the center, and what that changes by */
    double error; /* the most that the function is off, anywhere in the box */
    size_t first, end; /* the others: clusters, in near */
    size_t piece_count; /* of the others */
} svo_i_winding_box;

/* Made by svo_i_winding_of_tree. All owned. */
typedef struct svo_i_winding {
    svo_i_clusters clusters; /* of the boundary */
    svo_decide_params grid;
    svo_i_winding_box *boxes; /* by level, from the root to the node that was entered */
    uint32_t *near; /* box by box: clusters */
    uint32_t box_level; /* of the node that was entered */
} svo_i_winding;

/* How a number compares with 1/2. */
typedef enum svo_i_winding_side {
    SVO_I_WINDING_BELOW,
    SVO_I_WINDING_ABOVE,
    SVO_I_WINDING_AMBIGUOUS
} svo_i_winding_side;

SVO_I_SHARED_BEGIN

/* Makes them of a tree's mesh. positions, kind, grid: those that decide, SVO_SOLID_*; of snapped ones the grid is not
   read. Where it fails, there is nothing to release, and no message if that is SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_winding_of_tree(svo_i_device_work *work, const svo_tree *tree, cl_mem positions, uint32_t kind,
                                 const svo_decide_params *grid, svo_i_winding *out);

void svo_i_winding_release(svo_i_winding *winding);

/* Enters the node with a code on a level above the leaves: sums up what is far from all of it. Nodes that follow each
   other in the order of their codes share the work for those above them. */
void svo_i_winding_enter(svo_i_winding *winding, uint32_t level, uint64_t code);

/* The winding number at the center of a voxel of the node that was entered, beside 1/2. crossings: the sum along the
   line from the center in direction +z. The center lies at least half a voxel from the boundary. */
svo_i_winding_side svo_i_winding_at(const svo_i_winding *winding, const uint32_t voxel[3], int32_t crossings);

SVO_I_SHARED_END

#endif
