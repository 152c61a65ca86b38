/* SPDX-License-Identifier: MIT */
/*
 * Built trees equal the exact ones: nodes and leaf lists against the oracle for scenes, random and degenerate meshes,
 * fitted and caller's grids, at every depth; and trees that are known in closed form.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "support/compare_tree.h"
#include "support/meshes.h"
#include "support/suite.h"

static const svo_plan_options with_lists = {.need = SVO_NEED_RAYS};

static void check_mesh(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options)
{
    built actual;
    fixture_build(opened, mesh, depth, options, &actual);
    assert_build_is_exact(mesh, options, &actual);
    built_destroy(&actual);
}

static void scenes_are_exact(void **state)
{
    static const struct {
        const char *spec;
        unsigned depths[3];
    } cases[] = {{"atrium", {3, 6, 8}},        {"statue:20000", {5, 8, 9}},     {"knot:5000", {4, 7, 9}},
                 {"terrain:20000", {5, 7, 9}}, {"needles:2000", {4, 7, 9}},     {"dust:20000", {2, 6, 9}},
                 {"cornell", {4, 7, 8}},       {"statue:120000:2", {7, 8, 10}}, {"cube", {1, 5, 8}}};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        scene *made = fixture_scene(cases[i].spec);
        for (unsigned k = 0; k < 3; ++k) {
            print_message("%s at depth %u\n", cases[i].spec, cases[i].depths[k]);
            check_mesh(opened, scene_mesh(made), cases[i].depths[k], &with_lists);
        }
        scene_destroy(&made);
    }
}

static void all_depths_are_exact(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = fixture_scene("knot:1000");
    for (unsigned depth = SVO_DEPTH_MIN; depth <= 9; ++depth) {
        check_mesh(opened, scene_mesh(made), depth, &with_lists);
    }
    scene_destroy(&made);
    owned_mesh few;
    random_mesh(12, 12, 0.0, &few);
    for (unsigned depth = SVO_DEPTH_MIN; depth <= SVO_DEPTH_MAX; ++depth) {
        /* Large meshes touch millions of voxels at the last depths; small ones suffice there. */
        few.mesh.triangle_count = depth <= 10 ? 12 : 3;
        /* Beyond depth 12 the grid grows, but not the number of voxels. */
        const double edge = depth <= 12 ? 0.0 : ldexp(1.0, (int)depth - 12);
        check_mesh(opened, &few.mesh, depth, &(svo_plan_options){.need = SVO_NEED_RAYS, .edge = edge});
    }
    owned_mesh_free(&few);
}

static void random_meshes_are_exact(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 1; seed <= 24; ++seed) {
        const unsigned depth = 1 + (unsigned)(seed % 8);
        print_message("seed %llu at depth %u\n", (unsigned long long)seed, depth);
        owned_mesh made;
        random_mesh(seed, seed % 5 == 0 ? 1 + (size_t)seed : 400, 0.0, &made);
        check_mesh(opened, &made.mesh, depth, &with_lists);
        check_mesh(opened, &made.mesh, depth, &(svo_plan_options){.need = SVO_NEED_RAYS, .edge = 1.0});
        owned_mesh_free(&made);
    }
}

static void needles_are_exact(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (unsigned depth = 3; depth <= 10; ++depth) {
        owned_mesh made;
        random_needles(depth, 600, &made);
        check_mesh(opened, &made.mesh, depth, &with_lists);
        owned_mesh_free(&made);
    }
}

/* Triangles that reach far outside the caller's grid, up to the largest allowed coordinate and beyond. */
static void meshes_larger_than_the_grid_are_exact(void **state)
{
    static const double reaches[] = {0.01, 0.5, 3.0, 40.0, 250.0, 500.0, 800.0};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof reaches / sizeof reaches[0]; ++i) {
        for (uint64_t seed = 1; seed <= 3; ++seed) {
            print_message("reach %g, seed %llu\n", reaches[i], (unsigned long long)seed);
            owned_mesh made;
            random_mesh(seed * 100 + i, 150, reaches[i], &made);
            const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = 1.0};
            check_mesh(opened, &made.mesh, 3 + (unsigned)(seed + i) % 5, &options);
            owned_mesh_free(&made);
        }
    }
}

