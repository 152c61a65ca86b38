/* SPDX-License-Identifier: MIT */
/* Snaps the mesh again with the reference and compares the result with the tree. */
#include "support/snap_check.h"

#include <stdlib.h>
#include <string.h>

#include "reference/oracle.h"

static double *copy_positions(const svo_mesh *mesh)
{
    const size_t count = mesh->vertex_count * 3;
    double *positions = malloc(count * sizeof *positions + 1);
    for (size_t i = 0; positions != NULL && i < count; ++i) {
        positions[i] = mesh->positions_double != NULL ? mesh->positions_double[i] : (double)mesh->positions[i];
    }
    return positions;
}

static unsigned count_grid_differences(const oracle_grid *grid, const svo_tree_info *info)
{
    unsigned count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        count += grid->origin[axis] < info->origin[axis] || grid->origin[axis] > info->origin[axis];
    }
    count += grid->edge < info->edge || grid->edge > info->edge;
    count += grid->scale < info->scale || grid->scale > info->scale;
    return count;
}

/* A triangle's snapped vertices; false if the reference refuses it. */
static bool snap_triangle(const oracle_positions *mesh, const oracle_grid *grid, size_t triangle, int32_t snapped[3][3])
{
    uint32_t vertices[3];
    if (!oracle_triangle_accepted(mesh, triangle, vertices)) {
        return false;
    }
    for (int corner = 0; corner < 3; ++corner) {
        if (!oracle_snap(grid, mesh->positions + (size_t)vertices[corner] * 3, snapped[corner])) {
            return false;
        }
    }
    return true;
}

static bool is_kept_triangle(const svo_tree_arrays *arrays, const svo_tree_info *info, uint64_t kept,
                             int32_t snapped[3][3])
{
    for (size_t corner = 0; corner < 3; ++corner) {
        const uint32_t vertex = arrays->indices[kept * 3 + corner];
        if (vertex >= info->vertex_count ||
            memcmp(arrays->vertices + (size_t)vertex * 3, snapped[corner], sizeof snapped[corner]) != 0) {
            return false;
        }
    }
    return true;
}

static uint64_t count_triangle_differences(const oracle_positions *mesh, const oracle_grid *grid,
                                           const svo_tree_info *info, const svo_tree_arrays *arrays)
{
    uint64_t count = 0;
    uint64_t kept = 0; /* index into the tree's triangles, which are sorted by their index in the mesh */
    for (size_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
        int32_t snapped[3][3];
        const bool expected = snap_triangle(mesh, grid, triangle, snapped);
        const bool held = kept < info->list_triangle_count && arrays->triangle_ids[kept] == triangle;
        count += expected != held || (held && !is_kept_triangle(arrays, info, kept, snapped));
        kept += held;
    }
    return count + (info->list_triangle_count - kept);
}

bool snap_check(const svo_mesh *mesh, const options *given, const svo_tree_info *info, const svo_tree_arrays *arrays,
                snap_differences *found)
{
    double *positions = copy_positions(mesh);
    if (positions == NULL) {
        return false;
    }
    const oracle_positions source = {positions, mesh->vertex_count, mesh->indices, mesh->triangle_count};
    oracle_grid grid;
    *found = (snap_differences){0};
    const bool has_grid = given->edge > 0.0 ? oracle_grid_given(given->origin, given->edge, info->snap_bits, &grid)
                                            : oracle_grid_fit(&source, info->snap_bits, &grid);
    if (has_grid) {
        found->grid_values = count_grid_differences(&grid, info);
        found->triangles = count_triangle_differences(&source, &grid, info, arrays);
    } else {
        found->triangles = info->list_triangle_count; /* the reference accepts nothing */
    }
    free(positions);
    return true;
}
