/* SPDX-License-Identifier: MIT */
/*
 * Skies that depend on direction: irradiance beside closed forms and beside integrals, by rays and by cones; suns in
 * them, at which paths aim; what mirrors, pictures and probes see of the map; maps of one radiance; updates; what is
 * refused.
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

#include "cone_scene.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "svocl/probes.h"

#define DEPTH 5u
#define PI    3.14159265358979323846

/* ---- maps ---- */

typedef struct map {
    float *texels;
    uint32_t width, height;
} map;

static map map_new(uint32_t width, uint32_t height)
{
    const map made = {calloc((size_t)3 * width * height, sizeof(float)), width, height};
    assert_non_null(made.texels);
    return made;
}

static float *texel(const map *of, uint32_t column, uint32_t row)
{
    return of->texels + 3 * ((size_t)row * of->width + column);
}

/* The direction of a texel's center. */
static void direction_of(const map *of, uint32_t column, uint32_t row, double out[3])
{
    const double turn = 2 * PI * ((column + 0.5) / of->width - 0.5);
    const double polar = PI * (row + 0.5) / of->height;
    out[0] = sin(polar) * sin(turn);
    out[1] = cos(polar);
    out[2] = -sin(polar) * cos(turn);
}

/* Smooth enough for texels of 5 degrees: red grows to the zenith, green to +x, blue is a lobe around -z. */
static map smooth_map(void)
{
    const map made = map_new(72, 36);
    for (uint32_t row = 0; row < made.height; ++row) {
        for (uint32_t column = 0; column < made.width; ++column) {
            double d[3];
            direction_of(&made, column, row, d);
            texel(&made, column, row)[0] = (float)(1 + d[1]);
            texel(&made, column, row)[1] = (float)(1 + d[0]);
            texel(&made, column, row)[2] = (float)exp(4 * (-d[2] - 1));
        }
    }
    return made;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The lobe's irradiance, by a sum over many directions. */
static double lobe_irradiance(const double normal[3])
{
    const map fine = {NULL, 720, 360};
    double sum = 0;
    for (uint32_t row = 0; row < fine.height; ++row) {
        const double angle = 2 * PI / fine.width * (cos(PI * row / fine.height) - cos(PI * (row + 1.0) / fine.height));
        for (uint32_t column = 0; column < fine.width; ++column) {
            double d[3];
            direction_of(&fine, column, row, d);
            sum += angle * fmax(dot(d, normal), 0) * exp(4 * (-d[2] - 1));
        }
    }
    return sum;
}

/* ---- light ---- */

static svo_light_setup setup_of(const map *sky)
{
    return (svo_light_setup){.struct_size = sizeof(svo_light_setup),
                             .sky_map = sky->texels,
                             .sky_width = sky->width,
                             .sky_height = sky->height};
}

static svo_gather_options by_rays(uint32_t paths)
{
    return (svo_gather_options){.struct_size = sizeof(svo_gather_options), .method = SVO_GATHER_RAYS, .paths = paths};
}

static svo_gather_options by_cones(uint32_t cones)
{
    return (svo_gather_options){.struct_size = sizeof(svo_gather_options), .method = SVO_GATHER_CONES, .cones = cones};
}

/* A tree that is nearly empty: a small quad far from the points, which are around the middle. */
typedef struct open_scene {
    fixture opened;
    cone_scene *scene;
    svo_tree *tree;
    svo_light *light;
} open_scene;

static open_scene open_scene_new(void **state)
{
    static const double corner[3] = {-15.5, -15.5, -15.5};
    static const double u[3] = {0.1, 0, 0};
    static const double v[3] = {0, 0.1, 0};
    open_scene made = {.opened = fixture_cl_of_group(state), .scene = cone_scene_new(DEPTH, 1)};
    cone_scene_add_quad(made.scene, corner, u, v);
    made.tree = cone_scene_build(&made.opened, made.scene, SVO_NEED_NORMAL | SVO_NEED_RAYS);
    made.light = light_of(&made.opened, made.tree, SVO_LIGHT_FACES);
    return made;
}

static void open_scene_free(open_scene *of)
{
    svo_light_destroy(&of->light);
    svo_tree_destroy(&of->tree);
    cone_scene_free(of->scene);
}

static void add_normal(open_scene *to, double x, double y, double z)
{
    static const double middle[3] = {0.3, 0.2, 0.1};
    const double length = sqrt(x * x + y * y + z * z);
    const double normal[3] = {x / length, y / length, z / length};
    cone_scene_add_point(to->scene, middle, normal, 1);
}

static void shine(open_scene *on, const svo_light_setup *setup)
{
    light_succeed(&on->opened, svo_light_set_sources(on->light, setup, on->opened.queue));
}

static void gather(open_scene *on, const svo_gather_options *options)
{
    cone_scene_gather(&on->opened, on->scene, on->light, options);
}

static void check_near(const char *what, double value, double expected, double bound)
{
    if (!(fabs(value - expected) <= bound)) {
        fail_msg("%s is %g instead of %g, within %g", what, value, expected, bound);
    }
}

/* Of a sky of 1 where x > 0 and 0 elsewhere, a surface at an angle a from +x sees (1 + cos a) / 2. */
static void half_a_sky_has_half_its_light(void **state)
{
    open_scene on = open_scene_new(state);
    const map sky = map_new(1024, 1);
    const svo_light_setup setup = setup_of(&sky);
    const svo_gather_options rays = by_rays(16384);
    const svo_gather_options cones = by_cones(64);
    for (uint32_t column = 512; column < 1024; ++column) {
        texel(&sky, column, 0)[0] = texel(&sky, column, 0)[1] = 1;
    }
    add_normal(&on, 0, 1, 0);
    add_normal(&on, 0, -1, 0);
    add_normal(&on, 0, 0, 1);
    add_normal(&on, 1, 0, 0);
    add_normal(&on, -1, 0, 0);
    add_normal(&on, 1, 2, 0.5);
    add_normal(&on, -1, -0.2, 1);
    add_normal(&on, 3, 1, -1);
    shine(&on, &setup);
    for (int method = 0; method < 2; ++method) {
        double worst = 0;
        gather(&on, method == 0 ? &rays : &cones);
        for (size_t i = 0; i < on.scene->point_count; ++i) {
            const float *got = on.scene->results[i].irradiance;
            const double expected = PI * (1 + (double)on.scene->points[i].normal[0]) / 2;
            worst = fmax(worst, fabs((double)got[0] - expected));
            check_near("red of half a sky", (double)got[0], expected, method == 0 ? 0.01 : 0.15);
            check_near("its green", (double)got[1], (double)got[0], 0);
            check_near("its blue", (double)got[2], 0, 0);
        }
        print_message("half a sky by %s: at most %.4f off\n", method == 0 ? "rays" : "cones", worst);
    }
    free(sky.texels);
    open_scene_free(&on);
}

/* A linear function b . d of the direction brings 2 pi / 3 b . n. */
static void gradients_have_their_integrals(void **state)
{
    static const double bounds[] = {0.01, 0.1, 0.25}; /* rays, 64 cones, 16 cones */
    const svo_gather_options ways[] = {by_rays(16384), by_cones(64), by_cones(16)};
    open_scene on = open_scene_new(state);
    const map sky = smooth_map();
    svo_light_setup setup = setup_of(&sky);
    uint64_t seed = 5;
    setup.sky[0] = 0.5F; /* the map is on top of it */
    for (int i = 0; i < 24; ++i) {
        add_normal(&on, 2 * random_unit(&seed) - 1, 2 * random_unit(&seed) - 1, 2 * random_unit(&seed) - 1);
    }
    shine(&on, &setup);
    for (size_t way = 0; way < sizeof ways / sizeof ways[0]; ++way) {
        double worst = 0;
        gather(&on, &ways[way]);
        for (size_t i = 0; i < on.scene->point_count; ++i) {
            const float *n = on.scene->points[i].normal;
            const float *got = on.scene->results[i].irradiance;
            const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
            const double expected[3] = {PI * 1.5 + 2 * PI / 3 * normal[1], PI + 2 * PI / 3 * normal[0],
                                        lobe_irradiance(normal)};
            for (int channel = 0; channel < 3; ++channel) {
                worst = fmax(worst, fabs((double)got[channel] - expected[channel]));
                check_near("irradiance of a gradient", (double)got[channel], expected[channel], bounds[way]);
            }
        }
        print_message("gradients, way %zu: at most %.4f off\n", way, worst);
    }
    free(sky.texels);
    open_scene_free(&on);
}

/* Means keep the flux: a cone of 60 degrees sees nearly that of a map of noise, whose mean is 1. */
static void wide_cones_see_means(void **state)
{
    static const uint32_t sizes[][2] = {{1, 1}, {2, 1}, {1, 7}, {129, 65}, {512, 256}, {1000, 3}};
    const svo_gather_options one = by_cones(1);
    open_scene on = open_scene_new(state);
    uint64_t seed = 9;
    add_normal(&on, 0, 1, 0);
    add_normal(&on, 1, 0, 0.1);
    add_normal(&on, -1, -2, 0.1);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        const map sky = map_new(sizes[i][0], sizes[i][1]);
        const size_t texels = (size_t)sky.width * sky.height;
        for (size_t k = 0; k < 3 * texels; ++k) {
            sky.texels[k] = texels > 1000 ? (float)(2 * random_unit(&seed)) : 1;
        }
        const svo_light_setup setup = setup_of(&sky);
        shine(&on, &setup);
        gather(&on, &one);
        for (size_t point = 0; point < on.scene->point_count; ++point) {
            check_near("a wide cone's mean", (double)on.scene->results[point].irradiance[0] / PI, 1,
                       texels > 1000 ? 0.05 : 1e-6);
        }
        free(sky.texels);
    }
    open_scene_free(&on);
}

