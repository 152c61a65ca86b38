/* SPDX-License-Identifier: MIT */
/*
 * Light through voxels that show in part, of trees without triangles: beside what passes each voxel on the way, found
 * one after the other in double precision.
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
#include "support/meshes.h"
#include "support/suite.h"

#define DEPTH  4u
#define WIDTH  ((size_t)1 << DEPTH)
#define CELLS  (WIDTH * WIDTH * WIDTH)
#define POINTS 60
/* Rays leave a point by so much, in voxels (kernels/light/surface.clh). */
#define OFFSET 1.75
/* Of shorter ways through a voxel the library may know nothing, in voxels. */
#define SHORTEST 0.03

/* Voxels in a grid with a free layer around it. */
typedef struct cloud {
    fixture opened;
    uint8_t alphas[CELLS];
    uint64_t random;
    svo_tree *tree;
    svo_light *light;
    svo_gather_point points[POINTS];
    svo_gather_result results[POINTS];
} cloud;

static cloud *cloud_new(void **state, uint64_t seed)
{
    cloud *made = calloc(1, sizeof *made);
    assert_non_null(made);
    made->opened = fixture_cl_of_group(state);
    made->random = seed;
    return made;
}

/* Lights the tree of the alphas with a sky of 1 and a sun. */
static void cloud_light(cloud *of, const float direction[3])
{
    svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .value = {1, 1, 1}};
    const svo_light_setup setup = {.struct_size = sizeof setup, .sources = &sun, .source_count = 1, .sky = {1, 1, 1}};
    const svo_light_options options = {.struct_size = sizeof options, .no_cones = 1};
    memcpy(sun.direction, direction, sizeof sun.direction);
    of->tree = light_tree_of(&of->opened, DEPTH, of->alphas);
    light_succeed(&of->opened, svo_light_create(of->tree, &options, of->opened.queue, &of->light));
    light_succeed(&of->opened, svo_light_set_sources(of->light, &setup, of->opened.queue));
}

static void cloud_dim(cloud *of)
{
    svo_light_destroy(&of->light);
    svo_tree_destroy(&of->tree);
}

static void cloud_gather(cloud *of, size_t count, uint32_t paths, uint32_t no_light)
{
    const svo_gather_options options = {
        .struct_size = sizeof options, .method = SVO_GATHER_RAYS, .paths = paths, .no_light = no_light};
    light_succeed(&of->opened,
                  svo_gather(of->light, svo_in_host(of->points), svo_in_host(of->results), count, &options, NULL));
}

/* How long a ray's way through a voxel is. */
static double way_through(const double from[3], const double along[3], const size_t cell[3])
{
    double first = 0;
    double last = HUGE_VAL;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = ((double)cell[axis] - from[axis]) / along[axis];
        const double high = ((double)cell[axis] + 1 - from[axis]) / along[axis];
        if (along[axis] != 0) {
            first = fmax(first, fmin(low, high));
            last = fmin(last, fmax(low, high));
        } else if (from[axis] < (double)cell[axis] || from[axis] > (double)cell[axis] + 1) {
            return 0;
        }
    }
    return fmax(last - first, 0);
}

/* What passes along a ray, and whether it grazes no voxel. */
static double passes(const cloud *of, const double from[3], const double along[3], bool *is_sure)
{
    double pass = 1;
    *is_sure = true;
    for (size_t k = 0; k < CELLS; ++k) {
        const size_t cell[3] = {k % WIDTH, k / WIDTH % WIDTH, k / WIDTH / WIDTH};
        const double way = of->alphas[k] != 0 ? way_through(from, along, cell) : 0;
        pass *= way > SHORTEST ? 1 - of->alphas[k] / 255.0 : 1;
        *is_sure = *is_sure && (way <= 0 || way > SHORTEST);
    }
    return pass;
}

