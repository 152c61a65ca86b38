/* SPDX-License-Identifier: MIT */
/*
 * Photons that go on: from triangles that emit, from what they met, and through what shows in part. Flux and radiance
 * against closed forms; the same bytes on every run.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "cone_scene.h"
#include "support/suite.h"

#define DEPTH   6u
#define PI      3.14159265358979323846
#define PHOTONS (1u << 17)
#define POINTS  64

static const svo_finish lamp[2] = {{.emission = {0, 0, 0}}, {.emission = {5, 2.5F, 1}}};

static void check_share(const char *what, double value, double expected, double share)
{
    print_message("%s: %.6f, expected %.6f\n", what, value, expected);
    if (!(fabs(value - expected) <= share * expected)) {
        fail_msg("%s is %.9g instead of %.9g, within %g %%", what, value, expected, 100 * share);
    }
}

/* The tree of a scene whose triangles from `plain` on have material 1. */
static svo_tree *build(const fixture *opened, const cone_scene *scene, size_t plain, uint8_t gray, uint8_t alpha)
{
    const uint8_t colors[2][4] = {{gray, gray, gray, 255}, {gray, gray, gray, alpha}};
    return cone_scene_build_colored(opened, scene, plain, colors,
                                    SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_MATERIAL | SVO_NEED_RAYS |
                                        SVO_NEED_PROJECTED_AREA);
}

/* A horizontal quad of sides 2 a and 2 b. */
static void add_plane(cone_scene *scene, double a, double b, double z)
{
    const double corner[3] = {-a, -b, z};
    const double u[3] = {2 * a, 0, 0};
    const double v[3] = {0, 2 * b, 0};
    cone_scene_add_quad(scene, corner, u, v);
}

static void check_message(const fixture *opened, const char *text)
{
    if (strstr(svo_device_message(opened->device), text) == NULL) {
        fail_msg("'%s' does not say '%s'", svo_device_message(opened->device), text);
    }
}

/* ---- emission ---- */

/* A quad in a black closed room: all that both of its sides emit comes to leaves, in all forms and by any number of
   photons. */
static void rooms_keep_all_that_is_emitted(void **state)
{
    static const uint32_t counts[] = {PHOTONS, 1000, 1};
    const fixture opened = fixture_cl_of_group(state);
    const double half[3] = {20, 15, 12};
    cone_scene *scene = cone_scene_new(DEPTH, 31);
    cone_scene_pose(scene, true, 2);
    cone_scene_add_room(scene, half);
    const size_t plain = scene->triangle_count;
    add_plane(scene, 6, 4, 3);
    svo_tree *tree = build(&opened, scene, plain, 0, 255);
    for (int k = 0; k < 9; ++k) {
        svo_light *light = light_of(&opened, tree, (svo_light_form)(k / 3));
        const svo_light_setup setup = {
            .struct_size = sizeof setup, .finishes = lamp, .finish_count = 2, .emission_photons = counts[k % 3]};
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        const svo_light_info info = light_info_of(light);
        assert_int_equal(info.photons, counts[k % 3]);
        assert_int_equal(info.photon_hits, counts[k % 3]);
        assert_int_equal(info.sent_photons, 0);
        for (int channel = 0; channel < 3; ++channel) {
            const double emitted = 2 * PI * 96 * (double)lamp[1].emission[channel];
            check_share("stored flux", info.flux[channel], emitted, 2e-6);
        }
        assert_true(info.lost_flux < 1e-4);
        svo_light_destroy(&light);
    }
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* The share of what one of two equal rectangles emits that meets the other one, opposite (Howell, "A Catalog of
   Radiation Heat Transfer Configuration Factors", C-11). x, y: sides in units of their distance. */
static double opposite_factor(double x, double y)
{
    const double a = sqrt(1 + x * x);
    const double b = sqrt(1 + y * y);
    return 2 / (PI * x * y) *
           (log(a * b / sqrt(1 + x * x + y * y)) + x * b * atan(x / b) + y * a * atan(y / a) - x * atan(x) -
            y * atan(y));
}

/* A quad over an equal black one: half of the light goes up, and of the other half a plate has its form factor. */
static void plates_get_their_form_factor(void **state)
{
    static const double distances[] = {4, 12, 24};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < 3; ++i) {
        cone_scene *scene = cone_scene_new(DEPTH, 32 + i);
        cone_scene_pose(scene, true, 2);
        add_plane(scene, 12, 8, -distances[i] / 2);
        add_plane(scene, 12, 8, distances[i] / 2);
        svo_tree *tree = build(&opened, scene, 2, 0, 255);
        svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
        const svo_light_setup setup = {
            .struct_size = sizeof setup, .finishes = lamp, .finish_count = 2, .emission_photons = PHOTONS};
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        const svo_light_info info = light_info_of(light);
        const double share = opposite_factor(24 / distances[i], 16 / distances[i]);
        check_share("flux of a plate", info.flux[0], PI * 5 * 24 * 16 * share, 0.004);
        svo_light_destroy(&light);
        svo_tree_destroy(&tree);
        cone_scene_free(scene);
    }
}

/* What has no alpha emits nothing. */
static void clear_emitters_are_dark(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 35);
    cone_scene_pose(scene, false, 2);
    add_plane(scene, 12, 8, -6);
    add_plane(scene, 12, 8, 6);
    svo_tree *tree = build(&opened, scene, 2, 0, 0);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .finishes = lamp, .finish_count = 2, .emission_photons = PHOTONS};
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    assert_int_equal(light_info_of(light).photons, 0);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* ---- bounces ---- */

