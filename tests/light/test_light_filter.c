/* SPDX-License-Identifier: MIT */
/*
 * Radiance of given leaves, filtered upwards: where there is any, against dense grids; what fields make of it; and the
 * logarithm that opacities are stored by.
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

#include "light/extinction.clh"
#include "light/radiance_filter.h"
#include "light_scene.h"
#include "support/meshes.h"
#include "support/suite.h"

/* ---- the logarithm ---- */

static void extinctions_are_logarithms(void **state)
{
    (void)state;
    for (uint32_t opacity = 0; opacity < SVO_OPACITY_ONE - 1; ++opacity) {
        const double exact = 4096 * (log2(65535.0) - log2(65535.0 - opacity));
        if (fabs(svo_extinction_of(opacity) - exact) > 0.505) {
            fail_msg("opacity %u: %u instead of %g", opacity, svo_extinction_of(opacity), exact);
        }
    }
    assert_int_equal(svo_extinction_of(0), 0);
    assert_int_equal(svo_extinction_of(SVO_OPACITY_ONE), SVO_EXTINCTION_MAX);
}

static void what_passes_is_their_power(void **state)
{
    (void)state;
    for (uint32_t extinction = 0; extinction < SVO_EXTINCTION_MAX; ++extinction) {
        const double exact = 65535 * exp2(-(double)extinction / 4096);
        if (fabs(svo_passing_of(extinction) - exact) > 0.505) {
            fail_msg("extinction %u: %u instead of %g", extinction, svo_passing_of(extinction), exact);
        }
    }
    assert_int_equal(svo_passing_of(SVO_EXTINCTION_MAX), 0);
}

/* ---- lit leaves ---- */

/* Radiance of some leaves: every other one in half of the grid. Others are dark. */
typedef struct lit_leaves {
    uint32_t *leaves;
    uint32_t *values; /* as svo_i_lit_leaves.radiance; green is half of red, blue a quarter */
    double *dense; /* red, premultiplied, six values for each cell of the grid */
    uint64_t count;
} lit_leaves;

static uint32_t values_of(svo_light_form form)
{
    return form == SVO_LIGHT_FACES ? 6 : 1;
}

static void add_leaf(const light_scene *scene, uint32_t leaf, const svo_node *node, uint64_t *seed, lit_leaves *out)
{
    const size_t cell = node->cell[0] + LIGHT_SCENE_WIDTH * (node->cell[1] + LIGHT_SCENE_WIDTH * (size_t)node->cell[2]);
    const uint32_t count = values_of(scene->levels.form);
    for (uint32_t direction = 0; direction < count; ++direction) {
        const uint32_t red = 1000 + random_word(seed) / 4;
        uint32_t *value = out->values + 3 * (count * out->count + direction);
        value[0] = red;
        value[1] = red / 2;
        value[2] = red / 4;
        out->dense[6 * cell + direction] = count == 6 ? red : red * (scene->alphas[cell] / 255.0);
    }
    out->leaves[out->count++] = leaf;
}

static void make_lit(const fixture *opened, const light_scene *scene, lit_leaves *out)
{
    uint64_t seed = 99;
    *out = (lit_leaves){.leaves = calloc((size_t)scene->info.leaf_count, sizeof(uint32_t)),
                        .values = calloc((size_t)scene->info.leaf_count, 18 * sizeof(uint32_t)),
                        .dense = calloc(LIGHT_SCENE_CELLS, 6 * sizeof(double))};
    assert_non_null(out->leaves);
    assert_non_null(out->values);
    assert_non_null(out->dense);
    for (uint32_t leaf = 0; leaf < scene->info.leaf_count; leaf += 2) {
        svo_node node;
        light_succeed(opened, svo_tree_find_node(scene->tree, (uint32_t)scene->info.inner_count + leaf, &node));
        if (node.cell[0] < LIGHT_SCENE_WIDTH / 2) {
            add_leaf(scene, leaf, &node, &seed, out);
        }
    }
}

static void free_lit(lit_leaves *lit)
{
    free(lit->leaves);
    free(lit->values);
    free(lit->dense);
}

/* Gives a light these leaves. */
static void light_up(const fixture *opened, const light_scene *scene, const lit_leaves *lit, float unit)
{
    const uint64_t words = 3 * values_of(scene->levels.form) * lit->count;
    svo_i_device_work work;
    svo_i_lit_leaves from = {.lit_count = lit->count, .unit = unit};
    light_succeed(opened, svo_i_work_begin(opened->device, "test", opened->queue, &work));
    light_succeed(opened, svo_i_work_alloc(&work, "leaves", lit->count * sizeof(uint32_t), &from.leaves));
    light_succeed(opened, svo_i_work_alloc(&work, "radiance", words * sizeof(uint32_t), &from.radiance));
    light_succeed(opened, svo_i_work_write(&work, from.leaves, lit->leaves, lit->count * sizeof(uint32_t)));
    light_succeed(opened, svo_i_work_write(&work, from.radiance, lit->values, words * sizeof(uint32_t)));
    light_succeed(opened, svo_i_light_filter(&work, scene->light, &from));
    svo_i_work_end(&work);
}

