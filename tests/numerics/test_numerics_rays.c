/* SPDX-License-Identifier: MIT */
/*
 * The catalog's rows on rays, against a reference that tests every triangle in long double: closed surfaces have no
 * gaps (T11), no direction or origin loses a hit (T12), invalid rays hit nothing and cost nothing (T13).
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
#include "support/ray_check.h"
#include "support/suite.h"

/* ---- T11: watertight ---- */

enum { RINGS = 48, SIDES = 96, BALL_VERTICES = 2 + (RINGS - 1) * SIDES, BALL_TRIANGLES = 2 * SIDES * (RINGS - 1) };

/* A closed ball whose corners are at integer multiples of a step from its center. */
typedef struct ball {
    int32_t corners[BALL_VERTICES][3]; /* in steps, from the center */
    double positions[BALL_VERTICES][3];
    uint32_t indices[BALL_TRIANGLES][3];
    svo_mesh mesh;
} ball;

static uint32_t ring_vertex(uint32_t ring, uint32_t side)
{
    return 1 + (ring - 1) * SIDES + side % SIDES;
}

static void make_indices(ball *made)
{
    uint32_t n = 0;
    for (uint32_t side = 0; side < SIDES; ++side) {
        const uint32_t caps[2][3] = {
            {0, ring_vertex(1, side), ring_vertex(1, side + 1)},
            {BALL_VERTICES - 1, ring_vertex(RINGS - 1, side + 1), ring_vertex(RINGS - 1, side)}};
        memcpy(made->indices[n], caps, sizeof caps);
        n += 2;
        for (uint32_t ring = 1; ring + 1 < RINGS; ++ring) {
            const uint32_t halves[2][3] = {
                {ring_vertex(ring, side), ring_vertex(ring + 1, side), ring_vertex(ring, side + 1)},
                {ring_vertex(ring, side + 1), ring_vertex(ring + 1, side), ring_vertex(ring + 1, side + 1)}};
            memcpy(made->indices[n], halves, sizeof halves);
            n += 2;
        }
    }
    assert_int_equal(n, BALL_TRIANGLES);
}

static ball *make_ball(const double center[3], double step, double radius_steps)
{
    const double pi = 3.14159265358979323846;
    ball *made = calloc(1, sizeof *made);
    assert_non_null(made);
    for (uint32_t ring = 0; ring <= RINGS; ++ring) {
        for (uint32_t side = 0; side < SIDES; ++side) {
            const double height = cos(pi * ring / RINGS);
            const double around = 2 * pi * side / SIDES;
            const double out = sin(pi * ring / RINGS);
            int32_t *corner = made->corners[ring == 0       ? 0
                                            : ring == RINGS ? BALL_VERTICES - 1
                                                            : ring_vertex(ring, side)];
            corner[0] = (int32_t)rint(radius_steps * out * cos(around));
            corner[1] = (int32_t)rint(radius_steps * height);
            corner[2] = (int32_t)rint(radius_steps * out * sin(around));
        }
    }
    for (uint32_t i = 0; i < BALL_VERTICES; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            made->positions[i][axis] = center[axis] + step * made->corners[i][axis];
        }
    }
    make_indices(made);
    made->mesh = (svo_mesh){.struct_size = sizeof(svo_mesh),
                            .positions_double = made->positions[0],
                            .vertex_count = BALL_VERTICES,
                            .indices = made->indices[0],
                            .triangle_count = BALL_TRIANGLES};
    return made;
}

typedef enum aim { AIM_ANYWHERE, AIM_AT_VERTICES, AIM_AT_EDGES, AIM_COUNT } aim;