static double mean_irradiance(const cone_scene *scene, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
        sum += (double)scene->results[i].irradiance[1] / (double)count;
    }
    return sum;
}

static void add_points(cone_scene *scene, const double half[3])
{
    static const double up[3] = {0, 0, 1};
    for (int i = 0; i < POINTS; ++i) {
        const int column = i % 8;
        const int row = i / 8;
        const double position[3] = {half[0] * (0.1875 * column - 0.65), half[1] * (0.1875 * row - 0.65), -half[2]};
        cone_scene_add_point(scene, position, up, 0);
    }
}

/* A closed room of albedo a that emits e: emission and n reflections of it are e (1 - a^(n + 1)) / (1 - a). */
static void furnaces_have_all_reflections(void **state)
{
    static const uint8_t grays[] = {0, 188, 225};
    static const uint32_t bounces[] = {0, 2, 5, 64};
    static const svo_finish glowing[2] = {{.emission = {0.5F, 0.5F, 0.5F}}, {.emission = {0.5F, 0.5F, 0.5F}}};
    const double half[3] = {14, 16, 20};
    const fixture opened = fixture_cl_of_group(state);
    for (int k = 0; k < 12; ++k) {
        const int gray = k / 4;
        const double albedo = gray == 0 ? 0 : pow((grays[gray] / 255.0 + 0.055) / 1.055, 2.4);
        const double reflections = bounces[k % 4] > 0 ? bounces[k % 4] : 1;
        cone_scene *scene = cone_scene_new(DEPTH, 36);
        cone_scene_pose(scene, false, 2);
        cone_scene_add_room(scene, half);
        add_points(scene, half);
        svo_tree *tree = build(&opened, scene, scene->triangle_count, grays[k / 4], 255);
        svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
        const svo_light_setup setup = {.struct_size = sizeof setup,
                                       .finishes = glowing,
                                       .finish_count = 2,
                                       .emission_photons = PHOTONS,
                                       .bounces = bounces[k % 4]};
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        cone_scene_gather(&opened, scene, light, NULL);
        const double truth = 0.5 * (1 - pow(albedo, reflections + 1)) / (1 - albedo);
        check_share("radiance in a furnace", mean_irradiance(scene, POINTS) / PI, truth, 0.02);
        /* What is stored, without cones: each reflection has albedo times the flux of the one before. Half of the
           emission leaves outwards. */
        const double emitted = PI * 0.5 * 8 * (half[0] * half[1] + half[0] * half[2] + half[1] * half[2]);
        check_share("flux in a furnace", light_info_of(light).flux[2],
                    emitted * (1 - pow(albedo, reflections)) / (1 - albedo), 0.002);
        svo_light_destroy(&light);
        svo_tree_destroy(&tree);
        cone_scene_free(scene);
    }
}

