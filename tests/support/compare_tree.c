/* SPDX-License-Identifier: MIT */
/* Runs tools/lab/reference on a caller's mesh and compares a built tree with its result. */
#include "compare_tree.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "oracle_exact.h"

/* Pairs at which both references are compared, at least where there are as many. */
#define PAIRS_COMPARED 200

static unsigned snap_bits_of(unsigned depth)
{
    return depth <= 12 ? 20 : depth + 8;
}

/* The vertices as doubles, allocated by malloc. */
static double *positions_of(const svo_mesh *mesh)
{
    double *values = malloc((mesh->vertex_count * 3 + 1) * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < mesh->vertex_count * 3; ++i) {
        values[i] = mesh->positions_double != NULL ? mesh->positions_double[i] : (double)mesh->positions[i];
    }
    return values;
}

static oracle_space space_of(const exact *made, unsigned depth)
{
    const oracle_grid *grid = &made->grid;
    return (oracle_space){{grid->origin[0], grid->origin[1], grid->origin[2]}, grid->edge, depth};
}

/* Snaps a triangle's corners; false if one is too far away, which becomes 2^29. */
static bool snap_corners(const oracle_positions *mesh, const uint32_t corners[3], exact *out)
{
    bool good = true;
    for (unsigned corner = 0; corner < 3; ++corner) {
        int32_t *snapped = out->vertices + (size_t)corners[corner] * 3;
        if (!oracle_snap(&out->grid, mesh->positions + (size_t)corners[corner] * 3, snapped)) {
            snapped[0] = snapped[1] = snapped[2] = 1 << 29;
            good = false;
        }
    }
    return good;
}

/* Rounds a triangle's corners to sub-units. */
static void refine_corners(const oracle_positions *mesh, const uint32_t corners[3], unsigned depth, exact *out)
{
    for (unsigned i = 0; i < 9; ++i) {
        const size_t at = (size_t)corners[i / 3] * 3 + i % 3;
        out->fine[at] = oracle_exact_rounded(mesh->positions[at], out->grid.origin[i % 3], out->grid.edge, depth + 24);
    }
}

/* Triangles that are refused for being too far away get no valid index in near. */
static void snap_triangles(const oracle_positions *mesh, unsigned depth, exact *out, uint32_t *near)
{
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        uint32_t *corners = out->indices + out->triangle_count * 3;
        memset(near + t * 3, 0xff, 3 * sizeof *near);
        if (!oracle_triangle_accepted(mesh, t, corners)) {
            continue;
        }
        if (snap_corners(mesh, corners, out)) {
            memcpy(near + t * 3, corners, 3 * sizeof *near);
            refine_corners(mesh, corners, depth, out);
        }
        out->triangle_ids[out->triangle_count++] = (uint32_t)t;
    }
}

/* Snaps the mesh and lists its pairs, on the grid that out has. */
static void enumerate(const oracle_positions *mesh, unsigned depth, exact *out)
{
    uint32_t *near = calloc(mesh->triangle_count * 3 + 1, sizeof *near);
    assert_non_null(near);
    snap_triangles(mesh, depth, out, near);
    const oracle_positions accepted = {mesh->positions, mesh->vertex_count, near, mesh->triangle_count};
    const oracle_space space = space_of(out, depth);
    assert_true(oracle_exact_enumerate(&accepted, &space, out->coverage, &out->pairs));
    free(near);
}

void exact_create(const svo_mesh *mesh, unsigned depth, const svo_plan_options *grid_options, exact *out)
{
    const unsigned snap_bits = snap_bits_of(depth);
    *out = (exact){.coverage = grid_options != NULL ? (oracle_coverage)grid_options->coverage : ORACLE_HALF_OPEN};
    out->positions = positions_of(mesh);
    const oracle_positions positions = {out->positions, mesh->vertex_count, mesh->indices, mesh->triangle_count};
    out->vertices = calloc(mesh->vertex_count * 3 + 1, sizeof(int32_t));
    out->fine = calloc(mesh->vertex_count * 3 + 1, sizeof(int64_t));
    out->indices = calloc(mesh->triangle_count * 3 + 3, sizeof(uint32_t));
    out->triangle_ids = calloc(mesh->triangle_count + 1, sizeof(uint32_t));
    assert_non_null(out->vertices);
    assert_non_null(out->fine);
    assert_non_null(out->indices);
    assert_non_null(out->triangle_ids);
    const bool has_grid = grid_options != NULL && grid_options->edge > 0.0
                              ? oracle_grid_given(grid_options->origin, grid_options->edge, snap_bits, &out->grid)
                              : oracle_grid_fit(&positions, snap_bits, &out->grid);
    if (has_grid) {
        enumerate(&positions, depth, out);
    }
    assert_true(oracle_tree_make(&out->pairs, depth, &out->tree));
}

void exact_destroy(exact *made)
{
    oracle_tree_free(&made->tree);
    oracle_pairs_free(&made->pairs);
    free(made->triangle_ids);
    free(made->indices);
    free(made->fine);
    free(made->vertices);
    free(made->positions);
    *made = (exact){0};
}

static int compare_pairs(const void *a, const void *b)
{
    const oracle_pair *first = a;
    const oracle_pair *second = b;
    if (first->code != second->code) {
        return first->code < second->code ? -1 : 1;
    }
    return (first->triangle > second->triangle) - (first->triangle < second->triangle);
}

static int compare_ids(const void *a, const void *b)
{
    const uint32_t first = *(const uint32_t *)a;
    const uint32_t second = *(const uint32_t *)b;
    return (first > second) - (first < second);
}