/* The first voxel, which every tree of the fixture has, is left as it is: absent, and so clear. */
static void fill(cloud *of, double share)
{
    static const uint8_t some[4] = {51, 102, 204, 255};
    memset(of->alphas, 0, sizeof of->alphas);
    for (size_t k = 1; k < CELLS; ++k) {
        if (random_unit(&of->random) < share) {
            of->alphas[k] = some[random_below(&of->random, 4)];
        }
    }
}

/* Direct light is the product of what all voxels on the way let through. */
static void suns_shine_through_voxels(void **state)
{
    static const float directions[][3] = {
        {0, 0, -1}, {0.36F, 0.48F, 0.8F}, {-0.8F, 0.6F, 0}, {-0.11F, -0.79F, 0.6F}, {1, 0, 0}};
    cloud *of = cloud_new(state, 5);
    size_t checked = 0;
    size_t dim = 0;
    for (size_t i = 0; i < sizeof directions / sizeof directions[0]; ++i) {
        double to_sun[3];
        fill(of, 0.06);
        cloud_light(of, directions[i]);
        for (int axis = 0; axis < 3; ++axis) {
            to_sun[axis] = -(double)directions[i][axis];
        }
        for (size_t k = 0; k < POINTS; ++k) {
            for (int axis = 0; axis < 3; ++axis) {
                of->points[k].position[axis] = (float)(0.1 + random_unit(&of->random) * ((double)WIDTH - 0.2));
                of->points[k].normal[axis] = (float)to_sun[axis];
            }
        }
        cloud_gather(of, POINTS, 16, 0);
        for (size_t k = 0; k < POINTS; ++k) {
            const float *position = of->points[k].position;
            double from[3];
            bool is_sure = true;
            for (int axis = 0; axis < 3; ++axis) {
                from[axis] = (double)position[axis] + OFFSET * to_sun[axis];
            }
            const double expected = passes(of, from, to_sun, &is_sure);
            const double found = (double)of->results[k].direct[1];
            if (is_sure && !(fabs(found - expected) <= 1.0 / 255 + 1e-5)) {
                fail_msg("direction %zu, point %zu: light %g, not %g", i, k, found, expected);
            }
            checked += is_sure ? 1 : 0;
            dim += is_sure && expected > 0.01 && expected < 0.99 ? 1 : 0;
        }
        cloud_dim(of);
    }
    print_message("%zu points, %zu of them in part\n", checked, dim);
    assert_true(checked > 200 && dim > 50);
    free(of);
}

/* The share of the sky above a point that shows, by directions with the density of the cosine. */
static double openness_of(cloud *of, const svo_gather_point *point)
{
    enum { RAYS = 4000 };
    const double from[3] = {(double)point->position[0], (double)point->position[1],
                            (double)point->position[2] + OFFSET};
    double sum = 0;
    for (int k = 0; k < RAYS; ++k) {
        const double radius = sqrt((k + 0.5) / RAYS);
        const double turn = 2.39996322972865332 * k;
        const double along[3] = {radius * cos(turn), radius * sin(turn), sqrt(1 - radius * radius)};
        bool is_sure = true;
        sum += passes(of, from, along, &is_sure);
    }
    return sum / RAYS;
}

/* Paths stop by chance as often as alpha tells, and rays that ask for occlusion alone weigh it. */
static void skies_shine_through_voxels(void **state)
{
    enum { SOME = 6 };
    static const float down[3] = {0, 0, -1};
    cloud *of = cloud_new(state, 11);
    double expected[SOME];
    fill(of, 0.03);
    for (size_t k = 0; k < CELLS; ++k) {
        of->alphas[k] = of->alphas[k] == 255 ? 102 : of->alphas[k];
    }
    cloud_light(of, down);
    for (size_t k = 0; k < SOME; ++k) {
        of->points[k] = (svo_gather_point){.position = {2.3F * (float)k + 1.1F, 8.2F, 1.4F}, .normal = {0, 0, 1}};
        expected[k] = openness_of(of, &of->points[k]);
    }
    for (uint32_t no_light = 0; no_light < 2; ++no_light) {
        cloud_gather(of, SOME, 4096, no_light);
        for (size_t k = 0; k < SOME; ++k) {
            const double found = (double)of->results[k].openness;
            if (!(fabs(found - expected[k]) <= 0.02 && expected[k] < 0.9)) {
                fail_msg("no_light %u, point %zu: openness %g, not %g", no_light, k, found, expected[k]);
            }
        }
    }
    cloud_dim(of);
    free(of);
}

