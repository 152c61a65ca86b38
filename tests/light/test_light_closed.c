/* SPDX-License-Identifier: MIT */
/*
 * Light of rooms whose truth is a formula, as a caller sees it: svo_gather by rays with all options at their defaults,
 * but for the bounces of furnaces. Means over points within 10 %, leaks at most 1 %.
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

#define DEPTH  7u
#define PI     3.14159265358979323846
#define SIDE   30
#define POINTS (SIDE * SIDE) /* of a mean: a point has 64 paths, too few for a bound on each */

static const double up[3] = {0, 0, 1};

static void check_share(const char *what, double value, double expected, double share)
{
    print_message("%s: %.5f, expected %.5f\n", what, value, expected);
    if (!(fabs(value - expected) <= share * expected)) {
        fail_msg("%s is %g instead of %g, within %g %%", what, value, expected, 100 * share);
    }
}

/* ---- scenes ---- */

/* Points around a place, all within a sixteenth of a voxel: what they see is the same, their paths are not. */
static void add_points(cone_scene *scene, double x, double y, double z)
{
    for (int i = 0; i < POINTS; ++i) {
        const int row = i / SIDE;
        const double position[3] = {x + 0.002 * (i % SIDE - 15), y + 0.002 * (row - 15), z};
        cone_scene_add_point(scene, position, up, 0);
    }
}

/* A horizontal rectangle x0 .. x1, y0 .. y1. */
static void add_plane(cone_scene *scene, double x0, double x1, double y0, double y1, double z)
{
    const double corner[3] = {x0, y0, z};
    const double u[3] = {x1 - x0, 0, 0};
    const double v[3] = {0, y1 - y0, 0};
    cone_scene_add_quad(scene, corner, u, v);
}

/* A vertical wall above the line from one place to another. */
static void add_wall(cone_scene *scene, const double from[2], const double to[2], double bottom, double top)
{
    const double corner[3] = {from[0], from[1], bottom};
    const double u[3] = {to[0] - from[0], to[1] - from[1], 0};
    const double v[3] = {0, 0, top - bottom};
    cone_scene_add_quad(scene, corner, u, v);
}

/* Walls around -a .. a, -b .. b. */
static void add_walls(cone_scene *scene, double a, double b, double bottom, double top)
{
    const double corners[4][2] = {{-a, -b}, {a, -b}, {a, b}, {-a, b}};
    for (size_t i = 0; i < 4; ++i) {
        add_wall(scene, corners[i], corners[(i + 1) % 4], bottom, top);
    }
}

/* A ceiling over -a .. a, -b .. b with a hole of -c .. c, -d .. d. */
static void add_ceiling(cone_scene *scene, double a, double b, double c, double d, double z)
{
    add_plane(scene, -a, -c, -b, b, z);
    add_plane(scene, c, a, -b, b, z);
    add_plane(scene, -c, c, -b, -d, z);
    add_plane(scene, -c, c, d, b, z);
}

static void turn_round(cone_scene *scene)
{
    for (size_t i = 0; i < scene->triangle_count; ++i) {
        float *corners = scene->corners + 9 * i;
        for (int k = 0; k < 3; ++k) {
            const float kept = corners[3 + k];
            corners[3 + k] = corners[6 + k];
            corners[6 + k] = kept;
        }
    }
}

/* Gathers the scene lit by the setup. Its triangles from `plain` on have material 1, those before material 0, of one
   gray. */
static void gather_lit(const fixture *opened, cone_scene *scene, size_t plain, uint8_t gray,
                       const svo_light_setup *setup, const svo_gather_options *options)
{
    const uint8_t colors[2][4] = {{gray, gray, gray, 255}, {gray, gray, gray, 255}};
    svo_tree *tree = cone_scene_build_colored(opened, scene, plain, colors,
                                              SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_MATERIAL | SVO_NEED_RAYS |
                                                  SVO_NEED_PROJECTED_AREA);
    svo_light *light = light_of(opened, tree, SVO_LIGHT_FACES);
    light_succeed(opened, svo_light_set_sources(light, setup, opened->queue));
    cone_scene_gather(opened, scene, light, options);
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
}

/* Under a sky of radiance 1, in black surroundings. */
static void gather_under_sky(const fixture *opened, cone_scene *scene)
{
    const svo_light_setup setup = {.struct_size = sizeof setup, .sky = {1, 1, 1}};
    const svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
    gather_lit(opened, scene, scene->triangle_count, 0, &setup, &options);
}

/* ---- means ---- */

static double mean_openness(const cone_scene *scene, size_t first, size_t count)
{
    double sum = 0;
    for (size_t i = first; i < first + count; ++i) {
        sum += (double)scene->results[i].openness / (double)count;
    }
    return sum;
}

