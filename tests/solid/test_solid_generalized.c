/* SPDX-License-Identifier: MIT */
/*
 * Solids by generalized winding numbers: every empty cell beside the sum of the solid angles of all triangles, in long
 * double and by another formula than the library's, and closed forms.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "oracle_exact.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/solid_meshes.h"
#include "support/suite.h"

#define DEPTH 5
#define WIDTH (1u << DEPTH)

/* Numbers so close to 1/2 are ambiguous, and none of those here is as close without being it. */
#define AMBIGUOUS       0x1p-32L
#define AMBIGUOUS_LEAST 0x1p-36L
#define AMBIGUOUS_MOST  0x1p-28L

typedef struct cells {
    const built *tree;
    const uint8_t *levels;
    svo_solid_info counted; /* by the reference */
    uint64_t above, below; /* cells */
} cells;

/* The position of a vertex's coordinate from a point, in voxels. */
static long double coordinate(const built *tree, uint32_t vertex, size_t axis, const uint32_t voxel[3])
{
    const svo_tree_info *info = &tree->info;
    const size_t i = 3 * (size_t)vertex + axis;
    const long double given = info->positions == SVO_POSITIONS_DOUBLE ? (long double)tree->arrays.positions_double[i]
                                                                      : (long double)tree->arrays.positions[i];
    const long double width = (long double)info->edge / (long double)(1u << info->depth);
    return (given - (long double)info->origin[axis]) / width - ((long double)voxel[axis] + 0.5L);
}

/* Twice the tangent's angle of Van Oosterom and Strackee, 1983. */
static long double solid_angle(long double (*corner)[3])
{
    const long double(*a)[3] = (const long double(*)[3])corner;
    long double length[3];
    long double dots[3];
    for (size_t i = 0; i < 3; ++i) {
        const size_t j = (i + 1) % 3;
        length[i] = sqrtl(a[i][0] * a[i][0] + a[i][1] * a[i][1] + a[i][2] * a[i][2]);
        dots[i] = a[i][0] * a[j][0] + a[i][1] * a[j][1] + a[i][2] * a[j][2];
    }
    const long double volume = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) +
                               a[0][1] * (a[1][2] * a[2][0] - a[1][0] * a[2][2]) +
                               a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    return 2.0L * atan2l(volume, length[0] * length[1] * length[2] + dots[0] * length[2] + dots[1] * length[0] +
                                     dots[2] * length[1]);
}

static long double winding_number(const built *tree, const uint32_t voxel[3])
{
    long double sum = 0.0L;
    for (size_t triangle = 0; triangle < (size_t)tree->info.list_triangle_count; ++triangle) {
        long double corner[3][3];
        for (size_t i = 0; i < 9; ++i) {
            corner[i / 3][i % 3] = coordinate(tree, tree->arrays.indices[3 * triangle + i / 3], i % 3, voxel);
        }
        sum += solid_angle(corner);
    }
    return sum / (4.0L * acosl(-1.0L));
}

static void check_cell(cells *c, const uint32_t cell[3], uint32_t level)
{
    const uint32_t width = 1u << (DEPTH - level);
    uint32_t voxel[3];
    for (size_t k = 0; k < 3; ++k) {
        voxel[k] = cell[k] * width + width / 2;
    }
    const long double over = winding_number(c->tree, voxel) - 0.5L;
    assert_true(fabsl(over) < AMBIGUOUS_LEAST || fabsl(over) > AMBIGUOUS_MOST);
    const bool inside = over > AMBIGUOUS;
    const uint64_t voxels = (uint64_t)width * width * width;
    ++c->counted.tests;
    c->above += inside ? 1 : 0;
    c->counted.inside_voxels += inside ? voxels : 0;
    c->counted.ambiguous_cells += fabsl(over) < AMBIGUOUS ? 1 : 0;
    c->counted.ambiguous_voxels += fabsl(over) < AMBIGUOUS ? voxels : 0;
    for (uint32_t i = 0; i < voxels; ++i) {
        const size_t at = (cell[0] * width + i % width) + (cell[1] * width + i / width % width) * WIDTH +
                          (size_t)(cell[2] * width + i / (width * width)) * WIDTH * WIDTH;
        if (c->levels[at] != (inside ? level : ORACLE_NO_LEAF)) {
            fail_msg("cell %u %u %u of level %u, number 1/2 + %Lg: level %u", cell[0], cell[1], cell[2], level, over,
                     c->levels[at]);
        }
    }
}

