/* SPDX-License-Identifier: MIT */
/*
 * The catalog of ill-conditioned and extreme cases, by shape: closed forms (T2), needles (T3), pairs at large offsets
 * (T4), garbage (T8) and depths (T9), through the whole pipeline, with every coverage, against both exact references.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "hard_cases.h"
#include "support/compare_tree.h"
#include "support/meshes.h"
#include "support/suite.h"

/* Builds by OpenGL and by OpenCL, compares, and checks that both references agree. */
static void build_and_compare(const fixture *opened, const svo_mesh *mesh, unsigned depth,
                              const svo_plan_options *options)
{
    fixture by_cl = *opened;
    built actual;
    built same;
    exact expected;
    by_cl.frontend = opened->cl;
    fixture_build(opened, mesh, depth, options, &actual);
    fixture_build(&by_cl, mesh, depth, options, &same);
    exact_create(mesh, depth, options, &expected);
    assert_references_agree(&expected);
    assert_tree_is_exact(&actual, &expected);
    assert_string_equal(actual.hash, same.hash);
    exact_destroy(&expected);
    built_destroy(&same);
    built_destroy(&actual);
}

/* On a grid of this edge, snapping does not change coordinates up to depth 12. */
#define EDGE 0x1p20

static const svo_coverage coverages[] = {SVO_COVERAGE_HALF_OPEN, SVO_COVERAGE_CLOSED, SVO_COVERAGE_THIN};
enum { COVERAGES = sizeof coverages / sizeof coverages[0] };

static svo_mesh mesh_of(const double *positions, size_t triangle_count)
{
    return (svo_mesh){.struct_size = sizeof(svo_mesh),
                      .positions_double = positions,
                      .vertex_count = triangle_count * 3,
                      .triangle_count = triangle_count};
}

static void compare_all_coverages(const fixture *opened, const svo_mesh *mesh, unsigned depth, double edge)
{
    for (unsigned c = 0; c < COVERAGES; ++c) {
        const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = edge, .coverage = coverages[c]};
        build_and_compare(opened, mesh, depth, &options);
    }
}

/*
 * T2 closed forms.
 */