static double mean_irradiance(const cone_scene *scene, size_t first, size_t count)
{
    double sum = 0;
    for (size_t i = first; i < first + count; ++i) {
        sum += (double)scene->results[i].irradiance[1] / (double)count;
    }
    return sum;
}

/* The share of a hemisphere, weighted by the cosine, that a rectangle with one corner above the point, of sides a and b
   in units of its height, fills (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3). */
static double corner_factor(double a, double b)
{
    const double x = sqrt(1 + a * a);
    const double y = sqrt(1 + b * b);
    return (a / x * atan(b / x) + b / y * atan(a / y)) / (2 * PI);
}

/* Of the rectangle x0 .. x1, y0 .. y1 at a height over the point: corner rectangles add up, with the sign of their
   sides. */
static double rectangle_share(double x0, double x1, double y0, double y1, double height)
{
    return corner_factor(x1 / height, y1 / height) - corner_factor(x0 / height, y1 / height) -
           corner_factor(x1 / height, y0 / height) + corner_factor(x0 / height, y0 / height);
}

/* ---- openings ---- */

/* A room 12 high, closed but for a slot in its roof that is 33.2 long and 2 or 4 wide: .0750 and .1485 of the sky. */
static void slots_bring_their_share_of_the_sky(void **state)
{
    static const double widths[] = {2, 4};
    static const double shares[] = {0.0750, 0.1485};
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 1);
    for (size_t i = 0; i < sizeof widths / sizeof widths[0]; ++i) {
        const double half = widths[i] / 2;
        const double truth = rectangle_share(-half, half, -16.6, 16.6, 12);
        assert_true(fabs(truth - shares[i]) < 1e-4);
        cone_scene_clear(scene);
        cone_scene_pose(scene, true, 2);
        add_plane(scene, -20, 20, -20, 20, 0);
        add_ceiling(scene, 20, 20, half, 16.6, 12);
        add_walls(scene, 20, 20, 0, 12);
        add_points(scene, 0, 0, 0);
        gather_under_sky(&opened, scene);
        check_share("openness below a slot", mean_openness(scene, 0, POINTS), truth, 0.1);
        check_share("its skylight", mean_irradiance(scene, 0, POINTS), PI * truth, 0.1);
    }
    cone_scene_free(scene);
}

/* A shaft, open above: in its middle, and beside a wall, where the opening is seen from below its edge. */
static void wells_bring_their_share_of_the_sky(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 2);
    cone_scene_pose(scene, true, 2);
    add_plane(scene, -8, 8, -8, 8, -20);
    add_walls(scene, 8, 8, -20, 12);
    add_points(scene, 0, 0, -20);
    add_points(scene, 7, 0, -20);
    gather_under_sky(&opened, scene);
    for (size_t i = 0; i < 2; ++i) {
        const double x = i == 0 ? 0 : 7;
        const double truth = rectangle_share(-8 - x, 8 - x, -8, 8, 32);
        check_share("openness in a well", mean_openness(scene, i * POINTS, POINTS), truth, 0.1);
        check_share("its skylight", mean_irradiance(scene, i * POINTS, POINTS), PI * truth, 0.1);
    }
    cone_scene_free(scene);
}

/* A closed cube under a sky is dark inside, whichever way its triangles face: on its walls, in corners, in the air. */
static void closed_cubes_are_closed(void **state)
{
    static const double places[][3] = {{0, 0, -20}, {19.9, 19.9, -20}, {0, 0, 0}, {-19.9, 3, 7}};
    const fixture opened = fixture_cl_of_group(state);
    const double half[3] = {20, 20, 20};
    for (int turned = 0; turned < 2; ++turned) {
        cone_scene *scene = cone_scene_new(DEPTH, 3);
        cone_scene_pose(scene, turned == 0, 2);
        cone_scene_add_room(scene, half);
        for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
            add_points(scene, places[i][0], places[i][1], places[i][2]);
        }
        if (turned != 0) {
            turn_round(scene);
        }
        gather_under_sky(&opened, scene);
        for (size_t i = 0; i < scene->point_count; ++i) {
            if (!((double)scene->results[i].openness <= 0.02)) {
                fail_msg("openness %zu in a closed cube is %g", i, (double)scene->results[i].openness);
            }
        }
        const double leak = mean_irradiance(scene, 0, scene->point_count) / PI;
        if (!(leak <= 0.01)) {
            fail_msg("%g %% of the sky leak into a closed cube", 100 * leak);
        }
        cone_scene_free(scene);
    }
}

/* ---- sources ---- */

/* A shade 10 above a floor, under a sun of tangent (0.75, 0, -1): its shadow's edge lies 7.5 before the shade's. On the
   bright side a hundredth of a voxel from it the sun shines in full, on the other side not at all. */
