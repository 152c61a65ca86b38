/* SPDX-License-Identifier: MIT */
/*
 * Tests the reference for grid and snap: against the definition in doubles, against exact products by fma, on ties and
 * signs computed by hand, and on accepted and refused triangles. Seeds are fixed and printed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "oracle.h"
#include "support/suite.h"

#define SNAP_BITS 20

static uint64_t next_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return *state >> 33;
}

/* A double of either sign, its exponent between 2^-bits and 2^bits. */
static double random_double(uint64_t *state, int bits)
{
    double significand = (double)(next_random(state) << 22 ^ next_random(state)) + 1;
    double value = ldexp(significand, (int)(next_random(state) % (unsigned)(2 * bits + 1)) - bits - 53);

    return next_random(state) & 1 ? -value : value;
}

/* The documented definition in C; the tests are compiled without contraction. */
static double snap_in_doubles(const oracle_grid *grid, double value, int axis)
{
    double offset = value - grid->origin[axis];
    double product = offset * grid->scale;

    return rint(product);
}

static void snap_equals_the_definition_in_doubles(void **state)
{
    uint64_t seed = 77, refused_count = 0;

    (void)state;
    print_message("seed %llu\n", (unsigned long long)seed);
    for (int i = 0; i < 300000; i++) {
        int bits = i % 3 == 0 ? 3 : i % 3 == 1 ? 30 : 300;
        const double origin[3] = {random_double(&seed, bits), random_double(&seed, bits), random_double(&seed, bits)};
        double edge = fabs(random_double(&seed, bits)), position[3], expected[3];
        oracle_grid grid;
        int32_t snapped[3] = {0, 0, 0};
        bool is_near = true;

        assert_true(oracle_grid_given(origin, edge, SNAP_BITS, &grid));
        for (int k = 0; k < 3; k++) {
            position[k] = i & 1 ? random_double(&seed, bits) : origin[k] + edge * random_double(&seed, 4);
            expected[k] = snap_in_doubles(&grid, position[k], k);
            is_near = is_near && fabs(expected[k]) < 0x1p29;
        }
        assert_int_equal(oracle_snap(&grid, position, snapped), is_near);
        for (int k = 0; is_near && k < 3; k++)
            assert_int_equal(snapped[k], (int32_t)expected[k]);
        refused_count += !is_near;
    }
    assert_in_range(refused_count, 1000, 200000);
}

/* With edge 2^20 the scale is 1: halves round to the even neighbor. */
static void ties_go_to_even(void **state)
{
    const double origin[3] = {0, 0, 0}, values[] = {0.5, 1.5, 2.5, -0.5, -1.5, -2.5, 2.5000000000000004, -0.0, 5e-324};
    const int32_t expected[] = {0, 2, 2, 0, -2, -2, 3, 0, 0};
    oracle_grid grid;

    (void)state;
    assert_true(oracle_grid_given(origin, 0x1p20, SNAP_BITS, &grid));
    assert_true(grid.scale == 1);
    for (size_t i = 0; i < sizeof(values) / sizeof(values[0]); i++) {
        const double position[3] = {values[i], 0, values[i]};
        int32_t snapped[3];

        assert_true(oracle_snap(&grid, position, snapped));
        assert_int_equal(snapped[0], expected[i]);
        assert_int_equal(snapped[1], 0);
        assert_int_equal(snapped[2], expected[i]);
    }
}

static void limit_is_two_to_the_29(void **state)
{
    const double origin[3] = {0, 0, 0};
    const double inside[3] = {0x1p29 - 1, 1 - 0x1p29, 0}, outside[3] = {0, 0, -0x1p29};
    const double far_off[3] = {1e300, 0, 0}, rounds_up[3] = {0x1p29 - 0.5, 0, 0};
    oracle_grid grid;
    int32_t snapped[3] = {7, 7, 7};

    (void)state;
    assert_true(oracle_grid_given(origin, 0x1p20, SNAP_BITS, &grid));
    assert_false(oracle_snap(&grid, outside, snapped));
    assert_false(oracle_snap(&grid, far_off, snapped));
    assert_false(oracle_snap(&grid, rounds_up, snapped));
    assert_int_equal(snapped[0], 7);
    assert_true(oracle_snap(&grid, inside, snapped));
    assert_int_equal(snapped[0], (1 << 29) - 1);
    assert_int_equal(snapped[1], 1 - (1 << 29));
}

/* Of 24 bits, and above the extent by a millionth, rounded up; scale is the double nearest to 2^G / edge. */
static void default_edge_is_above_the_extent(void **state)
{
    uint64_t seed = 78;

    (void)state;
    print_message("seed %llu\n", (unsigned long long)seed);
    for (int i = 0; i < 100000; i++) {
        double positions[9] = {0}, extent = 0, step;
        const oracle_positions mesh = {positions, 3, NULL, 1};
        oracle_grid grid;

        for (int j = 0; j < 9; j++)
            positions[j] = random_double(&seed, i % 2 ? 2 : 200);
        assert_true(oracle_grid_fit(&mesh, SNAP_BITS, &grid));
        for (int k = 0; k < 3; k++)
            extent = fmax(extent, fmax(fmax(positions[k], positions[3 + k]), positions[6 + k]) -
                                      fmin(fmin(positions[k], positions[3 + k]), positions[6 + k]));
        step = ldexp(1, ilogb(grid.edge) - 23);
        assert_true(fmod(grid.edge, step) == 0);
        assert_true(grid.edge - extent >= extent * 0x1p-20);
        assert_true(grid.edge - step - extent < extent * 0x1p-20);
        assert_true(grid.scale == 0x1p20 / grid.edge);
    }
}