/* The two triangles of the square across axis at the given value, from 0 to the last unit. */
static void add_square(double *positions, unsigned axis, double value)
{
    static const double corners[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    for (size_t i = 0; i < 6; ++i) {
        positions[3 * i + axis] = value;
        positions[3 * i + (axis + 1) % 3] = corners[i][0] * (EDGE - 1.0);
        positions[3 * i + (axis + 2) % 3] = corners[i][1] * (EDGE - 1.0);
    }
}

static void assert_leaves(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_coverage coverage,
                          uint64_t expected)
{
    const svo_plan_options options = {.need = SVO_NEED_NONE, .edge = EDGE, .coverage = coverage};
    built actual;
    fixture_build(opened, mesh, depth, &options, &actual);
    if (actual.info.leaf_count != expected) {
        fail_msg("%s at depth %u: %llu voxels, not %llu", svo_name(SVO_NAME_COVERAGE, coverage), depth,
                 (unsigned long long)actual.info.leaf_count, (unsigned long long)expected);
    }
    built_destroy(&actual);
}

/* The hull of a cube with an edge of r voxels has 8 corners, 12 edges and 6 faces. */
static void t2_cube_hull_has_its_closed_form(void **state)
{
    double positions[6 * 18];
    const svo_mesh mesh = mesh_of(positions, 12);
    for (unsigned face = 0; face < 6; ++face) {
        add_square(positions + (size_t)18 * face, face % 3, face < 3 ? 0.0 : EDGE - 1.0);
    }
    for (unsigned depth = 1; depth <= 9; ++depth) {
        const uint64_t inner = (UINT64_C(1) << depth) - 2;
        const uint64_t hull = 8 + 12 * inner + 6 * inner * inner;
        assert_leaves(fixture_of_group(state), &mesh, depth, SVO_COVERAGE_HALF_OPEN, hull);
        assert_leaves(fixture_of_group(state), &mesh, depth, SVO_COVERAGE_CLOSED, hull);
    }
}

/* A square between two layers of voxels belongs to the upper layer, with closed coverage to both. */
static void t2_mid_plane_has_its_closed_form(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (unsigned axis = 0; axis < 3; ++axis) {
        double positions[18];
        const svo_mesh mesh = mesh_of(positions, 2);
        add_square(positions, axis, EDGE / 2);
        for (unsigned depth = 1; depth <= 9; ++depth) {
            const uint64_t layer = UINT64_C(1) << 2 * depth;
            assert_leaves(opened, &mesh, depth, SVO_COVERAGE_HALF_OPEN, layer);
            assert_leaves(opened, &mesh, depth, SVO_COVERAGE_CLOSED, 2 * layer);
            assert_leaves(opened, &mesh, depth, SVO_COVERAGE_THIN, layer);
        }
    }
}

/* One node per level; with closed coverage, a voxel corner has eight. */
static void t2_points_have_one_voxel_per_level(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static const double points[3][3] = {{123456, 7, EDGE - 1}, {0, 0, 0}, {EDGE / 2, EDGE / 2, EDGE / 2}};
    for (unsigned p = 0; p < 3; ++p) {
        double positions[9];
        const svo_mesh mesh = mesh_of(positions, 1);
        for (unsigned k = 0; k < 9; ++k) {
            positions[k] = points[p][k % 3];
        }
        for (unsigned depth = 1; depth <= 12; ++depth) {
            for (unsigned c = 0; c < COVERAGES; ++c) {
                const bool eight = p == 2 && coverages[c] == SVO_COVERAGE_CLOSED;
                assert_leaves(opened, &mesh, depth, coverages[c], eight ? 8 : 1);
            }
        }
    }
}

/*
 * T3 needles. Coordinates in voxels of a grid of 64^3.
 */

/* Modeled on the conformance shapes of Direct3D's conservative rasterization: needles across pixels, triangles smaller
   than a pixel at every position in it, edges that pass a corner at a distance of 1/1024 on either side. */
static void t3_conformance_shapes_are_exact(void **state)
{
    static const double shapes[][9] = {
        {1, 1, 1, 60, 1, 1, 60, 1.0009765625, 1}, /* along an axis, on a face of voxels */
        {1, 1, 1, 60, 31, 47, 60, 31.0009765625, 47},
        {3.5, 3.5, 3.5, 3.5009765625, 3.5, 3.5, 3.5, 50.5, 3.5},
        {0, 0, 0, 63, 63, 63, 63, 63, 62.9990234375}, /* the diagonal, through voxel corners */
        {5, 5, 5, 5.0009765625, 5, 5, 5, 5.0009765625, 5.0009765625}, /* much smaller than a voxel, at a corner */
        {4.9990234375, 4.9990234375, 4.9990234375, 5.0009765625, 5, 5, 5, 5.0009765625, 4.9990234375},
        {10, 10, 10.5, 20, 10, 10.5, 10, 20, 10.5}, /* edges on the borders of pixels */
        {10, 10, 20, 20, 10, 10, 10, 20, 10}, /* x + y + z = 40 through voxel corners */
    };
    const fixture *opened = fixture_of_group(state);
    double positions[sizeof shapes / sizeof shapes[0] * 27 * 9];
    size_t count = 0;
    for (size_t s = 0; s < sizeof shapes / sizeof shapes[0]; ++s) {
        /* None, one or two steps of 1/1024 along each axis. */
        for (unsigned offset = 0; offset < 27; ++offset, ++count) {
            const unsigned counts[3] = {offset % 3, offset / 3 % 3, offset / 9};
            const double steps[3] = {counts[0] / 1024.0, counts[1] / 1024.0, counts[2] / 1024.0};
            for (unsigned k = 0; k < 9; ++k) {
                positions[count * 9 + k] = shapes[s][k] + steps[k % 3];
            }
        }
    }
    const svo_mesh mesh = mesh_of(positions, count);
    compare_all_coverages(opened, &mesh, 6, 64.0);
}

/* From a hundred to a hundred million times as long as wide. */
static void t3_slivers_of_any_aspect_are_exact(void **state)
{
    enum { PER_ASPECT = 40 };
    const fixture *opened = fixture_of_group(state);
    const uint64_t seed = 20240301;
    uint64_t random = seed;
    print_message("seed %llu\n", (unsigned long long)seed);
    double positions[7 * PER_ASPECT * 9];
    size_t count = 0;
    double aspect = 1e2;
    for (unsigned power = 2; power <= 8; ++power, aspect *= 10.0) {
        for (unsigned i = 0; i < PER_ASPECT; ++i, ++count) {
            double *corners = positions + count * 9;
            const double along = random_unit(&random);
            for (unsigned axis = 0; axis < 3; ++axis) {
                corners[axis] = random_unit(&random);
                corners[3 + axis] = random_unit(&random);
                const double inside = corners[axis] + along * (corners[3 + axis] - corners[axis]);
                corners[6 + axis] = fmin(fmax(inside + (random_unit(&random) - 0.5) / aspect, 0.0), 1.0);
            }
        }
    }
    const svo_mesh mesh = mesh_of(positions, count);
    compare_all_coverages(opened, &mesh, 8, 0.0);
    compare_all_coverages(opened, &mesh, 4, 0.0);
}

/* A needle through a point of the unit cube, with ends up to reach beyond the cube. The third corner lies on or near
   the segment between the others. */
static void needle_through_cube(uint64_t *random, double reach, double *corners)
{
    static const double widths[] = {0.0, 1e-7, 1e-5};
    const double width = widths[random_below(random, 3)];
    const double ahead = random_unit(random);
    const double along = random_unit(random);
    for (unsigned axis = 0; axis < 3; ++axis) {
        const double through = random_unit(random);
        corners[axis] = random_unit(random) * (1.0 + 2.0 * reach) - reach;
        corners[3 + axis] = through + (through - corners[axis]) * ahead;
        const double inside = corners[axis] + along * (corners[3 + axis] - corners[axis]);
        corners[6 + axis] = inside + (random_unit(random) - 0.5) * width;
    }
}

/* Needles are drawn as bands. These cross the deepest grids and reach far outside them. */
static void t3_needles_across_deep_grids_are_exact(void **state)
{
    enum { NEEDLES = 3 };
    static const double reaches[] = {0.0, 0.5, 15.0};
    static const unsigned depths[] = {11, 14, 16};
    const fixture *opened = fixture_of_group(state);
    const uint64_t seed = 20240302;
    uint64_t random = seed;
    print_message("seed %llu\n", (unsigned long long)seed);
    for (unsigned d = 0; d < 3; ++d) {
        for (unsigned r = 0; r < 3; ++r) {
            double positions[NEEDLES * 9];
            const svo_mesh mesh = mesh_of(positions, NEEDLES);
            for (unsigned i = 0; i < NEEDLES; ++i) {
                needle_through_cube(&random, reaches[r], positions + (size_t)i * 9);
            }
            const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = 1.0, .coverage = coverages[r]};
            build_and_compare(opened, &mesh, depths[d], &options);
        }
    }
}