/* Means weigh texels by their solid angle: a cap of 11.25 degrees around the zenith has (1 - cos 11.25) / (1 - cos 60)
   of a cone of 60 degrees. Rows around the pole are as many as others, and smaller. */
static void caps_keep_their_light(void **state)
{
    const svo_gather_options one = by_cones(1);
    const svo_gather_options rays = by_rays(16384);
    open_scene on = open_scene_new(state);
    const map sky = map_new(128, 64);
    const svo_light_setup setup = setup_of(&sky);
    for (size_t i = 0; i < (size_t)3 * 128 * 4; ++i) {
        sky.texels[i] = 1;
    }
    add_normal(&on, 0, 1, 0);
    shine(&on, &setup);
    gather(&on, &one);
    const double of_cone = (double)on.scene->results[0].irradiance[0] / PI;
    gather(&on, &rays);
    const double of_rays = (double)on.scene->results[0].irradiance[0] / PI;
    print_message("a cap by a cone: %.4f instead of .0384; by rays: %.4f instead of .0381\n", of_cone, of_rays);
    check_near("a cap in a wide cone", of_cone, 0.0384, 0.01);
    check_near("a cap by rays", of_rays, sin(PI / 16) * sin(PI / 16), 0.001);
    free(sky.texels);
    open_scene_free(&on);
}