static void check_node(cells *c, uint32_t node, uint32_t level, const uint32_t cell[3])
{
    uint32_t child = c->tree->arrays.first_child[node];
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t below[3] = {2 * cell[0] + (octant & 1), 2 * cell[1] + (octant >> 1 & 1),
                                   2 * cell[2] + (octant >> 2)};
        if ((c->tree->arrays.child_mask[node] >> octant & 1) == 0) {
            check_cell(c, below, level + 1);
        } else if (level + 1 < DEPTH) {
            check_node(c, child++, level + 1, below);
        } else {
            ++child;
        }
    }
}

typedef struct request {
    bool skewed; /* on a grid whose planes are no doubles */
    bool floats;
} request;

/* Builds a mesh in voxels on a grid, fills it, compares every cell, and frees the parts. */
static svo_solid_info solve(void **state, parts *made, request asked)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_solid_options options = {.struct_size = sizeof options, .rule = SVO_SOLID_GENERALIZED};
    svo_plan_options plan = {.need = SVO_NEED_RAYS, .edge = WIDTH};
    svo_mesh mesh = parts_mesh(made);
    float *floats = malloc(made->vertex_count * 3 * sizeof *floats);
    uint8_t *levels = malloc((size_t)1 << 3 * DEPTH);
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    svo_solid_info found = SVO_SOLID_INFO_INIT;
    svo_compact *solid = NULL;
    built tree;
    assert_true(floats != NULL && levels != NULL);
    if (asked.skewed) {
        const double origin[3] = {0.1, -0.2, 1.0 / 3.0};
        memcpy(plan.origin, origin, sizeof origin);
        plan.edge = 0.7;
    }
    for (size_t i = 0; i < made->vertex_count * 3; ++i) {
        made->positions[i] = plan.origin[i % 3] + made->positions[i] * (plan.edge / WIDTH);
        floats[i] = (float)made->positions[i];
    }
    if (asked.floats) {
        mesh.positions = floats;
        mesh.positions_double = NULL;
    }
    fixture_build(&opened, &mesh, DEPTH, &plan, &tree);
    if (svo_solid_create(tree.tree, &options, opened.queue, &solid, &found) != SVO_OK ||
        svo_compact_download(solid, opened.queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened.device));
    }
    assert_int_equal(svo_compact_get_info(solid, &info), SVO_OK);
    assert_int_equal(svo_compact_get_arrays(solid, &arrays), SVO_OK);
    assert_true(oracle_descriptor_levels(arrays.nodes, (size_t)info.stored_count, DEPTH, levels));
    cells c = {.tree = &tree, .levels = levels};
    const uint32_t root[3] = {0, 0, 0};
    check_node(&c, 0, 0, root);
    assert_int_equal(found.tests, c.counted.tests);
    assert_int_equal(found.inside_leaves, c.above);
    assert_int_equal(found.inside_voxels, c.counted.inside_voxels);
    assert_int_equal(found.ambiguous_cells, c.counted.ambiguous_cells);
    assert_int_equal(found.ambiguous_voxels, c.counted.ambiguous_voxels);
    svo_compact_destroy(&solid);
    built_destroy(&tree);
    free(floats);
    free(levels);
    parts_free(made);
    return found;
}

/* ---- closed forms ---- */

/* In the plane of the hole half of all directions are covered: the number is 1/2 there, exactly. Outside of it there is
   nothing, and a dome of what is below 1/2 is missing inside. */