static oracle_exact_triangle triangle_of(const exact *made, uint32_t id)
{
    const uint32_t *found =
        bsearch(&id, made->triangle_ids, made->triangle_count, sizeof *made->triangle_ids, compare_ids);
    oracle_exact_triangle triangle = {{{0}}};
    assert_non_null(found);
    for (unsigned corner = 0; corner < 3; ++corner) {
        const size_t v = made->indices[(size_t)(found - made->triangle_ids) * 3 + corner];
        memcpy(triangle.vertices[corner], made->positions + v * 3, sizeof triangle.vertices[corner]);
    }
    return triangle;
}

/* Asks the second reference for a pair's voxel and its neighbors. */
static void assert_reference_agrees(const exact *made, const oracle_pair *pair)
{
    const int32_t cells = 1 << made->tree.depth;
    const oracle_space space = space_of(made, made->tree.depth);
    const oracle_exact_triangle triangle = triangle_of(made, pair->triangle);
    oracle_box box;
    oracle_voxel_box(pair->code, made->tree.depth, made->tree.depth, &box);
    for (int i = 0; i < 27; ++i) {
        const int32_t cell[3] = {(int32_t)box.corner[0] + i % 3 - 1, (int32_t)box.corner[1] + i / 3 % 3 - 1,
                                 (int32_t)box.corner[2] + i / 9 - 1};
        if (((cell[0] | cell[1] | cell[2]) & -cells) != 0) {
            continue;
        }
        const oracle_pair asked = {
            oracle_voxel_code((uint32_t)cell[0], (uint32_t)cell[1], (uint32_t)cell[2], made->tree.depth),
            pair->triangle};
        const bool expected = oracle_exact_clip_touches(&triangle, &space, cell, made->coverage);
        const bool found = bsearch(&asked, made->pairs.pairs, made->pairs.count, sizeof asked, compare_pairs) != NULL;
        if (found != expected) {
            fail_msg("triangle %u %s voxel %d %d %d by clipping", pair->triangle, expected ? "touches" : "misses",
                     cell[0], cell[1], cell[2]);
        }
    }
}

void assert_references_agree(const exact *made)
{
    const size_t step = made->pairs.count / PAIRS_COMPARED + 1;
    for (size_t i = 0; i < made->pairs.count; i += step) {
        assert_reference_agrees(made, &made->pairs.pairs[i]);
    }
}

static void assert_nodes(const built *actual, const oracle_tree *expected)
{
    assert_int_equal(actual->info.depth, expected->depth);
    assert_int_equal(actual->info.node_count, expected->node_count);
    assert_int_equal(actual->info.inner_count, expected->inner_count);
    assert_int_equal(actual->info.leaf_count, expected->node_count - expected->inner_count);
    assert_memory_equal(actual->info.level_begin, expected->level_begin, (expected->depth + 2) * sizeof(uint32_t));
    assert_memory_equal(actual->arrays.child_mask, expected->child_mask, expected->inner_count);
    assert_memory_equal(actual->arrays.first_child, expected->first_child, expected->inner_count * sizeof(uint32_t));
}

static void assert_lists(const built *actual, const oracle_pairs *expected)
{
    const svo_tree_arrays *arrays = &actual->arrays;
    assert_int_equal(actual->info.list_count, expected->count);
    size_t leaf = 0;
    for (size_t i = 0; i < expected->count; ++i) {
        if (i == 0 || expected->pairs[i].code != expected->pairs[i - 1].code) {
            assert_int_equal(arrays->list_begin[leaf++], i);
        }
        assert_in_range(arrays->list[i], 0, actual->info.list_triangle_count - 1);
        assert_int_equal(arrays->triangle_ids[arrays->list[i]], expected->pairs[i].triangle);
    }
    assert_int_equal(leaf, actual->info.leaf_count);
    assert_int_equal(arrays->list_begin[leaf], expected->count);
}

/* The geometry that rays read: the kept triangles, with their corners and their vertices in the mesh. */
static void assert_geometry(const built *actual, const exact *expected)
{
    const svo_tree_arrays *arrays = &actual->arrays;
    size_t e = 0;
    for (size_t k = 0; k < actual->info.list_triangle_count; ++k) {
        while (e < expected->triangle_count && expected->triangle_ids[e] < arrays->triangle_ids[k]) {
            ++e;
        }
        assert_in_range(e, 0, expected->triangle_count - 1);
        assert_int_equal(arrays->triangle_ids[k], expected->triangle_ids[e]);
        assert_memory_equal(arrays->indices + k * 3, expected->indices + e * 3, 3 * sizeof(uint32_t));
        for (unsigned corner = 0; corner < 3; ++corner) {
            const size_t v = arrays->indices[k * 3 + corner];
            assert_memory_equal(arrays->vertices + v * 3, expected->vertices + v * 3, 3 * sizeof(int32_t));
        }
    }
}

void assert_tree_is_exact(const built *actual, const exact *expected)
{
    assert_int_equal(actual->info.coverage, expected->coverage);
    assert_int_equal(actual->info.fragments, expected->pairs.count);
    if (expected->triangle_count > 0) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            assert_true(actual->info.origin[axis] == expected->grid.origin[axis]); /* -0 equals 0 */
        }
        assert_int_equal(actual->info.snap_bits, expected->grid.snap_bits);
        assert_true(actual->info.edge == expected->grid.edge);
        assert_true(actual->info.scale == expected->grid.scale);
    }
    assert_nodes(actual, &expected->tree);
    if ((actual->info.need & SVO_NEED_RAYS) != 0) {
        assert_lists(actual, &expected->pairs);
        assert_geometry(actual, expected);
    }
}

void assert_build_is_exact(const svo_mesh *mesh, const svo_plan_options *grid_options, const built *actual)
{
    exact expected;
    exact_create(mesh, actual->info.depth, grid_options, &expected);
    assert_tree_is_exact(actual, &expected);
    exact_destroy(&expected);
}