/* From a lattice point inside the ball; exact in float, so a ray aimed at a corner or an edge hits it exactly. */
static svo_ray ball_ray(const ball *target, const double center[3], double step, double radius_steps, aim kind,
                        uint64_t *random)
{
    svo_ray ray = {.t_min = 0, .t_max = INFINITY};
    const uint32_t *corners = target->indices[random_below(random, BALL_TRIANGLES)];
    const int32_t *a = target->corners[corners[0]];
    const int32_t *b = target->corners[corners[1 + random_below(random, 2)]];
    const int32_t share = kind == AIM_AT_EDGES ? 1 + (int32_t)random_below(random, 7) : 8;
    for (int axis = 0; axis < 3; ++axis) {
        const int32_t from = (int32_t)((random_unit(random) - 0.5) * radius_steps);
        const double towards = kind == AIM_ANYWHERE
                                   ? random_unit(random) - 0.5
                                   : (double)((a[axis] - from) * share + (b[axis] - from) * (8 - share));
        ray.origin[axis] = (float)(center[axis] + step * from);
        ray.direction[axis] = (float)towards;
    }
    return ray;
}

static void check_ball(const fixture *opened, const double center[3], double step, double radius_steps)
{
    enum { BATCH = 333334 };
    const double edge = 4096 * step;
    const double origin[3] = {center[0] - edge / 2, center[1] - edge / 2, center[2] - edge / 2};
    uint64_t random = 11;
    svo_ray *rays = calloc(BATCH, sizeof *rays);
    svo_hit *hits = calloc(BATCH, sizeof *hits);
    ball *target = make_ball(center, step, radius_steps);
    built tree;
    assert_non_null(rays);
    assert_non_null(hits);
    build_for_rays(opened, &target->mesh, 7, origin, edge, &tree);
    for (aim kind = AIM_ANYWHERE; kind < AIM_COUNT; ++kind) {
        for (size_t i = 0; i < BATCH; ++i) {
            rays[i] = ball_ray(target, center, step, radius_steps, kind, &random);
        }
        trace_rays(opened, &tree, rays, BATCH, SVO_TRACE_CLOSEST, hits);
        for (size_t i = 0; i < BATCH; ++i) {
            if (hits[i].triangle == SVO_NO_TRIANGLE) {
                fail_msg("ball at %g, aim %d, ray %zu slips through", center[0], (int)kind, i);
            }
            if (i % 5003 == 0) {
                assert_is_closest("ball", &tree, &rays[i], &hits[i]);
            }
        }
    }
    built_destroy(&tree);
    free(target);
    free(hits);
    free(rays);
}

static void t11_closed_surfaces_have_no_gaps(void **state)
{
    const fixture *opened = fixture_of_group(state);
    check_ball(opened, (const double[3]){0, 0, 0}, 0x1p-10, 1900);
    check_ball(opened, (const double[3]){100, 100, 100}, 0x1p-10, 1900);
    check_ball(opened, (const double[3]){148376, 1234, -223423}, 0x1p-6, 1900);
}

/* ---- T12: directions and origins ---- */

static const float components[] = {0.0f, -0.0f, 1.0f, -1.0f, 0x1p-24f, -0x1p-24f, 1e-40f, -1e-40f, 0.37f};
enum { COMPONENTS = sizeof components / sizeof components[0], DIRECTIONS = COMPONENTS * COMPONENTS * COMPONENTS };

/* All directions with these components from one origin. */
static void check_directions(const fixture *opened, const char *what, const built *tree, const double origin[3])
{
    static svo_ray rays[DIRECTIONS];
    static svo_hit hits[DIRECTIONS];
    for (uint32_t i = 0; i < DIRECTIONS; ++i) {
        const uint32_t picks[3] = {i % COMPONENTS, i / COMPONENTS % COMPONENTS, i / COMPONENTS / COMPONENTS};
        rays[i].t_min = -1e-3f; /* includes a surface at the origin */
        rays[i].t_max = INFINITY;
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)origin[axis];
            rays[i].direction[axis] = components[picks[axis]];
        }
    }
    trace_rays(opened, tree, rays, DIRECTIONS, SVO_TRACE_CLOSEST, hits);
    for (uint32_t i = 0; i < DIRECTIONS; ++i) {
        const float *along = rays[i].direction;
        if (along[0] == 0.0f && along[1] == 0.0f && along[2] == 0.0f) {
            assert_int_equal(hits[i].triangle, SVO_NO_TRIANGLE);
        } else if (fabsf(along[0]) >= 0x1p-24f || fabsf(along[1]) >= 0x1p-24f || fabsf(along[2]) >= 0x1p-24f) {
            assert_is_closest(what, tree, &rays[i], &hits[i]);
        }
        assert_in_range(hits[i].count, 0, 3u * (1u << tree->info.depth) + 1);
    }
}