static void in_the_plane_of_a_hole_all_is_ambiguous(void **state)
{
    for (int face = 0; face < 6; ++face) {
        parts made = {.vertex_count = 0};
        parts_add_cube(&made, 6.5, 25.5, false, face);
        const svo_solid_info found = solve(state, &made, (request){.skewed = false});
        /* Of the plane, the cells of one voxel: those that surround 16 x 16 voxels of larger ones, which decide behind
           it or before it. */
        assert_int_equal(found.ambiguous_cells, 18 * 18 - 16 * 16);
        assert_int_equal(found.ambiguous_voxels, 18 * 18 - 16 * 16);
        assert_true(found.inside_voxels > 18 * 18 * 12 && found.inside_voxels < 18 * 18 * 18);
        assert_int_equal(found.boundary_edges, 4);
        assert_int_equal(found.regions, 0);
    }
}

/* What faces inwards has negative numbers. */
static void a_mesh_that_is_turned_inside_out_is_empty(void **state)
{
    for (int skip = -1; skip < 1; ++skip) {
        parts made = {.vertex_count = 0};
        parts_add_cube(&made, 4.25, 27.75, true, skip);
        assert_int_equal(solve(state, &made, (request){.skewed = false}).inside_voxels, 0);
    }
}

static void closed_parts_make_their_union(void **state)
{
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 3.5, 18.5, false, -1); /* voxels 3 .. 18 */
    parts_add_cube(&made, 10.5, 27.5, false, -1); /* 10 .. 27, common 10 .. 18 */
    const svo_solid_info found = solve(state, &made, (request){.skewed = false});
    assert_int_equal(found.surface_voxels + found.inside_voxels, 16 * 16 * 16 + 18 * 18 * 18 - 9 * 9 * 9);
    assert_int_equal(found.boundary_edges, 0);
    assert_true(found.regions > 0);
}

/* ---- beside the sum ---- */

/* Leaves out what is not all below a plane, of the triangles from the first one on. */
static void keep_below(parts *made, size_t first, const double center[3], const double normal[3], double limit)
{
    size_t kept = first;
    for (size_t i = first; i < made->triangle_count; ++i) {
        bool keep = true;
        for (size_t corner = 0; corner < 3; ++corner) {
            const double *at = made->positions + 3 * (size_t)made->indices[3 * i + corner];
            double height = 0.0;
            for (size_t k = 0; k < 3; ++k) {
                height += (at[k] - center[k]) * normal[k];
            }
            keep = keep && height < limit;
        }
        if (keep) {
            memmove(made->indices + 3 * kept++, made->indices + 3 * i, 3 * sizeof *made->indices);
        }
    }
    made->triangle_count = kept;
}

/* A sphere without what is above a plane, and so with a rim of 2 rings edges, in any direction. */
static void add_bowl(parts *made, unsigned rings, const double normal[3], double limit)
{
    const double center[3] = {15.7, 16.1, 15.9};
    const size_t first = made->triangle_count;
    parts_add_sphere(made, center, 12.3, rings);
    keep_below(made, first, center, normal, limit);
}

/* Rims that are long enough for clusters of a part of them. */
static void bowls_of_all_directions(void **state)
{
    const double normals[4][3] = {{0.0, 0.0, 1.0}, {0.0, 0.0, -1.0}, {1.0, 0.0, 0.0}, {0.48, 0.64, 0.6}};
    for (size_t i = 0; i < 4; ++i) {
        parts made = {.vertex_count = 0};
        add_bowl(&made, 24, normals[i], i == 3 ? 3.0 : 6.0);
        const svo_solid_info found = solve(state, &made, (request){.skewed = i % 2 != 0, .floats = i == 2});
        assert_true(found.boundary_edges > 24);
        assert_true(found.inside_voxels > 1000);
    }
}

