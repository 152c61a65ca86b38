/* SPDX-License-Identifier: MIT */
/* From places to nodes and back: the host's side of kernels/shared/nodes.clh. */
#include "svocl/nodes.h"

#include <math.h>

#include "core/device.h"
#include "core/message.h"
#include "core/tree.h"
#include "shared/nodes.clh"
#include "shared/snap.clh"

svo_status svo_tree_get_grid(const svo_tree *tree, svo_grid *grid)
{
    SVO_I_TRY(svo_i_tree_check(tree, "svo_tree_get_grid"));
    if (grid == NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "svo_tree_get_grid: grid is NULL");
    }
    const svo_tree_info *info = &tree->info;
    /* In old files of fitted grids the edge is less than the grid's width. */
    const double width = ldexp(1.0, (int)info->snap_bits) / info->scale;
    const bool is_width = ldexp(1.0, (int)info->snap_bits) / info->edge == info->scale;
    *grid = (svo_grid){.depth = info->depth,
                       .snap_bits = info->snap_bits,
                       .origin = {info->origin[0], info->origin[1], info->origin[2]},
                       .scale = info->scale,
                       .edge = is_width ? info->edge : width};
    return SVO_OK;
}

double svo_grid_cell_edge(const svo_grid *grid, uint32_t level)
{
    return ldexp(1.0, (int)grid->snap_bits - (int)level) / grid->scale;
}

static double world_coordinate(const svo_grid *grid, int axis, uint64_t units)
{
    return (double)units / grid->scale + grid->origin[axis];
}

void svo_grid_cell_box(const svo_grid *grid, uint32_t level, const uint32_t cell[3], double low[3], double high[3])
{
    const uint32_t shift = grid->snap_bits - level;
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = world_coordinate(grid, axis, (uint64_t)cell[axis] << shift);
        if (high != NULL) {
            high[axis] = world_coordinate(grid, axis, ((uint64_t)cell[axis] + 1) << shift);
        }
    }
}

int svo_grid_cell_of_point(const svo_grid *grid, uint32_t level, const double point[3], uint32_t cell[3])
{
    const svo_snap snap = svo_make_snap(grid->scale, grid->edge, (int32_t)grid->snap_bits);
    const int32_t end = (int32_t)(1u << grid->snap_bits);
    uint32_t found[3] = {0, 0, 0};
    for (int axis = 0; axis < 3; ++axis) {
        const int32_t units = isfinite(point[axis]) ? svo_snap_coordinate(&snap, point[axis], grid->origin[axis]) : -1;
        if (units < 0 || units >= end) {
            return 0;
        }
        found[axis] = (uint32_t)units >> (grid->snap_bits - level);
    }
    for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = found[axis];
    }
    return 1;
}

uint64_t svo_cell_to_code(const uint32_t cell[3])
{
    return svo_interleave(cell);
}

void svo_code_to_cell(uint64_t code, uint32_t cell[3])
{
    svo_deinterleave(code, cell);
}

/* Whether the tree's nodes are on the host and the outputs are there. */
static svo_status check(const svo_tree *tree, const char *function, const void *given, const void *node)
{
    SVO_I_TRY(svo_i_tree_check(tree, function));
    if (given == NULL || node == NULL) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: an argument is NULL", function);
    }
    return tree->downloaded
               ? SVO_OK
               : svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT,
                                   "%s: the tree has no host arrays; call svo_tree_download first", function);
}

svo_status svo_tree_find_cell(const svo_tree *tree, uint32_t level, const uint32_t cell[3], svo_node *node)
{
    static const char function[] = "svo_tree_find_cell";
    SVO_I_TRY(check(tree, function, cell, node));
    if (level > tree->info.depth) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: level %u is above %u", function, level,
                                 tree->info.depth);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (cell[axis] >> level != 0) {
            return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: cell[%d] %u is not below %u", function,
                                     axis, cell[axis], 1u << level);
        }
    }
    svo_walk_down(tree->host[SVO_TREE_CHILD_MASK], tree->host[SVO_TREE_FIRST_CHILD], level, cell, node);
    return SVO_OK;
}

svo_status svo_tree_find_point(const svo_tree *tree, const double point[3], svo_node *node)
{
    svo_grid grid = {.depth = 0};
    uint32_t cell[3] = {0, 0, 0};
    SVO_I_TRY(check(tree, "svo_tree_find_point", point, node));
    SVO_I_TRY(svo_tree_get_grid(tree, &grid));
    if (!svo_grid_cell_of_point(&grid, grid.depth, point, cell)) {
        *node = (svo_node){.index = SVO_NO_NODE};
        return SVO_OK;
    }
    return svo_tree_find_cell(tree, grid.depth, cell, node);
}

/* svo_tree_find_node for a function that its message names. */
static svo_status find_node(const svo_tree *tree, const char *function, uint32_t index, svo_node *node)
{
    if (index >= tree->info.node_count) {
        return svo_i_device_fail(tree->device, SVO_INVALID_ARGUMENT, "%s: node %u is not below %llu", function, index,
                                 (unsigned long long)tree->info.node_count);
    }
    svo_walk_up(tree->host[SVO_TREE_CHILD_MASK], tree->host[SVO_TREE_FIRST_CHILD], (uint32_t)tree->info.inner_count,
                index, node);
    return SVO_OK;
}

svo_status svo_tree_find_node(const svo_tree *tree, uint32_t index, svo_node *node)
{
    static const char function[] = "svo_tree_find_node";
    SVO_I_TRY(check(tree, function, node, node));
    return find_node(tree, function, index, node);
}

svo_status svo_tree_node_box(const svo_tree *tree, uint32_t index, double low[3], double high[3])
{
    static const char function[] = "svo_tree_node_box";
    svo_grid grid = {.depth = 0};
    svo_node node = {.index = 0};
    SVO_I_TRY(check(tree, function, low, high));
    SVO_I_TRY(find_node(tree, function, index, &node));
    SVO_I_TRY(svo_tree_get_grid(tree, &grid));
    svo_grid_cell_box(&grid, node.level, node.cell, low, high);
    return SVO_OK;
}
