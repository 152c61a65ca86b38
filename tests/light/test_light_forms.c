/* SPDX-License-Identifier: MIT */
/*
 * Opacity in its three forms: each stored value against a dense grid that is filtered by the formulas, what bricks have
 * in common, the fields between stored values, and boxes that let nothing through.
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
#include "light_scene.h"
#include "support/meshes.h"
#include "support/suite.h"

#define DEPTH LIGHT_SCENE_DEPTH
#define WIDTH LIGHT_SCENE_WIDTH

/* ---- stored values ---- */

static void check_value(const char *what, const svo_node *node, uint32_t value, double stored, double expected)
{
    if (stored != expected) {
        fail_msg("%s: level %u, cell %u %u %u, value %u is %g instead of %g", what, node->level, node->cell[0],
                 node->cell[1], node->cell[2], value, stored, expected);
    }
}

static double extinction_of(double opacity)
{
    return opacity > 65533 ? 65535 : 4096 * log2(65535 / (65535 - opacity));
}

/* A random scene of either kind. */
static void open_kind(const fixture *opened, int kind, uint64_t seed, svo_light_form form, light_scene *out)
{
    if (kind == 0) {
        light_scene_open(opened, seed, form, out);
    } else {
        light_scene_open_mesh(opened, seed, form, out);
        assert_int_equal(light_info_of(out->light).opacity, SVO_OPACITY_AREA);
    }
}

static void check_voxels(const fixture *opened, const light_scene *scene)
{
    for (uint32_t index = 0; index < scene->info.node_count; ++index) {
        svo_node node;
        light_succeed(opened, svo_tree_find_node(scene->tree, index, &node));
        const int cell[3] = {(int)node.cell[0], (int)node.cell[1], (int)node.cell[2]};
        check_value("voxels", &node, 0, scene->opacity[index], light_levels_get(&scene->levels, node.level, cell, 0));
    }
}

static void every_node_has_the_opacity_of_a_dense_grid(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (int kind = 0; kind < 2; ++kind) {
        light_scene scene;
        open_kind(&opened, kind, 1, SVO_LIGHT_VOXELS, &scene);
        check_voxels(&opened, &scene);
        light_scene_close(&scene);
    }
}

static void check_faces(const fixture *opened, const light_scene *scene)
{
    for (uint32_t index = 0; index < scene->info.node_count; ++index) {
        svo_node node;
        light_succeed(opened, svo_tree_find_node(scene->tree, index, &node));
        const int cell[3] = {(int)node.cell[0], (int)node.cell[1], (int)node.cell[2]};
        for (uint32_t direction = 0; direction < 6; ++direction) {
            const double expected = extinction_of(light_levels_get(&scene->levels, node.level, cell, direction));
            const double stored = scene->opacity[6 * (size_t)index + direction];
            check_value("faces", &node, direction, fabs(stored - expected) < 0.51 ? expected : stored, expected);
        }
    }
}

static void every_face_has_the_extinction_of_a_dense_grid(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (int kind = 0; kind < 2; ++kind) {
        light_scene scene;
        open_kind(&opened, kind, 2, SVO_LIGHT_FACES, &scene);
        check_faces(&opened, &scene);
        light_scene_close(&scene);
    }
}

/* The area that a node covers of its face is that of its leaves. */
static void covers_add_up(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    light_scene scene;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    light_scene_open_mesh(&opened, 4, SVO_LIGHT_FACES, &scene);
    light_succeed(&opened, svo_tree_get_arrays(scene.tree, &arrays));
    uint16_t *cover = light_read(&opened, scene.light, SVO_LIGHT_COVER);
    for (uint32_t index = (uint32_t)scene.info.node_count; index-- > 0;) {
        const bool leaf = index >= scene.info.inner_count;
        const uint32_t children = leaf ? 0 : (uint32_t)__builtin_popcount(arrays.child_mask[index]);
        for (size_t direction = 0; direction < 6; ++direction) {
            double sum = 0;
            for (uint32_t child = 0; child < children; ++child) {
                sum += cover[6 * (size_t)(arrays.first_child[index] + child) + direction];
            }
            const double alpha = leaf ? arrays.colors[4 * (size_t)index + 3] / 255.0 : 0;
            const double expected =
                leaf ? alpha * arrays.areas[6 * (index - scene.info.inner_count) + direction] : sum / 4;
            assert_true(fabs(cover[6 * (size_t)index + direction] - fmin(expected, 65535)) <= 0.5001);
        }
    }
    free(cover);
    light_scene_close(&scene);
}

