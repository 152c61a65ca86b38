/* SPDX-License-Identifier: MIT */
/* Builds the tree of the exact reference and compares it with a built one, and snaps the mesh again, for verify and
   stress. */
#include "measure/tree_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reference/oracle_exact.h"

/* Snapped coordinates below this are not refused, however they are rounded. */
#define NEAR_UNITS 0x1p28

/* ---- voxels, pairs and nodes ---- */

bool tree_check_list_pairs(const svo_tree_info *info, const svo_tree_arrays *arrays, oracle_pairs *out,
                           uint64_t *empty_leaf_count)
{
    uint64_t *codes = malloc((size_t)info->leaf_count * sizeof *codes + 1);
    out->pairs = malloc((size_t)info->list_count * sizeof *out->pairs + 1);
    out->count = 0;
    *empty_leaf_count = 0;
    bool good = codes != NULL && out->pairs != NULL;
    good = good && oracle_leaf_codes(arrays->child_mask, info->inner_count, info->depth, info->leaf_count, codes);
    for (uint64_t leaf = 0; good && leaf < info->leaf_count; ++leaf) {
        const uint32_t begin = arrays->list_begin[leaf];
        const uint32_t end = arrays->list_begin[leaf + 1];
        good = begin <= end && end <= info->list_count && out->count + (end - begin) <= info->list_count;
        *empty_leaf_count += begin == end;
        for (uint32_t i = begin; good && i < end; ++i) {
            good = arrays->list[i] < info->list_triangle_count;
            if (good) {
                out->pairs[out->count++] = (oracle_pair){codes[leaf], arrays->triangle_ids[arrays->list[i]]};
            }
        }
    }
    free(codes);
    good = good && oracle_pairs_sort(out->pairs, out->count);
    if (!good) {
        oracle_pairs_free(out);
    }
    return good;
}

static bool count_node_differences(const oracle_pairs *expected, const svo_tree_info *info,
                                   const svo_tree_arrays *arrays, uint64_t *count)
{
    oracle_tree tree;
    if (!oracle_tree_make(expected, info->depth, &tree)) {
        return false;
    }
    *count = 0;
    for (unsigned level = 0; level <= info->depth + 1; ++level) {
        *count += tree.level_begin[level] != info->level_begin[level];
    }
    for (uint64_t i = 0; i < tree.inner_count && i < info->inner_count; ++i) {
        *count += tree.child_mask[i] != arrays->child_mask[i] || tree.first_child[i] != arrays->first_child[i];
    }
    oracle_tree_free(&tree);
    return true;
}

/* ---- snapped vertices ---- */

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

/* ---- exact pairs ---- */

/* Whether the reference refuses a triangle. Snapping takes long, so that only distant ones are snapped. */
static bool is_refused(const oracle_positions *mesh, const oracle_grid *grid, size_t triangle)
{
    int32_t snapped[3][3];
    uint32_t vertices[3];
    bool near = oracle_triangle_accepted(mesh, triangle, vertices);
    for (size_t i = 0; near && i < 9; ++i) {
        const double position = mesh->positions[(size_t)vertices[i / 3] * 3 + i % 3];
        near = fabs((position - grid->origin[i % 3]) * grid->scale) < NEAR_UNITS;
    }
    return !near && !snap_triangle(mesh, grid, triangle, snapped);
}

/* Three indices per triangle, out of range for those that the reference refuses. NULL: out of memory. */
static uint32_t *copy_kept_indices(const oracle_positions *mesh, const svo_tree_info *info)
{
    const oracle_grid grid = {
        {info->origin[0], info->origin[1], info->origin[2]}, info->edge, info->scale, info->snap_bits};
    uint32_t *indices = malloc(mesh->triangle_count * 3 * sizeof *indices + 1);
    for (size_t triangle = 0; indices != NULL && triangle < mesh->triangle_count; ++triangle) {
        const bool refused = is_refused(mesh, &grid, triangle);
        for (size_t corner = triangle * 3; corner < triangle * 3 + 3; ++corner) {
            indices[corner] = refused ? UINT32_MAX : mesh->indices != NULL ? mesh->indices[corner] : (uint32_t)corner;
        }
    }
    return indices;
}

