/* SPDX-License-Identifier: MIT */
/*
 * Rays and nearest points against the mesh as it was given, by brute force in long double: no hit names a triangle
 * whose exact t is more than an ulp of float beyond the nearest one; t is rounded correctly in nine of ten, and off by
 * less than an ulp in all. Rays are aimed at corners and edges. A file without the mesh's own positions gives rays
 * against the snapped mesh.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/meshes.h"
#include "support/older_file.h"
#include "support/ray_check.h"
#include "support/suite.h"
#include "svocl/io.h"

enum { TRIANGLES = 400, RAYS = 6000, POINTS = 3000 };

/* A random mesh, shifted and scaled, whose coordinates are floats or use all bits of a double. */
typedef struct input {
    owned_mesh owned;
    float *floats;
    svo_mesh mesh;
    double low, width; /* of the cube around it, on each axis */
} input;

static void make_input(uint64_t seed, double shift, double scale, bool in_doubles, input *out)
{
    random_mesh(seed, TRIANGLES, 0.0, &out->owned);
    out->mesh = out->owned.mesh;
    out->low = shift;
    out->width = scale;
    out->floats = calloc(out->mesh.vertex_count * 3, sizeof *out->floats);
    assert_non_null(out->floats);
    for (size_t i = 0; i < out->mesh.vertex_count * 3; ++i) {
        out->owned.positions[i] = shift + scale * out->owned.positions[i];
        out->floats[i] = (float)out->owned.positions[i];
    }
    if (!in_doubles) {
        out->mesh.positions = out->floats;
        out->mesh.positions_double = NULL;
    }
}

static void free_input(input *made)
{
    free(made->floats);
    owned_mesh_free(&made->owned);
}

/* A point of a random triangle: a corner, a point of an edge, or one inside. */
static void pick_target(const input *made, uint64_t *random, double target[3])
{
    const size_t triangle = random_below(random, TRIANGLES);
    const uint32_t kind = random_below(random, 3);
    double share[3] = {1.0, 0.0, 0.0};
    if (kind > 0) {
        share[1] = random_unit(random);
        share[2] = kind > 1 ? (1.0 - share[1]) * random_unit(random) : 0.0;
        share[0] = 1.0 - share[1] - share[2];
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        target[axis] = 0.0;
        for (size_t corner = 0; corner < 3; ++corner) {
            const size_t vertex = made->owned.indices[3 * triangle + corner];
            target[axis] += share[corner] * made->owned.positions[3 * vertex + axis];
        }
    }
}

static void aim_rays(const input *made, uint64_t *random, svo_ray *rays)
{
    for (size_t i = 0; i < RAYS; ++i) {
        double target[3];
        pick_target(made, random, target);
        rays[i] = (svo_ray){.t_min = 0, .t_max = INFINITY};
        for (int axis = 0; axis < 3; ++axis) {
            const double away = made->width * (random_unit(random) * (i % 4 == 0 ? 20.0 : 2.0) - 0.5);
            rays[i].origin[axis] = (float)(made->low + away);
            rays[i].direction[axis] = (float)(target[axis] - (double)rays[i].origin[axis]);
        }
    }
}

static double ulp_of(double number)
{
    const float size = fabsf((float)number);
    return isinf(size) ? 0.0 : (double)nextafterf(size, INFINITY) - (double)size;
}

/* The closest hit of a ray that leans to one side by far less than a float resolves: long double may take a ray through
   a corner for one beside it. */
static oracle_ray_hit closest_when_leaning(const oracle_ray_scene *mesh, const svo_ray *ray, int side)
{
    oracle_ray wide = widen_ray(ray);
    for (int axis = 0; axis < 3; ++axis) {
        wide.direction[axis] *= 1.0 + ((side >> axis & 1) != 0 ? 0x1p-50 : -0x1p-50);
    }
    return oracle_ray_closest(mesh, &wide);
}

/* exact: infinity for a ray that meets nothing. */
static bool is_near_enough(const oracle_ray_scene *mesh, const oracle_ray *ray, uint32_t triangle, double exact)
{
    if (triangle == SVO_NO_TRIANGLE) {
        return isinf(exact);
    }
    const double t = (double)oracle_ray_plane(mesh, triangle, ray);
    return t <= exact + ulp_of(exact) && oracle_ray_touches(mesh, triangle, ray);
}