/* Origins at 0 and 1 lie on the mesh's bounds, but for rounding. */
static double largest_extent(const svo_mesh *mesh)
{
    double extent = 0;
    for (int axis = 0; axis < 3; ++axis) {
        double low = INFINITY;
        double high = -INFINITY;
        for (size_t v = 0; v < mesh->vertex_count; ++v) {
            const size_t i = v * 3 + (size_t)axis;
            const double x = mesh->positions != NULL ? (double)mesh->positions[i] : mesh->positions_double[i];
            low = fmin(low, x);
            high = fmax(high, x);
        }
        extent = fmax(extent, high - low);
    }
    return extent;
}

static void check_origins(const fixture *opened, const char *name, const svo_mesh *mesh, unsigned depth)
{
    static const double places[][3] = {
        {0.5, 0.5, 0.5},   {0.3125, 0.25, 0.75}, {0, 0.5, 0.5}, {0, 0, 0.5},  {0, 0, 0},           {1, 1, 1},
        {-0.25, 0.5, 0.5}, {1.5, 1.25, -0.5},    {0.5, 0.5, 5}, {-40, 17, 3}, {0.1, 0.7, 0.30001}, {0.5, 0, 0.5}};
    const double extent = largest_extent(mesh);
    built tree;
    build_for_rays(opened, mesh, depth, NULL, 0, &tree);
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        double origin[3];
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = tree.info.origin[axis] + extent * places[i][axis];
        }
        check_directions(opened, name, &tree, origin);
    }
    built_destroy(&tree);
}

static void t12_every_direction_from_every_origin(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static const char *const names[] = {"cube", "knot:600", "needles:200"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        scene *made = make_scene(names[i]);
        check_origins(opened, names[i], scene_mesh(made), 5);
        scene_destroy(&made);
    }
    owned_mesh owned;
    random_mesh(20240312, 300, 0, &owned);
    check_origins(opened, "random triangles", &owned.mesh, 8);
    owned_mesh_free(&owned);
}

/* A ray that some cell traversals are known to miss. */
static void t12_a_long_ray_between_cells_of_16(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const double corner[3] = {-1024, -1024, -1024};
    owned_mesh owned;
    built tree;
    uint64_t random = 5;
    random_dust(77, 4000, corner, 2048, &owned);
    for (size_t i = 0; i < 4000 * 9; ++i) {
        owned.positions[i] += (random_unit(&random) - 0.5) * 200;
    }
    build_for_rays(opened, &owned.mesh, 7, corner, 2048, &tree); /* 128 cells of 16 */
    for (int turn = 0; turn < 64; ++turn) {
        svo_ray ray = {{-668, -340, 77}, {404 + 668, -64 + 340, -784 - 77}, 0, 1};
        svo_hit hit;
        ray.origin[turn % 3] += (float)turn / 8;
        trace_rays(opened, &tree, &ray, 1, SVO_TRACE_CLOSEST, &hit);
        assert_is_closest("cells of 16", &tree, &ray, &hit);
        assert_in_range(hit.count, 1, 3 * 128 + 1);
    }
    built_destroy(&tree);
    owned_mesh_free(&owned);
}

