/* SPDX-License-Identifier: MIT */
/*
 * Rays against the triangles of a tree, beside a reference that tries every triangle in long double: closed surfaces have
 * no gaps (T11), no direction or origin loses a hit (T12), bad rays meet nothing and cost nothing (T13); any hit, counts,
 * trees of every depth, and the ways to call it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fixture.h"
#include "meshes.h"
#include "oracle_rays.h"
#include "scenes.h"

/* ---- trees, rays, answers ---- */

static oracle_ray_scene scene_of(const built *tree)
{
    return (oracle_ray_scene){.vertices = tree->arrays.vertices,
                              .indices = tree->arrays.indices,
                              .triangle_count = (size_t)tree->info.list_triangle_count,
                              .origin = {tree->info.origin[0], tree->info.origin[1], tree->info.origin[2]},
                              .scale = tree->info.scale};
}

static void build_for_rays(const fixture *opened, const svo_mesh *mesh, unsigned depth, const double origin[3],
                           double edge, built *out)
{
    svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = edge};
    for (int axis = 0; axis < 3 && edge > 0; ++axis) {
        options.origin[axis] = origin[axis];
    }
    fixture_build(opened, mesh, depth, &options, out);
}

static void trace(const fixture *opened, const built *tree, const svo_ray *rays, size_t ray_count, uint32_t flags,
                  svo_hit *hits)
{
    memset(hits, 0x5a, ray_count * sizeof *hits);
    if (svo_tree_trace(tree->tree, rays, hits, ray_count, flags, opened->queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
}

static oracle_ray widen(const svo_ray *ray)
{
    oracle_ray wide = {.t_min = (double)ray->t_min, .t_max = (double)ray->t_max};
    for (int axis = 0; axis < 3; ++axis) {
        wide.origin[axis] = (double)ray->origin[axis];
        wide.direction[axis] = (double)ray->direction[axis];
    }
    return wide;
}

/* Two ts that are the same up to the rounding of a float, or a thousandth of a grid unit. */
static bool is_tied(const oracle_ray_scene *mesh, const svo_ray *ray, double a, double b)
{
    double length = 0;
    for (int axis = 0; axis < 3; ++axis) {
        length = fmax(length, fabs((double)ray->direction[axis]));
    }
    return fabs(a - b) <= 0x1p-22 * fmax(fabs(a), fabs(b)) + 1e-3 / (mesh->scale * length);
}

static bool is_closest(const built *tree, const svo_ray *ray, const svo_hit *hit, oracle_ray_hit *exact)
{
    const oracle_ray_scene mesh = scene_of(tree);
    const oracle_ray wide = widen(ray);
    *exact = oracle_ray_closest(&mesh, &wide);
    if (!exact->hit || hit->triangle == SVO_NO_TRIANGLE) {
        return !exact->hit && hit->triangle == SVO_NO_TRIANGLE;
    }
    return is_tied(&mesh, ray, (double)hit->t, exact->t);
}

/* The same triangle as the reference, or another with the same t. In long double a denormal component cannot be told from
   zero; beside the edge of a triangle the answer of a ray that leans to the same side a little more will do. */
static void check_closest(const char *what, const built *tree, const svo_ray *ray, const svo_hit *hit)
{
    oracle_ray_hit exact;
    oracle_ray_hit other;
    svo_ray leaning = *ray;
    for (int axis = 0; axis < 3; ++axis) {
        const float component = ray->direction[axis];
        const bool denormal = component != 0.0f && fabsf(component) < 0x1p-126f;
        leaning.direction[axis] = denormal ? copysignf(0x1p-40f, component) : component;
    }
    if (!is_closest(tree, ray, hit, &exact) && !is_closest(tree, &leaning, hit, &other)) {
        fail_msg("%s: from %a %a %a along %a %a %a: triangle %d at %.9g, the reference has %d at %.9g", what,
                 (double)ray->origin[0], (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0],
                 (double)ray->direction[1], (double)ray->direction[2], (int)hit->triangle, (double)hit->t,
                 exact.hit ? (int)tree->arrays.triangle_ids[exact.triangle] : -1, exact.t);
    }
}

static svo_ray random_ray(uint64_t *random, double spread)
{
    svo_ray ray = {.t_min = 0, .t_max = INFINITY};
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = (float)(0.5 + (random_unit(random) - 0.5) * spread);
        ray.direction[axis] = (float)(random_unit(random) - (double)ray.origin[axis]);
    }
    return ray;
}

static scene *make_scene(const char *name)
{
    scene *made = NULL;
    svo_message message = {""};
    if (scene_create(name, &made, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

/* ---- T11: watertight ---- */

enum { RINGS = 48, SIDES = 96, BALL_VERTICES = 2 + (RINGS - 1) * SIDES, BALL_TRIANGLES = 2 * SIDES * (RINGS - 1) };

/* A closed ball whose corners are whole numbers of steps from its centre. */
typedef struct ball {
    int32_t corners[BALL_VERTICES][3]; /* in steps, from the centre */
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

/* From a lattice point inside the ball; exact in float, so a ray aimed at a corner or an edge meets it exactly. */
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
    assert_true(tree.info.snap_error == 0);
    for (aim kind = AIM_ANYWHERE; kind < AIM_COUNT; ++kind) {
        for (size_t i = 0; i < BATCH; ++i) {
            rays[i] = ball_ray(target, center, step, radius_steps, kind, &random);
        }
        trace(opened, &tree, rays, BATCH, SVO_TRACE_CLOSEST, hits);
        for (size_t i = 0; i < BATCH; ++i) {
            if (hits[i].triangle == SVO_NO_TRIANGLE) {
                fail_msg("ball at %g, aim %d, ray %zu slips through", center[0], (int)kind, i);
            }
            if (i % 5003 == 0) {
                check_closest("ball", &tree, &rays[i], &hits[i]);
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

/* All directions of these components from one origin. */
static void check_directions(const fixture *opened, const char *what, const built *tree, const double origin[3])
{
    static svo_ray rays[DIRECTIONS];
    static svo_hit hits[DIRECTIONS];
    for (uint32_t i = 0; i < DIRECTIONS; ++i) {
        const uint32_t picks[3] = {i % COMPONENTS, i / COMPONENTS % COMPONENTS, i / COMPONENTS / COMPONENTS};
        rays[i].t_min = -1e-3f; /* what the origin lies on is met for certain */
        rays[i].t_max = INFINITY;
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)origin[axis];
            rays[i].direction[axis] = components[picks[axis]];
        }
    }
    trace(opened, tree, rays, DIRECTIONS, SVO_TRACE_CLOSEST, hits);
    for (uint32_t i = 0; i < DIRECTIONS; ++i) {
        const float *along = rays[i].direction;
        if (along[0] == 0.0f && along[1] == 0.0f && along[2] == 0.0f) {
            assert_int_equal(hits[i].triangle, SVO_NO_TRIANGLE);
        } else if (fabsf(along[0]) >= 0x1p-24f || fabsf(along[1]) >= 0x1p-24f || fabsf(along[2]) >= 0x1p-24f) {
            check_closest(what, tree, &rays[i], &hits[i]);
        }
        assert_in_range(hits[i].count, 0, 3u * (1u << tree->info.depth) + 1);
    }
}

static void check_origins(const fixture *opened, const char *name, const svo_mesh *mesh, unsigned depth)
{
    static const double places[][3] = {
        {0.5, 0.5, 0.5},   {0.3125, 0.25, 0.75}, {0, 0.5, 0.5}, {0, 0, 0.5},  {0, 0, 0},           {1, 1, 1},
        {-0.25, 0.5, 0.5}, {1.5, 1.25, -0.5},    {0.5, 0.5, 5}, {-40, 17, 3}, {0.1, 0.7, 0.30001}, {0.5, 0, 0.5}};
    built tree;
    build_for_rays(opened, mesh, depth, NULL, 0, &tree);
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        double origin[3];
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = tree.info.origin[axis] + tree.info.edge * places[i][axis];
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

/* A ray that is known to slip past the cells of careless walks. */
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
        trace(opened, &tree, &ray, 1, SVO_TRACE_CLOSEST, &hit);
        check_closest("cells of 16", &tree, &ray, &hit);
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
    trace(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, hits);
    for (size_t i = 0; i < RAYS; ++i) {
        check_closest("random", &tree, &rays[i], &hits[i]);
    }
    built_destroy(&tree);
    scene_destroy(&made);
}

/* ---- T13: bad rays ---- */

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
    trace(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, good);
    for (size_t i = 0; i < RAYS; i += 2) {
        float *const fields[] = {&rays[i].origin[0],    &rays[i].origin[1],    &rays[i].origin[2],
                                 &rays[i].direction[0], &rays[i].direction[1], &rays[i].direction[2],
                                 &rays[i].t_min,        &rays[i].t_max};
        *fields[i / 2 % 8] = i / 2 % 8 == 7 ? NAN : bad[i / 16 % 3];
        rays[i].t_min = i / 2 % 8 == 6 && !isnan(rays[i].t_min) ? NAN : rays[i].t_min;
    }
    trace(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, mixed);
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

/* ---- any hit, counts, depths ---- */

static void any_hit_and_count_agree_with_the_reference(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 2000 };
    static svo_ray rays[RAYS];
    static svo_hit closest[RAYS];
    static svo_hit any[RAYS];
    static svo_hit count[RAYS];
    uint64_t random = 99;
    owned_mesh owned;
    built tree;
    random_mesh(4, 500, 0, &owned);
    build_for_rays(opened, &owned.mesh, 6, NULL, 0, &tree);
    const oracle_ray_scene mesh = scene_of(&tree);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = random_ray(&random, 3.0);
    }
    trace(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, closest);
    trace(opened, &tree, rays, RAYS, SVO_TRACE_ANY, any);
    trace(opened, &tree, rays, RAYS, SVO_TRACE_COUNT, count);
    for (size_t i = 0; i < RAYS; ++i) {
        const oracle_ray wide = widen(&rays[i]);
        assert_int_equal(any[i].triangle == SVO_NO_TRIANGLE, closest[i].triangle == SVO_NO_TRIANGLE);
        assert_int_equal(count[i].triangle, closest[i].triangle);
        assert_int_equal(count[i].count, oracle_ray_count(&mesh, &wide));
        double t = 0;
        if (any[i].triangle != SVO_NO_TRIANGLE) {
            assert_true(oracle_ray_meets(&mesh, any[i].triangle, &wide, &t)); /* none refused: ids are positions */
            assert_true(is_tied(&mesh, &rays[i], (double)any[i].t, t));
        }
    }
    built_destroy(&tree);
    owned_mesh_free(&owned);
}

/* Everything but the leaves looked into. */
static void assert_same_hits(const svo_hit *a, const svo_hit *b, size_t count, unsigned depth)
{
    for (size_t i = 0; i < count; ++i) {
        if (memcmp(&a[i], &b[i], offsetof(svo_hit, count)) != 0) {
            fail_msg("depth %u, ray %zu: triangle %d at %.9g instead of %d at %.9g", depth, i, (int)a[i].triangle,
                     (double)a[i].t, (int)b[i].triangle, (double)b[i].t);
        }
    }
}

static void hits_do_not_depend_on_the_depth(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 4000 };
    static svo_ray rays[RAYS];
    static svo_hit first[RAYS];
    static svo_hit hits[RAYS];
    uint64_t random = 2;
    scene *made = make_scene("knot:3000");
    for (unsigned depth = 1; depth <= 11; ++depth) {
        built tree;
        build_for_rays(opened, scene_mesh(made), depth, NULL, 0, &tree);
        for (size_t i = 0; i < RAYS && depth == 1; ++i) {
            rays[i] = random_ray(&random, 3.0);
            for (int axis = 0; axis < 3; ++axis) {
                rays[i].origin[axis] = (float)(tree.info.origin[axis] + tree.info.edge * (double)rays[i].origin[axis]);
            }
        }
        trace(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, depth == 1 ? first : hits);
        assert_same_hits(depth == 1 ? first : hits, first, RAYS, depth);
        built_destroy(&tree);
    }
    scene_destroy(&made);
}

/* u, v and the normal of one known triangle. */
static void a_hit_says_where_on_the_triangle(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static const float corners[9] = {0, 0, 0, 4, 0, 0, 0, 4, 0};
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = corners, .vertex_count = 3, .triangle_count = 1};
    const double origin[3] = {-4, -4, -4};
    const svo_ray ray = {{1, 2, 3}, {0, 0, -0.5f}, 0, 100};
    svo_hit hit;
    built tree;
    build_for_rays(opened, &mesh, 3, origin, 16, &tree);
    trace(opened, &tree, &ray, 1, SVO_TRACE_CLOSEST, &hit);
    assert_int_equal(hit.triangle, 0);
    assert_true(hit.t == 6.0f && hit.u == 0.25f && hit.v == 0.5f);
    assert_true(hit.normal[0] == 0.0f && hit.normal[1] == 0.0f && hit.normal[2] == 1.0f);
    built_destroy(&tree);
}

static void an_empty_tree_is_never_met(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const svo_mesh nothing = {.struct_size = sizeof nothing};
    const svo_ray ray = {{0.5f, 0.5f, -1}, {0, 0, 1}, 0, INFINITY};
    for (unsigned depth = 1; depth <= 4; ++depth) {
        svo_hit hit;
        built tree;
        build_for_rays(opened, &nothing, depth, NULL, 0, &tree);
        trace(opened, &tree, &ray, 1, SVO_TRACE_CLOSEST, &hit);
        assert_int_equal(hit.triangle, SVO_NO_TRIANGLE);
        built_destroy(&tree);
    }
}

/* ---- nearest triangles ---- */

static void check_nearest(const fixture *opened, const svo_mesh *mesh, unsigned depth, uint64_t seed)
{
    enum { POINTS = 1500 };
    static svo_query_point points[POINTS];
    static svo_nearest results[POINTS];
    uint64_t random = seed;
    built tree;
    build_for_rays(opened, mesh, depth, NULL, 0, &tree);
    const oracle_ray_scene snapped = scene_of(&tree);
    for (size_t i = 0; i < POINTS; ++i) {
        const double spread = i % 3 == 0 ? 1.0 : i % 3 == 1 ? 2.0 : 30.0;
        for (int axis = 0; axis < 3; ++axis) {
            points[i].position[axis] =
                (float)(tree.info.origin[axis] + tree.info.edge * (0.5 + spread * (random_unit(&random) - 0.5)));
        }
        points[i].farthest = i % 5 == 0 ? (float)(tree.info.edge * 0.05) : INFINITY;
    }
    assert_int_equal(svo_tree_nearest(tree.tree, points, results, POINTS, opened->queue), SVO_OK);
    for (size_t i = 0; i < POINTS; ++i) {
        const double at[3] = {(double)points[i].position[0], (double)points[i].position[1],
                              (double)points[i].position[2]};
        size_t triangle = 0;
        const double distance = oracle_nearest(&snapped, at, &triangle);
        const double slack = distance * 0x1p-22 + 1e-3 / snapped.scale;
        if (results[i].triangle == SVO_NO_TRIANGLE) {
            assert_true(distance >= (double)points[i].farthest - slack);
            continue;
        }
        const uint32_t met = results[i].triangle; /* none refused: ids are positions */
        if (fabs((double)results[i].distance - distance) > slack ||
            oracle_triangle_distance(&snapped, met, at) > distance + slack) {
            fail_msg("depth %u, point %zu: triangle %u at %.9g, the reference has %zu at %.9g", depth, i, met,
                     (double)results[i].distance, triangle, distance);
        }
        double moved = 0;
        for (int axis = 0; axis < 3; ++axis) {
            moved += ((double)results[i].position[axis] - at[axis]) * ((double)results[i].position[axis] - at[axis]);
        }
        assert_true(fabs(sqrt(moved) - distance) <= tree.info.edge * 1e-5);
    }
    built_destroy(&tree);
}

static void the_nearest_triangle_is_the_nearest(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = make_scene("knot:1500");
    owned_mesh owned;
    random_mesh(31, 300, 0, &owned);
    for (unsigned depth = 1; depth <= 7; depth += 2) {
        check_nearest(opened, &owned.mesh, depth, depth);
    }
    check_nearest(opened, scene_mesh(made), 6, 6);
    owned_mesh_free(&owned);
    scene_destroy(&made);
}

/* ---- a kernel of one's own ---- */

static const char voxel_kernel[] =
    "__kernel void find(SVO_TREE_PARAMETERS, __global const svo_ray *rays, __global svo_voxel_hit *hits)\n"
    "{\n"
    "    SVO_TREE_MAKE(tree);\n"
    "    const svo_ray ray = rays[get_global_id(0)];\n"
    "    svo_voxel_hit hit;\n"
    "    svo_trace_voxel(&tree, &ray, 0.0f, &hit);\n"
    "    hits[get_global_id(0)] = hit;\n"
    "}\n";

static cl_kernel make_voxel_kernel(const fixture *opened)
{
    const char *sources[2] = {svo_tree_kernel_source(), voxel_kernel};
    const cl_device_id device = svo_device_cl_device(opened->device);
    cl_int error = CL_SUCCESS;
    cl_program program = clCreateProgramWithSource(svo_device_cl_context(opened->device), 2, sources, NULL, &error);
    assert_int_equal(clBuildProgram(program, 1, &device, svo_tree_kernel_options(), NULL, NULL), CL_SUCCESS);
    cl_kernel kernel = clCreateKernel(program, "find", &error);
    assert_int_equal(error, CL_SUCCESS);
    clReleaseProgram(program);
    return kernel;
}

static void run_voxel_kernel(const fixture *opened, const built *tree, const svo_ray *rays, svo_voxel_hit *hits,
                             size_t count)
{
    cl_context context = svo_device_cl_context(opened->device);
    cl_kernel kernel = make_voxel_kernel(opened);
    const size_t local = 50;
    cl_mem from = clCreateBuffer(context, CL_MEM_READ_WRITE, count * sizeof *rays, NULL, NULL);
    cl_mem to = clCreateBuffer(context, CL_MEM_READ_WRITE, count * sizeof *hits, NULL, NULL);
    assert_int_equal(svo_tree_set_args(tree->tree, kernel, 0), SVO_OK);
    clSetKernelArg(kernel, SVO_TREE_ARGUMENTS, sizeof from, (const void *)&from);
    clSetKernelArg(kernel, SVO_TREE_ARGUMENTS + 1, sizeof to, (const void *)&to);
    clEnqueueWriteBuffer(opened->queue, from, CL_TRUE, 0, count * sizeof *rays, rays, 0, NULL, NULL);
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &count, &local, 0, NULL, NULL), CL_SUCCESS);
    clEnqueueReadBuffer(opened->queue, to, CL_TRUE, 0, count * sizeof *hits, hits, 0, NULL, NULL);
    clReleaseMemObject(from);
    clReleaseMemObject(to);
    clReleaseKernel(kernel);
}