/* ---- bright places ---- */

#define SUN_RADIANCE 20000.0

/* .1 all around and a sun of two by two texels, some 1.4 degrees wide. */
static map sun_map(uint32_t column, uint32_t row)
{
    const map made = map_new(512, 256);
    for (size_t i = 0; i < (size_t)3 * made.width * made.height; ++i) {
        made.texels[i] = 0.1F;
    }
    for (uint32_t k = 0; k < 4; ++k) {
        for (uint32_t channel = 0; channel < 3; ++channel) {
            texel(&made, (column + k % 2) % made.width, row + k / 2)[channel] += 20000;
        }
    }
    return made;
}

/* The irradiance by the sun alone, in steps of a 16th of a texel, linear between their centers. */
static double sun_irradiance(const map *sky, uint32_t column, uint32_t row, const double normal[3])
{
    const map fine = {NULL, 16 * sky->width, 16 * sky->height};
    double sum = 0;
    for (int32_t j = row == 0 ? 0 : 16 * (int32_t)row - 8; j < 16 * (int32_t)row + 40; ++j) {
        const double angle = 2 * PI / fine.width * (cos(PI * j / fine.height) - cos(PI * (j + 1.0) / fine.height));
        const double below = (j + 0.5) / 16 - row - 1; /* texels from the middle; above the first row that goes on */
        const double of_row = row == 0 && below < 0 ? 1 : fmin(1, 1.5 - fabs(below));
        for (int32_t i = -8; i < 40; ++i) {
            double d[3];
            direction_of(&fine, (uint32_t)(16 * (int32_t)column + i), (uint32_t)j, d);
            sum += angle * fmax(dot(d, normal), 0) * 20000 * of_row * fmin(1, 1.5 - fabs((i + 0.5) / 16 - 1));
        }
    }
    return sum;
}

/* 64 paths find a sun by aiming at it: high up, at the horizon across the map's edge, and below. With a plain sky there
   is no map that they could take for it, and each has its share. */
