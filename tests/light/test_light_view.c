/* SPDX-License-Identifier: MIT */
/*
 * What sources see, as pixels (lib/light/source_views.c): the flux of all photons of a source is its closed form, every
 * point of the tree's box has a pixel of exactly one view, and four pixels fall on a leaf that faces the light.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "light/source_views.h"
#include "support/meshes.h"
#include "support/suite.h"

#define PI      3.14159265358979323846
#define PHOTONS 4096 /* of a band */

static const svo_i_lit_box unit_box = {.low = {0, 0, 0}, .high = {1, 1, 1}, .leaf_edge = 1.0 / 64};

/* The sum of a view's weights times the area of a pixel, by bands. */
static double sum_weights(const svo_i_light_view *view, uint64_t *shot)
{
    svo_photon_weight weights[PHOTONS];
    double sum = 0;
    for (uint32_t first = 0; first < view->photon_count; first += PHOTONS) {
        const uint32_t count = view->photon_count - first < PHOTONS ? view->photon_count - first : PHOTONS;
        *shot += svo_i_view_weights(view, first, count, weights);
        for (uint32_t i = 0; i < count; ++i) {
            sum += weights[i].flux;
        }
    }
    return sum / (double)(UINT32_C(1) << SVO_WEIGHT_UNIT_LOG2) * view->pixel;
}

/* The flux of a source whose value is 1, and its photons. */
static double sum_source(const svo_light_source *source, const svo_i_lit_box *box, uint32_t resolution, uint64_t *shot)
{
    svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
    const uint32_t count = svo_i_light_views(source, box, resolution, views);
    double sum = 0;
    *shot = 0;
    for (uint32_t i = 0; i < count; ++i) {
        sum += sum_weights(&views[i], shot);
    }
    return sum;
}

static void assert_near(double found, double expected, double error, const char *what)
{
    if (!(fabs(found - expected) <= error)) {
        fail_msg("%s: %.12g is not within %g of %.12g", what, found, error, expected);
        return;
    }
}

static void test_cosine_is_the_library_s(void **state)
{
    (void)state;
    for (int i = 0; i <= 1000; ++i) {
        const double angle = i * PI / 2000;
        assert_near(svo_i_plain_cosine(angle), cos(angle), 4e-16, "cosine");
    }
}

static void test_faces_of_a_cube_sum_to_the_sphere(void **state)
{
    (void)state;
    const svo_light_source source = {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.5F, 0.5F}};
    uint64_t shot = 0;
    assert_near(sum_source(&source, &unit_box, 256, &shot), 4 * PI, 4 * PI * 4e-6, "256 x 256");
    assert_int_equal(shot, UINT64_C(6) * 256 * 256);
    assert_near(sum_source(&source, &unit_box, 1024, &shot), 4 * PI, 4 * PI * 1e-6, "1024 x 1024");
}

/* The integral of the smooth edge over the cosine is half its width. */
static void test_spots_have_the_flux_of_their_cone(void **state)
{
    (void)state;
    const float angles[][2] = {{0.1F, 0.2F}, {0.0F, 0.6F}, {0.7F, 0.9F}, {0.2F, 1.5F}, {1.4F, 1.55F}};
    for (size_t i = 0; i < sizeof angles / sizeof angles[0]; ++i) {
        const svo_light_source source = {.kind = SVO_SOURCE_SPOT,
                                         .position = {0.5F, 0.5F, 0.5F},
                                         .direction = {0.3F, -2.0F, 0.7F},
                                         .inner_angle = angles[i][0],
                                         .outer_angle = angles[i][1]};
        const double inner = cos((double)angles[i][0]);
        const double outer = cos((double)angles[i][1]);
        const double expected = 2 * PI * (1 - inner + (inner - outer) / 2);
        uint64_t shot = 0;
        assert_near(sum_source(&source, &unit_box, 512, &shot), expected, expected * 2e-4, "spot");
        assert_true(shot > 0);
    }
}

/* The integral of the cosine over a hemisphere is pi. */
static void test_disks_have_the_flux_of_their_cosine(void **state)
{
    (void)state;
    const svo_light_source source = {
        .kind = SVO_SOURCE_DISK, .position = {0.5F, 0.5F, 0.5F}, .direction = {0.3F, -2.0F, 0.7F}, .radius = 0.2F};
    uint64_t shot = 0;
    assert_near(sum_source(&source, &unit_box, 512, &shot), PI, PI * 2e-4, "disk");
    assert_true(shot > 0);
}

static void test_parallel_light_covers_the_box(void **state)
{
    (void)state;
    const svo_light_source source = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.0F, -3.0F, 0.0F}};
    const svo_i_lit_box box = {.low = {-1, 0, 2}, .high = {1, 5, 3}, .leaf_edge = 0.125};
    uint64_t shot = 0;
    assert_near(sum_source(&source, &box, 0, &shot), 2.0, 1e-12, "area");
    assert_int_equal(shot, 32 * 16); /* two by two for a leaf */
}

