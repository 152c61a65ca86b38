/* SPDX-License-Identifier: MIT */
/*
 * Rays through scenes that move: whatever has moved, hidden, gone or come, hits are those of a BVH of the whole mesh,
 * bit for bit; only what changed is refit or made; what is refused says why; memory is flat.
 */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "attributed_mesh.h"
#include "enqueued.h"
#include "fixture.h"
#include "memory_ledger.h"

enum { OBJECTS = 12, RAYS = 1500, POINTS = 100 };

/* ---- scenes ---- */

/* A static mesh around the unit cube and objects, in floats or doubles. */
typedef struct stage {
    attributed_mesh meshes[OBJECTS + 1];
    float *floats[OBJECTS + 1];
    svo_mesh views[OBJECTS + 1]; /* the static mesh, then the objects; positions and triangles alone */
    svo_moving_options options;
    svo_moving *moving;
    bool is_there[OBJECTS], is_visible[OBJECTS];
} stage;

static void make_mesh(stage *s, int index, uint64_t seed, size_t triangles, bool in_floats)
{
    attributed_mesh *made = &s->meshes[index];
    attributed_mesh_create(seed, triangles, index == 0 ? 0.1 : 0.0, made);
    s->views[index] = made->mesh;
    s->views[index].normals = NULL;
    s->views[index].colors = NULL;
    s->views[index].uvs = NULL;
    s->views[index].triangle_materials = NULL;
    if (!in_floats) {
        return;
    }
    const size_t count = made->mesh.vertex_count * 3;
    s->floats[index] = malloc(count * sizeof *s->floats[index]);
    assert_non_null(s->floats[index]);
    for (size_t i = 0; i < count; ++i) {
        s->floats[index][i] = (float)made->base.positions[i];
    }
    s->views[index].positions = s->floats[index];
    s->views[index].positions_double = NULL;
}

/* A random turn, stretch and shift. Inside a grid of edge 6 around the unit cube; not always inside one of edge 1. */
static void random_transform(uint64_t *seed, double out[12])
{
    const double angle = 6.28 * random_unit(seed);
    const double size = 0.1 + 0.4 * random_unit(seed);
    const double turn[9] = {cos(angle), -sin(angle), 0, sin(angle), cos(angle), 0.3, 0.1, 0, 0.5 + random_unit(seed)};
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k) {
            out[4 * row + k] = size * turn[3 * row + k];
        }
        out[4 * row + 3] = 1.2 * random_unit(seed) - 0.2;
    }
}

static void add_object(const fixture *opened, stage *s, uint32_t object, uint64_t *seed)
{
    double transform[12];
    uint32_t number = 77;
    random_transform(seed, transform);
    succeed(opened, svo_moving_add(s->moving, &s->views[object + 1], transform, &number));
    assert_int_equal(number, object);
    s->is_there[object] = true;
    s->is_visible[object] = true;
}

static void open_stage(const fixture *opened, uint64_t seed, bool in_floats, double edge, uint32_t objects, stage *s)
{
    *s = (stage){.options = {.struct_size = sizeof s->options,
                             .need = SVO_NEED_RAYS,
                             .edge = edge,
                             .max_area = 1e3,
                             .origin = {0.5 - 0.5 * edge, 0.5 - 0.5 * edge, 0.5 - 0.5 * edge}}};
    for (int i = 0; i <= OBJECTS; ++i) {
        make_mesh(s, i, seed * 31 + (uint64_t)i, i == 0 ? 300 : 40 + 5 * (size_t)i, in_floats);
    }
    succeed(opened, svo_moving_create(opened->device, &s->views[0], 6, &s->options, opened->queue, &s->moving));
    for (uint32_t i = 0; i < objects; ++i) {
        add_object(opened, s, i, &seed);
    }
    succeed(opened, svo_moving_update(s->moving, opened->queue, NULL));
}

static void close_stage(stage *s)
{
    svo_moving_destroy(&s->moving);
    for (int i = 0; i <= OBJECTS; ++i) {
        attributed_mesh_destroy(&s->meshes[i]);
        free(s->floats[i]);
    }
}

static uint32_t count_shown(const stage *s)
{
    uint32_t count = 1;
    for (int i = 0; i < OBJECTS; ++i) {
        count += s->is_there[i] && s->is_visible[i] ? 1 : 0;
    }
    return count;
}