static void suns_of_maps_are_found(void **state)
{
    static const uint32_t places[][2] = {{100, 60}, {511, 127}, {300, 240}, {17, 0}};
    const svo_gather_options rays = by_rays(64);
    open_scene on = open_scene_new(state);
    uint64_t seed = 11;
    for (int i = 0; i < 24; ++i) {
        add_normal(&on, 2 * random_unit(&seed) - 1, 2 * random_unit(&seed) - 1, 2 * random_unit(&seed) - 1);
    }
    for (size_t place = 0; place < sizeof places / sizeof places[0]; ++place) {
        const uint32_t column = places[place][0];
        const uint32_t row = places[place][1];
        const map sky = sun_map(column, row);
        double worst = 0;
        svo_light_setup setup = setup_of(&sky);
        setup.sky[0] = 1;
        shine(&on, &setup);
        assert_int_equal(light_info_of(on.light).sky_bytes, 12 * ((512 * 256 * 4 - 1) / 3 + 1) + 4 * (256 + 512 * 256));
        gather(&on, &rays);
        for (size_t i = 0; i < on.scene->point_count; ++i) {
            const float *n = on.scene->points[i].normal;
            const float *got = on.scene->results[i].irradiance;
            const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
            const double sun = sun_irradiance(&sky, column, row, normal);
            worst = fmax(worst, fabs((double)got[1] - 0.1 * PI - sun) / (0.1 * PI + sun));
            check_near("irradiance of a sun", (double)got[1], 0.1 * PI + sun, 0.02 * (0.1 * PI + sun));
            check_near("with the plain sky", (double)got[0] - (double)got[1], PI, 1e-5 * (PI + sun));
        }
        print_message("a sun at column %u, row %u: at most %.4f of irradiance off\n", column, row, worst);
        free(sky.texels);
    }
    open_scene_free(&on);
}

/* The irradiance of both points of a scene. */
static void gather_pair(open_scene *on, const svo_light_setup *setup, double out[2])
{
    const svo_gather_options rays = by_rays(64);
    shine(on, setup);
    gather(on, &rays);
    for (int i = 0; i < 2; ++i) {
        out[i] = (double)on->scene->results[i].irradiance[0];
    }
}

/* A lamp above a point hides the sun from it, not from the one beside, and paths aim at both: with both, points have
   the sum of what they have of each. */
static void lamps_hide_suns_of_maps(void **state)
{
    static const double corners[2][3] = {{-14, -10, -14}, {-3, 4, -3}};
    static const double u[2][3] = {{28, 0, 0}, {6, 0, 0}};
    static const double v[2][3] = {{0, 0, 28}, {0, 0, 6}};
    static const double points[2][3] = {{0.1, 0.2, 0.3}, {10.1, 0.2, 0.3}};
    static const double up[3] = {0, 1, 0};
    static const uint8_t white[2][4] = {{255, 255, 255, 255}, {255, 255, 255, 255}};
    static const svo_finish finishes[2] = {{.emission = {0, 0, 0}}, {.emission = {2, 2, 2}}};
    open_scene on = {.opened = fixture_cl_of_group(state), .scene = cone_scene_new(DEPTH, 1)};
    const map sky = sun_map(256, 10);
    const map dark = map_new(2, 2);
    const double sun = sun_irradiance(&sky, 256, 10, up);
    svo_light_setup setup = setup_of(&sky);
    double of_sky[2];
    double of_lamp[2];
    double of_both[2];
    for (int i = 0; i < 2; ++i) {
        cone_scene_add_quad(on.scene, corners[i], u[i], v[i]);
        cone_scene_add_point(on.scene, points[i], up, 1);
    }
    on.tree =
        cone_scene_build_colored(&on.opened, on.scene, 2, white, SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_MATERIAL);
    on.light = light_of(&on.opened, on.tree, SVO_LIGHT_FACES);
    gather_pair(&on, &setup, of_sky);
    assert_true(sun > 1);
    check_near("irradiance below a lamp", of_sky[0], 0, 0.1 * PI);
    check_near("irradiance beside it", of_sky[1], 0.1 * PI + sun, 0.01 * (0.1 * PI + sun));
    setup.finishes = finishes;
    setup.finish_count = 2;
    gather_pair(&on, &setup, of_both);
    setup.sky_map = dark.texels;
    setup.sky_width = setup.sky_height = 2;
    gather_pair(&on, &setup, of_lamp);
    assert_true(of_lamp[0] > 1);
    for (int i = 0; i < 2; ++i) {
        check_near("irradiance of lamp and sky", of_both[i], of_sky[i] + of_lamp[i], 0.02 * of_both[i]);
    }
    free(sky.texels);
    free(dark.texels);
    open_scene_free(&on);
}