/* The tree need not hold lists. Voxels come before the triangles in them, by at most their diagonal. */
static void voxels_are_met_just_before_their_triangles(void **state)
{
    const fixture *opened = fixture_of_group(state);
    enum { RAYS = 1000 };
    static svo_ray rays[RAYS];
    static svo_hit triangles[RAYS];
    static svo_voxel_hit voxels[RAYS];
    uint64_t random = 8;
    scene *made = make_scene("knot:3000");
    built tree;
    built plain;
    size_t met = 0;
    build_for_rays(opened, scene_mesh(made), 6, NULL, 0, &tree);
    fixture_build(opened, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_NONE}, &plain);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = random_ray(&random, 1.0);
        for (int axis = 0; axis < 3; ++axis) {
            const double side = axis == (int)(i % 3) ? 2.0 : (double)rays[i].origin[axis];
            const double towards = tree.info.origin[axis] + tree.info.edge * random_unit(&random);
            rays[i].origin[axis] = (float)(tree.info.origin[axis] + tree.info.edge * side);
            rays[i].direction[axis] = (float)(towards - (double)rays[i].origin[axis]);
        }
    }
    trace(opened, &tree, rays, RAYS, SVO_TRACE_CLOSEST, triangles);
    run_voxel_kernel(opened, &plain, rays, voxels, RAYS);
    for (size_t i = 0; i < RAYS; ++i) {
        if (triangles[i].triangle != SVO_NO_TRIANGLE) {
            ++met;
            assert_int_not_equal(voxels[i].node, SVO_NO_NODE);
            assert_true(voxels[i].t <= triangles[i].t * 1.0001f);
        }
        if (voxels[i].node != SVO_NO_NODE) {
            assert_int_equal(voxels[i].level, 6);
            assert_in_range(voxels[i].node, plain.info.inner_count, plain.info.node_count - 1);
            assert_in_range(voxels[i].face, 0, 5);
            const int axis = (int)voxels[i].face / 2;
            assert_true(voxels[i].normal[axis] == (voxels[i].face % 2 == 0 ? -1.0f : 1.0f));
            assert_true(voxels[i].normal[axis] * rays[i].direction[axis] < 0.0f);
        }
    }
    assert_true(met > RAYS / 20);
    built_destroy(&plain);
    built_destroy(&tree);
    scene_destroy(&made);
}