/* Triangles that share nothing, the same one twice, and its opposite beside it. */
static void soups_of_triangles(void **state)
{
    for (uint64_t seed = 1; seed < 4; ++seed) {
        uint64_t random = seed;
        parts made = {.vertex_count = 0};
        for (int i = 0; i < 12; ++i) {
            double corners[4][3];
            for (size_t k = 0; k < 12; ++k) {
                const double width = i < 6 ? 24.0 : 5.0;
                const double at = 3.0 + random_unit(&random) * width + (k < 3 || i < 6 ? 0.0 : corners[0][k % 3] - 3.0);
                corners[k / 3][k % 3] = fmin(at, 30.0);
            }
            parts_add_tetrahedron(&made, (const double(*)[3])corners);
        }
        /* Faces of tetrahedra at random: each third one is left out, and each seventh is there twice. */
        size_t kept = 0;
        for (size_t i = 0; i < made.triangle_count; ++i) {
            if (i % 3 != 0) {
                memmove(made.indices + 3 * kept++, made.indices + 3 * i, 3 * sizeof *made.indices);
            }
        }
        for (size_t i = 0; i + 7 < kept; i += 7) {
            memcpy(made.indices + 3 * i, made.indices + 3 * (i + 1), 3 * sizeof *made.indices);
        }
        made.triangle_count = kept;
        assert_true(solve(state, &made, (request){.skewed = seed == 2, .floats = seed == 3}).boundary_edges > 40);
    }
}

/* A sphere whose triangles do not meet, each as large as a part of one that does. Seen from inside that part by its
   square of all directions is covered, by what is far. */
static svo_solid_info solve_with_gaps(void **state, double part, unsigned rings, bool is_half)
{
    const double center[3] = {15.7, 16.1, 15.9};
    parts sphere = {.vertex_count = 0};
    parts_add_sphere(&sphere, center, 13.1, rings);
    if (is_half) {
        const double up[3] = {0.48, 0.64, 0.6};
        keep_below(&sphere, 0, center, up, 0.1);
    }
    const size_t corners = 3 * sphere.triangle_count;
    parts made = {malloc(3 * corners * sizeof(double)), malloc(corners * sizeof(uint32_t)), corners,
                  sphere.triangle_count};
    assert_true(made.positions != NULL && made.indices != NULL);
    for (size_t i = 0; i < corners; ++i) {
        const uint32_t *triangle = sphere.indices + i / 3 * 3;
        made.indices[i] = (uint32_t)i;
        for (size_t k = 0; k < 3; ++k) {
            const double sum = sphere.positions[3 * triangle[0] + k] + sphere.positions[3 * triangle[1] + k] +
                               sphere.positions[3 * triangle[2] + k];
            made.positions[3 * i + k] = part * sphere.positions[3 * sphere.indices[i] + k] + (1.0 - part) * sum / 3.0;
        }
    }
    parts_free(&sphere);
    const svo_solid_info found = solve(state, &made, (request){.skewed = true});
    assert_int_equal(found.boundary_edges, corners);
    return found;
}

/* With a half of all directions covered, numbers are so close to 1/2 that little error would show. */
static void triangles_with_gaps_enclose(void **state)
{
    assert_true(solve_with_gaps(state, 0.84, 8, false).inside_voxels > 4000);
    solve_with_gaps(state, sqrt(0.5), 8, false);
    /* Small ones, which are far from all of a cube of cells; of a half, whose sum changes from cell to cell. */
    solve_with_gaps(state, sqrt(0.5), 20, false);
    solve_with_gaps(state, 0.9, 36, true);
}

/* Corners and edges on the lines through centers: what crosses there and what the walls jump by must be of one mind. */
static void corners_of_holes_on_the_columns(void **state)
{
    for (uint64_t seed = 11; seed < 15; ++seed) {
        uint64_t random = seed;
        parts made = {.vertex_count = 0};
        for (int i = 0; i < 6; ++i) {
            double corners[4][3];
            for (size_t k = 0; k < 12; ++k) {
                corners[k / 3][k % 3] = 2.5 + random_below(&random, 27);
            }
            parts_add_tetrahedron(&made, (const double(*)[3])corners);
        }
        for (size_t i = 0; i < made.triangle_count; i += 4) {
            memset(made.indices + 3 * i, 0, 3 * sizeof *made.indices); /* no triangle */
        }
        assert_true(solve(state, &made, (request){.skewed = false}).boundary_edges > 6);
    }
}