bool mesh_list_pairs(const svo_mesh *mesh, const svo_tree_info *info, oracle_coverage coverage, oracle_pairs *out)
{
    const grid_node root = {.level = 0};
    return mesh_list_pairs_below(mesh, info, coverage, &root, 1, out);
}

bool mesh_list_pairs_below(const svo_mesh *mesh, const svo_tree_info *info, oracle_coverage coverage,
                           const grid_node *nodes, size_t count, oracle_pairs *out)
{
    const oracle_space space = {{info->origin[0], info->origin[1], info->origin[2]}, info->edge, info->depth};
    double *positions = copy_positions(mesh);
    const oracle_positions source = {positions, mesh->vertex_count, mesh->indices, mesh->triangle_count};
    uint32_t *indices = positions != NULL ? copy_kept_indices(&source, info) : NULL;
    const oracle_positions kept = {positions, mesh->vertex_count, indices, mesh->triangle_count};
    bool good = indices != NULL;
    for (size_t i = 0; i < count; ++i) {
        out[i] = (oracle_pairs){0};
        good = good && oracle_exact_enumerate_below(&kept, &space, coverage, nodes[i].level, nodes[i].code, &out[i]);
    }
    for (size_t i = 0; !good && i < count; ++i) {
        oracle_pairs_free(&out[i]);
    }
    free(indices);
    free(positions);
    return good;
}

/* Coordinate i of a tree's vertices; in grid units if it has only snapped ones. */
static double coordinate(const svo_tree_arrays *arrays, size_t i)
{
    return arrays->positions_double != NULL ? arrays->positions_double[i]
           : arrays->positions != NULL      ? (double)arrays->positions[i]
                                            : (double)arrays->vertices[i];
}

/* The exact pairs of the triangles that a tree holds. */
static bool tree_list_pairs(const svo_tree_info *info, const svo_tree_arrays *arrays, oracle_pairs *out)
{
    const bool is_snapped = arrays->positions == NULL && arrays->positions_double == NULL;
    oracle_space space = {{info->origin[0], info->origin[1], info->origin[2]}, info->edge, info->depth};
    if (is_snapped) {
        space = (oracle_space){.edge = ldexp(1.0, (int)info->snap_bits), .depth = info->depth};
    }
    const size_t count = (size_t)info->vertex_count * 3;
    double *positions = malloc(count * sizeof *positions + 1);
    for (size_t i = 0; positions != NULL && i < count; ++i) {
        positions[i] = coordinate(arrays, i);
    }
    const oracle_positions mesh = {positions, (size_t)info->vertex_count, arrays->indices,
                                   (size_t)info->list_triangle_count};
    *out = (oracle_pairs){0};
    const bool good = positions != NULL && oracle_exact_enumerate(&mesh, &space, (oracle_coverage)info->coverage, out);
    for (size_t i = 0; good && i < out->count; ++i) {
        out->pairs[i].triangle = arrays->triangle_ids[out->pairs[i].triangle]; /* ids rise: the order stays */
    }
    free(positions);
    return good;
}

/* ---- the tree ---- */

bool tree_check(const svo_mesh *mesh, const svo_tree_info *info, const svo_tree_arrays *arrays, tree_differences *found)
{
    *found = (tree_differences){0};
    oracle_pairs expected = {0};
    oracle_pairs actual = {0};
    uint64_t empty_leaf_count = 0;
    const bool listed = mesh != NULL ? mesh_list_pairs(mesh, info, (oracle_coverage)info->coverage, &expected)
                                     : tree_list_pairs(info, arrays, &expected);
    const bool good = listed && tree_check_list_pairs(info, arrays, &actual, &empty_leaf_count) &&
                      count_node_differences(&expected, info, arrays, &found->node_differences);
    if (good) {
        oracle_compare(&expected, &actual, &found->difference);
        found->difference.surplus_voxels += empty_leaf_count;
        found->expected_voxels = oracle_pairs_voxel_count(&expected);
        found->expected_pairs = expected.count;
        found->built_voxels = info->leaf_count;
        found->built_pairs = actual.count;
    }
    oracle_pairs_free(&expected);
    oracle_pairs_free(&actual);
    return good;
}

bool tree_check_is_exact(const tree_differences *found)
{
    const oracle_difference *d = &found->difference;
    return d->missed_voxels == 0 && d->surplus_voxels == 0 && d->missed_pairs == 0 && d->surplus_pairs == 0 &&
           found->node_differences == 0;
}
