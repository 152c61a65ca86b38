/* SPDX-License-Identifier: MIT */
/*
 * T1 golden: compares every front end with the golden counts: leaves with voxels, fragments with pairs, half-open and
 * closed, at every depth of the table that can be built. The table has no thin counts. Thin builds are compared with
 * the references, and their pairs must be a subset of the half-open pairs.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "support/compare_tree.h"
#include "support/fixture.h"
#include "support/golden.h"
#include "support/suite.h"

/* Returns whether there was something to compare. */
typedef bool check_function(const fixture *opened, const svo_mesh *mesh, const char *name, const golden_count *count);

/* A grid that does not change the table's coordinates. */
static svo_plan_options table_options(svo_coverage coverage, svo_need need)
{
    return (svo_plan_options){.edge = 1u << GOLDEN_SNAP_BITS, .need = (uint32_t)need, .coverage = coverage};
}

static bool check_count(const fixture *opened, const svo_mesh *mesh, const char *name, const golden_count *count)
{
    const svo_plan_options options =
        table_options(count->is_closed ? SVO_COVERAGE_CLOSED : SVO_COVERAGE_HALF_OPEN, SVO_NEED_NONE);
    built actual;
    fixture_build(opened, mesh, count->depth, &options, &actual);
    if (actual.info.leaf_count != count->voxels || actual.info.fragments != count->pairs) {
        fail_msg("%s, %s at depth %u: %llu voxels and %llu pairs, not %llu and %llu", name,
                 svo_name(SVO_NAME_COVERAGE, options.coverage), count->depth,
                 (unsigned long long)actual.info.leaf_count, (unsigned long long)actual.info.fragments,
                 (unsigned long long)count->voxels, (unsigned long long)count->pairs);
    }
    built_destroy(&actual);
    return true;
}

/* Thin coverage at the depth of a half-open count. The references take most of the time: OpenCL has the even depths and
   OpenGL the odd ones, all where tests are long. */
static bool check_thin(const fixture *opened, const svo_mesh *mesh, const char *name, const golden_count *count)
{
    if (count->is_closed || (!suite_is_long() && count->depth % 2 == (opened->frontend == opened->cl))) {
        return false;
    }
    const svo_plan_options half_open = table_options(SVO_COVERAGE_HALF_OPEN, SVO_NEED_RAYS);
    const svo_plan_options thin = table_options(SVO_COVERAGE_THIN, SVO_NEED_RAYS);
    exact all;
    exact expected;
    exact_create(mesh, count->depth, &half_open, &all);
    exact_create(mesh, count->depth, &thin, &expected);
    assert_int_equal(all.pairs.count, count->pairs);
    assert_references_agree(&expected);

    oracle_difference difference;
    oracle_compare(&all.pairs, &expected.pairs, &difference);
    if (difference.surplus_pairs != 0) {
        fail_msg("%s, thin at depth %u: %llu pairs that are not half-open pairs", name, count->depth,
                 (unsigned long long)difference.surplus_pairs);
    }
    built actual;
    fixture_build(opened, mesh, count->depth, &thin, &actual);
    if (actual.info.fragments != expected.pairs.count) {
        fail_msg("%s, thin at depth %u: %llu pairs, not %llu", name, count->depth,
                 (unsigned long long)actual.info.fragments, (unsigned long long)expected.pairs.count);
    }
    assert_tree_is_exact(&actual, &expected);
    built_destroy(&actual);
    exact_destroy(&expected);
    exact_destroy(&all);
    return true;
}

/* Returns how many counts were compared. */
static size_t check_scene(const fixture *opened, const golden_scene *scene, check_function *check)
{
    const size_t vertex_count = scene->triangle_count * 3;
    float *positions = malloc(vertex_count * 3 * sizeof *positions);
    assert_non_null(positions);
    for (size_t i = 0; i < vertex_count * 3; ++i) {
        positions[i] = (float)scene->vertices[i]; /* below 2^24: exact */
    }
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions = positions,
                           .vertex_count = vertex_count,
                           .triangle_count = scene->triangle_count};
    size_t compared = 0;
    for (size_t i = 0; i < scene->count_count; ++i) {
        const golden_count *count = &scene->counts[i];
        if (count->depth >= SVO_DEPTH_MIN) { /* trees of depth 0 cannot be built */
            compared += check(opened, &mesh, scene->name, count);
        }
    }
    free(positions);
    return compared;
}

static void check_table(const fixture *opened, check_function *check)
{
    golden_table *table = golden_load(GOLDEN_COUNTS_PATH);
    assert_non_null(table);
    for (size_t i = 0; i < table->scene_count; ++i) {
        const size_t compared = check_scene(opened, &table->scenes[i], check);
        print_message("%s: %zu counts\n", table->scenes[i].name, compared);
        assert_in_range(compared, 1, GOLDEN_COUNTS_MAX);
    }
    golden_free(table);
}

static void t1_golden_counts_are_reproduced_by_opencl(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    check_table(&opened, check_count);
}

static void t1_golden_counts_are_reproduced_by_opengl(void **state)
{
    check_table(fixture_of_group(state), check_count);
}

static void t1_thin_counts_match_the_references_by_opencl(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    check_table(&opened, check_thin);
}

static void t1_thin_counts_match_the_references_by_opengl(void **state)
{
    check_table(fixture_of_group(state), check_thin);
}

TEST_GROUP(golden)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t1_golden_counts_are_reproduced_by_opencl),
        cmocka_unit_test(t1_golden_counts_are_reproduced_by_opengl),
        cmocka_unit_test(t1_thin_counts_match_the_references_by_opencl),
        cmocka_unit_test(t1_thin_counts_match_the_references_by_opengl),
    };
    return cmocka_run_group_tests_name("golden", tests, fixture_group_setup, fixture_group_teardown);
}
