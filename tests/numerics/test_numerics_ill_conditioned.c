/* SPDX-License-Identifier: MIT */
/*
 * The largest rows of the catalog of ill-conditioned and extreme cases: a million pairs for each variant of the shared
 * overlap test (T4), and a scene of one huge triangle among hundreds of thousands of tiny ones (T7).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "numerics/agree/probe.h"
#include "numerics/agree/sample.h"
#include "support/compare_tree.h"
#include "support/meshes.h"
#include "support/suite.h"

/* A compiled variant of the shared test. */
typedef struct pair_class {
    const char *name;
    probe_function *ask;
    sample_width width;
    bool thin;
} pair_class;

static const pair_class classes[] = {
    {"narrow", probe_narrow, SAMPLE_NARROW, false},
    {"regular", probe_regular, SAMPLE_REGULAR, false},
    {"wide", probe_wide, SAMPLE_WIDE, false},
    {"thin narrow", probe_thin_narrow, SAMPLE_NARROW, true},
    {"thin regular", probe_thin_regular, SAMPLE_REGULAR, true},
    {"thin wide", probe_thin_wide, SAMPLE_WIDE, true},
};

/* No false negative and no false positive, by either reference. */
static void check_pairs(const pair_class *of)
{
    enum { PAIRS = 1000000 };
    const uint64_t seed = 20240303;
    unsigned touched = 0;
    print_message("%s, seed %llu\n", of->name, (unsigned long long)seed);
    for (uint32_t i = 0; i < PAIRS; ++i) {
        sample s = {.kind = (sample_kind)0};
        probe_output found;
        (of->thin ? sample_make_thin : sample_make)(of->width, seed, i, &s);
        of->ask(&s.record, &found, 1);
        const bool first = oracle_sat_touches(&s.triangle, &s.box, s.coverage);
        const bool second = oracle_clip_touches(&s.triangle, &s.box, s.coverage);
        if (sample_is_wrong(&s, &found, first) || first != second) {
            fail_msg("%s, seed %llu, record %u (%s): %d and %d, references %d and %d", of->name,
                     (unsigned long long)seed, i, sample_kind_name(s.kind), found.words[PROBE_COLUMN],
                     found.words[PROBE_VOXEL], first, second);
        }
        touched += first;
    }
    assert_in_range(touched, PAIRS / 20, PAIRS - PAIRS / 20);
}

static void t4_a_million_pairs_are_decided_exactly(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof classes / sizeof classes[0]; ++i) {
        check_pairs(&classes[i]);
    }
}

enum { TINY = 100000, ILL_CONDITIONED_TRIANGLES = 1 + 2 * TINY };

/* One triangle across the grid, a hundred thousand as large as a voxel, and as many smaller than a hundredth of one. */
static void make_ill_conditioned(uint64_t seed, unsigned depth, owned_mesh *out)
{
    static const double huge[9] = {0.01, 0.02, 0.03, 0.99, 0.05, 0.3, 0.03, 0.98, 0.4};
    uint64_t random = seed;
    random_dust(seed, ILL_CONDITIONED_TRIANGLES, (const double[3]){0, 0, 0}, 1.0, out);
    for (size_t k = 0; k < 9; ++k) {
        out->positions[k] = huge[k];
    }
    for (size_t t = 1; t < ILL_CONDITIONED_TRIANGLES; ++t) {
        const double extent = ldexp(t <= TINY ? 1.0 : 0.01, -(int)depth);
        double *corners = out->positions + t * 9;
        for (unsigned k = 0; k < 9; ++k) {
            corners[k] = k < 3 ? random_unit(&random) * 0.99 : corners[k % 3] + random_unit(&random) * extent;
        }
    }
}

static void check_ill_conditioned(const fixture *opened, unsigned depth, uint64_t capacity, uint32_t reruns)
{
    const uint64_t seed = 20240304;
    print_message("seed %llu at depth %u\n", (unsigned long long)seed, depth);
    const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = 1.0, .fragment_capacity = capacity};
    owned_mesh made;
    exact expected;
    built actual;
    make_ill_conditioned(seed, depth, &made);
    exact_create(&made.mesh, depth, &options, &expected);
    assert_references_agree(&expected);
    fixture_build(opened, &made.mesh, depth, &options, &actual);
    assert_int_equal(actual.report.reruns, reruns);
    assert_tree_is_exact(&actual, &expected);
    print_message("%llu fragments\n", (unsigned long long)actual.report.fragments);
    built_destroy(&actual);
    exact_destroy(&expected);
    owned_mesh_free(&made);
}

/* Ten million fragments, with the estimated capacity and with a list that initially holds one fragment. */
static void t7_ill_conditioned_scene_is_exact(void **state)
{
    check_ill_conditioned(fixture_of_group(state), 12, 0, 0);
    check_ill_conditioned(fixture_of_group(state), 11, 1, 1);
}

TEST_GROUP(numerics_ill_conditioned)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t4_a_million_pairs_are_decided_exactly),
        cmocka_unit_test(t7_ill_conditioned_scene_is_exact),
    };
    return cmocka_run_group_tests_name("numerics_ill_conditioned", tests, fixture_group_setup, fixture_group_teardown);
}