/* A stored word: red, and whether the others are what they are of it. */
static double red_of(uint32_t word)
{
    const uint32_t red = word & 511u;
    const uint32_t green = word >> 9 & 511u;
    const uint32_t blue = word >> 18 & 511u;
    assert_true(abs((int)red - 2 * (int)green) <= 4 && abs((int)green - 2 * (int)blue) <= 4);
    return ldexp(red, (int)(word >> 27));
}

/* ---- stored radiance ---- */

/* Whether any of a node's values is lit in the dense grid; bricks: of its samples. */
static bool is_lit(const light_levels *levels, const svo_node *node, uint32_t words, double *expected)
{
    bool lit = false;
    for (uint32_t k = 0; k < words; ++k) {
        int at[3] = {(int)node->cell[0], (int)node->cell[1], (int)node->cell[2]};
        uint32_t level = node->level;
        if (levels->form == SVO_LIGHT_BRICKS) {
            light_scene_place(node, k, at);
            ++level;
        }
        expected[k] = light_levels_get(levels, level, at, words == 6 ? k : 0);
        lit = lit || expected[k] > 0;
    }
    return lit;
}

static void check_nodes(const fixture *opened, const light_scene *scene, const light_levels *expected)
{
    const svo_light_info info = light_info_of(scene->light);
    const bool bricks = expected->form == SVO_LIGHT_BRICKS;
    const uint32_t words = bricks ? 27 : values_of(expected->form);
    const uint64_t nodes = bricks ? scene->info.inner_count : scene->info.node_count;
    uint32_t *places = light_read(opened, scene->light, SVO_LIGHT_LIT);
    uint32_t *radiance = light_read(opened, scene->light, SVO_LIGHT_RADIANCE);
    uint32_t lit = 0;
    assert_int_equal(info.bytes[SVO_LIGHT_LIT], nodes * sizeof(uint32_t));
    assert_int_equal(info.bytes[SVO_LIGHT_RADIANCE], info.lit_nodes * words * sizeof(uint32_t));
    for (uint32_t index = 0; index < nodes; ++index) {
        svo_node node;
        double values[27];
        light_succeed(opened, svo_tree_find_node(scene->tree, index, &node));
        const bool is = is_lit(expected, &node, words, values);
        if (is != (places[index] != SVO_NO_NODE)) {
            fail_msg("level %u, cell %u %u %u: lit in one and dark in the other", node.level, node.cell[0],
                     node.cell[1], node.cell[2]);
        }
        lit += is ? 1 : 0;
        for (uint32_t k = 0; is && k < words; ++k) {
            const double stored = red_of(radiance[(size_t)places[index] * words + k]);
            /* A level rounds by 1/512 at most. */
            if (fabs(stored - values[k]) > 0.002 * (LIGHT_SCENE_DEPTH + 1) * values[k] + 1) {
                fail_msg("level %u, cell %u %u %u, value %u: %g instead of %g", node.level, node.cell[0], node.cell[1],
                         node.cell[2], k, stored, values[k]);
            }
        }
    }
    assert_int_equal(lit, info.lit_nodes);
    assert_true(lit > 100 && lit < nodes / 2 + nodes / 4);
    free(places);
    free(radiance);
}

static void stored_radiance_is_that_of_dense_grids(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (svo_light_form form = SVO_LIGHT_FACES; form < SVO_LIGHT_FORM_COUNT; ++form) {
        light_scene scene;
        lit_leaves lit;
        light_levels expected;
        light_scene_open(&opened, 30 + (uint64_t)form, form, &scene);
        make_lit(&opened, &scene, &lit);
        light_levels_make_light(&scene.levels, lit.dense, &expected);
        light_up(&opened, &scene, &lit, 1.0f);
        check_nodes(&opened, &scene, &expected);
        light_levels_free(&expected);
        free_lit(&lit);
        light_scene_close(&scene);
    }
}

/* Bricks that share a point have the same word there; one without radiance counts as 0. */
static void lit_bricks_agree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const size_t width = LIGHT_SCENE_WIDTH + 1;
    light_scene scene;
    lit_leaves lit;
    light_scene_open(&opened, 41, SVO_LIGHT_BRICKS, &scene);
    make_lit(&opened, &scene, &lit);
    light_up(&opened, &scene, &lit, 1.0f);
    uint32_t *places = light_read(&opened, scene.light, SVO_LIGHT_LIT);
    uint32_t *radiance = light_read(&opened, scene.light, SVO_LIGHT_RADIANCE);
    int64_t *seen = malloc(width * width * width * sizeof *seen);
    assert_non_null(seen);
    for (uint32_t level = 0; level < LIGHT_SCENE_DEPTH; ++level) {
        memset(seen, 255, width * width * width * sizeof *seen);
        for (uint32_t index = scene.info.level_begin[level]; index < scene.info.level_begin[level + 1]; ++index) {
            svo_node node;
            light_succeed(&opened, svo_tree_find_node(scene.tree, index, &node));
            for (uint32_t k = 0; k < 27; ++k) {
                int at[3];
                light_scene_place(&node, k, at);
                int64_t *there = seen + (size_t)at[0] + width * ((size_t)at[1] + width * (size_t)at[2]);
                const int64_t word = places[index] != SVO_NO_NODE ? radiance[27 * (size_t)places[index] + k] : 0;
                assert_true(*there < 0 || *there == word);
                *there = word;
            }
        }
    }
    free(seen);
    free(places);
    free(radiance);
    free_lit(&lit);
    light_scene_close(&scene);
}