/*
 * T4 pairs, far from the origin: the tree of the mesh is exact.
 */
static void t4_meshes_at_any_offset_are_exact(void **state)
{
    static const double offsets[] = {0, 1e3, 0x1p16, 0x1p20, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof offsets / sizeof offsets[0]; ++i) {
        owned_mesh made;
        random_mesh(400 + i, 300, 0.0, &made);
        for (size_t k = 0; k < made.mesh.vertex_count * 3; ++k) {
            made.positions[k] += offsets[i];
        }
        const svo_plan_options options = {
            .struct_size = sizeof options, .need = SVO_NEED_RAYS, .coverage = coverages[i % COVERAGES]};
        print_message("offset %g: seed %zu\n", offsets[i], 400 + i);
        build_and_compare(opened, &made.mesh, 7, &options);
        owned_mesh_free(&made);
    }
}

/*
 * T8 garbage.
 */

enum { GARBAGE_VERTICES = 240, GARBAGE_TRIANGLES = 400 };

static float garbage_float(uint64_t *random, uint32_t share)
{
    static const float odd[] = {NAN, INFINITY, -INFINITY, -0.0F, 1e-45F, -1e-39F, 1e38F, -3e38F};
    if (random_below(random, share) == 0) {
        return odd[random_below(random, 8)];
    }
    return (float)random_unit(random);
}

/* Refused and counted, or exact; repeated builds agree. */
static void check_garbage(const fixture *opened, const svo_mesh *mesh, const svo_plan_options *options)
{
    built first;
    built second;
    fixture_build(opened, mesh, 6, options, &first);
    fixture_build(opened, mesh, 6, options, &second);
    assert_string_equal(first.hash, second.hash);
    assert_int_equal(first.info.refused_triangles, second.info.refused_triangles);
    built_destroy(&second);
    built_destroy(&first);
    build_and_compare(opened, mesh, 6, options);
}

