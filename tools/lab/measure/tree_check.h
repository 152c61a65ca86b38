/* SPDX-License-Identifier: MIT */
/* Compares a tree that has leaf lists with the exact reference of tools/lab/reference, which voxelizes the mesh as it
   was given again; and its grid and snapped vertices with those that the reference computes from the mesh. */
#ifndef SVOCL_TOOLS_MEASURE_TREE_CHECK_H
#define SVOCL_TOOLS_MEASURE_TREE_CHECK_H

#include <stdbool.h>
#include <stdint.h>

#include "reference/oracle.h"
#include "support/options.h"
#include "svocl/mesh.h"
#include "svocl/tree.h"

/* Differences, which must be 0, and how much was compared. */
typedef struct tree_differences {
    oracle_difference difference;
    uint64_t node_differences; /* child masks, first children and level offsets that differ */
    uint64_t expected_voxels, expected_pairs;
    uint64_t built_voxels, built_pairs;
} tree_differences;

/* mesh: the input of the tree; NULL: of a tree from a file, whose own positions are compared. info, arrays: of a
   downloaded tree built with SVO_NEED_RAYS. Returns false if memory runs out or the tree is malformed. */
bool tree_check(const svo_mesh *mesh, const svo_tree_info *info, const svo_tree_arrays *arrays,
                tree_differences *found);
bool tree_check_is_exact(const tree_differences *found);

/* The tree's voxel-triangle pairs from its masks and leaf lists, sorted; leaves without triangles are only counted.
   Release them by oracle_pairs_free. Returns false under the same conditions as tree_check. */
bool tree_check_list_pairs(const svo_tree_info *info, const svo_tree_arrays *arrays, oracle_pairs *out,
                           uint64_t *empty_leaf_count);

typedef struct snap_differences {
    unsigned grid_values; /* of origin, edge and scale */
    uint64_t triangles; /* accepted by only one of the two, or with a different snapped vertex */
} snap_differences;

/* mesh: the input of the tree, built by the options given. The tree has its geometry (SVO_NEED_RAYS). Returns false
   if memory runs out. */
bool snap_check(const svo_mesh *mesh, const options *given, const svo_tree_info *info, const svo_tree_arrays *arrays,
                snap_differences *found);

/* The exact pairs of a mesh on a tree's grid, sorted; triangles that are refused for being too far away are left out.
   Release them by oracle_pairs_free. Returns false if memory runs out. */
bool mesh_list_pairs(const svo_mesh *mesh, const svo_tree_info *info, oracle_coverage coverage, oracle_pairs *out);

/* A node of the octree: its Morton code on its level. */
typedef struct grid_node {
    unsigned level;
    uint64_t code;
} grid_node;

/* The pairs below each of some nodes, one list for each. info: depth, snap_bits, origin, edge and scale. */
bool mesh_list_pairs_below(const svo_mesh *mesh, const svo_tree_info *info, oracle_coverage coverage,
                           const grid_node *nodes, size_t count, oracle_pairs *out);

#endif
