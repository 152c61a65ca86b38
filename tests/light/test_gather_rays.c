/* SPDX-License-Identifier: MIT */
/*
 * Light gathered by rays, beside closed forms: openness under openings, sources with shadows, emitters, furnaces of
 * several bounces; the errors that it estimates; and that a point's light does not depend on its neighbors.
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
#include "support/suite.h"

#define DEPTH 7u
#define PI    3.14159265358979323846

static const double up[3] = {0, 0, 1};

static svo_gather_options by_rays(uint32_t paths, uint32_t bounces)
{
    return (svo_gather_options){
        .struct_size = sizeof(svo_gather_options), .method = SVO_GATHER_RAYS, .paths = paths, .bounces = bounces};
}

/* Gathers by the scene's triangles, without sources. */
static void gather_alone(const fixture *opened, cone_scene *scene, const svo_gather_options *options)
{
    svo_tree *tree = cone_scene_build(opened, scene, SVO_NEED_RAYS);
    svo_light *light = light_of(opened, tree, SVO_LIGHT_FACES);
    cone_scene_gather(opened, scene, light, options);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
}

static void check_near(const char *what, double value, double expected, double bound)
{
    if (!(fabs(value - expected) <= bound)) {
        fail_msg("%s is %g instead of %g, within %g", what, value, expected, bound);
    }
}

/* The share of a hemisphere, weighted by the cosine, that a rectangle of -a .. a, -b .. b at height 1 fills (Howell, "A
   Catalog of Radiation Heat Transfer Configuration Factors", B-3). */
static double rectangle_factor(double a, double b)
{
    const double x = sqrt(1 + a * a);
    const double y = sqrt(1 + b * b);
    return 2 / PI * (a / x * atan(b / x) + b / y * atan(a / y));
}

/* ---- openness ---- */

/* A plane at a height with a hole of 2 a x 2 b, as wide as the grid allows. */
static void add_roof(cone_scene *scene, double height, double a, double b)
{
    const double far_off = 60;
    const double sides[4][2][3] = {{{a, -far_off, height}, {far_off, far_off, height}},
                                   {{-far_off, -far_off, height}, {-a, far_off, height}},
                                   {{-a, b, height}, {a, far_off, height}},
                                   {{-a, -far_off, height}, {a, -b, height}}};
    for (int side = 0; side < 4; ++side) {
        const double u[3] = {sides[side][1][0] - sides[side][0][0], 0, 0};
        const double v[3] = {0, sides[side][1][1] - sides[side][0][1], 0};
        cone_scene_add_quad(scene, sides[side][0], u, v);
    }
}

/* Slots and square holes, of less than a voxel too; beside the roof's edges 1.5 % of the hemisphere is open. */
static void openings_have_their_share(void **state)
{
    static const double holes[][2] = {{1, 30}, {2, 30}, {0.4, 30}, {4, 4}, {12, 3}};
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options options = by_rays(16384, 1);
    const double height = 6;
    cone_scene *scene = cone_scene_new(DEPTH, 3);
    for (size_t i = 0; i < sizeof holes / sizeof holes[0]; ++i) {
        const double eye[3] = {0, 0, 0};
        cone_scene_clear(scene);
        cone_scene_pose(scene, true, 1);
        add_roof(scene, height, holes[i][0], holes[i][1]);
        const double outside = 1 - rectangle_factor(60 / height, 60 / height);
        cone_scene_add_point(scene, eye, up, outside + rectangle_factor(holes[i][0] / height, holes[i][1] / height));
        gather_alone(&opened, scene, &options);
        check_near("openness under a hole", (double)scene->results[0].openness, scene->openness[0], 0.003);
        assert_true((double)scene->results[0].openness_error < 0.003);
    }
    cone_scene_free(scene);
}

/* A closed room is dark and closed, whichever way its triangles face. */
static void closed_rooms_are_closed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options options = by_rays(256, 1);
    const double half[3] = {20, 25, 30};
    for (int turned = 0; turned < 2; ++turned) {
        cone_scene *scene = cone_scene_new(DEPTH, 4);
        cone_scene_pose(scene, true, 3);
        cone_scene_add_room(scene, half);
        if (turned != 0) {
            cone_scene_flip(scene);
        }
        const double middle[3] = {1, 2, 3};
        const double on_floor[3] = {5, 5, -30};
        cone_scene_add_point(scene, middle, up, 0);
        cone_scene_add_point(scene, on_floor, up, 0);
        gather_alone(&opened, scene, &options);
        for (int i = 0; i < 2; ++i) {
            check_near("openness in a closed room", (double)scene->results[i].openness, 0, 0);
            check_near("its error", (double)scene->results[i].openness_error, 0, 0);
        }
        cone_scene_free(scene);
    }
}