static void t8_garbage_is_refused_and_counted_or_exact(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        print_message("seed %llu\n", (unsigned long long)seed);
        static float positions[GARBAGE_VERTICES * 3];
        static uint32_t indices[GARBAGE_TRIANGLES * 3];
        uint64_t random = seed;
        for (size_t i = 0; i < GARBAGE_VERTICES * 3; ++i) {
            positions[i] = garbage_float(&random, seed % 3 == 0 ? 4 : 60);
        }
        for (size_t i = 0; i < GARBAGE_TRIANGLES * 3; ++i) { /* some are out of range, some triangles occur twice */
            indices[i] =
                random_below(&random, 50) == 0 ? random_word(&random) : random_below(&random, GARBAGE_VERTICES);
            indices[i] = i >= 3 && i / 3 % 10 == 9 ? indices[i - 3] : indices[i];
        }
        const svo_mesh mesh = {.struct_size = sizeof mesh,
                               .positions = positions,
                               .vertex_count = GARBAGE_VERTICES,
                               .indices = indices,
                               .triangle_count = GARBAGE_TRIANGLES};
        for (unsigned c = 0; c < COVERAGES; ++c) {
            check_garbage(opened, &mesh, &(svo_plan_options){.need = SVO_NEED_RAYS, .coverage = coverages[c]});
            check_garbage(opened, &mesh,
                          &(svo_plan_options){.need = SVO_NEED_RAYS, .coverage = coverages[c], .edge = 1.0});
        }
    }
}

/* A mesh whose extent overflows a double is refused with a message. */
static void t8_an_extent_beyond_doubles_is_refused(void **state)
{
    static const double positions[9] = {-1.7e308, 0, 0, 1.7e308, 0, 0, 0, 1, 0};
    const fixture *opened = fixture_of_group(state);
    const svo_mesh mesh = mesh_of(positions, 1);
    svo_plan *plan = NULL;
    assert_int_equal(svo_plan_create(opened->device, &mesh, 5, NULL, &plan), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "edge inf"));
    assert_null(plan);
}

/*
 * T9 depths.
 */

/* Needles of up to a thousand voxels, and triangles of a few voxels at the depth, of some dozens, and of a hundred,
   whose units are the coarsest. */
static void make_for_depth(uint64_t seed, unsigned depth, owned_mesh *out)
{
    enum { COUNT = 60, NEEDLES = 6 };
    uint64_t random = seed;
    random_mesh(seed, COUNT, 0.0, out);
    for (size_t t = 0; t < COUNT; ++t) {
        double *corners = out->positions + t * 9;
        const double extent = ldexp(t % 20 == 19 ? 120.0 : t % 3 == 0 ? 40.0 : 3.0, -(int)depth);
        for (unsigned k = 0; k < 9; ++k) {
            const double start = k < 3 ? random_unit(&random) : corners[k % 3];
            corners[k] = fmin(fmax(start + (random_unit(&random) - 0.5) * extent, 0.0), 1.0);
        }
        for (unsigned axis = 0; axis < 3 && t < NEEDLES; ++axis) {
            const double other = random_unit(&random);
            corners[3 + axis] =
                depth <= 10 ? other : corners[axis] + (other - corners[axis]) * ldexp(1.0, 10 - (int)depth);
        }
        for (unsigned corner = 0; corner < 3; ++corner) {
            out->indices[t * 3 + corner] = (uint32_t)(t * 3 + corner);
        }
    }
}

static void t9_every_depth_is_exact(void **state)
{
    static const unsigned depths[] = {1, 2, 10, 11, 12, 13, 14, 15, 16};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof depths / sizeof depths[0]; ++i) {
        print_message("depth %u, seed %u\n", depths[i], depths[i]);
        owned_mesh made;
        make_for_depth(depths[i], depths[i], &made);
        compare_all_coverages(opened, &made.mesh, depths[i], 0.0);
        compare_all_coverages(opened, &made.mesh, depths[i], 0.75);
        owned_mesh_free(&made);
    }
}