/* Photons of sources bounce likewise: in a closed room all of a lamp's flux comes again, times the albedo. */
static void photons_of_sources_bounce(void **state)
{
    static const uint32_t bounces[] = {1, 2, 3, 64};
    const double half[3] = {20, 15, 12};
    const double albedo = pow((188 / 255.0 + 0.055) / 1.055, 2.4);
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 37);
    cone_scene_pose(scene, true, 2);
    cone_scene_add_room(scene, half);
    svo_tree *tree = build(&opened, scene, scene->triangle_count, 188, 255);
    svo_light_source source = {.kind = SVO_SOURCE_POINT, .value = {1, 2, 4}};
    for (int axis = 0; axis < 3; ++axis) {
        source.position[axis] = (float)scene->center[axis];
    }
    for (int k = 0; k < 12; ++k) {
        svo_light *light = light_of(&opened, tree, (svo_light_form)(k / 4));
        const svo_light_setup setup = {
            .struct_size = sizeof setup, .sources = &source, .source_count = 1, .bounces = bounces[k % 4]};
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        const svo_light_info info = light_info_of(light);
        assert_int_equal(info.photon_hits, info.photons);
        assert_true(k % 4 > 0 || info.sent_photons == 0);
        for (int channel = 0; channel < 3; ++channel) {
            const double all = 4 * PI * (double)source.value[channel];
            check_share("flux of a lamp", info.flux[channel], all * (1 - pow(albedo, bounces[k % 4])) / (1 - albedo),
                        0.002);
        }
        svo_light_destroy(&light);
    }
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* A lamp in a closed room, by cones beside many paths: with photons they have what surfaces reflect of it. */
static void emitters_light_rooms_for_cones(void **state)
{
    const double half[3] = {20, 20, 12};
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 38);
    double found[4][POINTS]; /* paths and cones, of emission alone and of all reflections */
    cone_scene_pose(scene, true, 2);
    cone_scene_add_room(scene, half);
    const size_t plain = scene->triangle_count;
    add_plane(scene, 5, 5, 7);
    add_points(scene, half);
    svo_tree *tree = build(&opened, scene, plain, 188, 255);
    for (int k = 0; k < 4; ++k) {
        const bool of_all = k % 2 == 1;
        svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
        const svo_gather_options paths = {.struct_size = sizeof paths, .paths = 1024, .bounces = of_all ? 64 : 1};
        const svo_light_setup setup = {.struct_size = sizeof setup,
                                       .finishes = lamp,
                                       .finish_count = 2,
                                       .emission_photons = of_all ? PHOTONS : 0,
                                       .bounces = 64};
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        cone_scene_gather(&opened, scene, light, k < 2 ? &paths : NULL);
        for (int i = 0; i < POINTS; ++i) {
            found[k][i] = (double)scene->results[i].irradiance[1];
        }
        svo_light_destroy(&light);
    }
    double sums[2] = {0, 0};
    double errors[2] = {0, 0};
    for (int i = 0; i < POINTS; ++i) {
        for (int k = 0; k < 2; ++k) {
            sums[k] += (found[2 * k + 1][i] - found[2 * k][i]) / POINTS;
            errors[k] += pow(found[2 + k][i] / found[1][i] - 1, 2) / POINTS;
        }
    }
    print_message("cones, relative RMSE without and with photons: %.3f, %.3f\n", sqrt(errors[0]), sqrt(errors[1]));
    check_share("reflected light of a lamp", sums[1], sums[0], 0.1);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* ---- what shows in part ---- */

/* A card under a sun catches its alpha's share, and what is below has the rest. */
static void cards_catch_their_alpha(void **state)
{
    static const uint8_t alphas[] = {0, 64, 128, 254, 255};
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, 0, -1}, .value = {1, 2, 3}};
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .sources = &sun, .source_count = 1, .view_resolution = 400, .photon_alpha = 1};
    const fixture opened = fixture_cl_of_group(state);
    for (int k = 0; k < 10; ++k) {
        const bool has_floor = k >= 5;
        cone_scene *scene = cone_scene_new(DEPTH, 39);
        cone_scene_pose(scene, false, 2);
        if (has_floor) {
            add_plane(scene, 15, 15, -10);
        }
        add_plane(scene, 10, 10, 5);
        svo_tree *tree = build(&opened, scene, has_floor ? 2 : 0, 188, alphas[k % 5]);
        svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        const double catches = has_floor ? 900 : 400.0 * alphas[k % 5] / 255;
        check_share("light of a card and what is below", light_info_of(light).flux[1], 2 * catches, 0.01);
        svo_light_destroy(&light);
        svo_tree_destroy(&tree);
        cone_scene_free(scene);
    }
}

