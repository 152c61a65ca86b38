/* SPDX-License-Identifier: MIT */
/* Runs tools/lab/reference on a caller's mesh and compares a built tree with its result. */
#include "compare_tree.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

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

/* Refused and outside vertices touch no voxel. The oracle gets 2^29 for them, beyond the range of the test. */
static void snap_vertex(const oracle_grid *grid, const double position[3], int32_t snapped[3])
{
    if (!oracle_snap(grid, position, snapped)) {
        snapped[0] = snapped[1] = snapped[2] = 1 << 29;
    }
}

static void snap_triangles(const oracle_positions *mesh, exact *out)
{
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        uint32_t *corners = out->indices + out->triangle_count * 3;
        if (!oracle_triangle_accepted(mesh, t, corners)) {
            continue;
        }
        for (unsigned corner = 0; corner < 3; ++corner) {
            const size_t v = corners[corner];
            snap_vertex(&out->grid, mesh->positions + v * 3, out->vertices + v * 3);
        }
        out->triangle_ids[out->triangle_count++] = (uint32_t)t;
    }
}

static void enumerate(const exact *made, unsigned depth, oracle_method method, oracle_pairs *out)
{
    const oracle_mesh snapped = {made->vertices, made->indices, made->triangle_ids, made->triangle_count};
    const oracle_request request = {depth, snap_bits_of(depth), made->coverage, method};
    assert_true(oracle_enumerate(&snapped, &request, out));
}

void exact_create(const svo_mesh *mesh, unsigned depth, const svo_plan_options *grid_options, exact *out)
{
    const unsigned snap_bits = snap_bits_of(depth);
    *out = (exact){.coverage = grid_options != NULL ? (oracle_coverage)grid_options->coverage : ORACLE_HALF_OPEN};
    double *values = positions_of(mesh);
    const oracle_positions positions = {values, mesh->vertex_count, mesh->indices, mesh->triangle_count};
    out->vertices = calloc(mesh->vertex_count * 3 + 1, sizeof(int32_t));
    out->indices = calloc(mesh->triangle_count * 3 + 3, sizeof(uint32_t));
    out->triangle_ids = calloc(mesh->triangle_count + 1, sizeof(uint32_t));
    assert_non_null(out->vertices);
    assert_non_null(out->indices);
    assert_non_null(out->triangle_ids);
    const bool has_grid = grid_options != NULL && grid_options->edge > 0.0
                              ? oracle_grid_given(grid_options->origin, grid_options->edge, snap_bits, &out->grid)
                              : oracle_grid_fit(&positions, snap_bits, &out->grid);
    if (has_grid) {
        snap_triangles(&positions, out);
    }
    free(values);
    enumerate(out, depth, ORACLE_SAT, &out->pairs);
    assert_true(oracle_tree_make(&out->pairs, depth, &out->tree));
}

void exact_destroy(exact *made)
{
    oracle_tree_free(&made->tree);
    oracle_pairs_free(&made->pairs);
    free(made->triangle_ids);
    free(made->indices);
    free(made->vertices);
    *made = (exact){0};
}

void assert_references_agree(const exact *made)
{
    oracle_pairs other;
    oracle_difference difference;
    enumerate(made, made->tree.depth, ORACLE_CLIP, &other);
    oracle_compare(&made->pairs, &other, &difference);
    oracle_pairs_free(&other);
    assert_int_equal(difference.missed_pairs, 0);
    assert_int_equal(difference.surplus_pairs, 0);
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
