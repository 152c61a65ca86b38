/* SPDX-License-Identifier: MIT */
/* What setup.diagnose counts: leaves that should have met a photon. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "light_fixture.h"
#include "support/suite.h"
#include "wall_mesh.h"

static svo_light_info shine(const fixture *opened, svo_light *light, const svo_light_source *source,
                            uint32_t resolution)
{
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = source;
    setup.source_count = 1;
    setup.view_resolution = resolution;
    setup.diagnose = 1;
    light_succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
    return light_info_of(light);
}

/* Steep light meets each leaf of a bare wall below its center, so the leaves without photons are the rest. */
static void test_leaves_without_photons_are_counted(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh mesh = wall_mesh();
    const svo_plan_options grid = wall_grid();
    const svo_light_source sources[] = {
        {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.125F, -1, 0.25F}, .value = {1, 1, 1}},
        {.kind = SVO_SOURCE_POINT, .position = {0.5F, 3, 0.5F}, .value = {1, 1, 1}},
        {.kind = SVO_SOURCE_SPOT,
         .position = {0.5F, 2, 0.5F},
         .direction = {0, -1, 0},
         .value = {1, 1, 1},
         .inner_angle = 0.5F,
         .outer_angle = 0.75F},
    };
    const uint64_t wall_leaves = UINT64_C(32) * 32;
    built made;
    fixture_build(&opened, &mesh, WALL_DEPTH, &grid, &made);
    svo_light *light = light_of(&opened, made.tree, SVO_LIGHT_FACES);
    for (size_t i = 0; i < sizeof sources / sizeof sources[0]; ++i) {
        const svo_light_info coarse = shine(&opened, light, &sources[i], 9);
        assert_in_range(coarse.lit_leaves, 9, 3 * 81);
        assert_int_equal(coarse.lit_leaves + coarse.missed_leaves, wall_leaves);
        const svo_light_info fine = shine(&opened, light, &sources[i], 500);
        assert_int_equal(fine.missed_leaves, 0);
        assert_int_equal(fine.lit_leaves, wall_leaves);
    }
    svo_light_destroy(&light);
    built_destroy(&made);
}

TEST_GROUP(light_diagnose)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_leaves_without_photons_are_counted),
    };
    return cmocka_run_group_tests_name("light_diagnose", tests, fixture_group_setup, fixture_group_teardown);
}