/* Gives an object the vertices of its mesh in another order: its triangles are torn apart. */
static void tear(const fixture *opened, stage *s, uint32_t object, uint64_t seed)
{
    const size_t count = s->views[object + 1].vertex_count;
    float *positions = malloc(count * 12);
    assert_non_null(positions);
    for (size_t i = 0; i < count * 3; ++i) {
        positions[i] = (float)random_unit(&seed);
    }
    svo_mesh torn = s->views[object + 1];
    torn.positions = positions;
    succeed(opened, svo_moving_set_vertices(s->moving, object, &torn));
    free(positions);
}

/* ---- results ---- */

static svo_tree *build_whole(const fixture *opened, const stage *s)
{
    svo_mesh mesh;
    svo_tree *tree = NULL;
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    succeed(opened, svo_moving_get_mesh(s->moving, &mesh));
    succeed(opened, svo_moving_get_info(s->moving, &info));
    svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = s->options.edge, .weight_log2 = info.weight_log2};
    memcpy(options.origin, s->options.origin, sizeof options.origin);
    svo_plan *plan = make_plan(opened, &mesh, 6, options);
    succeed(opened, svo_build(plan, opened->frontend, opened->queue, &tree, NULL));
    svo_plan_destroy(&plan);
    succeed(opened, svo_tree_make_bvh(tree, SVO_BVH_BEST, opened->queue));
    return tree;
}

static void random_rays(uint64_t seed, svo_ray rays[RAYS])
{
    for (int i = 0; i < RAYS; ++i) {
        rays[i] = (svo_ray){.t_min = 0.0F, .t_max = INFINITY};
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)(3.0 * random_unit(&seed) - 1.0);
            rays[i].direction[axis] = (float)random_unit(&seed) - rays[i].origin[axis];
        }
    }
}

/* Hits equal but for the leaves visited. Returns how many rays hit. */
static int compare_hits(const svo_hit *actual, const svo_hit *expected, bool with_count)
{
    int met = 0;
    for (int i = 0; i < RAYS; ++i) {
        const size_t bytes = with_count ? sizeof *actual : offsetof(svo_hit, count);
        if (memcmp(&actual[i], &expected[i], bytes) != 0) {
            fail_msg("ray %d: triangle %u at %a and count %u, in the whole BVH %u at %a and %u", i, actual[i].triangle,
                     (double)actual[i].t, actual[i].count, expected[i].triangle, (double)expected[i].t,
                     expected[i].count);
            return 0;
        }
        met += expected[i].triangle != SVO_NO_TRIANGLE ? 1 : 0;
    }
    return met;
}

static void compare_rays(const fixture *opened, svo_tree *tree, svo_tree *whole, uint64_t seed)
{
    svo_ray rays[RAYS];
    svo_hit actual[RAYS];
    svo_hit expected[RAYS];
    random_rays(seed, rays);
    for (uint32_t flags = SVO_TRACE_CLOSEST; flags <= SVO_TRACE_COUNT; ++flags) {
        succeed(opened, svo_tree_trace(tree, rays, actual, RAYS, flags, opened->queue));
        succeed(opened, svo_tree_trace(whole, rays, expected, RAYS, flags, opened->queue));
        if (flags != SVO_TRACE_ANY) {
            const int met = compare_hits(actual, expected, flags == SVO_TRACE_COUNT);
            assert_in_range(met, RAYS / 10, RAYS);
        }
        for (int i = 0; flags == SVO_TRACE_ANY && i < RAYS; ++i) {
            assert_int_equal(actual[i].triangle == SVO_NO_TRIANGLE, expected[i].triangle == SVO_NO_TRIANGLE);
        }
    }
}

/* For meshes that are inside the grid. */
static void compare_points(const fixture *opened, svo_tree *tree, svo_tree *whole, uint64_t seed)
{
    svo_query_point points[POINTS];
    svo_nearest actual[POINTS];
    svo_nearest expected[POINTS];
    for (int i = 0; i < POINTS; ++i) {
        points[i].max_distance = INFINITY;
        for (int axis = 0; axis < 3; ++axis) {
            points[i].position[axis] = (float)(2.0 * random_unit(&seed) - 0.5);
        }
    }
    succeed(opened, svo_tree_nearest(tree, points, actual, POINTS, opened->queue));
    succeed(opened, svo_tree_nearest(whole, points, expected, POINTS, opened->queue));
    for (int i = 0; i < POINTS; ++i) {
        assert_int_equal(actual[i].triangle, expected[i].triangle);
        assert_memory_equal(&actual[i], &expected[i], offsetof(svo_nearest, leaves));
    }
}