/* ---- progress ---- */

typedef struct watcher {
    unsigned calls, stop_at; /* it stops the call with this one, from 1 on; 0: never */
    double last;
} watcher;

static int watch(void *user, double fraction)
{
    watcher *seen = user;
    assert_true(seen->calls > 0 ? fraction >= seen->last && fraction <= 1.0 : fraction == 0.0);
    seen->last = fraction;
    ++seen->calls;
    return seen->calls == seen->stop_at;
}

/* Stops a fill at each call of the callback. */
static void stop_at_each_call(const fixture *opened, const svo_tree *tree, svo_solid_options options, unsigned calls)
{
    for (unsigned stop_at = 1; stop_at <= calls; ++stop_at) {
        watcher some = {.stop_at = stop_at};
        svo_compact *solid = NULL;
        char message[128];
        options.progress_user = &some;
        assert_int_equal(svo_solid_create(tree, &options, opened->queue, &solid, NULL), SVO_CANCELED);
        assert_null(solid);
        assert_int_equal(some.calls, stop_at);
        (void)snprintf(message, sizeof message, "svo_solid_create: the progress callback stopped the call at %.0f %%",
                       100.0 * some.last);
        assert_string_equal(svo_device_message(opened->device), message);
    }
}

/* A call that is stopped makes nothing; the next one makes what it does without. */
static void solids_tell_their_progress_and_stop(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double up[3] = {0.0, 0.0, 1.0};
    const svo_plan_options plan = {.need = SVO_NEED_RAYS, .edge = WIDTH};
    parts made = {.vertex_count = 0};
    add_bowl(&made, 24, up, 6.0);
    const svo_mesh mesh = parts_mesh(&made);
    built tree;
    fixture_build(&opened, &mesh, DEPTH, &plan, &tree);
    for (int rule = SVO_SOLID_WINDING; rule <= SVO_SOLID_GENERALIZED; ++rule) {
        watcher all = {.calls = 0};
        svo_solid_options options = {
            .struct_size = sizeof options, .rule = (svo_solid_rule)rule, .progress = watch, .progress_user = &all};
        svo_solid_info infos[2] = {SVO_SOLID_INFO_INIT, SVO_SOLID_INFO_INIT};
        svo_compact *solid = NULL;
        assert_int_equal(svo_solid_create(tree.tree, &options, opened.queue, &solid, &infos[0]), SVO_OK);
        svo_compact_destroy(&solid);
        assert_true(all.last == 1.0);
        assert_true(all.calls >= (rule == SVO_SOLID_GENERALIZED ? 3 + DEPTH : 3));
        stop_at_each_call(&opened, tree.tree, options, all.calls);
        options.progress = NULL;
        assert_int_equal(svo_solid_create(tree.tree, &options, opened.queue, &solid, &infos[1]), SVO_OK);
        assert_memory_equal(&infos[0], &infos[1], sizeof infos[0]);
        svo_compact_destroy(&solid);
    }
    built_destroy(&tree);
    parts_free(&made);
}

TEST_GROUP(solid_generalized)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(in_the_plane_of_a_hole_all_is_ambiguous),
        cmocka_unit_test(a_mesh_that_is_turned_inside_out_is_empty),
        cmocka_unit_test(closed_parts_make_their_union),
        cmocka_unit_test(bowls_of_all_directions),
        cmocka_unit_test(soups_of_triangles),
        cmocka_unit_test(triangles_with_gaps_enclose),
        cmocka_unit_test(corners_of_holes_on_the_columns),
        cmocka_unit_test(solids_tell_their_progress_and_stop),
    };
    return cmocka_run_group_tests_name("solid_generalized", tests, fixture_group_setup, fixture_group_teardown);
}