static void default_grid_is_the_bounds_cube(void **state)
{
    uint64_t seed = 79;

    (void)state;
    print_message("seed %llu\n", (unsigned long long)seed);
    for (int i = 0; i < 50000; i++) {
        double positions[9], edge = 0;
        const oracle_positions mesh = {positions, 3, NULL, 1};
        oracle_grid grid;

        for (int j = 0; j < 9; j++)
            positions[j] = random_double(&seed, i % 2 ? 2 : 200);
        assert_true(oracle_grid_fit(&mesh, SNAP_BITS, &grid));
        for (int k = 0; k < 3; k++) {
            double low = fmin(fmin(positions[k], positions[3 + k]), positions[6 + k]);
            double high = fmax(fmax(positions[k], positions[3 + k]), positions[6 + k]);

            assert_true(grid.origin[k] == low);
            edge = fmax(edge, high - low);
        }
        assert_true(grid.edge > edge && grid.edge < edge * 1.000002);
        for (int j = 0; j < 3; j++) {
            int32_t snapped[3];

            assert_true(oracle_snap(&grid, positions + 3 * j, snapped));
            for (int k = 0; k < 3; k++)
                assert_in_range(snapped[k], 0, 1048575);
        }
    }
}

/* Integer coordinates that span 0 .. 2^20 - 1 do not change, on both kinds of grid. */
static void integer_meshes_do_not_change_when_snapped(void **state)
{
    const double positions[9] = {0, 1048575, 7, 1048575, 0, 524288, 3, 5, 123456}, origin[3] = {0, 0, 0};
    const oracle_positions mesh = {positions, 3, NULL, 1};
    oracle_grid grids[2];

    (void)state;
    assert_true(oracle_grid_given(origin, 1048576, SNAP_BITS, &grids[0]));
    assert_true(oracle_grid_fit(&mesh, SNAP_BITS, &grids[1]));
    assert_true(grids[1].origin[2] == 7); /* so fitted z is moved by 7 */
    for (int g = 0; g < 2; g++) {
        for (int j = 0; j < 9; j++) {
            int32_t snapped[3];

            assert_true(oracle_snap(&grids[g], positions + j / 3 * 3, snapped));
            assert_int_equal(snapped[j % 3], (int32_t)(positions[j] - grids[g].origin[j % 3]));
        }
    }
}

static void default_grid_covers_accepted_triangles_only(void **state)
{
    const double positions[] = {0, 0, 0, 8, 1, 1, 1, 4, 2, -900, 5, NAN, INFINITY, 0, 0, 5000, 5000, 5000};
    const uint32_t indices[] = {0, 1, 3, 4, 1, 0, 0, 1, 2, 5, 6, 5, UINT32_MAX, 5, 5};
    const oracle_positions mesh = {positions, 6, indices, 5}, none = {positions, 6, indices, 2};
    uint32_t vertex_indices[3];
    oracle_grid grid;

    (void)state;
    for (size_t t = 0; t < 5; t++)
        assert_int_equal(oracle_triangle_accepted(&mesh, t, vertex_indices), t == 2);
    assert_true(oracle_grid_fit(&mesh, SNAP_BITS, &grid));
    assert_true(grid.origin[0] == 0 && grid.origin[1] == 0 && grid.origin[2] == 0);
    assert_true(grid.edge == 0x800008p-20);
    assert_false(oracle_grid_fit(&none, SNAP_BITS, &grid));
}

static void one_point_has_edge_one(void **state)
{
    const double positions[9] = {3, 4, 5, 3, 4, 5, 3, 4, 5};
    const oracle_positions mesh = {positions, 3, NULL, 1};
    oracle_grid grid;
    int32_t snapped[3];

    (void)state;
    assert_true(oracle_grid_fit(&mesh, SNAP_BITS, &grid));
    assert_true(grid.edge == 1 && grid.scale == 0x1p20);
    assert_true(oracle_snap(&grid, positions, snapped));
    assert_int_equal(snapped[0] | snapped[1] | snapped[2], 0);
}

TEST_GROUP(oracle_snap)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(snap_equals_the_definition_in_doubles),
        cmocka_unit_test(ties_go_to_even),
        cmocka_unit_test(limit_is_two_to_the_29),
        cmocka_unit_test(default_edge_is_above_the_extent),
        cmocka_unit_test(default_grid_is_the_bounds_cube),
        cmocka_unit_test(integer_meshes_do_not_change_when_snapped),
        cmocka_unit_test(default_grid_covers_accepted_triangles_only),
        cmocka_unit_test(one_point_has_edge_one),
    };

    return cmocka_run_group_tests_name("oracle_snap", tests, NULL, NULL);
}