static svo_moving_bvh_report make_bvh(const fixture *opened, const stage *s, svo_bvh_quality quality, float cost_ratio)
{
    svo_moving_bvh_report report = SVO_MOVING_BVH_REPORT_INIT;
    succeed(opened, svo_moving_make_bvh(s->moving, quality, cost_ratio, opened->queue, &report));
    return report;
}

static void compare(const fixture *opened, const stage *s, uint64_t seed)
{
    svo_tree *whole = build_whole(opened, s);
    svo_tree *tree = svo_moving_tree(s->moving);
    const uint64_t bytes = svo_tree_ray_bytes(tree);
    compare_rays(opened, tree, whole, seed);
    if (s->options.edge > 2.0) {
        compare_points(opened, tree, whole, seed);
    }
    assert_int_equal(svo_tree_ray_bytes(tree), bytes); /* no other BVH was made */
    svo_tree_destroy(&whole);
}

/* ---- equality ---- */

/* An object moves, hides, appears, goes, comes, or gets other vertices. */
static void play(const fixture *opened, stage *s, uint64_t *seed)
{
    double transform[12];
    const uint32_t object = random_below(seed, OBJECTS);
    const uint32_t act = random_below(seed, 8);
    if (!s->is_there[object]) {
        for (uint32_t i = 0; i <= object; ++i) { /* the least number that is free */
            if (!s->is_there[i]) {
                add_object(opened, s, i, seed);
                return;
            }
        }
    } else if (act == 0) {
        s->is_visible[object] = !s->is_visible[object];
        succeed(opened, svo_moving_show(s->moving, object, s->is_visible[object]));
    } else if (act == 1) {
        succeed(opened, svo_moving_remove(s->moving, object));
        s->is_there[object] = false;
    } else if (act == 2) {
        succeed(opened, svo_moving_set_vertices(s->moving, object, &s->views[object + 1]));
    } else if (act == 3 && s->floats[0] != NULL) {
        tear(opened, s, object, *seed);
    } else {
        random_transform(seed, transform);
        succeed(opened, svo_moving_set_transform(s->moving, object, transform));
    }
}

static void compare_moves(const fixture *opened, uint64_t seed, int moves, bool in_floats, double edge)
{
    static const float ratios[] = {0.0F, 0.5F, FLT_MAX};
    stage s;
    open_stage(opened, seed, in_floats, edge, OBJECTS / 2, &s);
    print_message("seed %llu\n", (unsigned long long)seed);
    for (int i = 0; i < moves; ++i) {
        const uint32_t shown = count_shown(&s);
        const svo_bvh_quality quality = i % 4 == 1 ? SVO_BVH_FAST : SVO_BVH_BEST;
        const svo_moving_bvh_report report = make_bvh(opened, &s, quality, ratios[i % 3]);
        assert_int_equal(report.kept + report.refit + report.made, shown);
        compare(opened, &s, seed);
        for (uint32_t k = random_below(&seed, 4) + 1; k > 0; --k) {
            play(opened, &s, &seed);
        }
        succeed(opened, svo_moving_update(s.moving, opened->queue, NULL));
    }
    close_stage(&s);
}

static void hits_are_those_of_the_whole_bvh(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    compare_moves(&opened, 1, 15, true, 6.0);
}

/* Objects reach outside the grid, leave it and come back; so does the static mesh. */
static void hits_are_the_same_at_the_grids_faces(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    compare_moves(&opened, 2, 12, true, 1.0);
}

static void hits_are_the_same_in_doubles(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    compare_moves(&opened, 3, 6, false, 6.0);
    compare_moves(&opened, 4, 6, false, 1.0);
}

/* Several levels of common nodes; objects that lie in one place. */
static void many_objects_can_be_traced(void **state)
{
    enum { MANY = 150 };
    const fixture opened = fixture_cl_of_group(state);
    uint64_t seed = 5;
    stage s;
    open_stage(&opened, seed, true, 6.0, 0, &s);
    for (uint32_t i = 0; i < MANY; ++i) {
        double transform[12];
        uint32_t object = 0;
        svo_mesh one = s.views[1];
        one.triangle_count = 2;
        random_transform(&seed, transform);
        succeed(&opened, svo_moving_add(s.moving, &one, i < MANY / 2 ? transform : NULL, &object));
    }
    succeed(&opened, svo_moving_update(s.moving, opened.queue, NULL));
    assert_int_equal(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F).made, MANY + 1);
    compare(&opened, &s, seed);
    close_stage(&s);
}

