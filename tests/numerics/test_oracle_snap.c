/* SPDX-License-Identifier: MIT */
/*
 * Tests the reference for grid and snap: against the definition in rationals, on neighbors of whole numbers computed by
 * hand, and on accepted and refused triangles. Seeds are fixed and printed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <gmp.h>
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

/* The documented definition in rationals. Returns false from 2^29 on. */
static bool snap_in_rationals(const oracle_grid *grid, double value, int axis, int32_t *snapped)
{
    mpq_t units, operand;
    mpz_t whole;
    bool is_near;

    mpq_inits(units, operand, NULL);
    mpz_init(whole);
    mpq_set_d(units, value);
    mpq_set_d(operand, grid->origin[axis]);
    mpq_sub(units, units, operand);
    mpq_mul_2exp(units, units, grid->snap_bits);
    mpq_set_d(operand, grid->edge);
    mpq_div(units, units, operand);
    mpz_fdiv_q(whole, mpq_numref(units), mpq_denref(units));
    if (mpz_cmp_ui(mpq_denref(units), 1) != 0)
        mpz_setbit(whole, 0);
    is_near = mpz_cmpabs_ui(whole, 1u << 29) < 0;
    *snapped = is_near ? (int32_t)mpz_get_si(whole) : 0;
    mpz_clear(whole);
    mpq_clears(units, operand, NULL);
    return is_near;
}

/* Whole units of an edge of few bits, some of them exact, and their neighbors. */
static double random_near_unit(uint64_t *seed, double edge, double origin)
{
    double position = origin + edge * ldexp((double)(next_random(seed) % 4194304) - 1048576, -SNAP_BITS);
    int moved = (int)(next_random(seed) % 3) - 1;

    return moved == 0 ? position : nextafter(position, moved > 0 ? INFINITY : -INFINITY);
}

static void snap_equals_the_definition_in_rationals(void **state)
{
    uint64_t seed = 77, refused_count = 0, even_count = 0;

    (void)state;
    print_message("seed %llu\n", (unsigned long long)seed);
    for (int i = 0; i < 60000; i++) {
        const int kind = i % 4, bits = kind == 0 ? 3 : kind == 1 ? 30 : kind == 2 ? 300 : 5;
        double origin[3] = {random_double(&seed, bits), random_double(&seed, bits), random_double(&seed, bits)};
        double edge = fabs(random_double(&seed, bits)), position[3];
        int32_t snapped[3] = {0, 0, 0}, expected[3];
        bool is_near = true;
        oracle_grid grid;

        if (kind == 3) {
            edge = (double)(1 + next_random(&seed) % 1000);
            for (int k = 0; k < 3; k++)
                origin[k] = rint(origin[k]);
        }
        assert_true(oracle_grid_given(origin, edge, SNAP_BITS, &grid));
        for (int k = 0; k < 3; k++) {
            position[k] = kind == 3                ? random_near_unit(&seed, edge, origin[k])
                          : next_random(&seed) & 1 ? random_double(&seed, bits)
                                                   : origin[k] + edge * random_double(&seed, 4);
            is_near = snap_in_rationals(&grid, position[k], k, &expected[k]) && is_near;
        }
        assert_int_equal(oracle_snap(&grid, position, snapped), is_near);
        for (int k = 0; is_near && k < 3; k++) {
            assert_int_equal(snapped[k], expected[k]);
            even_count += kind == 3 && snapped[k] % 2 == 0;
        }
        refused_count += !is_near;
    }
    print_message("%llu even, %llu refused\n", (unsigned long long)even_count, (unsigned long long)refused_count);
    assert_in_range(refused_count, 1000, 40000);
    assert_in_range(even_count, 1000, 30000); /* exact ones */
}

/* With edge 2^20 a unit is 1. */
static void whole_units_are_kept_and_others_become_odd(void **state)
{
    const double origin[3] = {0, 0, 0}, values[] = {0.5,  1.5,  2.5,   -0.5,   -1.5,          -2.5, 2.0000000000000004,
                                                    -0.0, 2,    -4,    5e-324, -5e-324,       3,    1.9999999999999998,
                                                    -7,   1e-9, 2.999, 4.001,  -2.0000000001, -1};
    const int32_t expected[] = {1, 1, 3, -1, -1, -3, 3, 0, 2, -4, 1, -1, 3, 1, -7, 1, 3, 5, -3, -1};
    oracle_grid grid;

    (void)state;
    assert_int_equal(sizeof(values) / sizeof(values[0]), sizeof(expected) / sizeof(expected[0]));
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

/* What lies beside a whole unit by far less than a double can tell: a tiny number, with an origin of 1. */
static void differences_are_not_rounded(void **state)
{
    const double origin[3] = {1, -1, 0x1p-1070}, position[3] = {0x1p-1074, -0x1p-1074, 16};
    const int32_t expected[3] = {-65535, 65535, 1048575};
    oracle_grid grid;
    int32_t snapped[3];

    (void)state;
    assert_true(oracle_grid_given(origin, 16, SNAP_BITS, &grid));
    assert_true(oracle_snap(&grid, position, snapped));
    for (int k = 0; k < 3; k++)
        assert_int_equal(snapped[k], expected[k]);
}

static void limit_is_two_to_the_29(void **state)
{
    const double origin[3] = {0, 0, 0};
    const double inside[3] = {0x1p29 - 1, 1 - 0x1p29, 0}, outside[3] = {0, 0, -0x1p29};
    const double far_off[3] = {1e300, 0, 0}, almost[3] = {0x1p29 - 0.5, 0.5 - 0x1p29, 0};
    oracle_grid grid;
    int32_t snapped[3] = {7, 7, 7};

    (void)state;
    assert_true(oracle_grid_given(origin, 0x1p20, SNAP_BITS, &grid));
    assert_false(oracle_snap(&grid, outside, snapped));
    assert_false(oracle_snap(&grid, far_off, snapped));
    assert_int_equal(snapped[0], 7);
    for (int i = 0; i < 2; i++) {
        assert_true(oracle_snap(&grid, i == 0 ? inside : almost, snapped));
        assert_int_equal(snapped[0], (1 << 29) - 1);
        assert_int_equal(snapped[1], 1 - (1 << 29));
    }
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
        cmocka_unit_test(snap_equals_the_definition_in_rationals),
        cmocka_unit_test(whole_units_are_kept_and_others_become_odd),
        cmocka_unit_test(differences_are_not_rounded),
        cmocka_unit_test(limit_is_two_to_the_29),
        cmocka_unit_test(default_edge_is_above_the_extent),
        cmocka_unit_test(default_grid_is_the_bounds_cube),
        cmocka_unit_test(integer_meshes_do_not_change_when_snapped),
        cmocka_unit_test(default_grid_covers_accepted_triangles_only),
        cmocka_unit_test(one_point_has_edge_one),
    };

    return cmocka_run_group_tests_name("oracle_snap", tests, NULL, NULL);
}