/* A map of one radiance is as good as a sky of it, and as none at all where it is 0. */
static void one_radiance_is_the_plain_sky(void **state)
{
    const svo_gather_options ways[] = {by_rays(256), by_cones(16)};
    open_scene on = open_scene_new(state);
    const map sky = map_new(7, 5);
    const svo_light_setup mapped = setup_of(&sky);
    const svo_light_setup plain = {.struct_size = sizeof plain, .sky = {0.3F, 0.7F, 1.1F}};
    for (uint32_t i = 0; i < 35; ++i) {
        memcpy(sky.texels + (size_t)3 * i, plain.sky, sizeof plain.sky);
    }
    add_normal(&on, 0, 1, 0);
    add_normal(&on, 1, 2, 3);
    for (size_t way = 0; way < 2; ++way) {
        float before[2][3];
        shine(&on, &plain);
        assert_int_equal(light_info_of(on.light).sky_bytes, 0);
        gather(&on, &ways[way]);
        for (int i = 0; i < 2; ++i) {
            memcpy(before[i], on.scene->results[i].irradiance, sizeof before[i]);
        }
        shine(&on, &mapped);
        assert_int_equal(light_info_of(on.light).sky_bytes, 12 * (7 * 5 + 4 * 3 + 2 * 2 + 1));
        gather(&on, &ways[way]);
        for (int i = 0; i < 6; ++i) {
            check_near("irradiance of a map of one radiance", (double)on.scene->results[i / 3].irradiance[i % 3],
                       (double)before[i / 3][i % 3], 1e-5 * (double)before[i / 3][i % 3]);
        }
    }
    const svo_light_setup dark = SVO_LIGHT_SETUP_INIT;
    shine(&on, &dark);
    gather(&on, &ways[0]);
    check_near("light without a sky", (double)on.scene->results[0].irradiance[0], 0, 0);
    free(sky.texels);
    open_scene_free(&on);
}

/* ---- what is seen ---- */

/* A texel's value, exact at its center: each has its own red and green. */
static map numbered_map(void)
{
    const map made = map_new(16, 8);
    for (uint32_t row = 0; row < made.height; ++row) {
        for (uint32_t column = 0; column < made.width; ++column) {
            texel(&made, column, row)[0] = 1.0F + (float)column;
            texel(&made, column, row)[1] = 1.0F + (float)row;
            texel(&made, column, row)[2] = 1;
        }
    }
    return made;
}

/* Narrow lobes see the radiance along their axis. */
static void mirrors_see_the_map(void **state)
{
    const svo_gather_options ways[] = {by_rays(64), by_cones(5)};
    open_scene on = open_scene_new(state);
    const map sky = numbered_map();
    const svo_light_setup setup = setup_of(&sky);
    for (uint32_t row = 1; row < sky.height; row += 3) {
        for (uint32_t column = 0; column < sky.width; column += 5) {
            double d[3];
            direction_of(&sky, column, row, d);
            add_normal(&on, d[0], d[1], d[2]);
            svo_gather_point *point = &on.scene->points[on.scene->point_count - 1];
            memcpy(point->reflected, point->normal, sizeof point->reflected);
            point->exponent = 1e7F;
        }
    }
    shine(&on, &setup);
    for (size_t way = 0; way < 2; ++way) {
        size_t i = 0;
        gather(&on, &ways[way]);
        for (uint32_t row = 1; row < sky.height; row += 3) {
            for (uint32_t column = 0; column < sky.width; column += 5) {
                const float *got = on.scene->results[i++].specular;
                /* Between the last column and the first one the map falls from 16 to 1. */
                check_near("what a mirror sees, column", (double)got[0], column + 1.0, 0.05);
                check_near("what a mirror sees, row", (double)got[1], row + 1.0, 0.02);
            }
        }
    }
    free(sky.texels);
    open_scene_free(&on);
}