static void t12_random_rays(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 3000 };
    static svo_ray rays[RAYS];
    static svo_hit hits[RAYS];
    const uint64_t seed = 20240310;
    uint64_t random = seed;
    scene *made = make_scene("statue:4000");
    built tree;
    print_message("seed %llu\n", (unsigned long long)seed);
    build_for_rays(opened, scene_mesh(made), 6, NULL, 0, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = random_ray(&random, i % 2 == 0 ? 4.0 : 1.0);
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)(tree.info.origin[axis] + tree.info.edge * (double)rays[i].origin[axis]);
        }
    }
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, hits);
    for (size_t i = 0; i < RAYS; ++i) {
        assert_is_closest("random", &tree, &rays[i], &hits[i]);
    }
    built_destroy(&tree);
    scene_destroy(&made);
}

/* Aimed at the middle of edges from ten thousand scene widths away, where a cell traversal in floats once hit the
   surface behind. */
static void t12_rays_from_far_away_at_edges(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 3000 };
    static svo_ray rays[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 1000;
    scene *made = make_scene("knot:4000");
    const svo_mesh *mesh = scene_mesh(made);
    built tree;
    build_for_rays(opened, mesh, 7, NULL, 0, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        const uint32_t *corners = mesh->indices + (size_t)random_below(&random, (uint32_t)mesh->triangle_count) * 3;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = (double)mesh->positions[(size_t)corners[i % 3] * 3 + (size_t)axis];
            const double b = (double)mesh->positions[(size_t)corners[(i + 1) % 3] * 3 + (size_t)axis];
            const double offset = (random_unit(&random) - 0.5) * 2e4 * tree.info.edge;
            rays[i].origin[axis] = (float)((a + b) / 2 - offset);
            rays[i].direction[axis] = (float)(((a + b) / 2 - (double)rays[i].origin[axis]) * 8);
        }
        rays[i].t_min = 0;
        rays[i].t_max = 1;
    }
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, hits);
    for (size_t i = 0; i < RAYS; ++i) {
        assert_is_closest("far away", &tree, &rays[i], &hits[i]);
    }
    built_destroy(&tree);
    scene_destroy(&made);
}

/* ---- T13: invalid rays ---- */

static void t13_bad_rays_meet_nothing_and_cost_nothing(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 4096 };
    static svo_ray rays[RAYS];
    static svo_hit good[RAYS];
    static svo_hit mixed[RAYS];
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    uint64_t random = 13;
    scene *made = make_scene("knot:2000");
    built tree;
    uint64_t good_leaves = 0;
    uint64_t mixed_leaves = 0;
    build_for_rays(opened, scene_mesh(made), 6, NULL, 0, &tree);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = random_ray(&random, 2.0);
    }
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, good);
    for (size_t i = 0; i < RAYS; i += 2) {
        float *const fields[] = {&rays[i].origin[0],    &rays[i].origin[1],    &rays[i].origin[2],
                                 &rays[i].direction[0], &rays[i].direction[1], &rays[i].direction[2],
                                 &rays[i].t_min,        &rays[i].t_max};
        *fields[i / 2 % 8] = i / 2 % 8 == 7 ? NAN : bad[i / 16 % 3];
    }
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, mixed);
    for (size_t i = 0; i < RAYS; ++i) {
        if (i % 2 == 0) {
            assert_int_equal(mixed[i].triangle, SVO_NO_TRIANGLE);
            assert_true(isinf(mixed[i].t));
        } else {
            assert_memory_equal(&mixed[i], &good[i], sizeof good[i]);
        }
        good_leaves += good[i].count;
        mixed_leaves += mixed[i].count;
    }
    assert_true((double)mixed_leaves <= 2.5 * (double)good_leaves);
    built_destroy(&tree);
    scene_destroy(&made);
}

TEST_GROUP(numerics_rays)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t11_closed_surfaces_have_no_gaps),
        cmocka_unit_test(t12_every_direction_from_every_origin),
        cmocka_unit_test(t12_a_long_ray_between_cells_of_16),
        cmocka_unit_test(t12_random_rays),
        cmocka_unit_test(t12_rays_from_far_away_at_edges),
        cmocka_unit_test(t13_bad_rays_meet_nothing_and_cost_nothing),
    };
    return cmocka_run_group_tests_name("numerics_rays", tests, fixture_group_setup, fixture_group_teardown);
}
