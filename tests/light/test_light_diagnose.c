/* SPDX-License-Identifier: MIT */
/*
 * What setup.diagnose counts: leaves that should have met a photon, and the items of a node map, which are compared
 * with its rule, item by item.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "light/source_views.h"
#include "light_fixture.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "wall_mesh.h"

/* ---- node maps ---- */

#define DEPTH      4
#define SIDE_MAX   13
#define LEVELS_MAX 5 /* of the pyramid: 2^4 is above SIDE_MAX */
#define NONE       UINT64_MAX

/* The level of the deepest node that holds the leaves of a cell of the pyramid; -1: there are none. A cell is 2^up
   pixels wide. first: receives its first pixel with a leaf. */
static int ancestor_level(const uint64_t *leaves, const uint32_t size[2], const uint32_t cell[2], uint32_t up,
                          uint64_t *first)
{
    uint64_t code = NONE;
    int level = -1;
    *first = NONE;
    for (uint32_t y = cell[1] << up; y < (cell[1] + 1) << up && y < size[1]; ++y) {
        for (uint32_t x = cell[0] << up; x < (cell[0] + 1) << up && x < size[0]; ++x) {
            const uint64_t leaf = leaves[y * size[0] + x];
            if (leaf == NONE) {
                continue;
            }
            *first = *first == NONE ? (uint64_t)y * size[0] + x : *first;
            level = code == NONE ? DEPTH : level;
            code = code == NONE ? leaf : code;
            while (leaf >> 3 * (DEPTH - level) != code >> 3 * (DEPTH - level)) {
                --level;
            }
        }
    }
    return level;
}

/* Whether the item of a pixel filters a level: it is the first of the largest cell around it whose leaves have an
   ancestor at or below that level. */
static bool filters(const uint64_t *leaves, const uint32_t size[2], uint32_t x, uint32_t y, int level)
{
    uint64_t first = NONE;
    for (uint32_t up = 0; up < LEVELS_MAX; ++up) {
        uint64_t first_of_cell = NONE;
        if (ancestor_level(leaves, size, (const uint32_t[]){x >> up, y >> up}, up, &first_of_cell) < level) {
            break;
        }
        first = first_of_cell;
    }
    return first == (uint64_t)y * size[0] + x;
}

/* The items of all levels, one by one. */
static uint64_t count_items(const uint64_t *leaves, const uint32_t size[2])
{
    uint64_t items = 0;
    for (uint32_t y = 0; y < size[1]; ++y) {
        for (uint32_t x = 0; x < size[0]; ++x) {
            for (int level = 0; level < DEPTH; ++level) {
                items += filters(leaves, size, x, y, level) ? 1 : 0;
            }
        }
    }
    return items;
}

static void test_node_maps_follow_their_rule(void **state)
{
    uint64_t seed = 5;
    (void)state;
    for (int n = 0; n < 200; ++n) {
        const uint32_t size[2] = {1 + random_below(&seed, SIDE_MAX), 1 + random_below(&seed, SIDE_MAX)};
        const uint32_t kinds = 1 + random_below(&seed, 1u << 3 * DEPTH);
        uint64_t leaves[SIDE_MAX * SIDE_MAX] = {0};
        svo_i_map_cell cells[SIDE_MAX * SIDE_MAX];
        for (uint32_t i = 0; i < size[0] * size[1]; ++i) {
            leaves[i] = random_below(&seed, 4) == 0 ? NONE : random_below(&seed, kinds);
            cells[i] = (svo_i_map_cell){.code = leaves[i], .level = leaves[i] == NONE ? SVO_I_MAP_EMPTY : DEPTH};
        }
        const uint64_t expected = count_items(leaves, size);
        assert_int_equal(svo_i_node_map_items(cells, size[0], size[1], DEPTH), expected);
    }
}

/* ---- leaves without photons ---- */

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
        assert_true(fine.node_map_items > fine.lit_nodes - fine.lit_leaves);
    }
    svo_light_destroy(&light);
    built_destroy(&made);
}

TEST_GROUP(light_diagnose)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_node_maps_follow_their_rule),
        cmocka_unit_test(test_leaves_without_photons_are_counted),
    };
    return cmocka_run_group_tests_name("light_diagnose", tests, fixture_group_setup, fixture_group_teardown);
}