/* triangle: its index in the mesh, of which none is refused, or SVO_NO_TRIANGLE. */
static bool is_right(const oracle_ray_scene *mesh, const svo_ray *ray, uint32_t triangle, double *exact)
{
    const oracle_ray wide = widen_ray(ray);
    oracle_ray_hit nearest = oracle_ray_closest(mesh, &wide);
    *exact = nearest.hit ? nearest.t : (double)INFINITY;
    bool right = is_near_enough(mesh, &wide, triangle, *exact);
    for (int side = 0; side < 8 && !right; ++side) {
        nearest = closest_when_leaning(mesh, ray, side);
        right = is_near_enough(mesh, &wide, triangle, nearest.hit ? nearest.t : (double)INFINITY);
    }
    return right;
}

/* Returns how many ts are rounded correctly. */
static size_t check_hits(const char *what, const built *tree, const svo_ray *rays, const svo_hit *hits, size_t *met)
{
    const oracle_ray_scene mesh = ray_scene_of(tree);
    size_t rounded = 0;
    *met = 0;
    for (size_t i = 0; i < RAYS; ++i) {
        const oracle_ray wide = widen_ray(&rays[i]);
        double exact = 0.0;
        if (!is_right(&mesh, &rays[i], hits[i].triangle, &exact)) {
            fail_msg("%s, ray %zu: triangle %d at %.9g, the nearest is at %.9g", what, i, (int)hits[i].triangle,
                     (double)hits[i].t, exact);
            return 0;
        }
        if (hits[i].triangle != SVO_NO_TRIANGLE) {
            const double t = (double)oracle_ray_plane(&mesh, hits[i].triangle, &wide);
            assert_true(fabs((double)hits[i].t - t) <= ulp_of(t));
            rounded += hits[i].t == (float)t;
            ++*met;
        }
    }
    return rounded;
}

static void check_rays(const fixture *opened, const char *what, const input *made, uint32_t positions)
{
    static svo_ray rays[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 18;
    size_t met = 0;
    built tree;
    build_for_rays(opened, &made->mesh, 6, NULL, 0, &tree);
    assert_int_equal(tree.info.positions, positions);
    assert_true((tree.arrays.positions != NULL) == (positions == SVO_POSITIONS_FLOAT));
    assert_true((tree.arrays.positions_double != NULL) == (positions == SVO_POSITIONS_DOUBLE));
    aim_rays(made, &random, rays);
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, hits);
    const size_t rounded = check_hits(what, &tree, rays, hits, &met);
    assert_true(met > RAYS / 2 && 10 * rounded >= 9 * met);
    built_destroy(&tree);
}

/* Shifted so that coordinates use their lowest bits, and where float stages would be out of range. */
static const struct {
    const char *name;
    double shift, scale;
} places[] = {{"at the origin", -0.5, 1.0}, {"shifted", 3.1, 0.7},     {"far away", 1000.0, 1.0},
              {"tiny", 0x1p-62, 0x1p-60},   {"huge", -0x1p59, 0x1p60}, {"millimeters", -0.0031, 0.001}};

static void check_places(const fixture *opened, bool in_doubles, uint32_t positions)
{
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        input made;
        make_input(i, places[i].shift, places[i].scale, in_doubles, &made);
        check_rays(opened, places[i].name, &made, positions);
        free_input(&made);
    }
}

static void hits_are_those_of_the_input(void **state)
{
    check_places(fixture_of_group(state), false, SVO_POSITIONS_FLOAT);
}

static void doubles_stay_doubles(void **state)
{
    check_places(fixture_of_group(state), true, SVO_POSITIONS_DOUBLE);
}

/* ---- nearest points ---- */

static void check_nearest(const fixture *opened, const input *made)
{
    static svo_query_point points[POINTS];
    static svo_nearest found[POINTS];
    uint64_t random = 8;
    size_t rounded = 0;
    built tree;
    build_for_rays(opened, &made->mesh, 6, NULL, 0, &tree);
    const oracle_ray_scene mesh = ray_scene_of(&tree);
    for (size_t i = 0; i < POINTS; ++i) {
        points[i].max_distance = INFINITY;
        for (int axis = 0; axis < 3; ++axis) {
            const double away = random_unit(&random) * (i % 4 == 0 ? 20.0 : 1.0);
            points[i].position[axis] = (float)(made->low + made->width * away);
        }
    }
    assert_int_equal(svo_tree_nearest(tree.tree, svo_in_host(points), svo_in_host(found), POINTS,
                                      &(svo_submit){.queue = opened->queue}),
                     SVO_OK);
    for (size_t i = 0; i < POINTS; ++i) {
        const double at[3] = {(double)points[i].position[0], (double)points[i].position[1],
                              (double)points[i].position[2]};
        size_t nearest = 0;
        const double least = oracle_nearest(&mesh, at, &nearest);
        const double own = oracle_triangle_distance(&mesh, found[i].triangle, at);
        if (own > least + ulp_of(least) || fabs((double)found[i].distance - own) > ulp_of(own)) {
            fail_msg("point %zu: triangle %u at %.9g, exactly %.9g; the nearest is %zu at %.9g", i, found[i].triangle,
                     (double)found[i].distance, own, nearest, least);
            return;
        }
        rounded += found[i].distance == (float)own;
    }
    assert_true(10 * rounded >= 9 * (size_t)POINTS);
    built_destroy(&tree);
}