/* What a picture of the outside shows: a pixel in the middle looks along the camera. */
static void pictures_show_the_map(void **state)
{
    enum { SIDE = 5 };
    float pixels[4 * SIDE * SIDE];
    open_scene on = open_scene_new(state);
    const map sky = numbered_map();
    const svo_light_setup setup = setup_of(&sky);
    shine(&on, &setup);
    for (uint32_t row = 1; row < sky.height - 1; ++row) {
        double d[3];
        svo_render_options options = {.struct_size = sizeof options, .width = SIDE, .height = SIDE};
        direction_of(&sky, 2 * row, row, d);
        options.view = SVO_VIEW_SHADED;
        options.output.format = SVO_PIXELS_LINEAR;
        options.output.samples = 1;
        options.camera.vertical_fov = 0.001F;
        options.camera.up[1] = 1;
        for (int axis = 0; axis < 3; ++axis) {
            options.camera.eye[axis] = 16;
            options.camera.target[axis] = (float)(16 + 8 * d[axis]);
        }
        light_succeed(&on.opened, svo_render(svo_light_target(on.light), &options, svo_in_host(pixels),
                                             &(svo_submit){.queue = on.opened.queue}));
        const float *middle = pixels + (size_t)4 * (SIDE / 2 * SIDE + SIDE / 2);
        check_near("a pixel's column", (double)middle[0], 2 * row + 1.0, 0.01);
        check_near("a pixel's row", (double)middle[1], row + 1.0, 0.01);
    }
    free(sky.texels);
    open_scene_free(&on);
}

/* Rays that probes see miss bring the radiance along them; what probes took stays until they take the next. */
static void probes_show_the_map(void **state)
{
    enum { RAYS = 9, SEAM = 7, NOWHERE = 8 };
    open_scene on = open_scene_new(state);
    const map sky = numbered_map();
    const svo_light_setup setup = setup_of(&sky);
    const svo_light_setup dark = SVO_LIGHT_SETUP_INIT;
    svo_probe_options options = SVO_PROBE_OPTIONS_INIT;
    svo_probes *probes = NULL;
    svo_ray rays[RAYS];
    svo_probe_hit hits[RAYS];
    for (uint32_t i = 0; i < SEAM; ++i) {
        double d[3];
        direction_of(&sky, 2 * i, i, d);
        rays[i] = (svo_ray){.origin = {16, 16, 16},
                            .direction = {(float)(2 * d[0]), (float)(2 * d[1]), (float)(2 * d[2])},
                            .t_max = INFINITY};
    }
    rays[SEAM] = rays[NOWHERE] = rays[0];
    memcpy(rays[SEAM].direction, (const float[3]){0, 0, 5}, sizeof rays[SEAM].direction);
    memset(rays[NOWHERE].direction, 0, sizeof rays[NOWHERE].direction);
    options.tree = on.tree;
    options.light = on.light;
    options.resolution = 64;
    options.counts[0] = options.counts[1] = options.counts[2] = 2;
    shine(&on, &setup);
    light_succeed(&on.opened, svo_probes_create(&options, on.opened.queue, &probes));
    shine(&on, &dark);
    for (int taken = 0; taken < 2; ++taken) {
        light_succeed(&on.opened, svo_probes_trace(probes, svo_in_host(rays), svo_in_host(hits), RAYS, NULL,
                                                   &(svo_submit){.queue = on.opened.queue}));
        for (uint32_t i = 0; i < SEAM; ++i) {
            assert_int_equal(hits[i].state, SVO_PROBE_MISS);
            check_near("a miss's column", (double)hits[i].radiance[0], taken == 0 ? 2 * i + 1.0 : 0, 1e-4);
            check_near("a miss's row", (double)hits[i].radiance[1], taken == 0 ? i + 1.0 : 0, 1e-4);
        }
        /* Between the last column and the first, and between the rows in the middle. */
        check_near("a miss at the seam, column", (double)hits[SEAM].radiance[0], taken == 0 ? 8.5 : 0, 1e-4);
        check_near("a miss at the seam, row", (double)hits[SEAM].radiance[1], taken == 0 ? 4.5 : 0, 1e-4);
        check_near("a ray without direction, row", (double)hits[NOWHERE].radiance[1], taken == 0 ? 1 : 0, 1e-4);
        light_succeed(&on.opened, svo_probes_relight(probes, on.opened.queue));
    }
    svo_probes_destroy(&probes);
    free(sky.texels);
    open_scene_free(&on);
}

/* ---- changes, refusals ---- */