static void shadows_of_a_sun_end_at_their_edge(void **state)
{
    static const double offsets[] = {-20, -3, -1, -0.1, -0.01, 0.01, 0.1, 1, 3, 20};
    enum { COUNT = sizeof offsets / sizeof offsets[0] };
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.75F, 0, -1}, .value = {2, 4, 8}}; /* length 1.25 */
    const svo_light_setup setup = {.struct_size = sizeof setup, .sources = &sun, .source_count = 1};
    const svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 4);
    cone_scene_pose(scene, false, 2);
    add_plane(scene, -40, 40, -40, 40, 0);
    add_plane(scene, -30, 0, -30, 30, 10); /* shades x of -22.5 .. 7.5 */
    for (size_t i = 0; i < COUNT; ++i) {
        const double position[3] = {7.5 + offsets[i], 0.3, 0};
        cone_scene_add_point(scene, position, up, 0);
    }
    gather_lit(&opened, scene, scene->triangle_count, 0, &setup, &options);
    for (size_t i = 0; i < COUNT; ++i) {
        const double expected = offsets[i] > 0 ? 4 / 1.25 : 0;
        const double direct = (double)scene->results[i].direct[1];
        if (!(fabs(direct - expected) <= 1e-4)) {
            fail_msg("the sun brings %g instead of %g at %g from the shadow's edge", direct, expected, offsets[i]);
        }
    }
    cone_scene_free(scene);
}

/* A quad under the ceiling of a black room emits 5: below it, and beside it. It hangs four voxels below the ceiling:
   what is met has the material of its leaf, and leaves that hold a piece of both are the ceiling's in part. */
static void emitters_bring_their_form_factor(void **state)
{
    static const svo_finish finishes[2] = {{.emission = {0, 0, 0}}, {.emission = {5, 5, 5}}};
    const svo_light_setup setup = {.struct_size = sizeof setup, .finishes = finishes, .finish_count = 2};
    const svo_gather_options options = SVO_GATHER_OPTIONS_INIT;
    const double half[3] = {25, 25, 15};
    const fixture opened = fixture_cl_of_group(state);
    cone_scene *scene = cone_scene_new(DEPTH, 5);
    cone_scene_pose(scene, true, 2);
    cone_scene_add_room(scene, half);
    const size_t plain = scene->triangle_count;
    add_plane(scene, -6, 6, -4, 4, 11);
    add_points(scene, 0, 0, -15);
    add_points(scene, 10, 5, -15);
    gather_lit(&opened, scene, plain, 0, &setup, &options);
    for (size_t i = 0; i < 2; ++i) {
        const double x = i == 0 ? 0 : 10;
        const double y = i == 0 ? 0 : 5;
        const double truth = 5 * PI * rectangle_share(-6 - x, 6 - x, -4 - y, 4 - y, 26);
        check_share("light of an emitter", mean_irradiance(scene, i * POINTS, POINTS), truth, 0.1);
    }
    cone_scene_free(scene);
}

/* A closed room of albedo a that emits e everywhere: with many bounces its radiance is e / (1 - a). */
static void furnaces_reach_their_limit(void **state)
{
    static const svo_finish glowing[2] = {{.emission = {0.5F, 0.5F, 0.5F}}, {.emission = {0.5F, 0.5F, 0.5F}}};
    static const uint8_t grays[] = {128, 188, 225};
    const svo_light_setup setup = {.struct_size = sizeof setup, .finishes = glowing, .finish_count = 2};
    const svo_gather_options options = {.struct_size = sizeof options, .bounces = 64};
    const double half[3] = {20, 25, 30};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof grays / sizeof grays[0]; ++i) {
        const double albedo = pow((grays[i] / 255.0 + 0.055) / 1.055, 2.4);
        cone_scene *scene = cone_scene_new(DEPTH, 6);
        cone_scene_pose(scene, true, 2);
        cone_scene_add_room(scene, half);
        add_points(scene, 3, 4, -30);
        gather_lit(&opened, scene, scene->triangle_count, grays[i], &setup, &options);
        check_share("light of a furnace", mean_irradiance(scene, 0, POINTS), PI * 0.5 / (1 - albedo), 0.01);
        cone_scene_free(scene);
    }
}

TEST_GROUP(light_closed)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slots_bring_their_share_of_the_sky),
        cmocka_unit_test(wells_bring_their_share_of_the_sky),
        cmocka_unit_test(closed_cubes_are_closed),
        cmocka_unit_test(shadows_of_a_sun_end_at_their_edge),
        cmocka_unit_test(emitters_bring_their_form_factor),
        cmocka_unit_test(furnaces_reach_their_limit),
    };
    return cmocka_run_group_tests_name("light_closed", tests, fixture_group_setup, fixture_group_teardown);
}