/* Twelve cards of half an alpha behind each other: each photon decides at each anew. */
static void layers_decide_on_their_own(void **state)
{
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, 0, -1}, .value = {1, 1, 1}};
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .sources = &sun, .source_count = 1, .view_resolution = 400, .photon_alpha = 1};
    const fixture opened = fixture_cl_of_group(state);
    for (int cards = 2; cards <= 12; cards += 5) {
        cone_scene *scene = cone_scene_new(DEPTH, 40);
        cone_scene_pose(scene, false, 0);
        for (int k = 0; k < cards; ++k) {
            add_plane(scene, 20, 20, 4 * k - 22.5);
        }
        svo_tree *tree = build(&opened, scene, 0, 188, 51);
        svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        check_share("light of cards", light_info_of(light).flux[0], 1600 * (1 - pow(0.8, cards)), 0.01);
        svo_light_destroy(&light);
        svo_tree_destroy(&tree);
        cone_scene_free(scene);
    }
}

/* ---- as a whole ---- */

/* The same bytes again, and after updates that cost a whole pass. */
static void photons_that_go_on_are_the_same_on_every_run(void **state)
{
    const double half[3] = {20, 15, 12};
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 41);
    cone_scene_pose(scene, true, 2);
    cone_scene_add_room(scene, half);
    add_plane(scene, 10, 9, -4);
    add_plane(scene, 6, 4, 3);
    svo_tree *tree = build(&opened, scene, scene->triangle_count - 2, 188, 140);
    svo_light_source source = {.kind = SVO_SOURCE_POINT, .value = {100, 200, 400}};
    for (int axis = 0; axis < 3; ++axis) {
        source.position[axis] = (float)scene->center[axis];
    }
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        const svo_light_setup setup = {.struct_size = sizeof setup,
                                       .sources = &source,
                                       .source_count = 1,
                                       .finishes = lamp,
                                       .finish_count = 2,
                                       .updatable = 1,
                                       .photon_alpha = 1,
                                       .emission_photons = 20001,
                                       .bounces = 4};
        char texts[3][SVO_HASH_TEXT_BYTES];
        svo_light *light = light_of(&opened, tree, (svo_light_form)form);
        for (int run = 0; run < 3; ++run) {
            light_succeed(&opened, run < 2 ? svo_light_set_sources(light, &setup, opened.queue)
                                           : svo_light_update(light, tree, NULL, 0, opened.queue));
            light_succeed(&opened, svo_light_hash(light, opened.queue, texts[run]));
            assert_string_equal(texts[run], texts[0]);
        }
        assert_true(light_info_of(light).sent_photons > light_info_of(light).photons);
        svo_light_destroy(&light);
    }
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

static void numbers_have_limits(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_tree *tree = light_tree_of(&opened, 1, (const uint8_t[8]){255});
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_VOXELS);
    svo_light_setup setup = {.struct_size = sizeof setup, .bounces = 65};
    assert_int_equal(svo_light_set_sources(light, &setup, opened.queue), SVO_INVALID_ARGUMENT);
    check_message(&opened, "svo_light_set_sources: setup.bounces 65 is above 64");
    setup.bounces = 64;
    setup.emission_photons = SVO_EMISSION_PHOTONS_MAX + 1;
    assert_int_equal(svo_light_set_sources(light, &setup, opened.queue), SVO_INVALID_ARGUMENT);
    check_message(&opened, "svo_light_set_sources: setup.emission_photons 1073741825 is above 1073741824");
    setup.emission_photons = SVO_EMISSION_PHOTONS_MAX;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue)); /* nothing emits */
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
}

TEST_GROUP(light_sent)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rooms_keep_all_that_is_emitted),
        cmocka_unit_test(plates_get_their_form_factor),
        cmocka_unit_test(clear_emitters_are_dark),
        cmocka_unit_test(furnaces_have_all_reflections),
        cmocka_unit_test(photons_of_sources_bounce),
        cmocka_unit_test(emitters_light_rooms_for_cones),
        cmocka_unit_test(cards_catch_their_alpha),
        cmocka_unit_test(layers_decide_on_their_own),
        cmocka_unit_test(photons_that_go_on_are_the_same_on_every_run),
        cmocka_unit_test(numbers_have_limits),
    };
    return cmocka_run_group_tests_name("light_sent", tests, fixture_group_setup, fixture_group_teardown);
}