/* An updated light has the map of the light before it, and aims at it as that did. */
static void check_updates(open_scene *on, const map *sky)
{
    const svo_gather_options rays = by_rays(64);
    const svo_gather_options cones = by_cones(5);
    svo_light_setup setup = setup_of(sky);
    const svo_box all = {.low = {0, 0, 0}, .high = {32, 32, 32}};
    svo_gather_result before[2];
    setup.updatable = 1;
    shine(on, &setup);
    free(sky->texels); /* the light has a copy */
    gather(on, &rays);
    before[0] = on->scene->results[0];
    gather(on, &cones);
    before[1] = on->scene->results[0];
    const uint64_t bytes = light_info_of(on->light).sky_bytes;
    assert_true(bytes > 0);
    for (int update = 0; update < 3; ++update) {
        light_succeed(&on->opened, svo_light_update(on->light, on->tree, &all, 1, on->opened.queue));
        assert_int_equal(light_info_of(on->light).sky_bytes, bytes);
        gather(on, &rays);
        assert_memory_equal(&before[0], &on->scene->results[0], sizeof before[0]);
        gather(on, &cones);
        check_near("irradiance by cones", (double)on->scene->results[0].irradiance[0], (double)before[1].irradiance[0],
                   0);
    }
}

static void updates_keep_the_map(void **state)
{
    open_scene on = open_scene_new(state);
    const map smooth = smooth_map();
    const map uneven = sun_map(100, 60);
    add_normal(&on, 1, 2, 3);
    check_updates(&on, &smooth);
    check_updates(&on, &uneven);
    open_scene_free(&on);
}

static void check_refused(open_scene *on, const svo_light_setup *setup, const char *text)
{
    assert_int_equal(svo_light_set_sources(on->light, setup, on->opened.queue), SVO_INVALID_ARGUMENT);
    if (strstr(svo_device_message(on->opened.device), text) == NULL) {
        fail_msg("'%s' is not in '%s'", text, svo_device_message(on->opened.device));
    }
    assert_int_equal(light_info_of(on->light).sky_bytes, 0);
}

static void bad_maps_are_refused(void **state)
{
    open_scene on = open_scene_new(state);
    const map sky = map_new(4, 3);
    svo_light_setup setup = setup_of(&sky);
    setup.sky_width = 0;
    check_refused(&on, &setup, "svo_light_set_sources: setup.sky_width 0 is not in 1 .. 8192");
    setup.sky_width = 8193;
    check_refused(&on, &setup, "setup.sky_width 8193 is not in 1 .. 8192");
    setup.sky_width = 4;
    setup.sky_height = 4097;
    check_refused(&on, &setup, "setup.sky_height 4097 is not in 1 .. 4096");
    setup.sky_height = 3;
    texel(&sky, 2, 1)[1] = -0.5F;
    check_refused(&on, &setup, "setup.sky_map[19] -0.5, of column 2 and row 1, is negative or not finite");
    texel(&sky, 2, 1)[1] = 0;
    texel(&sky, 3, 2)[2] = NAN;
    check_refused(&on, &setup, "setup.sky_map[35] nan, of column 3 and row 2");
    texel(&sky, 3, 2)[2] = INFINITY;
    check_refused(&on, &setup, "setup.sky_map[35] inf");
    setup.sky_map = NULL;
    check_refused(&on, &setup, "setup.sky_map is NULL; its size is 4 x 3");
    /* Callers of earlier headers have no map. */
    setup = (svo_light_setup){.struct_size = offsetof(svo_light_setup, sky_map), .sky_width = 7};
    shine(&on, &setup);
    free(sky.texels);
    open_scene_free(&on);
}

TEST_GROUP(light_sky)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(half_a_sky_has_half_its_light), cmocka_unit_test(gradients_have_their_integrals),
        cmocka_unit_test(wide_cones_see_means),          cmocka_unit_test(caps_keep_their_light),
        cmocka_unit_test(one_radiance_is_the_plain_sky), cmocka_unit_test(mirrors_see_the_map),
        cmocka_unit_test(pictures_show_the_map),         cmocka_unit_test(probes_show_the_map),
        cmocka_unit_test(updates_keep_the_map),          cmocka_unit_test(bad_maps_are_refused),
        cmocka_unit_test(suns_of_maps_are_found),        cmocka_unit_test(lamps_hide_suns_of_maps),
    };
    return cmocka_run_group_tests_name("light_sky", tests, fixture_group_setup, fixture_group_teardown);
}
