/* SPDX-License-Identifier: MIT */
/** \file
 * Nodes as places: sizes and corners of voxels, Morton codes, the leaf at a point, the box of a node. Kernels have the
 * same functions, see svo_tree_target.
 *
 * The grid is a cube of 2^snap_bits units along each axis, from origin on, and svo_tree_info.edge wide; a unit is
 * 1 / scale wide. Its cells on level l are 2^(snap_bits - l) units wide, and there are 2^l along each axis. A voxel is
 * a cell on level depth.
 *
 * A fitted grid begins at the mesh's minimum corner. Its edge is the mesh's largest extent times 1 + 2^-20, rounded up
 * to 24 significant bits: so the far end of the mesh lies inside, for a voxel does not hold its far faces, and the
 * planes between voxels need few bits. The same origin and edge as a grid of the caller's (svo_plan_options.edge) give
 * the same grid. In .svo files of fitted grids that svocl wrote before, edge is the extent, and spans 2^snap_bits - 1
 * units; these functions compute with scale, which is right for both.
 *
 * Thread-safety: functions without a tree are pure. Several threads may call the others for one tree.
 */
#ifndef SVOCL_NODES_H
#define SVOCL_NODES_H

#include <stdint.h>

#include "svocl/plan.h"
#include "svocl/tree.h"
#include "svocl/tree_types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A box in world coordinates. This struct does not grow. */
typedef struct svo_box {
    double low[3]; /**< least corner */
    double high[3]; /**< greatest corner; not below low on any axis */
} svo_box;

/** Where the cells of a grid are: five fields of svo_plan_info before a build. This struct does not grow. */
typedef struct svo_grid {
    uint32_t depth; /**< the grid has 2^depth voxels per axis */
    uint32_t snap_bits; /**< the grid is 2^snap_bits units wide */
    double origin[3]; /**< minimum corner, world coordinates */
    double scale; /**< grid units per world unit */
    double edge; /**< width of the grid, world units */
} svo_grid;

/** The grid of a tree.
 *
 * \param tree not NULL
 * \param grid receives the grid
 * \returns SVO_INVALID_ARGUMENT when grid is NULL or the tree has no content. */
SVO_API svo_status svo_tree_get_grid(const svo_tree *tree, svo_grid *grid);

/** The width of a cell, which is that of a node.
 *
 * \param grid not NULL
 * \param level 0 .. depth; depth for a voxel
 * \returns world units. */
SVO_API double svo_grid_cell_edge(const svo_grid *grid, uint32_t level);

/** The corners of a cell. Neighbors share their faces, bit for bit.
 *
 * \param grid not NULL
 * \param level 0 .. depth
 * \param cell x, y, z, each below 2^level
 * \param low receives the minimum corner, world coordinates
 * \param high receives the maximum corner; NULL allowed */
SVO_API void svo_grid_cell_box(const svo_grid *grid, uint32_t level, const uint32_t cell[3], double low[3],
                               double high[3]);

/** The cell that holds a point, exactly: cell c on level l holds what is c * edge / 2^l from origin along each axis, or
 *  more, and less than c + 1 times that. So the cell of a vertex is occupied.
 *
 * \param grid not NULL
 * \param level 0 .. depth
 * \param point x, y, z, world coordinates
 * \param cell receives x, y, z; untouched when the point is outside
 * \returns not 0 when the point is inside the grid. */
SVO_API int svo_grid_cell_of_point(const svo_grid *grid, uint32_t level, const double point[3], uint32_t cell[3]);

/** A cell's Morton code: bit 3 k + a is bit k of the coordinate on axis a. Within a level, nodes ascend by code.
 *
 * \param cell x, y, z, each below 2^21
 * \returns the code; on level l below 2^(3 l). */
SVO_API uint64_t svo_cell_to_code(const uint32_t cell[3]);

/** The cell of a Morton code.
 *
 * \param code below 2^63
 * \param cell receives x, y, z */
SVO_API void svo_code_to_cell(uint64_t code, uint32_t cell[3]);

/** The deepest node on the way from the root to a cell. node->level is level when the cell is occupied.
 *
 * \param tree with host arrays
 * \param level 0 .. depth
 * \param cell x, y, z, each below 2^level
 * \param node receives the node
 * \returns SVO_INVALID_ARGUMENT before svo_tree_download, or when level or cell are out of range. */
SVO_API svo_status svo_tree_find_cell(const svo_tree *tree, uint32_t level, const uint32_t cell[3], svo_node *node);

/** The deepest node that holds a point, by svo_grid_cell_of_point: a leaf when node->level is the tree's depth. Leaf k
 *  of the tree's lists is the node with index inner_count + k.
 *
 * \param tree with host arrays
 * \param point x, y, z, world coordinates
 * \param node receives the node; outside the grid its index is SVO_NO_NODE and the rest 0
 * \returns SVO_INVALID_ARGUMENT before svo_tree_download. */
SVO_API svo_status svo_tree_find_point(const svo_tree *tree, const double point[3], svo_node *node);

/** The place of a node, found by going up to the root.
 *
 * \param tree with host arrays
 * \param index below svo_tree_info.node_count
 * \param node receives the node
 * \returns SVO_INVALID_ARGUMENT before svo_tree_download, or when index is out of range. */
SVO_API svo_status svo_tree_find_node(const svo_tree *tree, uint32_t index, svo_node *node);

/** The bounding box of a node.
 *
 * \param tree with host arrays
 * \param index below svo_tree_info.node_count
 * \param low receives the minimum corner, world coordinates
 * \param high receives the maximum corner
 * \returns what svo_tree_find_node returns. */
SVO_API svo_status svo_tree_node_box(const svo_tree *tree, uint32_t index, double low[3], double high[3]);

#ifdef __cplusplus
}
#endif

#endif