/* A plane at height h, and what a range and a falloff leave of it. */
static void range_and_falloff_count(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double height = 5;
    const double range = 10; /* beyond 60 degrees from the normal */
    const double eye[3] = {0, 0, 0};
    svo_gather_options options = by_rays(4096, 1);
    cone_scene *scene = cone_scene_new(DEPTH, 5);
    cone_scene_pose(scene, true, 1);
    add_roof(scene, height, 1e-6, 1e-6);
    cone_scene_add_point(scene, eye, up, 0);
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_RAYS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    const svo_light_setup setup = {.struct_size = sizeof setup, .sky = {1, 1, 1}};
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    for (uint32_t no_light = 0; no_light < 2; ++no_light) {
        options.no_light = no_light;
        options.range = (float)range;
        options.falloff = 0;
        cone_scene_gather(&opened, scene, light, &options);
        check_near("openness within a range", (double)scene->results[0].openness, 0.25, 0.003);
        assert_true((no_light != 0) == (scene->results[0].irradiance[1] <= 0));
        /* The mean of 1 / (1 + falloff height / c) over the cosine c, with the density 2 c. */
        options.falloff = 0.2F;
        options.range = 0;
        const double k = 0.2 * height;
        const double occluded = 2 * (0.5 - k + k * k * log((1 + k) / k));
        cone_scene_gather(&opened, scene, light, &options);
        check_near("openness with falloff", (double)scene->results[0].openness, 1 - occluded, 0.01);
    }
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* ---- light ---- */

/* A tree of the scene's triangles, the first `plain` with material 0 and the others with material 1, of one gray. */
static svo_tree *build_materials(const fixture *opened, const cone_scene *scene, size_t plain, uint8_t gray)
{
    const uint8_t colors[2][4] = {{gray, gray, gray, 255}, {gray, gray, gray, 255}};
    return cone_scene_build_colored(opened, scene, plain, colors, SVO_NEED_COLOR | SVO_NEED_MATERIAL | SVO_NEED_RAYS);
}

/* All walls emit e and reflect a of what they get: e (1 + a + ... + a^(bounces - 1)) comes from everywhere, so that no
   path differs from another. */
static void furnaces_have_their_radiance(void **state)
{
    static const svo_finish glowing[2] = {{.emission = {2, 0.5F, 0}}, {.emission = {2, 0.5F, 0}}};
    static const uint32_t bounces[] = {1, 2, 5, 16};
    const fixture opened = fixture_cl_of_group(state);
    const double half[3] = {20, 25, 30};
    const double eye[3] = {3, 4, 5};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    cone_scene *scene = cone_scene_new(DEPTH, 6);
    cone_scene_pose(scene, true, 2);
    cone_scene_add_room(scene, half);
    cone_scene_add_point(scene, eye, up, 0);
    svo_tree *tree = build_materials(&opened, scene, scene->triangle_count, 188);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    setup.finishes = glowing;
    setup.finish_count = 2;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    const double albedo = pow((188.0 / 255 + 0.055) / 1.055, 2.4);
    for (size_t i = 0; i < sizeof bounces / sizeof bounces[0]; ++i) {
        const svo_gather_options options = by_rays(64, bounces[i]);
        const double series = (1 - pow(albedo, bounces[i])) / (1 - albedo);
        cone_scene_gather(&opened, scene, light, &options);
        check_near("red of a furnace", (double)scene->results[0].irradiance[0], 2 * PI * series, 3e-3 * PI * series);
        check_near("green", (double)scene->results[0].irradiance[1], 0.5 * PI * series, 1e-3 * PI * series);
        check_near("blue", (double)scene->results[0].irradiance[2], 0, 0);
        check_near("its error", (double)scene->results[0].irradiance_error, 0, 1e-3);
    }
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* A rectangle above that emits, between black walls; the lobe around its direction sees it too. */
static void emitters_light_what_they_face(void **state)
{
    static const svo_finish finishes[2] = {{.emission = {0, 0, 0}}, {.emission = {3, 2, 1}}};
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options options = by_rays(4096, 1);
    const double half[3] = {30, 30, 30};
    const double corner[3] = {-8, -5, 20};
    const double u[3] = {0, 10, 0};
    const double v[3] = {16, 0, 0};
    const double on_floor[3] = {0, 0, -10};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    cone_scene *scene = cone_scene_new(DEPTH, 7);
    cone_scene_pose(scene, true, 1);
    cone_scene_add_room(scene, half);
    const size_t plain = scene->triangle_count;
    cone_scene_add_quad(scene, corner, u, v);
    cone_scene_add_point(scene, on_floor, up, 0);
    memcpy(scene->points[0].reflected, scene->points[0].normal, sizeof scene->points[0].reflected);
    scene->points[0].exponent = 4096;
    svo_tree *tree = build_materials(&opened, scene, plain, 0);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    setup.finishes = finishes;
    setup.finish_count = 2;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    cone_scene_gather(&opened, scene, light, &options);
    const double share = rectangle_factor(8.0 / 30, 5.0 / 30);
    for (int channel = 0; channel < 3; ++channel) {
        check_near("light of an emitter", (double)scene->results[0].irradiance[channel], (3 - channel) * PI * share,
                   0.02 * (3 - channel) * PI * share);
        check_near("its mirror image", (double)scene->results[0].specular[channel], 3 - channel, 1e-4);
    }
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* Two panes above a point that let .6 and .2 of the light through, of a sky and of a lamp. */
static void panes_let_their_share_through(void **state)
{
    static const uint8_t colors[2][4] = {{0, 0, 0, 102}, {0, 0, 0, 204}};
    static const double far_off = 60;
    static const double heights[2] = {6, 20};
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_source lamp = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, 0, -1}, .value = {1, 1, 1}};
    const svo_light_setup setup = {.struct_size = sizeof setup, .sources = &lamp, .source_count = 1, .sky = {1, 1, 1}};
    const svo_gather_options options = by_rays(16384, 2);
    const svo_gather_options occlusion = {
        .struct_size = sizeof occlusion, .method = SVO_GATHER_RAYS, .paths = 16384, .no_light = 1, .range = 1000};
    const double eye[3] = {0, 0, 0};
    cone_scene *scene = cone_scene_new(DEPTH, 12);
    cone_scene_pose(scene, false, 1);
    for (int k = 0; k < 2; ++k) {
        const double corner[3] = {-far_off, -far_off, heights[k]};
        cone_scene_add_quad(scene, corner, (const double[3]){2 * far_off, 0, 0}, (const double[3]){0, 2 * far_off, 0});
    }
    cone_scene_add_point(scene, eye, up, 0);
    svo_tree *tree =
        cone_scene_build_colored(&opened, scene, 2, colors, SVO_NEED_COLOR | SVO_NEED_MATERIAL | SVO_NEED_RAYS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    const double low = rectangle_factor(far_off / heights[0], far_off / heights[0]);
    const double high = rectangle_factor(far_off / heights[1], far_off / heights[1]);
    const double open = 1 - low + 0.6 * (low - high) + 0.6 * 0.2 * high;
    cone_scene_gather(&opened, scene, light, &options);
    check_near("openness under panes", (double)scene->results[0].openness, open, 0.004);
    check_near("light of the sky", (double)scene->results[0].irradiance[1], PI * open, 0.004 * PI);
    check_near("light of the lamp", (double)scene->results[0].direct[1], 0.6 * 0.2, 1e-3);
    cone_scene_gather(&opened, scene, light, &occlusion);
    check_near("openness alone", (double)scene->results[0].openness, open, 0.004);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* A lamp over a floor, with a shade before a part of it: by both methods, up to the shadow's edge. */
static void sources_light_directly(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double floor_corner[3] = {-60, -60, -20};
    const double floor_u[3] = {120, 0, 0};
    const double floor_v[3] = {0, 120, 0};
    const double shade_corner[3] = {0, -60, 0}; /* x above 0: the floor's shadow begins at 0 */
    const double shade_u[3] = {60, 0, 0};
    const double shade_v[3] = {0, 120, 0};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .value = {100, 200, 400}};
    cone_scene *scene = cone_scene_new(DEPTH, 8);
    cone_scene_add_quad(scene, floor_corner, floor_u, floor_v);
    cone_scene_add_quad(scene, shade_corner, shade_u, shade_v);
    for (int i = -20; i <= 20; ++i) {
        const double position[3] = {i == 0 ? 0.05 : i, 1.5 * i, -20};
        cone_scene_add_point(scene, position, up, 0);
    }
    for (int axis = 0; axis < 3; ++axis) {
        lamp.position[axis] = (float)(64 + (axis == 2 ? 20 : 0));
    }
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_RAYS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    setup.sources = &lamp;
    setup.source_count = 1;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    for (int method = SVO_GATHER_CONES; method <= SVO_GATHER_RAYS; ++method) {
        const svo_gather_options options = {.struct_size = sizeof options, .method = (svo_gather_method)method};
        cone_scene_gather(&opened, scene, light, &options);
        for (int i = -20; i <= 20; ++i) {
            const svo_gather_result *result = &scene->results[i + 20];
            const double x = i == 0 ? 0.05 : i;
            const double square = x * x + 2.25 * i * i + 40 * 40;
            const double expected = i < 0 ? 100 * 40 / (square * sqrt(square)) : 0;
            check_near("light of a lamp", (double)result->direct[0], expected, 1e-4 * expected);
            check_near("its blue", (double)result->direct[2], 4 * expected, 4e-4 * expected);
            assert_true((method == SVO_GATHER_CONES) == (isnan(result->openness_error) != 0));
        }
    }
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* The share of a disk of radius 1 that lies on the side of a line below some height. */
static double disk_share(double height)
{
    const double h = fmin(fmax(height, -1), 1);
    return 0.5 + (h * sqrt(1 - h * h) + asin(h)) / PI;
}

/* A floor whose half lies below a shade: what a source with a size brings to it. per_disk: how far the shade's edge is
   from the middle of the disk that the source shows, in its radii, for a place aside by 1. */
static void check_penumbra(const fixture *opened, cone_scene *scene, svo_light *light, const svo_light_source *source,
                           double per_disk, const char *what)
{
    const svo_light_setup setup = {.struct_size = sizeof setup, .sources = source, .source_count = 1};
    light_succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
    for (int method = SVO_GATHER_CONES; method <= SVO_GATHER_RAYS; ++method) {
        const svo_gather_options options = {.struct_size = sizeof options, .method = (svo_gather_method)method};
        double difference = 0;
        cone_scene_gather(opened, scene, light, &options);
        for (size_t i = 0; i < scene->point_count; ++i) {
            const double x = (double)scene->points[i].position[0] - 64;
            const double away = 40 * 40 + x * x;
            const double whole = source->kind == SVO_SOURCE_DIRECTIONAL ? 1 : 40 / (away * sqrt(away));
            const double share = (double)scene->results[i].direct[0] / whole;
            difference += (share - disk_share(-x * per_disk)) / (double)scene->point_count;
            check_near(what, share, disk_share(-x * per_disk), 0.04);
        }
        check_near("the mean difference", difference, 0, 0.004);
    }
}

/* A sun and a ball over a floor with a shade before a part of it: half-shadows as wide as closed forms have them. */
static void sources_with_a_size_have_soft_shadows(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, 0, -3}, .value = {1, 1, 1}, .radius = 0.08F};
    const svo_light_source ball = {
        .kind = SVO_SOURCE_POINT, .position = {64, 64, 84}, .value = {1, 1, 1}, .radius = 2.5F};
    svo_light_source spot = ball;
    cone_scene *scene = cone_scene_new(DEPTH, 8);
    cone_scene_add_quad(scene, (const double[3]){-60, -60, -20}, (const double[3]){120, 0, 0},
                        (const double[3]){0, 120, 0});
    cone_scene_add_quad(scene, (const double[3]){0, -60, 0}, (const double[3]){60, 0, 0}, (const double[3]){0, 120, 0});
    for (int i = -40; i <= 40; ++i) {
        cone_scene_add_point(scene, (const double[3]){0.1 * i + 0.01, 0, -20}, up, 0);
    }
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_RAYS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    /* An edge 20 above the floor, x aside, lies x / 20 from the sun's middle; and x from the ball's, 40 above. */
    check_penumbra(&opened, scene, light, &sun, 1 / (20 * sin(0.08)), "a sun's share");
    check_penumbra(&opened, scene, light, &ball, 1 / 2.5, "a ball's share");
    spot.kind = SVO_SOURCE_SPOT;
    spot.direction[2] = -1;
    spot.inner_angle = 1.0F;
    spot.outer_angle = 1.2F;
    check_penumbra(&opened, scene, light, &spot, 1 / 2.5, "a wide spot's share");
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* A ball lights what faces it as its middle does, and what it is half above with the mean of the heights over half its
   disk, 2 / (3 pi); what is inside the ball is not in the way. Where the point is inside, it is a point. */
static void a_ball_shines_like_its_middle(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double aside[3] = {1, 0, 0};
    const double eye[3] = {0, 0, 0};
    const double size = 0.1;
    svo_light_source ball = {
        .kind = SVO_SOURCE_POINT, .position = {64, 64, 94}, .value = {900, 900, 900}, .radius = (float)(30 * size)};
    const svo_light_setup setup = {.struct_size = sizeof setup, .sources = &ball, .source_count = 1};
    cone_scene *scene = cone_scene_new(DEPTH, 8);
    cone_scene_add_quad(scene, (const double[3]){-60, -60, -40}, (const double[3]){9, 0, 0},
                        (const double[3]){0, 9, 0});
    cone_scene_add_point(scene, eye, up, 0);
    cone_scene_add_quad(scene, (const double[3]){0.2, 0.2, 29.5}, (const double[3]){0.8, 0, 0},
                        (const double[3]){0, 0.8, 0});
    cone_scene_add_point(scene, eye, aside, 0);
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_RAYS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    const svo_gather_options options = by_rays(16, 1);
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    cone_scene_gather(&opened, scene, light, &options);
    check_near("what faces the ball", (double)scene->results[0].direct[0], 1, 1e-3);
    check_near("what it is half above", (double)scene->results[1].direct[0], size * 2 / (3 * PI), 0.03 * size);
    ball.radius = 31;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    cone_scene_gather(&opened, scene, light, &options);
    check_near("from inside", (double)scene->results[0].direct[0], 1, 1e-3);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* A disk over a floor that it is parallel to (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors",
   B-13); dark above it; and, as small as a point, the cosine's square over the squared distance. */
static void disks_shine_to_one_side(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double height = 20;
    const double radius = 16;
    svo_light_source disk = {.kind = SVO_SOURCE_DISK,
                             .position = {64, 64, 64},
                             .direction = {0, 0, -2},
                             .value = {1000, 1000, 1000},
                             .radius = (float)radius};
    const svo_light_setup setup = {.struct_size = sizeof setup, .sources = &disk, .source_count = 1};
    const svo_gather_options options = by_rays(16, 1);
    cone_scene *scene = cone_scene_new(DEPTH, 8);
    cone_scene_add_quad(scene, (const double[3]){-60, -60, -20}, (const double[3]){120, 0, 0},
                        (const double[3]){0, 120, 0});
    for (int i = 0; i < 12; ++i) {
        cone_scene_add_point(scene, (const double[3]){4.0 * i, 0, -height}, up, 0);
    }
    cone_scene_add_point(scene, (const double[3]){3, 3, 20}, (const double[3]){0, 0, -1}, 0);
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_RAYS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    for (int size = 0; size < 2; ++size) {
        disk.radius = size > 0 ? (float)radius : 0;
        light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
        cone_scene_gather(&opened, scene, light, &options);
        for (int i = 0; i < 12; ++i) {
            const double squared = height * height + 16.0 * i * i;
            const double sum = squared + radius * radius;
            const double factor =
                (1 - (squared - radius * radius) / sqrt(sum * sum - 4 * 16.0 * i * i * radius * radius)) / 2;
            const double expected =
                1000 * (size > 0 ? factor / (radius * radius) : height * height / (squared * squared));
            check_near("a disk's light", (double)scene->results[i].direct[1], expected,
                       (size > 0 ? 0.02 : 1e-4) * expected);
        }
        check_near("behind the disk", (double)scene->results[12].direct[1], 0, 0);
    }
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* What cones gather costs a ray to each source besides, with a reflection too: none of a lobe that nobody asked for. */
static void cones_have_a_ray_to_each_source(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options cones = {.struct_size = sizeof cones, .cones = 16};
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {64, 64, 80}, .value = {1, 1, 1}};
    const double corner[3] = {-60, -60, -20};
    const double u[3] = {120, 0, 0};
    const double v[3] = {0, 120, 0};
    const double position[3] = {5, 6, -20};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    cone_scene *scene = cone_scene_new(DEPTH, 8);
    cone_scene_add_quad(scene, corner, u, v);
    cone_scene_add_point(scene, position, up, 0);
    memcpy(scene->points[0].reflected, scene->points[0].normal, sizeof scene->points[0].reflected);
    scene->points[0].exponent = 8;
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_RAYS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    cone_scene_gather(&opened, scene, light, &cones);
    const uint32_t dark_steps = scene->results[0].steps;
    setup.sources = &lamp;
    setup.source_count = 1;
    setup.no_photons = 1;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    cone_scene_gather(&opened, scene, light, &cones);
    assert_true(scene->results[0].direct[0] > 0);
    assert_int_equal(scene->results[0].steps, dark_steps + 1);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* ---- emitters ---- */

/* A closed room with a small lamp below its ceiling, and a dimmer one in a corner; points on floor and walls. */
static cone_scene *two_lamps(size_t *plain)
{
    const double half[3] = {30, 30, 30};
    const double corners[2][3] = {{-4, -3, 29}, {20, 20, -20}};
    const double edges[2][3] = {{0, 5, 0}, {6, 0, 0}};
    cone_scene *scene = cone_scene_new(DEPTH, 13);
    cone_scene_pose(scene, true, 1);
    cone_scene_add_room(scene, half);
    *plain = scene->triangle_count;
    for (int lamp = 0; lamp < 2; ++lamp) {
        cone_scene_add_quad(scene, corners[lamp], edges[0], edges[1]);
    }
    for (int i = 0; i < 400; ++i) {
        const double on_floor[3] = {(i % 20 - 9.5) * 2.5, (i / 20 - 9.5) * 2.5, -29.5}; /* NOLINT: a row */
        cone_scene_add_point(scene, on_floor, up, 0);
    }
    return scene;
}

/* 64 paths beside 16,384: a small lamp makes little noise, and no bias. Without aiming the error is .95. */
static void few_paths_find_small_lamps(void **state)
{
    static const svo_finish finishes[2] = {{.emission = {0, 0, 0}}, {.emission = {20, 10, 5}}};
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options many = by_rays(16384, 2);
    const svo_gather_options few = by_rays(64, 2);
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    double truth[400] = {0};
    double squares = 0;
    double sum = 0;
    double mean = 0;
    size_t plain = 0;
    cone_scene *scene = two_lamps(&plain);
    svo_tree *tree = build_materials(&opened, scene, plain, 128);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    setup.finishes = finishes;
    setup.finish_count = 2;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    assert_int_equal(light_info_of(light).emitter_bytes, 0);
    cone_scene_gather(&opened, scene, light, &many);
    assert_true(light_info_of(light).emitter_bytes > 0);
    for (size_t i = 0; i < scene->point_count; ++i) {
        truth[i] = (double)scene->results[i].irradiance[0];
        mean += truth[i] / (double)scene->point_count;
    }
    cone_scene_gather(&opened, scene, light, &few);
    for (size_t i = 0; i < scene->point_count; ++i) {
        const double off = (double)scene->results[i].irradiance[0] - truth[i];
        squares += off * off / (double)scene->point_count;
        sum += off / (double)scene->point_count;
    }
    print_message("two lamps: relative RMSE %.3f, bias %+.3f\n", sqrt(squares) / mean, sum / mean);
    assert_true(sqrt(squares) / mean < 0.15);
    assert_true(fabs(sum / mean) < 0.02);
    setup.finish_count = 0;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    assert_int_equal(light_info_of(light).emitter_bytes, 0);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* ---- errors ---- */

/* Points under holes: the errors that are estimated are those that are made; a goal is kept with fewer rays. */
static void errors_are_estimated(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 9);
    svo_gather_options options = by_rays(64, 1);
    double estimated = 0;
    double true_squares = 0;
    uint64_t all_rays = 0;
    uint64_t rays = 0;
    add_roof(scene, 20, 8, 8);
    for (int i = 0; i < 2000; ++i) {
        const double position[3] = {(i % 40 - 20) * 0.7, (i / 40 - 25) * 0.7, 0}; /* NOLINT: a row */
        cone_scene_add_point(scene, position, up, 0);
    }
    cone_scene_trace_openness(&opened, scene, 64);
    gather_alone(&opened, scene, &options);
    for (size_t i = 0; i < scene->point_count; ++i) {
        const double off = (double)scene->results[i].openness - scene->openness[i];
        true_squares += off * off;
        estimated += (double)(scene->results[i].openness_error * scene->results[i].openness_error);
    }
    const double ratio = sqrt(estimated / true_squares);
    print_message("64 rays: RMSE %.4f, estimated %.4f\n", sqrt(true_squares / (double)scene->point_count),
                  sqrt(estimated / (double)scene->point_count));
    assert_true(ratio > 0.8 && ratio < 2.5);
    options = by_rays(4096, 1);
    options.error = 0.02F;
    gather_alone(&opened, scene, &options);
    true_squares = 0;
    for (size_t i = 0; i < scene->point_count; ++i) {
        const double off = (double)scene->results[i].openness - scene->openness[i];
        true_squares += off * off;
        assert_true(scene->results[i].steps == 4096 || (double)scene->results[i].openness_error <= 0.02);
        rays += scene->results[i].steps;
        all_rays += 4096;
    }
    print_message("goal .02: RMSE %.4f, %.1f rays a point\n", sqrt(true_squares / (double)scene->point_count),
                  (double)rays / (double)scene->point_count);
    assert_true(sqrt(true_squares / (double)scene->point_count) < 0.02);
    assert_true(rays < all_rays / 16);
    cone_scene_free(scene);
}

/* A point alone, and in another place of a batch, has the same bits. */
static void points_do_not_depend_on_others(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options options = by_rays(32, 3);
    cone_scene *scene = cone_scene_new(DEPTH, 10);
    svo_gather_result first[100];
    cone_scene_pose(scene, true, 1);
    add_roof(scene, 12, 5, 9);
    for (int i = 0; i < 100; ++i) {
        const double position[3] = {0.3 * i - 15, 0.1 * i, 0.05 * i};
        cone_scene_add_point(scene, position, up, 0);
    }
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL | SVO_NEED_RAYS);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sky[1] = 1;
    light_succeed(&opened, svo_light_set_sources(light, &setup, opened.queue));
    cone_scene_gather(&opened, scene, light, &options);
    memcpy(first, scene->results, sizeof first);
    for (int i = 0; i < 50; ++i) {
        const svo_gather_point kept = scene->points[i];
        scene->points[i] = scene->points[99 - i];
        scene->points[99 - i] = kept;
    }
    cone_scene_gather(&opened, scene, light, &options);
    for (int i = 0; i < 100; ++i) {
        assert_memory_equal(&scene->results[99 - i], &first[i], sizeof first[i]);
    }
    scene->points[0] = scene->points[99];
    scene->point_count = 1;
    cone_scene_gather(&opened, scene, light, &options);
    assert_memory_equal(&scene->results[0], &first[0], sizeof first[0]);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

/* Trees without triangles are met by their voxels: a room of them is closed, and one with a wide hole is not. */
static void voxels_are_met_too(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options options = by_rays(1024, 1);
    const double eye[3] = {0, 0, 0};
    cone_scene *scene = cone_scene_new(DEPTH, 11);
    add_roof(scene, 12.5, 20, 20);
    cone_scene_add_point(scene, eye, up, 0);
    svo_tree *tree = cone_scene_build(&opened, scene, SVO_NEED_NORMAL);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_FACES);
    const double outside = 1 - rectangle_factor(60 / 12.5, 60 / 12.5);
    cone_scene_gather(&opened, scene, light, &options);
    check_near("openness under voxels", (double)scene->results[0].openness,
               outside + rectangle_factor(20 / 12.5, 20 / 12.5), 0.04);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    cone_scene_free(scene);
}

TEST_GROUP(gather_rays)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(openings_have_their_share),
        cmocka_unit_test(closed_rooms_are_closed),
        cmocka_unit_test(range_and_falloff_count),
        cmocka_unit_test(furnaces_have_their_radiance),
        cmocka_unit_test(emitters_light_what_they_face),
        cmocka_unit_test(panes_let_their_share_through),
        cmocka_unit_test(sources_light_directly),
        cmocka_unit_test(sources_with_a_size_have_soft_shadows),
        cmocka_unit_test(a_ball_shines_like_its_middle),
        cmocka_unit_test(disks_shine_to_one_side),
        cmocka_unit_test(cones_have_a_ray_to_each_source),
        cmocka_unit_test(few_paths_find_small_lamps),
        cmocka_unit_test(errors_are_estimated),
        cmocka_unit_test(points_do_not_depend_on_others),
        cmocka_unit_test(voxels_are_met_too),
    };
    return cmocka_run_group_tests_name("gather_rays", tests, fixture_group_setup, fixture_group_teardown);
}