/* ---- what is done ---- */

static void assert_report(svo_moving_bvh_report report, uint32_t kept, uint32_t refit, uint32_t made)
{
    assert_int_equal(report.kept, kept);
    assert_int_equal(report.refit, refit);
    assert_int_equal(report.made, made);
}

/* Nothing is made that can be kept or refit. */
static void only_what_changed_is_refit_or_made(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double moved[12] = {0.2, 0, 0, 0.3, 0, 0.2, 0, 0.4, 0, 0, 0.2, 0.5};
    const double far[12] = {0.2, 0, 0, 3.45, 0, 0.2, 0, 0.4, 0, 0, 0.2, 0.5};
    stage s;
    open_stage(&opened, 6, true, 6.0, 5, &s);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 0, 0, 6);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 6, 0, 0);

    succeed(&opened, svo_moving_set_transform(s.moving, 1, moved));
    succeed(&opened, svo_moving_update(s.moving, opened.queue, NULL));
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 5, 1, 0);

    succeed(&opened, svo_moving_show(s.moving, 0, 0)); /* the triangles of the others have other numbers */
    succeed(&opened, svo_moving_update(s.moving, opened.queue, NULL));
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 5, 0, 0);
    compare(&opened, &s, 6);

    succeed(&opened, svo_moving_show(s.moving, 0, 1));
    tear(&opened, &s, 2, 7);
    succeed(&opened, svo_moving_update(s.moving, opened.queue, NULL));
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.5F), 4, 0, 2);

    tear(&opened, &s, 2, 8); /* no two triangles are still neighbors */
    succeed(&opened, svo_moving_update(s.moving, opened.queue, NULL));
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 1.1F), 5, 0, 1);

    succeed(&opened, svo_moving_set_transform(s.moving, 3, far)); /* its box crosses a face of the grid */
    succeed(&opened, svo_moving_update(s.moving, opened.queue, NULL));
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 5, 0, 1);
    compare(&opened, &s, 8);

    succeed(&opened, svo_moving_remove(s.moving, 3)); /* the tree still has it */
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 6, 0, 0);
    succeed(&opened, svo_moving_update(s.moving, opened.queue, NULL));
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 5, 0, 0);
    compare(&opened, &s, 9);
    close_stage(&s);
}

/* A BVH of the whole tree that was asked for meanwhile gives way. */
static void a_whole_bvh_can_be_replaced(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    stage s;
    open_stage(&opened, 7, true, 6.0, 3, &s);
    succeed(&opened, svo_tree_make_bvh(svo_moving_tree(s.moving), SVO_BVH_FAST, opened.queue));
    const uint64_t whole_bytes = svo_tree_ray_bytes(svo_moving_tree(s.moving));
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 0, 0, 4);
    assert_true(svo_tree_ray_bytes(svo_moving_tree(s.moving)) != whole_bytes);
    succeed(&opened, svo_tree_make_bvh(svo_moving_tree(s.moving), SVO_BVH_FAST, opened.queue));
    assert_int_equal(svo_tree_ray_bytes(svo_moving_tree(s.moving)), whole_bytes);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 4, 0, 0);
    compare(&opened, &s, 1);
    close_stage(&s);
}

/* ---- failures ---- */

static void assert_fails(const fixture *opened, svo_status actual, const char *words)
{
    assert_int_equal(actual, SVO_INVALID_ARGUMENT);
    if (strstr(svo_device_message(opened->device), words) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", svo_device_message(opened->device), words);
    }
}