/* Corners at the last allowed unit and at the first refused one, and bounds that just miss the grid. */
static void coordinates_are_accepted_up_to_the_documented_limit(void **state)
{
    enum { EDGE = 1 << 20, FAR = 1 << 29 };
    static const struct {
        double corners[9];
        unsigned refused, outside;
    } cases[] = {
        {{1.0 - FAR, 1.0 - FAR, 7, FAR - 1.0, FAR - 1.0, 9, 5, FAR - 1.0, EDGE - 5.0}, 0, 0},
        {{0.5 - FAR, 1.5 - FAR, 7, FAR - 0.5, FAR - 1.5, 9, 5, FAR - 0.5, EDGE - 5.0}, 0, 0},
        {{-FAR, 0, 0, 1000, 0, 0, 0, 1000, 0}, 1, 0},
        {{0, FAR, 0, 1000, 0, 0, 0, 1000, 0}, 1, 0},
        {{0, 0, 1e300, 1000, 0, 0, 0, 1000, 0}, 1, 0},
        {{EDGE, 0, 0, 1e300, 0, 0, EDGE, 1000, 0}, 0, 1},
        {{-1, 0, 0, -1e300, 0, 0, -1, 1000, 0}, 0, 1},
        {{-0x1p-60, 0, 0, -9, 0, 0, -8, 1000, 0}, 0, 1},
        {{0, 0, 0, -9, 0, 0, -8, 1000, 0}, 0, 0},
        {{0, EDGE - 0x1p-30, 0, 9, EDGE, 0, 8, EDGE + 9.0, 4}, 0, 0},
        {{0, EDGE, 0, 9, EDGE, 0, 8, EDGE + 9.0, 4}, 0, 1},
    };
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = EDGE};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        print_message("case %zu\n", i);
        const svo_mesh mesh = {
            .struct_size = sizeof mesh, .positions_double = cases[i].corners, .vertex_count = 3, .triangle_count = 1};
        built actual;
        fixture_build(opened, &mesh, 7, &options, &actual);
        assert_int_equal(actual.info.refused_triangles, cases[i].refused);
        assert_int_equal(actual.plan.refused_triangles, cases[i].refused);
        assert_int_equal(actual.plan.outside_triangles, cases[i].outside);
        assert_int_equal(actual.info.leaf_count > 0, cases[i].refused + cases[i].outside == 0);
        assert_build_is_exact(&mesh, &options, &actual);
        built_destroy(&actual);
    }
}

/* The codes of a tree's leaves, allocated by malloc. */
static uint64_t *leaf_codes(const built *tree)
{
    uint64_t *codes = malloc((tree->info.leaf_count + 1) * sizeof *codes);
    assert_non_null(codes);
    assert_true(oracle_leaf_codes(tree->arrays.child_mask, tree->info.inner_count, tree->info.depth,
                                  tree->info.leaf_count, codes));
    return codes;
}

/* Whether whole's leaves from *leaf on, those of one octant, equal those of part, with the same triangles. Advances
   *leaf past them. */
static void assert_octant_is(const built *whole, const uint64_t *whole_codes, unsigned octant, const built *part,
                             size_t *leaf)
{
    uint64_t *codes = leaf_codes(part);
    const uint64_t base = (uint64_t)octant << 3 * part->info.depth;
    for (size_t k = 0; k < part->info.leaf_count; ++k, ++*leaf) {
        assert_in_range(*leaf, 0, whole->info.leaf_count - 1);
        assert_int_equal(whole_codes[*leaf], base | codes[k]);
        const uint32_t *a = whole->arrays.list_begin + *leaf;
        const uint32_t *b = part->arrays.list_begin + k;
        assert_int_equal(a[1] - a[0], b[1] - b[0]);
        for (uint32_t i = 0; i < a[1] - a[0]; ++i) {
            assert_int_equal(whole->arrays.triangle_ids[whole->arrays.list[a[0] + i]],
                             part->arrays.triangle_ids[part->arrays.list[b[0] + i]]);
        }
    }
    free(codes);
}

