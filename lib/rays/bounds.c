/* SPDX-License-Identifier: MIT */
/* Visits the nodes of the upper levels, which are the first ones: for cameras that frame a tree, and for the boxes of
   instances. */
#include "rays/bounds.h"

/* The deepest level that is visited. */
#define BOUNDS_LEVEL_MAX 6u

/* The tree's nodes on the host. */
typedef struct node_arrays {
    const uint8_t *child_mask;
    const uint32_t *first_child;
} node_arrays;

static void extend_bounds(const node_arrays *arrays, uint32_t node, uint32_t levels_left, const uint32_t cell[3],
                          svo_i_cell_bounds *bounds)
{
    if (levels_left == 0) {
        for (int axis = 0; axis < 3; ++axis) {
            bounds->low[axis] = cell[axis] < bounds->low[axis] ? cell[axis] : bounds->low[axis];
            bounds->high[axis] = cell[axis] >= bounds->high[axis] ? cell[axis] + 1 : bounds->high[axis];
        }
        return;
    }
    uint32_t child = arrays->first_child[node];
    for (uint32_t octant = 0; octant < 8; ++octant) {
        if ((arrays->child_mask[node] >> octant & 1) != 0) {
            const uint32_t inner[3] = {2 * cell[0] + (octant & 1), 2 * cell[1] + (octant >> 1 & 1),
                                       2 * cell[2] + (octant >> 2)};
            extend_bounds(arrays, child, levels_left - 1, inner, bounds);
            ++child;
        }
    }
}

static uint32_t bounds_level(const svo_tree_info *info)
{
    return info->depth < BOUNDS_LEVEL_MAX ? info->depth : BOUNDS_LEVEL_MAX;
}

uint64_t svo_i_bounds_nodes(const svo_tree_info *info)
{
    return info->level_begin[bounds_level(info)];
}

void svo_i_occupied_cells(const svo_tree_info *info, const uint8_t *child_mask, const uint32_t *first_child,
                          svo_i_cell_bounds *out)
{
    const uint32_t level = bounds_level(info);
    const uint32_t cells = 1u << level;
    const node_arrays arrays = {child_mask, first_child};
    *out = (svo_i_cell_bounds){cells, {0, 0, 0}, {cells, cells, cells}};
    if (child_mask != NULL && first_child != NULL && info->leaf_count > 0) {
        *out = (svo_i_cell_bounds){cells, {cells, cells, cells}, {0, 0, 0}};
        const uint32_t root[3] = {0, 0, 0};
        extend_bounds(&arrays, 0, level, root, out);
    }
}