static void check_bricks(const fixture *opened, const light_scene *scene)
{
    assert_int_equal(light_info_of(scene->light).bytes[SVO_LIGHT_OPACITY], 27 * 2 * scene->info.inner_count);
    for (uint32_t index = 0; index < scene->info.inner_count; ++index) {
        svo_node node;
        light_succeed(opened, svo_tree_find_node(scene->tree, index, &node));
        for (uint32_t sample = 0; sample < 27; ++sample) {
            int at[3];
            light_scene_place(&node, sample, at);
            check_value("bricks", &node, sample, scene->opacity[27 * (size_t)index + sample],
                        light_levels_get(&scene->levels, node.level + 1, at, 0));
        }
    }
}

static void every_sample_is_that_of_a_dense_lattice(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (int kind = 0; kind < 2; ++kind) {
        light_scene scene;
        open_kind(&opened, kind, 3, SVO_LIGHT_BRICKS, &scene);
        check_bricks(&opened, &scene);
        light_scene_close(&scene);
    }
}

/* The sum over the points of a level's lattice, each counted once; bricks that share a point must agree. *points: how
   many there are. */
static double sum_of_points(const fixture *opened, const light_scene *scene, uint32_t level, size_t *points)
{
    const size_t width = ((size_t)1 << level) + 1;
    int32_t *seen = malloc(width * width * width * sizeof *seen);
    double sum = 0;
    *points = 0;
    assert_non_null(seen);
    memset(seen, 255, width * width * width * sizeof *seen);
    for (uint32_t index = scene->info.level_begin[level - 1]; index < scene->info.level_begin[level]; ++index) {
        svo_node node;
        light_succeed(opened, svo_tree_find_node(scene->tree, index, &node));
        for (uint32_t sample = 0; sample < 27; ++sample) {
            int at[3];
            light_scene_place(&node, sample, at);
            int32_t *there = seen + (size_t)at[0] + width * ((size_t)at[1] + width * (size_t)at[2]);
            const int32_t value = scene->opacity[27 * (size_t)index + sample];
            assert_true(*there < 0 || *there == value);
            sum += *there < 0 ? value : 0;
            *points += *there < 0 ? 1 : 0;
            *there = value;
        }
    }
    free(seen);
    return sum;
}

static void bricks_agree_and_keep_the_sum(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint64_t seed = 10; seed < 13; ++seed) {
        light_scene scene;
        light_scene_open(&opened, seed, SVO_LIGHT_BRICKS, &scene);
        svo_light *voxels = light_of(&opened, scene.tree, SVO_LIGHT_VOXELS);
        uint16_t *leaves = light_read(&opened, voxels, SVO_LIGHT_OPACITY);
        double below = 0;
        for (size_t leaf = scene.info.inner_count; leaf < scene.info.node_count; ++leaf) {
            below += leaves[leaf];
        }
        for (uint32_t level = DEPTH; level >= 1; --level) {
            size_t points;
            const double sum = sum_of_points(&opened, &scene, level, &points);
            const double factor = level == DEPTH ? 1 : 8; /* a leaf has eight corners */
            /* A rounded point is off by a half at most. */
            if (fabs(factor * sum - below) > factor / 2 * (double)points) {
                fail_msg("level %u: %g x %.0f over %zu points is not %.0f", level, factor, sum, points, below);
            }
            below = sum;
        }
        free(leaves);
        svo_light_destroy(&voxels);
        light_scene_close(&scene);
    }
}

/* ---- fields ---- */

/* The field at a point of a level, between the values of a dense grid: faces in octaves, else opacity. */
static double dense_field(const light_levels *levels, const light_probe *probe, uint32_t value)
{
    const double cell = (double)(1u << (levels->depth - probe->level));
    double sum = 0;
    int low[3];
    double part[3];
    for (int axis = 0; axis < 3; ++axis) {
        const double at = probe->position[axis] / cell - (levels->form == SVO_LIGHT_FACES ? 0.5 : 0.0);
        low[axis] = (int)floor(at);
        part[axis] = levels->form == SVO_LIGHT_VOXELS ? 0 : at - floor(at);
    }
    for (unsigned corner = 0; corner < 8; ++corner) {
        double weight = 1;
        int at[3];
        for (int axis = 0; axis < 3; ++axis) {
            const int side = (int)(corner >> axis & 1u);
            at[axis] = low[axis] + side;
            weight *= side != 0 ? part[axis] : 1 - part[axis];
        }
        const double found = light_levels_get(levels, probe->level, at, value);
        sum += weight * (levels->form == SVO_LIGHT_FACES ? extinction_of(found) / 4096 : found / 65535);
    }
    return sum;
}