/* Eight adjacent grids together equal the one grid of twice the edge: no voxel is duplicated or lost. Corners lie on
   the large grid's units, which are two units of the small ones. */
static void abutting_grids_partition_the_scene(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const unsigned depth = 6;
    owned_mesh made;
    random_mesh(77, 500, 0.2, &made);
    for (size_t i = 0; i < made.mesh.vertex_count * 3; ++i) {
        made.positions[i] = rint(made.positions[i] * 0x1p20) * 0x1p-20;
    }
    built whole;
    fixture_build(opened, &made.mesh, depth + 1, &(svo_plan_options){.need = SVO_NEED_RAYS, .edge = 1.0}, &whole);
    uint64_t *codes = leaf_codes(&whole);
    size_t leaf = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
        const svo_plan_options options = {
            .need = SVO_NEED_RAYS,
            .edge = 0.5,
            .origin = {octant & 1 ? 0.5 : 0.0, octant & 2 ? 0.5 : 0.0, octant & 4 ? 0.5 : 0.0}};
        built part;
        fixture_build(opened, &made.mesh, depth, &options, &part);
        assert_octant_is(&whole, codes, octant, &part, &leaf);
        built_destroy(&part);
    }
    assert_int_equal(leaf, whole.info.leaf_count);
    free(codes);
    built_destroy(&whole);
    owned_mesh_free(&made);
}

static void trees_nest(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = fixture_scene("statue:20000");
    built deep;
    fixture_build(opened, scene_mesh(made), 10, &(svo_plan_options){.need = SVO_NEED_NONE}, &deep);
    for (unsigned depth = 1; depth < 10; depth += depth < 5 ? 2 : 1) {
        built shallow;
        fixture_build(opened, scene_mesh(made), depth, &(svo_plan_options){.need = SVO_NEED_NONE}, &shallow);
        assert_memory_equal(shallow.info.level_begin, deep.info.level_begin, (depth + 2) * sizeof(uint32_t));
        assert_memory_equal(shallow.arrays.child_mask, deep.arrays.child_mask, shallow.info.inner_count);
        assert_memory_equal(shallow.arrays.first_child, deep.arrays.first_child, shallow.info.inner_count * 4);
        built_destroy(&shallow);
    }
    built_destroy(&deep);
    scene_destroy(&made);
}

/* Points and segments alone, so that the mesh's bounds are flat, a line or a point too. */
static void degenerate_triangles_are_exact(void **state)
{
    static const struct {
        double corners[9];
        uint64_t leaves; /* at depth 5 */
    } cases[] = {
        {{3, 4, 5, 3, 4, 5, 3, 4, 5}, 1},     {{-7, 2, 2, 9, 2, 2, -7, 2, 2}, 32},
        {{0, 0, 0, 8, 8, 8, 4, 4, 4}, 32},    {{0, 0, 0, 0, 8, 0, 0, 0, 8}, 0},
        {{1, 2, 3, 9, 2, 3, 5, 2, 3}, 32},    {{0, 0, 1e-300, 0, 0, 0, 0, 0, 0}, 0},
        {{0, 0, 1, 0, 0, 3, 1e-9, 0, 2}, 32},
    };
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        print_message("case %zu\n", i);
        const svo_mesh mesh = {
            .struct_size = sizeof mesh, .positions_double = cases[i].corners, .vertex_count = 3, .triangle_count = 1};
        for (unsigned depth = 1; depth <= 8; ++depth) {
            built actual;
            fixture_build(opened, &mesh, depth, &with_lists, &actual);
            assert_build_is_exact(&mesh, &with_lists, &actual);
            if (depth == 5 && cases[i].leaves > 0) {
                assert_int_equal(actual.info.leaf_count, cases[i].leaves);
            }
            built_destroy(&actual);
        }
    }
}