static void wrong_calls_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_moving_bvh_report small = {.struct_size = 4};
    stage s;
    open_stage(&opened, 8, true, 6.0, 1, &s);
    assert_int_equal(svo_moving_make_bvh(NULL, SVO_BVH_BEST, 0.0F, opened.queue, NULL), SVO_INVALID_ARGUMENT);
    assert_fails(&opened, svo_moving_make_bvh(s.moving, (svo_bvh_quality)2, 0.0F, opened.queue, NULL), "quality 2");
    assert_fails(&opened, svo_moving_make_bvh(s.moving, SVO_BVH_BEST, -1.0F, opened.queue, NULL), "cost_ratio -1");
    assert_fails(&opened, svo_moving_make_bvh(s.moving, SVO_BVH_BEST, NAN, opened.queue, NULL), "cost_ratio");
    assert_fails(&opened, svo_moving_make_bvh(s.moving, SVO_BVH_BEST, 0.0F, opened.queue, &small), "struct_size");
    assert_int_equal(svo_tree_ray_bytes(svo_moving_tree(s.moving)), 0);
    svo_moving_options options = s.options;
    svo_moving *other = NULL;
    options.need = SVO_NEED_NONE;
    succeed(&opened, svo_moving_create(opened.device, &s.views[0], 6, &options, opened.queue, &other));
    assert_fails(&opened, svo_moving_make_bvh(other, SVO_BVH_BEST, 0.0F, opened.queue, NULL), "SVO_NEED_RAYS");
    svo_moving_destroy(&other);
    options.need = SVO_NEED_RAYS;
    options.coverage = SVO_COVERAGE_THIN;
    succeed(&opened, svo_moving_create(opened.device, &s.views[0], 6, &options, opened.queue, &other));
    assert_fails(&opened, svo_moving_make_bvh(other, SVO_BVH_BEST, 0.0F, opened.queue, NULL), "thin");
    svo_moving_destroy(&other);
    close_stage(&s);
}

/* ---- memory ---- */

/* Host blocks, and the buffers that rays read. */
static void memory_is_flat(void **state)
{
    enum { UPDATES = 1000, WARM = 200 };
    (void)state;
    if (getenv("SVOCL_TEST_PATH") != NULL) {
        print_message("skipped: the host's memory does not depend on the kernels\n");
        skip();
    }
    const svo_device_options device_options = {.struct_size = sizeof device_options, .memory = &ledger_callbacks};
    const float positions[9] = {0.1F, 0.1F, 0.1F, 0.3F, 0.1F, 0.1F, 0.1F, 0.4F, 0.1F};
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = positions, .vertex_count = 3, .triangle_count = 1};
    const svo_moving_options options = {.struct_size = sizeof options, .need = SVO_NEED_RAYS, .edge = 1.0};
    fixture opened = {.device = NULL};
    svo_moving *moving = NULL;
    uint64_t blocks = 0;
    uint64_t bytes = 0;
    uint32_t object = 0;
    assert_int_equal(svo_device_create_default(&device_options, &opened.device, NULL), SVO_OK);
    succeed(&opened, svo_moving_create(opened.device, &mesh, 3, &options, NULL, &moving));
    succeed(&opened, svo_moving_add(moving, &mesh, NULL, &object));
    for (int i = 0; i < UPDATES; ++i) {
        const double transform[12] = {1, 0, 0, (double)(i % 64) / 64.0, 0, 1, 0, 0, 0, 0, 1, 0}; /* outside and back */
        if (i % 10 == 3) {
            succeed(&opened, svo_moving_remove(moving, object));
            succeed(&opened, svo_moving_add(moving, &mesh, transform, &object));
        }
        succeed(&opened, svo_moving_set_transform(moving, object, transform));
        succeed(&opened, svo_moving_show(moving, object, i % 7 != 0));
        succeed(&opened, svo_moving_update(moving, NULL, NULL));
        succeed(&opened, svo_moving_make_bvh(moving, SVO_BVH_BEST, 0.0F, NULL, NULL));
        if (i == WARM) {
            ledger_begin(LEDGER_NEVER);
            blocks = ledger_end().live_blocks;
            bytes = svo_tree_ray_bytes(svo_moving_tree(moving));
        }
    }
    assert_int_equal(svo_tree_ray_bytes(svo_moving_tree(moving)), bytes);
    assert_int_equal(ledger_end().live_blocks, blocks);
    assert_null(ledger_end().wrong);
    svo_moving_destroy(&moving);
    fixture_close(&opened);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_the_whole_bvh),
        cmocka_unit_test(hits_are_the_same_at_the_grids_faces),
        cmocka_unit_test(hits_are_the_same_in_doubles),
        cmocka_unit_test(many_objects_can_be_traced),
        cmocka_unit_test(only_what_changed_is_refit_or_made),
        cmocka_unit_test(a_whole_bvh_can_be_replaced),
        cmocka_unit_test(wrong_calls_are_refused),
        cmocka_unit_test(memory_is_flat),
    };
    return cmocka_run_group_tests(tests, fixture_group_setup, fixture_group_teardown);
}