static void t9_depths_0_and_17_are_refused(void **state)
{
    static const double positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const char *const words[] = {"svo_plan_create: depth 0 is not in 1 .. 16",
                                        "svo_plan_create: depth 17 is not in 1 .. 16"};
    const fixture *opened = fixture_of_group(state);
    const svo_mesh mesh = mesh_of(positions, 1);
    for (unsigned i = 0; i < 2; ++i) {
        svo_plan *plan = NULL;
        assert_int_equal(svo_plan_create(opened->device, &mesh, i * 17, NULL, &plan), SVO_INVALID_ARGUMENT);
        assert_string_equal(svo_device_message(opened->device), words[i]);
        assert_null(plan);
    }
}

/* Every kind of hard triangle, on each of the spaces: edges that are no powers of two, origins far away. */
static void t4_hard_triangles_are_exact(void **state)
{
    enum { TRIANGLES = 60 };
    hard_cases_seed(47);
    for (int kind = 0; kind < HARD_KINDS; ++kind) {
        for (size_t space = 0; space < HARD_SPACES; ++space) {
            double positions[TRIANGLES * 9];
            hard_case s;
            hard_case_make((hard_kind)kind, space, &s);
            s.space.depth = s.space.depth % 6 + 1;
            for (size_t t = 0; t < TRIANGLES; ++t) {
                for (unsigned axis = 0; axis < 3; ++axis) {
                    s.cell[axis] = hard_between(0, (1 << s.space.depth) - 1);
                }
                hard_case_fill((hard_kind)kind, &s);
                memcpy(positions + t * 9, s.triangle.vertices, sizeof s.triangle.vertices);
            }
            print_message("%s, space %zu\n", hard_kind_name((hard_kind)kind), space);
            const svo_mesh mesh = mesh_of(positions, TRIANGLES);
            svo_plan_options options = {
                .need = SVO_NEED_RAYS, .coverage = coverages[((size_t)kind + space) % COVERAGES], .edge = s.space.edge};
            memcpy(options.origin, s.space.origin, sizeof options.origin);
            build_and_compare(fixture_of_group(state), &mesh, s.space.depth, &options);
        }
    }
}

/* Edges that rise above a plane between voxels for as long as it takes to a voxel's corner, by the coordinate of one
   end below the last unit that is looked at, which rounds to odd whoever decides. */
static void t4_bits_below_the_last_unit_round_to_odd(void **state)
{
    enum { DEPTH = 12, TRIANGLES = 6 };
    double positions[TRIANGLES * 9];
    for (size_t t = 0; t < TRIANGLES; ++t) {
        const double low = ldexp(-1.0, t < 3 ? -77 : -74);
        const double corners[3][3] = {{0.0, ldexp(1.0, -65), 0.25}, {1.0, low, 0.25}, {1.0, ldexp(-1.5, -DEPTH), 0.25}};
        for (size_t i = 0; i < 9; ++i) {
            positions[t * 9 + i] = corners[i / 3][(i + t) % 3];
        }
    }
    const svo_mesh mesh = mesh_of(positions, TRIANGLES);
    for (size_t c = 0; c < COVERAGES; ++c) {
        const svo_plan_options options = {.need = SVO_NEED_RAYS, .coverage = coverages[c], .edge = 1.0};
        build_and_compare(fixture_of_group(state), &mesh, DEPTH, &options);
    }
}

TEST_GROUP(numerics_shapes)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t2_cube_hull_has_its_closed_form),
        cmocka_unit_test(t2_mid_plane_has_its_closed_form),
        cmocka_unit_test(t2_points_have_one_voxel_per_level),
        cmocka_unit_test(t3_conformance_shapes_are_exact),
        cmocka_unit_test(t3_slivers_of_any_aspect_are_exact),
        cmocka_unit_test(t3_needles_across_deep_grids_are_exact),
        cmocka_unit_test(t4_meshes_at_any_offset_are_exact),
        cmocka_unit_test(t4_hard_triangles_are_exact),
        cmocka_unit_test(t4_bits_below_the_last_unit_round_to_odd),
        cmocka_unit_test(t8_garbage_is_refused_and_counted_or_exact),
        cmocka_unit_test(t8_an_extent_beyond_doubles_is_refused),
        cmocka_unit_test(t9_every_depth_is_exact),
        cmocka_unit_test(t9_depths_0_and_17_are_refused),
    };
    return cmocka_run_group_tests_name("numerics_shapes", tests, fixture_group_setup, fixture_group_teardown);
}