/* A tree with only a root of mask 0, for any requested attributes. */
static void assert_empty(const fixture *opened, const svo_mesh *mesh, const svo_plan_options *grid, uint64_t refused)
{
    static const uint32_t needs[] = {SVO_NEED_DEFAULT, SVO_NEED_NONE, SVO_NEED_COLOR,
                                     SVO_NEED_NORMAL,  SVO_NEED_RAYS, SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS};
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        svo_plan_options options = grid != NULL ? *grid : (svo_plan_options){0};
        options.need = needs[i];
        const unsigned depth = 1 + 2 * (unsigned)i;
        built actual;
        fixture_build(opened, mesh, depth, &options, &actual);
        assert_int_equal(actual.info.node_count, 1);
        assert_int_equal(actual.info.inner_count, 1);
        assert_int_equal(actual.info.leaf_count, 0);
        assert_int_equal(actual.info.list_count, 0);
        assert_int_equal(actual.info.fragments, 0);
        assert_int_equal(actual.info.triangles, mesh->triangle_count);
        assert_int_equal(actual.info.refused_triangles, refused);
        assert_int_equal(actual.arrays.child_mask[0], 0);
        assert_int_equal(actual.arrays.first_child[0], 1);
        assert_int_equal(actual.info.level_begin[0], 0);
        for (unsigned level = 1; level <= depth + 1; ++level) {
            assert_int_equal(actual.info.level_begin[level], 1);
        }
        if ((options.need & SVO_NEED_COLOR) != 0) {
            assert_memory_equal(actual.arrays.colors, "\0\0\0", 4);
        }
        if ((options.need & SVO_NEED_NORMAL) != 0) {
            assert_memory_equal(actual.arrays.normals, "\0\0\0\0\0", 6);
        }
        if ((options.need & SVO_NEED_RAYS) != 0) {
            assert_int_equal(actual.arrays.list_begin[0], 0);
        }
        built_destroy(&actual);
    }
}

static void a_mesh_without_triangles_gives_an_empty_tree(void **state)
{
    static const float position[3] = {1, 2, 3};
    const fixture *opened = fixture_of_group(state);
    svo_mesh mesh = {.struct_size = sizeof mesh};
    assert_empty(opened, &mesh, NULL, 0);
    mesh.positions = position;
    mesh.vertex_count = 1;
    assert_empty(opened, &mesh, NULL, 0);
    assert_empty(opened, &mesh, &(svo_plan_options){.edge = 4.0}, 0);
}

/* NaN, infinities, indices out of range; also triangles outside the grid, which are not refused. */
static void a_mesh_of_refused_triangles_gives_an_empty_tree(void **state)
{
    static const float positions[] = {NAN, 0, 0, 1, 0, 0, 0, 1, 0, 0, -INFINITY, 0, 0, 0, INFINITY};
    static const uint32_t indices[] = {0, 1, 2, 1, 2, 3, 4, 1, 2, 1, 2, 5, UINT32_MAX, 1, 2, 0, 3, 4};
    static const uint8_t colors[20] = {1, 2, 3, 4, 5};
    static const float normals[15] = {1, 0, 0, 0, 1, 0};
    const fixture *opened = fixture_of_group(state);
    svo_mesh mesh = {.struct_size = sizeof mesh,
                     .positions = positions,
                     .vertex_count = 5,
                     .indices = indices,
                     .triangle_count = 6,
                     .normals = normals,
                     .colors = colors};
    assert_empty(opened, &mesh, NULL, 6);
    assert_empty(opened, &mesh, &(svo_plan_options){.edge = 4.0}, 6);
    mesh.indices = NULL; /* the first triangle has a NaN, the others too few vertices */
    assert_empty(opened, &mesh, NULL, 6);
    static const uint32_t good[] = {1, 2, 1, 0, 1, 2};
    mesh.indices = good;
    mesh.triangle_count = 2;
    assert_empty(opened, &mesh, &(svo_plan_options){.edge = 4.0, .origin = {9, 9, 9}}, 1);
    check_mesh(opened, &mesh, 6, &with_lists);
}

