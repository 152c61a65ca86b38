/* SPDX-License-Identifier: MIT */
/* The rays of `svocl bench rays` are what their names say. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "measure/ray_sets.h"
#include "support/suite.h"

enum { COUNT = 1000, EDGE = 28, TILE = 4 }; /* 28: the largest multiple of 4 with at most 1000 pixels in its square */

static svo_camera make_camera(void)
{
    return (svo_camera){.eye = {0, 0, 5}, .up = {0, 1, 0}, .vertical_fov = 0.6f};
}

/* Tiles hold the pixels of a picture, each once: those of one tile are neighbours. Rays beyond the picture begin it
   again. */
static void tiles_hold_the_picture(void **state)
{
    (void)state;
    static svo_ray tiles[COUNT], rows[EDGE * EDGE];
    const svo_camera camera = make_camera();
    bool seen[EDGE * EDGE] = {false};
    ray_set_primary(&camera, TILE, COUNT, tiles);
    ray_set_primary(&camera, 1, EDGE * EDGE, rows);
    for (size_t i = 0; i < EDGE * EDGE; ++i) {
        const size_t tile = i / (TILE * TILE), within = i % (TILE * TILE);
        const size_t row = tile / (EDGE / TILE) * TILE + within / TILE;
        const size_t column = tile % (EDGE / TILE) * TILE + within % TILE;
        assert_memory_equal(&tiles[i], &rows[row * EDGE + column], sizeof tiles[i]);
        assert_false(seen[row * EDGE + column]);
        seen[row * EDGE + column] = true;
    }
    assert_memory_equal(&tiles[EDGE * EDGE], &tiles[0], (COUNT - EDGE * EDGE) * sizeof tiles[0]);
}

/* Rays by the cosine leave the side that the primary ray met, in front of the surface; the mean of the cosine is 2/3,
   and of the directions along the surface 0. */
static void diffuse_rays_are_by_the_cosine(void **state)
{
    (void)state;
    static svo_ray primary[20000], rays[20000];
    static svo_hit hits[20000];
    const size_t count = sizeof rays / sizeof rays[0];
    for (size_t i = 0; i < count; ++i) { /* every second one hits */
        primary[i] = (svo_ray){.origin = {0, 0, 5}, .direction = {0, 0, -1}, .t_max = INFINITY};
        hits[i] = i % 2 == 0 ? (svo_hit){.t = 2, .normal = {0, 0.6f, -0.8f}}
                             : (svo_hit){.t = INFINITY, .triangle = SVO_NO_TRIANGLE};
    }
    assert_true(ray_set_diffuse(primary, hits, 0.5f, count, rays));
    double cosine = 0, along[3] = {0, 0, 0};
    for (size_t i = 0; i < count; ++i) {
        const float *to = rays[i].direction;
        const double up = -0.6 * (double)to[1] + 0.8 * (double)to[2]; /* the normal looks away from the primary ray */
        assert_true(up >= 0 && fabs(sqrt((double)(to[0] * to[0] + to[1] * to[1] + to[2] * to[2])) - 1) < 1e-6);
        assert_true(rays[i].origin[2] > 3 && rays[i].origin[2] < 3.001f && rays[i].t_max == 0.5f);
        cosine += up / (double)count;
        along[0] += (double)to[0] / (double)count;
        along[1] += ((double)to[1] + 0.6 * up) / (double)count;
        along[2] += ((double)to[2] - 0.8 * up) / (double)count;
    }
    assert_true(fabs(cosine - 2.0 / 3.0) < 0.01);
    assert_true(fabs(along[0]) < 0.01 && fabs(along[1]) < 0.01 && fabs(along[2]) < 0.01);
    hits[0].triangle = SVO_NO_TRIANGLE;
    assert_false(ray_set_diffuse(primary, hits, 0.5f, 1, rays));
}

/* Those that miss, in their order, again and again; none where all hit. */
static void rays_through_the_box_missed(void **state)
{
    (void)state;
    svo_ray among[5], rays[5];
    svo_hit hits[5];
    for (size_t i = 0; i < 5; ++i) {
        among[i] = (svo_ray){.t_max = (float)i};
        hits[i] = (svo_hit){.triangle = i == 1 || i == 4 ? SVO_NO_TRIANGLE : 7};
    }
    assert_true(ray_set_through(among, hits, 5, rays));
    static const float expected[5] = {1, 4, 1, 4, 1};
    for (size_t i = 0; i < 5; ++i) {
        assert_true(rays[i].t_max == expected[i]);
    }
    hits[1].triangle = hits[4].triangle = 7;
    assert_false(ray_set_through(among, hits, 5, rays));
}

TEST_GROUP(ray_sets)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_hold_the_picture),
        cmocka_unit_test(diffuse_rays_are_by_the_cosine),
        cmocka_unit_test(rays_through_the_box_missed),
    };
    return cmocka_run_group_tests_name("ray_sets", tests, NULL, NULL);
}