/* A slanted picture of a wall of opaque voxels, by a sun. */
static void draw_wall(cloud *of, float pixels[64])
{
    static const float direction[3] = {0.6F, 0, -0.8F};
    const svo_render_options asked = {
        .struct_size = sizeof asked,
        .view = SVO_VIEW_DIRECT,
        .width = 4,
        .height = 4,
        .camera = {.eye = {8, 1, 15}, .target = {8, 8, 5}, .up = {0, 1, 0}, .vertical_fov = 0.3F},
        .output = {.format = SVO_PIXELS_LINEAR}};
    cloud_light(of, direction);
    light_succeed(&of->opened, svo_render(svo_light_target(of->light), &asked, svo_in_host(pixels), NULL));
    cloud_dim(of);
}

/* A film that hardly shows, right before a wall, changes nothing: the wall is met on the side that faces the film. */
static void films_leave_walls_as_they_are(void **state)
{
    float plain[64];
    float covered[64];
    cloud *of = cloud_new(state, 1);
    memset(of->alphas + 4 * WIDTH * WIDTH, 255, WIDTH * WIDTH);
    draw_wall(of, plain);
    memset(of->alphas + 5 * WIDTH * WIDTH, 1, WIDTH * WIDTH);
    draw_wall(of, covered);
    for (size_t k = 0; k < 64; ++k) {
        if (!(fabsf(covered[k] - plain[k]) <= 1e-5F && plain[k] > 0.001F)) {
            fail_msg("value %zu: %g behind a film, %g without", k, (double)covered[k], (double)plain[k]);
        }
    }
    free(of);
}

/* Columns of voxels catch what does not pass them, of a sun along them; without photon_alpha all of it. */
static void voxels_catch_their_alpha(void **state)
{
    cloud *of = cloud_new(state, 23);
    for (uint32_t photon_alpha = 0; photon_alpha < 2; ++photon_alpha) {
        const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, 0, -1}, .value = {1, 2, 3}};
        const svo_light_setup setup = {.struct_size = sizeof setup,
                                       .sources = &sun,
                                       .source_count = 1,
                                       .view_resolution = 512,
                                       .photon_alpha = photon_alpha};
        double expected = 0;
        fill(of, 0.1);
        of->alphas[0] = 204;
        for (size_t column = 0; column < WIDTH * WIDTH; ++column) {
            double passing = 1;
            for (size_t z = 0; z < WIDTH; ++z) {
                const uint8_t alpha = of->alphas[column + WIDTH * WIDTH * z];
                passing *= photon_alpha != 0 ? 1 - alpha / 255.0 : alpha == 0 ? 1 : 0;
            }
            expected += 1 - passing;
        }
        of->tree = light_tree_of(&of->opened, DEPTH, of->alphas);
        of->light = light_of(&of->opened, of->tree, SVO_LIGHT_FACES);
        light_succeed(&of->opened, svo_light_set_sources(of->light, &setup, of->opened.queue));
        const double found = light_info_of(of->light).flux[1] / 2;
        if (!(fabs(found - expected) <= 0.01 * expected)) {
            fail_msg("photon_alpha %u: flux %g, not %g", photon_alpha, found, expected);
        }
        cloud_dim(of);
    }
    free(of);
}

TEST_GROUP(light_clear)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(suns_shine_through_voxels), cmocka_unit_test(skies_shine_through_voxels),
        cmocka_unit_test(films_leave_walls_as_they_are), cmocka_unit_test(voxels_catch_their_alpha)};
    return cmocka_run_group_tests_name("light_clear", tests, fixture_group_setup, fixture_group_teardown);
}