/* One in ten triangles is bad, for varying reasons. The others, except for their ids, build the same tree as without
   it. */
static void bad_triangles_do_not_disturb_the_others(void **state)
{
    const fixture *opened = fixture_of_group(state);
    owned_mesh made;
    random_mesh(5, 1000, 0.0, &made);
    for (size_t t = 0; t < 1000; t += 10) {
        if (t % 20 == 0) {
            made.indices[t * 3 + t / 20 % 3] = UINT32_MAX - (uint32_t)t;
        } else {
            made.positions[t * 9 + t % 7] = t % 3 == 0 ? NAN : t % 3 == 1 ? INFINITY : -INFINITY;
        }
    }
    built actual;
    fixture_build(opened, &made.mesh, 7, &with_lists, &actual);
    assert_in_range(actual.info.refused_triangles, 90, 300); /* some corners are shared, some unused */
    assert_build_is_exact(&made.mesh, &with_lists, &actual);
    built_destroy(&actual);
    owned_mesh_free(&made);
}

static double total_ms(const svo_build_report *report)
{
    double ms = 0.0;
    for (int stage = 0; stage < SVO_STAGE_COUNT; ++stage) {
        ms += stage == SVO_STAGE_COMPILE ? 0.0 : report->stage_times[stage].ms;
    }
    return ms;
}

/* Many tiny triangles in one voxel: the list holds every triangle, in order. */
static void one_leaf_holds_very_many_triangles(void **state)
{
    static const size_t counts[] = {31, 32, 33, 63, 64, 65, 4096, 100000, 1000000};
    static const double corner[3] = {0.501, 0.251, 0.751};
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_RAYS | SVO_NEED_COLOR | SVO_NEED_NORMAL, .edge = 1.0};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        owned_mesh made;
        random_dust(i, counts[i], corner, 0.01, &made);
        built actual;
        fixture_build(opened, &made.mesh, 6, &options, &actual);
        print_message("%zu triangles in one leaf: %.1f ms\n", counts[i], total_ms(&actual.report));
        assert_int_equal(actual.info.leaf_count, 1);
        assert_int_equal(actual.info.list_count, counts[i]);
        assert_int_equal(actual.arrays.list_begin[0], 0);
        assert_int_equal(actual.arrays.list_begin[1], counts[i]);
        for (size_t k = 0; k < counts[i]; ++k) {
            assert_int_equal(actual.arrays.list[k], k);
            assert_int_equal(actual.arrays.triangle_ids[k], k);
        }
        built_destroy(&actual);
        owned_mesh_free(&made);
    }
}

/* Long and short lists over many triangles, so that the sort processes all its digits. */
static void lists_of_all_lengths_are_sorted(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = fixture_scene("dust:300000");
    for (unsigned depth = 1; depth <= 7; depth += 2) {
        check_mesh(opened, scene_mesh(made), depth, &with_lists);
    }
    scene_destroy(&made);
}

TEST_GROUP(build)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_are_exact),
        cmocka_unit_test(all_depths_are_exact),
        cmocka_unit_test(random_meshes_are_exact),
        cmocka_unit_test(needles_are_exact),
        cmocka_unit_test(meshes_larger_than_the_grid_are_exact),
        cmocka_unit_test(coordinates_are_accepted_up_to_the_documented_limit),
        cmocka_unit_test(abutting_grids_partition_the_scene),
        cmocka_unit_test(trees_nest),
        cmocka_unit_test(degenerate_triangles_are_exact),
        cmocka_unit_test(a_mesh_without_triangles_gives_an_empty_tree),
        cmocka_unit_test(a_mesh_of_refused_triangles_gives_an_empty_tree),
        cmocka_unit_test(bad_triangles_do_not_disturb_the_others),
        cmocka_unit_test(one_leaf_holds_very_many_triangles),
        cmocka_unit_test(lists_of_all_lengths_are_sorted),
    };
    return cmocka_run_group_tests_name("build", tests, fixture_group_setup, fixture_group_teardown);
}
