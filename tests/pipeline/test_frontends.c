/* SPDX-License-Identifier: MIT */
/* All front ends build trees with the same hash on every scene, and the default choice gives its reason. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "scenes.h"
#include "support/fixture.h"
#include "support/suite.h"

#define NEED_ALL (SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS)

static void assert_one_hash(const fixture *by_gl, const fixture *by_cl, const char *spec, unsigned depth,
                            svo_coverage coverage)
{
    const svo_plan_options options = {.need = NEED_ALL, .coverage = coverage};
    scene *made = fixture_scene(spec);
    built expected;
    built actual;
    fixture_build(by_gl, scene_mesh(made), depth, &options, &expected);
    fixture_build(by_cl, scene_mesh(made), depth, &options, &actual);
    print_message("%s at depth %u, %s: %s %s, %s %s\n", spec, depth, svo_name(SVO_NAME_COVERAGE, coverage),
                  expected.report.frontend, expected.hash, actual.report.frontend, actual.hash);
    assert_string_not_equal(actual.report.frontend, expected.report.frontend);
    assert_string_equal(actual.hash, expected.hash);
    built_destroy(&actual);
    built_destroy(&expected);
    scene_destroy(&made);
}

static void assert_builders_agree(const fixture *opened, const char *spec, unsigned depth, uint32_t need)
{
    scene *made = fixture_scene(spec);
    built expected;
    built actual;
    svo_plan_options options = {.need = need};
    fixture_build(opened, scene_mesh(made), depth, &options, &expected);
    options.builder = SVO_BUILDER_SORTED;
    fixture_build(opened, scene_mesh(made), depth, &options, &actual);
    assert_string_equal(expected.report.builder, "cl");
    assert_string_equal(actual.report.builder, "sorted");
    assert_string_equal(actual.hash, expected.hash);
    assert_string_equal(actual.nodes_hash, expected.nodes_hash);
    built_destroy(&actual);
    built_destroy(&expected);
    scene_destroy(&made);
}

/* Whether the i-th scene has the k-th of three builds: all have all where tests are long, and one each in turn. */
static bool has_build(size_t i, size_t k)
{
    return suite_is_long() || i % 3 == k;
}

/* Builders get fragment lists from both front ends. */
static void t15_all_builders_give_one_hash_on_all_scenes(void **state)
{
    const fixture *by_gl = fixture_of_group(state);
    const fixture by_cl = fixture_cl_of_group(state);
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        const char *name = scene_describe(i)->name;
        if (has_build(i, 0)) {
            assert_builders_agree(by_gl, name, 7, SVO_NEED_ALL);
        }
        if (has_build(i, 1)) {
            assert_builders_agree(&by_cl, name, 8, SVO_NEED_NONE);
        }
        if (has_build(i, 2)) {
            assert_builders_agree(&by_cl, name, 6, SVO_NEED_MATERIAL);
        }
    }
    for (unsigned depth = 1; depth <= 14; ++depth) {
        assert_builders_agree(&by_cl, "dust:2000", depth, SVO_NEED_RAYS | SVO_NEED_COLOR);
    }
}

/* T15 for every front end. */
static void t15_all_front_ends_give_one_hash_on_all_scenes(void **state)
{
    const fixture *by_gl = fixture_of_group(state);
    const fixture by_cl = fixture_cl_of_group(state);
    size_t scene_count = 0;
    for (; scene_describe(scene_count) != NULL; ++scene_count) {
        const char *name = scene_describe(scene_count)->name;
        static const svo_coverage coverages[] = {SVO_COVERAGE_HALF_OPEN, SVO_COVERAGE_CLOSED, SVO_COVERAGE_THIN};
        for (size_t k = 0; k < 3; ++k) {
            if (has_build(scene_count, k)) {
                assert_one_hash(by_gl, &by_cl, name, k == 0 ? 7 : 6, coverages[k]);
            }
        }
    }
    assert_true(scene_count >= 8);
    assert_one_hash(by_gl, &by_cl, "dust:20000", 13, SVO_COVERAGE_HALF_OPEN);
}

/* The choice is one of the two front ends, with a reason. */
static void the_choice_gives_a_reason(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_message reason = {""};
    const svo_frontend *chosen = svo_gl_prefer(opened->gl, opened->cl, &reason);
    print_message("%s: %s\n", svo_frontend_name(chosen), reason.text);
    assert_true(chosen == opened->cl || chosen == svo_gl_frontend(opened->gl));
    assert_true(strlen(reason.text) > 0);
    svo_gl_context_info info = SVO_GL_CONTEXT_INFO_INIT;
    svo_gl_context_get_info(opened->context, &info);
    if (strstr(info.renderer, "llvmpipe") != NULL) {
        assert_ptr_equal(chosen, opened->cl);
    }
}

/* svo_frontend_destroy does not release a front end that svo_gl owns. */
static void svo_frontend_destroy_keeps_the_opengl_front_end(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_frontend *const owned = svo_gl_frontend(opened->gl);
    svo_frontend *frontend = owned;
    char name[64];
    (void)snprintf(name, sizeof name, "%s", svo_frontend_name(owned));
    svo_frontend_destroy(&frontend);
    assert_null(frontend);
    assert_ptr_equal(svo_gl_frontend(opened->gl), owned);
    assert_string_equal(svo_frontend_name(owned), name);
}

TEST_GROUP(frontends)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t15_all_front_ends_give_one_hash_on_all_scenes),
        cmocka_unit_test(t15_all_builders_give_one_hash_on_all_scenes),
        cmocka_unit_test(the_choice_gives_a_reason),
        cmocka_unit_test(svo_frontend_destroy_keeps_the_opengl_front_end),
    };
    return cmocka_run_group_tests_name("frontends", tests, fixture_group_setup, fixture_group_teardown);
}
