/* SPDX-License-Identifier: MIT */
/*
 * Walls and boxes one voxel thick: a wall lets as much through wherever it lies in the grid, on every level; a sealed
 * box is opaque on every level that it fills.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "light_fixture.h"
#include "support/suite.h"

#define DEPTH 6u
#define WIDTH ((size_t)1 << DEPTH)
#define CELLS (WIDTH * WIDTH * WIDTH)

/* Samples to a voxel: where the field has no corner between two. */
enum { PER_VOXEL = 8, PROBES = 64 * PER_VOXEL };

/* A wall across an axis. */
static svo_tree *wall_at(const fixture *opened, unsigned axis, size_t place)
{
    uint8_t *alphas = calloc(CELLS, 1);
    assert_non_null(alphas);
    for (size_t k = 0; k < CELLS; ++k) {
        const size_t cell[3] = {k % WIDTH, k / WIDTH % WIDTH, k / WIDTH / WIDTH};
        alphas[k] = cell[axis] == place ? 255 : 0;
    }
    svo_tree *tree = light_tree_of(opened, DEPTH, alphas);
    free(alphas);
    return tree;
}

/* What a ray across the wall sums up on a level: opacities and extinctions, times steps in voxels. */
typedef struct crossed {
    double opacity, extinction;
} crossed;

static crossed cross(const fixture *opened, svo_light *light, unsigned axis, uint32_t level)
{
    static light_probe probes[PROBES];
    static light_sample samples[PROBES];
    crossed sums = {0, 0};
    for (size_t i = 0; i < PROBES; ++i) {
        probes[i] = (light_probe){.position = {30.3f, 41.9f, 25.6f}, .level = level};
        probes[i].position[axis] = ((float)i + 0.5f) / PER_VOXEL;
        probes[i].direction[axis] = 1;
    }
    light_probe_field(opened, light, probes, samples, PROBES);
    for (size_t i = 0; i < PROBES; ++i) {
        const double cell = (double)(1u << (DEPTH - level));
        sums.opacity += (double)samples[i].opacity / PER_VOXEL;
        sums.extinction += (double)samples[i].extinction / PER_VOXEL / cell;
    }
    return sums;
}

/* The most and the least over all shifts. */
typedef struct spread {
    double low, high;
} spread;

static void widen(spread *range, double value)
{
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

static void a_wall_is_as_opaque_at_every_shift(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    spread extinctions[SVO_LIGHT_FORM_COUNT][DEPTH + 1];
    for (int k = 0; k < SVO_LIGHT_FORM_COUNT * (int)(DEPTH + 1); ++k) {
        extinctions[k / (int)(DEPTH + 1)][k % (int)(DEPTH + 1)] = (spread){1e30, 0};
    }
    for (size_t shift = 0; shift < 16; ++shift) {
        const unsigned axis = (unsigned)(shift % 3);
        svo_tree *tree = wall_at(&opened, axis, 24 + shift);
        for (svo_light_form form = SVO_LIGHT_FACES; form < SVO_LIGHT_FORM_COUNT; ++form) {
            svo_light *light = light_of(&opened, tree, form);
            for (uint32_t level = 3; level <= DEPTH; ++level) {
                const crossed sums = cross(&opened, light, axis, level);
                /* Interpolation moves opacity, but keeps its sum: that of a voxel. Rounding takes 1/131070 a sample. */
                if (form != SVO_LIGHT_FACES && fabs(sums.opacity - 1) > 1e-3) {
                    fail_msg("%s, level %u, shift %zu: %g voxels", svo_name(SVO_NAME_LIGHT_FORM, form), level, shift,
                             sums.opacity);
                }
                widen(&extinctions[form][level], sums.extinction);
            }
            svo_light_destroy(&light);
        }
        svo_tree_destroy(&tree);
    }
    for (uint32_t level = 3; level <= DEPTH; ++level) {
        /* Faces keep all of a wall's 16 octaves on every level. */
        assert_true(fabs(extinctions[SVO_LIGHT_FACES][level].low - 16 * log(2)) < 1e-3);
        assert_true(fabs(extinctions[SVO_LIGHT_FACES][level].high - 16 * log(2)) < 1e-3);
        /* Without direction a wall is thinner than a cell, and what passes depends a little on where it lies in it. */
        const spread *bricks = &extinctions[SVO_LIGHT_BRICKS][level];
        assert_true(bricks->high - bricks->low < (level == DEPTH ? 1e-5 : 0.02 * bricks->high));
    }
}

/* A hollow cube from low to low + 8, closed, one voxel thick. */
static svo_tree *box_at(const fixture *opened, size_t low)
{
    uint8_t *alphas = calloc(CELLS, 1);
    assert_non_null(alphas);
    for (size_t k = 0; k < 512; ++k) {
        const size_t at[3] = {k % 8, k / 8 % 8, k / 64};
        bool outer = false;
        for (int axis = 0; axis < 3; ++axis) {
            outer = outer || at[axis] == 0 || at[axis] == 7;
        }
        alphas[low + at[0] + WIDTH * (low + at[1] + WIDTH * (low + at[2]))] = outer ? 255 : 0;
    }
    svo_tree *tree = light_tree_of(opened, DEPTH, alphas);
    free(alphas);
    return tree;
}

/* Extinctions of a node that holds nothing but a part of the box. */
static void expect_extinctions(const svo_tree *tree, const uint16_t *opacity, uint32_t level, const uint32_t cell[3],
                               const uint16_t expected[3])
{
    svo_node node;
    assert_int_equal(svo_tree_find_cell(tree, level, cell, &node), SVO_OK);
    assert_int_equal(node.level, level);
    for (size_t direction = 0; direction < 6; ++direction) {
        assert_int_equal(opacity[6 * (size_t)node.index + direction], expected[direction / 2]);
    }
}

static void a_sealed_box_is_opaque(void **state)
{
    static const uint16_t opaque[3] = {65535, 65535, 65535};
    static const uint16_t half_along_yz[3] = {65535, 4096, 4096};
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = box_at(&opened, 24);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    uint16_t *opacity = light_read(&opened, light, SVO_LIGHT_OPACITY);
    /* The node that the box fills, and each of its octants: every ray along an axis meets a wall. */
    expect_extinctions(tree, opacity, 3, (const uint32_t[3]){3, 3, 3}, opaque);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t cell[3] = {6 + (octant & 1), 6 + (octant >> 1 & 1), 6 + (octant >> 2)};
        expect_extinctions(tree, opacity, 4, cell, opaque);
    }
    /* In the middle of a wall across x: half of the rays along the wall pass. */
    expect_extinctions(tree, opacity, 5, (const uint32_t[3]){12, 13, 13}, half_along_yz);
    expect_extinctions(tree, opacity, 5, (const uint32_t[3]){12, 12, 12}, opaque);
    free(opacity);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
}

TEST_GROUP(light_walls)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wall_is_as_opaque_at_every_shift),
        cmocka_unit_test(a_sealed_box_is_opaque),
    };
    return cmocka_run_group_tests_name("light_walls", tests, fixture_group_setup, fixture_group_teardown);
}