/* The pixel of a point in a view, or false: where the photons of the view go, in double. */
static bool find_pixel(const svo_i_light_view *view, const double point[3], int64_t pixel[2], double *depth)
{
    const svo_light_view_params *params = &view->params;
    const double forward[3] = {params->forward[0], params->forward[1], params->forward[2]};
    double at[3] = {0, 0, 0};
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double to = point[axis] - (double)params->base[axis];
        at[0] += to * (double)params->right[axis];
        at[1] += to * (double)params->up[axis];
        at[2] += to * forward[axis];
        squared += forward[axis] * forward[axis];
    }
    *depth = 1;
    if (params->parallel == 0) {
        /* The middle direction is the frame's forward plus its middle. */
        const double beside = at[0] * view->middle[0] + at[1] * view->middle[1];
        const double middle = view->middle[0] * view->middle[0] + view->middle[1] * view->middle[1];
        assert_near(squared, 1 + middle, 1e-6, "length of the middle direction");
        *depth = at[2] - beside;
        at[0] = at[0] / *depth - view->middle[0];
        at[1] = at[1] / *depth - view->middle[1];
    }
    for (int i = 0; i < 2; ++i) {
        const uint32_t pixels = i == 0 ? params->columns : params->rows;
        const double place = at[i] / (2 * view->half[i]) + pixels / 2.0;
        pixel[i] = (int64_t)floor(place);
        if (!(place >= -1e-4 && place <= pixels + 1e-4)) {
            return false;
        }
    }
    return *depth > 0;
}

static void test_each_point_of_the_box_has_a_pixel(void **state)
{
    (void)state;
    uint64_t seed = 20260101;
    for (int n = 0; n < 60; ++n) {
        svo_light_source source = {.kind = n % 2 == 0 ? SVO_SOURCE_POINT : SVO_SOURCE_DIRECTIONAL};
        svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
        svo_i_lit_box box = {.leaf_edge = 1.0 / 256};
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = random_unit(&seed) - 0.5;
            box.high[axis] = box.low[axis] + 0.01 + random_unit(&seed);
            source.position[axis] = (float)(random_unit(&seed) * 6 - 3);
            source.direction[axis] = (float)(random_unit(&seed) * 2 - 1);
        }
        const uint32_t count = svo_i_light_views(&source, &box, 0, views);
        assert_in_range(count, 1, source.kind == SVO_SOURCE_POINT ? 6 : 1);
        for (int k = 0; k < 200; ++k) {
            double point[3];
            unsigned seen = 0;
            for (int axis = 0; axis < 3; ++axis) {
                point[axis] = box.low[axis] + random_unit(&seed) * (box.high[axis] - box.low[axis]);
            }
            for (uint32_t v = 0; v < count; ++v) {
                int64_t pixel[2];
                double depth = 0;
                if (find_pixel(&views[v], point, pixel, &depth)) {
                    ++seen;
                    /* No pixel is wider there than half a leaf, if the view may have as many as that takes. */
                    const bool enough =
                        views[v].params.columns < SVO_I_VIEW_PIXELS_MAX && views[v].params.rows < SVO_I_VIEW_PIXELS_MAX;
                    assert_true(!enough || 2 * views[v].half[0] * depth <= box.leaf_edge / 2 * (1 + 1e-6));
                    assert_true(!enough || 2 * views[v].half[1] * depth <= box.leaf_edge / 2 * (1 + 1e-6));
                }
            }
            if (seen != 1) {
                fail_msg("seed 20260101, box %d: point %g, %g, %g is seen by %u views", n, point[0], point[1], point[2],
                         seen);
                return;
            }
        }
    }
}

/* Photons come in any bands with the same weights. */
static void test_bands_do_not_matter(void **state)
{
    (void)state;
    const svo_light_source source = {.kind = SVO_SOURCE_POINT, .position = {3, 0.25F, 0.75F}};
    svo_i_light_view views[SVO_I_VIEWS_OF_ONE_MAX];
    svo_photon_weight *whole = malloc(sizeof *whole << 14);
    svo_photon_weight *parts = malloc(sizeof *parts << 14);
    assert_non_null(whole);
    assert_non_null(parts);
    assert_int_equal(svo_i_light_views(&source, &unit_box, 77, views), 1);
    const uint32_t count = views[0].photon_count;
    assert_in_range(count, 64, 1 << 14);
    const uint32_t shot = svo_i_view_weights(&views[0], 0, count, whole);
    assert_int_equal(shot, (uint64_t)views[0].params.columns * views[0].params.rows);
    uint32_t again = 0;
    for (uint32_t first = 0; first < count; first += 64) {
        again += svo_i_view_weights(&views[0], first, 64, parts + first);
    }
    assert_int_equal(again, shot);
    assert_memory_equal(whole, parts, count * sizeof *whole);
    free(whole);
    free(parts);
}

TEST_GROUP(light_view)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cosine_is_the_library_s),
        cmocka_unit_test(test_faces_of_a_cube_sum_to_the_sphere),
        cmocka_unit_test(test_spots_have_the_flux_of_their_cone),
        cmocka_unit_test(test_disks_have_the_flux_of_their_cosine),
        cmocka_unit_test(test_parallel_light_covers_the_box),
        cmocka_unit_test(test_each_point_of_the_box_has_a_pixel),
        cmocka_unit_test(test_bands_do_not_matter),
    };
    return cmocka_run_group_tests_name("light_view", tests, NULL, NULL);
}