/* ---- fields of light ---- */

/* Where all leaves have the same radiance, so has the field, whatever the opacity. */
static void field_keeps_a_radiance_that_is_everywhere(void **state)
{
    enum { PROBES = 5000 };
    const fixture opened = fixture_cl_of_group(state);
    static light_probe probes[PROBES];
    static light_sample samples[PROBES];
    uint64_t seed = 5;
    for (size_t i = 0; i < PROBES; ++i) {
        probes[i] = (light_probe){.direction = {0.48f, -0.6f, 0.64f}, .level = random_below(&seed, 6), .with_light = 1};
        for (int axis = 0; axis < 3; ++axis) {
            probes[i].position[axis] = (float)(random_unit(&seed) * (double)LIGHT_SCENE_WIDTH);
        }
    }
    for (svo_light_form form = SVO_LIGHT_FACES; form < SVO_LIGHT_FORM_COUNT; ++form) {
        light_scene scene;
        lit_leaves lit;
        size_t lit_probes = 0;
        light_scene_open(&opened, 50 + (uint64_t)form, form, &scene);
        make_lit(&opened, &scene, &lit);
        lit.count = scene.info.leaf_count;
        for (uint32_t leaf = 0; leaf < lit.count; ++leaf) {
            svo_node node;
            lit.leaves[leaf] = leaf;
            light_succeed(&opened, svo_tree_find_node(scene.tree, (uint32_t)scene.info.inner_count + leaf, &node));
            const uint8_t alpha =
                scene.alphas[node.cell[0] + LIGHT_SCENE_WIDTH * (node.cell[1] + LIGHT_SCENE_WIDTH * node.cell[2])];
            for (uint32_t k = 0; k < 3 * values_of(form); ++k) {
                /* 2^20, times the opacity where radiance is premultiplied. */
                lit.values[3 * values_of(form) * leaf + k] = form == SVO_LIGHT_FACES ? alpha * 4112u + 8u : 1u << 20;
            }
        }
        light_up(&opened, &scene, &lit, 0x1p-20f);
        light_probe_field(&opened, scene.light, probes, samples, PROBES);
        for (size_t i = 0; i < PROBES; ++i) {
            for (int channel = 0; samples[i].opacity > 0 && channel < 3; ++channel) {
                /* An extinction is rounded by 2^-13 octaves. */
                const float found = samples[i].radiance[channel] - samples[i].opacity;
                if (!(fabsf(found) < 0.004f * samples[i].opacity + 1e-4f)) {
                    fail_msg("%s, level %u at %g %g %g: %g of opacity %g is not 1", svo_name(SVO_NAME_LIGHT_FORM, form),
                             probes[i].level, probes[i].position[0], probes[i].position[1], probes[i].position[2],
                             samples[i].radiance[channel], samples[i].opacity);
                }
                ++lit_probes;
            }
        }
        assert_true(lit_probes > PROBES / 4);
        free_lit(&lit);
        light_scene_close(&scene);
    }
}

static void no_lit_leaf_is_dark(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    light_scene scene;
    lit_leaves lit;
    light_scene_open(&opened, 61, SVO_LIGHT_FACES, &scene);
    const uint64_t bytes = light_info_of(scene.light).total_bytes;
    make_lit(&opened, &scene, &lit);
    light_up(&opened, &scene, &lit, 1.0f);
    assert_true(light_info_of(scene.light).total_bytes > bytes);
    lit.count = 0;
    light_up(&opened, &scene, &lit, 1.0f);
    assert_int_equal(light_info_of(scene.light).total_bytes, bytes);
    assert_int_equal(light_info_of(scene.light).lit_nodes, 0);
    assert_null(svo_light_get_buffer(scene.light, SVO_LIGHT_RADIANCE));
    free_lit(&lit);
    light_scene_close(&scene);
}

TEST_GROUP(light_filter)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(extinctions_are_logarithms),
        cmocka_unit_test(what_passes_is_their_power),
        cmocka_unit_test(stored_radiance_is_that_of_dense_grids),
        cmocka_unit_test(lit_bricks_agree),
        cmocka_unit_test(field_keeps_a_radiance_that_is_everywhere),
        cmocka_unit_test(no_lit_leaf_is_dark),
    };
    return cmocka_run_group_tests_name("light_filter", tests, fixture_group_setup, fixture_group_teardown);
}
