/* SPDX-License-Identifier: MIT */
/* What `svocl bench scene` compares a lattice of instances with: one tree of the same voxels, and Embree's instances of
   the voxels as boxes. */
#ifndef SVOCL_TOOLS_BENCH_SCENE_PEERS_H
#define SVOCL_TOOLS_BENCH_SCENE_PEERS_H

#include "measure/embree.h"
#include "measure/suite.h"

/* A tree, and where its copies are: edge of them along each axis, a grid's width apart. */
typedef struct lattice {
    const suite *all;
    const svo_mesh *mesh;
    svo_tree *tree; /* with host arrays */
    svo_tree_info info;
    double width; /* of its grid, world */
} lattice;

/* One tree of edge^3 copies; edge is 2^edge_log2. NULL on failure, which the device's message explains. */
svo_tree *lattice_merge(const lattice *of, unsigned edge_log2);

/* The tree's leaves as boxes, placed by the matrices. NULL on failure, or without Embree. */
embree *lattice_boxes(const lattice *of, const float (*matrices)[12], size_t matrix_count);

#endif