/* ---- calls ---- */

static void refuses_what_it_cannot_do(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = make_scene("cube");
    const svo_ray ray = {{0.5f, 0.5f, -1}, {0, 0, 1}, 0, INFINITY};
    svo_hit hit;
    built plain;
    built tree;
    fixture_build(opened, scene_mesh(made), 3, &(svo_plan_options){.need = SVO_NEED_NONE}, &plain);
    build_for_rays(opened, scene_mesh(made), 3, NULL, 0, &tree);
    assert_int_equal(svo_tree_trace(plain.tree, &ray, &hit, 1, 0, opened->queue), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "SVO_NEED_RAYS"));
    assert_int_equal(svo_tree_trace(tree.tree, NULL, &hit, 1, 0, opened->queue), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_trace(tree.tree, &ray, NULL, 1, 0, opened->queue), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_trace(tree.tree, &ray, &hit, 1, 0, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_trace(tree.tree, &ray, &hit, 1, 7, opened->queue), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_trace(NULL, &ray, &hit, 1, 0, opened->queue), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_trace(tree.tree, &ray, &hit, 0, 0, opened->queue), SVO_OK);
    built_destroy(&tree);
    built_destroy(&plain);
    scene_destroy(&made);
}

/* On a queue that may run commands in any order, events alone say what comes first. */
static void events_order_an_out_of_order_queue(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = make_scene("cube");
    built tree;
    build_for_rays(opened, scene_mesh(made), 4, NULL, 0, &tree);
    cl_int error = CL_SUCCESS;
    cl_context context = svo_device_cl_context(opened->device);
    cl_command_queue queue = clCreateCommandQueue(context, svo_device_cl_device(opened->device),
                                                  CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
    if (error != CL_SUCCESS) {
        queue = clCreateCommandQueue(context, svo_device_cl_device(opened->device), 0, &error);
    }
    const svo_ray ray = {{(float)(tree.info.origin[0] + tree.info.edge * 0.3),
                          (float)(tree.info.origin[1] + tree.info.edge * 0.4), (float)(tree.info.origin[2] - 1)},
                         {0, 0, 1},
                         0,
                         INFINITY};
    svo_hit hit = {.triangle = SVO_NO_TRIANGLE};
    cl_mem rays = clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof ray, NULL, &error);
    cl_mem hits = clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof hit, NULL, &error);
    cl_event events[2] = {NULL, NULL};
    assert_int_equal(clEnqueueWriteBuffer(queue, rays, CL_FALSE, 0, sizeof ray, &ray, 0, NULL, &events[0]), CL_SUCCESS);
    assert_int_equal(svo_tree_trace_enqueue(tree.tree, rays, hits, 1, 0, queue, 1, &events[0], &events[1]), SVO_OK);
    assert_int_equal(clEnqueueReadBuffer(queue, hits, CL_TRUE, 0, sizeof hit, &hit, 1, &events[1], NULL), CL_SUCCESS);
    assert_int_not_equal(hit.triangle, SVO_NO_TRIANGLE);
    assert_true(fabsf(hit.t - 1.0f) < 1e-4f);
    assert_int_equal(svo_tree_trace_enqueue(tree.tree, rays, hits, 2, 0, queue, 0, NULL, NULL), SVO_INVALID_ARGUMENT);
    for (int i = 0; i < 2; ++i) {
        clReleaseEvent(events[i]);
    }
    clReleaseMemObject(rays);
    clReleaseMemObject(hits);
    clReleaseCommandQueue(queue);
    built_destroy(&tree);
    scene_destroy(&made);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hit_says_where_on_the_triangle),
        cmocka_unit_test(an_empty_tree_is_never_met),
        cmocka_unit_test(t11_closed_surfaces_have_no_gaps),
        cmocka_unit_test(t12_every_direction_from_every_origin),
        cmocka_unit_test(t12_a_long_ray_between_cells_of_16),
        cmocka_unit_test(t12_random_rays),
        cmocka_unit_test(t13_bad_rays_meet_nothing_and_cost_nothing),
        cmocka_unit_test(any_hit_and_count_agree_with_the_reference),
        cmocka_unit_test(hits_do_not_depend_on_the_depth),
        cmocka_unit_test(the_nearest_triangle_is_the_nearest),
        cmocka_unit_test(voxels_are_met_just_before_their_triangles),
        cmocka_unit_test(refuses_what_it_cannot_do),
        cmocka_unit_test(events_order_an_out_of_order_queue),
    };
    return cmocka_run_group_tests(tests, fixture_group_setup, fixture_group_teardown);
}