static double expected_extinction(const light_levels *levels, const light_probe *probe)
{
    if (levels->form != SVO_LIGHT_FACES) {
        return fmin(-log(1 - fmin(dense_field(levels, probe, 0), 1 - 1e-12)), 16 * log(2));
    }
    double sum = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const uint32_t direction = 2 * axis + (probe->direction[axis] < 0 ? 1 : 0);
        sum += fabs((double)probe->direction[axis]) * dense_field(levels, probe, direction) * log(2);
    }
    return sum;
}

static void make_probes(uint64_t seed, light_probe *probes, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        double length = 0;
        double direction[3];
        for (int axis = 0; axis < 3; ++axis) {
            probes[i].position[axis] = (float)(random_unit(&seed) * (double)WIDTH);
            direction[axis] = random_unit(&seed) - 0.5;
            length += direction[axis] * direction[axis];
        }
        for (int axis = 0; axis < 3; ++axis) {
            probes[i].direction[axis] = (float)(direction[axis] / sqrt(length));
        }
        probes[i].level = 1 + random_below(&seed, DEPTH);
        probes[i].with_light = (uint32_t)(i % 2);
        probes[i].in_pair = probes[i].level < DEPTH ? (uint32_t)(i % 3) : (uint32_t)(i % 3 % 2);
    }
}

enum { PROBES = 20000 };

/* The field is 0 as far as the sample at the probe says. */
static void check_empty(const light_levels *levels, const light_probe *probe, float empty)
{
    for (int k = 1; k < 8; ++k) {
        light_probe further = *probe;
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) {
            further.position[axis] += probe->direction[axis] * empty * (float)k / 8;
            inside = inside && further.position[axis] > 0 && further.position[axis] < (float)WIDTH;
        }
        if (inside && expected_extinction(levels, &further) != 0) {
            fail_msg("level %u at %g %g %g: not empty over %g of %g", probe->level, probe->position[0],
                     probe->position[1], probe->position[2], empty * (float)k / 8, empty);
        }
    }
}

static void fields_are_those_of_dense_grids(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    light_probe *probes = malloc(PROBES * sizeof *probes);
    light_sample *samples = malloc(PROBES * sizeof *samples);
    assert_non_null(probes);
    assert_non_null(samples);
    make_probes(7, probes, PROBES);
    for (svo_light_form form = SVO_LIGHT_FACES; form < SVO_LIGHT_FORM_COUNT; ++form) {
        light_scene scene;
        size_t not_zero = 0;
        size_t skips = 0;
        light_scene_open(&opened, 20 + (uint64_t)form, form, &scene);
        light_probe_field(&opened, scene.light, probes, samples, PROBES);
        for (size_t i = 0; i < PROBES; ++i) {
            const double expected = expected_extinction(&scene.levels, &probes[i]);
            if (fabs(samples[i].extinction - expected) > 2e-4 + 1e-4 * expected) {
                fail_msg("%s, level %u at %g %g %g: extinction %g instead of %g", svo_name(SVO_NAME_LIGHT_FORM, form),
                         probes[i].level, probes[i].position[0], probes[i].position[1], probes[i].position[2],
                         samples[i].extinction, expected);
            }
            assert_true(samples[i].empty == 0 || expected == 0);
            if (samples[i].empty > 0) {
                check_empty(&scene.levels, &probes[i], samples[i].empty);
            }
            not_zero += expected > 0 ? 1 : 0;
            skips += samples[i].empty > 0 ? 1 : 0;
        }
        assert_true(not_zero > PROBES / 8 && skips > PROBES / 50);
        light_scene_close(&scene);
    }
    free(probes);
    free(samples);
}

TEST_GROUP(light_forms)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_node_has_the_opacity_of_a_dense_grid),
        cmocka_unit_test(every_face_has_the_extinction_of_a_dense_grid),
        cmocka_unit_test(covers_add_up),
        cmocka_unit_test(every_sample_is_that_of_a_dense_lattice),
        cmocka_unit_test(bricks_agree_and_keep_the_sum),
        cmocka_unit_test(fields_are_those_of_dense_grids),
    };
    return cmocka_run_group_tests_name("light_forms", tests, fixture_group_setup, fixture_group_teardown);
}
