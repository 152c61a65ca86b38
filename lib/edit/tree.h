/* SPDX-License-Identifier: MIT */
/*
 * Trees of nodes: the arrays of svo_tree, written by the host from the root of an edit down, without a list of voxels.
 * Nodes of a level are met in Morton order, which is the order of the arrays, so one walk writes all levels.
 */
#ifndef SVO_LIB_EDIT_TREE_H
#define SVO_LIB_EDIT_TREE_H

#include "core/tree.h"
#include "edit/store.h"

/* Says how far a walk is, 0 .. 1; false stops it. */
typedef bool (*svo_i_edit_told)(void *user, double fraction);

/* The bounds of a root's voxels: the least cells and the greatest ones plus 1. root: not empty. least_level: 0, or from
   2 on: cubes of that level that have voxels count as full, which takes less time. */
void svo_i_edit_bounds(const svo_i_edit_store *store, svo_i_edit_ref root, uint32_t least_level, uint32_t low[3],
                       uint32_t high[3]);

/* Whether a cube of that level may begin at a cell; and the node of such a cube. */
bool svo_i_edit_is_aligned(const uint32_t low[3], uint32_t level);
svo_i_edit_ref svo_i_edit_find_cube(const svo_i_edit_store *store, svo_i_edit_ref root, const uint32_t low[3],
                                    uint32_t level);

/*
 * Writes the host arrays of a tree, where payload that is constant has one element.
 *
 * node: the cube of the grid, on the tree's depth as its level, at least 2; with voxels.
 * depth_first: payload lies in the order of a walk from the root down, as in SVO_FORM_SHARED; false: in that of nodes.
 * tree: its info has depth, need and payload_level, and receives counts and constant. On failure it may have arrays.
 * told: NULL: nothing is called.
 * Returns SVO_OUT_OF_HOST_MEMORY, SVO_CAPACITY_EXCEEDED (2^32 - 1 nodes or more) or SVO_CANCELED, without a message.
 */
svo_status svo_i_edit_write_tree(const svo_i_edit_store *store, svo_i_edit_ref node, bool depth_first, svo_tree *tree,
                                 svo_i_edit_told told, void *user);

#endif