static void nearest_points_are_those_of_the_input(void **state)
{
    for (size_t i = 0; i < 6; ++i) {
        input made;
        make_input(i, places[i / 2].shift, places[i / 2].scale, i % 2 != 0, &made);
        check_nearest(fixture_of_group(state), &made);
        free_input(&made);
    }
}

/* ---- a caller's grids ---- */

/* Two grids that abut in the middle of the mesh: the nearer of their hits is the mesh's, though each sees its own half
   alone. */
static void abutting_grids_lose_no_hit(void **state)
{
    static svo_ray rays[RAYS];
    static svo_hit hits[2][RAYS];
    const fixture *opened = fixture_of_group(state);
    uint64_t random = 77;
    input made;
    built halves[2];
    make_input(3, 0.0, 1.0, false, &made);
    for (int half = 0; half < 2; ++half) {
        build_for_rays(opened, &made.mesh, 6, (const double[3]){-0.01, -0.01, half == 0 ? -1.5 : 0.4}, 1.9,
                       &halves[half]);
    }
    aim_rays(&made, &random, rays);
    const oracle_ray_scene whole = {
        .positions = made.floats, .indices = made.owned.indices, .triangle_count = TRIANGLES};
    for (int half = 0; half < 2; ++half) {
        trace_rays(opened, &halves[half], rays, RAYS, SVO_TRACE_CLOSEST, hits[half]);
        built_destroy(&halves[half]);
    }
    for (size_t i = 0; i < RAYS; ++i) {
        const svo_hit *nearer = hits[0][i].t <= hits[1][i].t ? &hits[0][i] : &hits[1][i];
        double exact = 0.0;
        assert_true(is_right(&whole, &rays[i], nearer->triangle, &exact));
    }
    free_input(&made);
}

/* ---- files of version 1 ---- */

static void rays_of_version_1_meet_the_snapped_mesh(void **state)
{
    static svo_ray rays[RAYS];
    static svo_hit hits[RAYS], of_input[RAYS];
    const fixture *opened = fixture_of_group(state);
    uint64_t random = 1;
    size_t met = 0;
    size_t moved = 0;
    input made;
    built tree;
    make_input(5, 0.1, 0.7, false, &made);
    build_for_rays(opened, &made.mesh, 6, NULL, 0, &tree);
    aim_rays(&made, &random, rays);
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, of_input);
    size_t byte_count = 0;
    uint8_t *file = older_file_make(tree.tree, 1, &byte_count);
    built old = {.tree = NULL};
    svo_message message = {""};
    if (svo_tree_load(svo_from_memory(file, byte_count, "version 1"), NULL, &old.tree, &message) != SVO_OK) {
        fail_msg("%s", message.text);
        return;
    }
    free(file);
    old.info = (svo_tree_info)SVO_TREE_INFO_INIT;
    old.arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    assert_int_equal(svo_tree_get_info(old.tree, &old.info), SVO_OK);
    assert_int_equal(svo_tree_get_arrays(old.tree, &old.arrays), SVO_OK);
    assert_int_equal(old.info.positions, SVO_POSITIONS_ROUNDED);
    assert_int_equal(svo_tree_upload(old.tree, opened->device, opened->queue), SVO_OK);
    trace_rays(opened, &old, rays, RAYS, SVO_TRACE_CLOSEST, hits);
    (void)check_hits("version 1", &old, rays, hits, &met);
    for (size_t i = 0; i < RAYS; ++i) {
        moved += hits[i].triangle != of_input[i].triangle || hits[i].t != of_input[i].t;
    }
    assert_true(met > RAYS / 4 && moved > RAYS / 4);
    svo_tree_destroy(&old.tree);
    built_destroy(&tree);
    free_input(&made);
}

TEST_GROUP(ray_input)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_the_input), cmocka_unit_test(doubles_stay_doubles),
        cmocka_unit_test(nearest_points_are_those_of_the_input), cmocka_unit_test(abutting_grids_lose_no_hit),
        cmocka_unit_test(rays_of_version_1_meet_the_snapped_mesh)};
    return cmocka_run_group_tests_name("ray_input", tests, fixture_group_setup, fixture_group_teardown);
}
