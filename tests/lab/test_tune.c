/* SPDX-License-Identifier: MIT */
/* What svocl tune decides by: differences of colors against published pairs, statistics and distances against closed
   forms, who leaves and who wins. Times are made, not measured. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "scenes/maths.h"
#include "support/suite.h"
#include "tune/delta_e.h"
#include "tune/nearest_leaf.h"
#include "tune/race.h"

static void expect_near(double found, double expected, double within)
{
    if (!(fabs(found - expected) <= within)) {
        fail_msg("%.9g is not %.9g", found, expected);
    }
}

/* ---- colors ---- */

/* Of the table of Sharma, Wu and Dalal, 2005. */
static void differences_are_as_published(void **state)
{
    static const struct {
        double a[3], b[3], difference;
    } pairs[] = {
        {{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
        {{50, 3.1571, -77.2803}, {50, 0, -82.7485}, 2.8615},
        {{50, 2.8361, -74.0200}, {50, 0, -82.7485}, 3.4412},
        {{50, 0, 0}, {50, -1, 2}, 2.3669},
        {{50, 2.49, -0.001}, {50, -2.49, 0.0009}, 7.1792},
        {{50, 2.49, -0.001}, {50, -2.49, 0.0011}, 7.2195},
        {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
        {{50, 2.5, 0}, {50, 3.1736, 0.5854}, 1.0000},
        {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
        {{22.7233, 20.0904, -46.6940}, {23.0331, 14.9730, -42.5619}, 2.0373},
        {{90.8027, -2.0831, 1.4410}, {91.1528, -1.6435, 0.0447}, 1.4441},
        {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082},
    };
    (void)state;
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; ++i) {
        expect_near(delta_e_2000(pairs[i].a, pairs[i].b), pairs[i].difference, 5e-5);
        expect_near(delta_e_2000(pairs[i].b, pairs[i].a), pairs[i].difference, 5e-5);
    }
}

static void white_is_neutral(void **state)
{
    static const double white[3] = {1, 1, 1};
    static const double gray[3] = {0.184187, 0.184187, 0.184187}; /* L* 50: Y = (66 / 116)^3 */
    double lab[3];
    (void)state;
    delta_e_lab(white, lab);
    expect_near(lab[0], 100, 1e-9);
    expect_near(lab[1], 0, 1e-9);
    expect_near(lab[2], 0, 1e-9);
    delta_e_lab(gray, lab);
    expect_near(lab[0], 50, 1e-4);
}

/* ---- statistics ---- */

static size_t measure_of(const char *name)
{
    const size_t found = tune_measure_find(name, strlen(name));
    assert_true(found < tune_measure_count());
    return found;
}

static double value_of(const tune_errors *errors, const char *name)
{
    const tune_measure *which = tune_measure_at(measure_of(name));
    const sample_block sum = samples_sum(&errors->of[which->quantity]);
    return tune_measure_value(which, errors, &sum);
}

/* Of 0, 1, .. 999 over 1000: mean 0.4995, and the root of the mean square. */
static void statistics_are_closed_forms(void **state)
{
    tune_errors errors = {.kind = KIND_SHAPE, .voxel = 0.25};
    (void)state;
    for (size_t i = 0; i < 1000; ++i) {
        samples_add(&errors.of[QUANTITY_VOXEL], i, (double)i / 1000);
        samples_add(&errors.of[QUANTITY_OCCLUSION], i, i % 2 == 0 ? -0.5 : 0.25);
    }
    samples_add(&errors.of[QUANTITY_VOXEL], 0, NAN);
    expect_near(value_of(&errors, "voxel-mean"), 0.4995, 1e-12);
    expect_near(value_of(&errors, "voxel-rms"), sqrt(999.0 * 1999 / 6e6), 1e-12);
    expect_near(value_of(&errors, "voxel-max"), 0.999, 0);
    expect_near(value_of(&errors, "voxel-max-units"), 0.24975, 1e-12);
    expect_near(value_of(&errors, "ao-bias"), -0.125, 1e-12);
    expect_near(value_of(&errors, "ao"), sqrt(0.15625), 1e-12);
    const interval mean = interval_of_error(&errors, tune_measure_at(measure_of("voxel-mean")));
    assert_true(mean.low < 0.4995 && mean.high > 0.4995 && mean.high - mean.low < 0.1);
    const interval again = interval_of_error(&errors, tune_measure_at(measure_of("voxel-mean")));
    assert_memory_equal(&mean, &again, sizeof mean);
}

/* The same triangle; nothing; one that is missed; one where nothing is; a tie; another one, behind. */
static void triangles_are_compared(void **state)
{
    static const tune_hit exact[] = {{4, 2}, {SVO_NO_TRIANGLE, INFINITY}, {4, 2}, {SVO_NO_TRIANGLE, INFINITY}, {4, 2},
                                     {4, 2}};
    static const tune_hit found[] = {
        {4, 2}, {SVO_NO_TRIANGLE, INFINITY}, {SVO_NO_TRIANGLE, INFINITY}, {7, 3}, {7, 2.0000001}, {7, 2.5}};
    tune_errors errors = {.kind = KIND_RAYS, .voxel = 0.25};
    (void)state;
    for (size_t i = 0; i < sizeof exact / sizeof exact[0]; ++i) {
        samples_add_hit(&errors, i, exact[i], found[i]);
    }
    expect_near(value_of(&errors, "triangle"), 60, 1e-12); /* three of five: the second ray meets nothing at all */
    expect_near(value_of(&errors, "t-max-units"), 0.5, 1e-12);
    expect_near(value_of(&errors, "t-rms"), sqrt(4.0 / 3), 1e-6);
}

/* A root with one leaf, in its last octant: the center lies at 1.5, 1.5, 1.5 voxels. */
static void the_nearest_leaf_is_found(void **state)
{
    static const uint8_t mask[1] = {0x80};
    static const uint32_t first[1] = {1};
    static const double corner[3] = {10, 10, 10};
    static const double center[3] = {13, 13, 13};
    const svo_tree_info info = {.depth = 1, .inner_count = 1, .leaf_count = 1, .origin = {10, 10, 10}, .edge = 4};
    const svo_tree_arrays arrays = {.child_mask = mask, .first_child = first};
    (void)state;
    expect_near(nearest_leaf(&info, &arrays, corner), 1.5 * sqrt(3), 1e-12);
    expect_near(nearest_leaf(&info, &arrays, center), 0, 1e-12);
}

/* ---- races ---- */

#define SETTINGS 24u

/* Time grows with the index, error falls with it; each round is off by up to 3 %. */
static void make_race(candidate list[SETTINGS], tune_errors errors[SETTINGS], size_t rounds)
{
    random_stream random = {.state = 7};
    memset(list, 0, SETTINGS * sizeof *list);
    memset(errors, 0, SETTINGS * sizeof *errors);
    for (size_t i = 0; i < SETTINGS; ++i) {
        errors[i].kind = KIND_SHAPE;
        errors[i].voxel = 1;
        for (size_t k = 0; k < 512; ++k) {
            samples_add(&errors[i].of[QUANTITY_VOXEL], k, random_between(&random, 0.9, 1.1) / (1 + (double)i));
        }
        list[i].errors[KIND_SHAPE] = &errors[i];
        list[i].bytes = 1000 * (1 + (double)i);
        for (; list[i].round_count < rounds; ++list[i].round_count) {
            list[i].rounds[list[i].round_count] = 10 * (1 + (double)i) * random_between(&random, 0.97, 1.03);
        }
    }
}

static tune_bounds bound_of(const char *name, double most)
{
    tune_bounds bounds = {.least = tune_measure_count(), .time_ms = INFINITY, .bytes = INFINITY};
    bounds.list[bounds.count++] = (tune_bound){measure_of(name), most};
    return bounds;
}

/* 1 / (1 + i) is at most 0.105 from i = 9 on. */
static void halving_and_all_agree(void **state)
{
    candidate list[SETTINGS];
    tune_errors errors[SETTINGS];
    const tune_bounds bounds = bound_of("voxel-mean", 0.105);
    const race all = {list, SETTINGS, &bounds};
    (void)state;
    make_race(list, errors, 11);
    assert_int_equal(race_judge(&all).winner, 9);
    assert_int_equal(race_judge(&all).second, 10);
    for (unsigned rung = 1; rung <= 4; ++rung) {
        race_leave(&all, rung, true);
    }
    const race_verdict verdict = race_judge(&all);
    assert_int_equal(verdict.winner, 9);
    assert_true(verdict.sure > 0.95);
    assert_int_equal(list[0].left, LEFT_ERROR);
    assert_int_equal(list[23].left, LEFT_SLOWER);
    assert_int_equal(list[9].left, LEFT_NOT);
}

static void bounds_choose(void **state)
{
    candidate list[SETTINGS];
    tune_errors errors[SETTINGS];
    tune_bounds bounds = bound_of("voxel-mean", 0.105);
    const race all = {list, SETTINGS, &bounds};
    (void)state;
    make_race(list, errors, 11);
    bounds.bytes = 9500; /* the first that is exact enough takes 10,000 */
    assert_int_equal(race_judge(&all).winner, SETTINGS);
    bounds = (tune_bounds){.least = measure_of("voxel-mean"), .time_ms = 75, .bytes = INFINITY};
    assert_int_equal(race_judge(&all).winner, 6); /* 70 ms; the next one takes 80 */
    bounds = (tune_bounds){.least = tune_measure_count(), .time_ms = INFINITY, .bytes = INFINITY};
    assert_int_equal(race_judge(&all).winner, SETTINGS); /* nothing is asked */
    assert_true(race_is_on_front(&all, 0) && race_is_on_front(&all, 23));
    list[5].bytes = 1e9;
    list[5].errors[KIND_SHAPE] = list[4].errors[KIND_SHAPE];
    assert_false(race_is_on_front(&all, 5));
}

/* A setting without a value of what is bounded cannot win, and leaves for that reason alone. */
static void who_has_no_value_leaves(void **state)
{
    candidate list[SETTINGS];
    tune_errors errors[SETTINGS];
    const tune_bounds bounds = bound_of("triangle", 5);
    const race all = {list, SETTINGS, &bounds};
    (void)state;
    make_race(list, errors, 11);
    for (size_t i = 0; i < SETTINGS; ++i) {
        errors[i].kind = KIND_RAYS;
        list[i].errors[KIND_RAYS] = &errors[i];
        for (size_t k = 0; i > 0 && k < 512; ++k) {
            samples_add(&errors[i].of[QUANTITY_TRIANGLE], k, 0);
        }
    }
    list[0].lacks[QUANTITY_TRIANGLE] = true;
    race_leave(&all, 1, true);
    assert_int_equal(list[0].left, LEFT_UNABLE);
    assert_int_equal(list[1].left, LEFT_NOT);
    assert_int_equal(race_judge(&all).winner, 1);
}

TEST_GROUP(tune)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(differences_are_as_published), cmocka_unit_test(white_is_neutral),
        cmocka_unit_test(statistics_are_closed_forms),  cmocka_unit_test(the_nearest_leaf_is_found),
        cmocka_unit_test(triangles_are_compared),       cmocka_unit_test(who_has_no_value_leaves),
        cmocka_unit_test(halving_and_all_agree),        cmocka_unit_test(bounds_choose),
    };
    return cmocka_run_group_tests_name("tune", tests, NULL, NULL);
}
