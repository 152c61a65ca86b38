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

#include "moving_scene.h"
#include "support/enqueued.h"
#include "support/info_of.h"
#include "support/suite.h"

enum { RAYS = 1500, POINTS = 100, DEPTH = 6 };

/* ---- scenes ---- */

typedef struct stage {
    actors made;
    svo_moving_options options;
    svo_moving *moving;
    bool is_there[OBJECTS], is_visible[OBJECTS];
} stage;

/* In a grid of edge 6 all is inside; one of edge 1 has the static mesh and some objects at its faces. */
static void open_stage(const fixture *opened, uint64_t seed, bool in_floats, double edge, stage *s)
{
    *s = (stage){.options = {.need = SVO_NEED_RAYS,
                             .edge = edge,
                             .max_area = 1e3,
                             .origin = {0.5 - 0.5 * edge, 0.5 - 0.5 * edge, 0.5 - 0.5 * edge}}};
    actors_create(seed, 160, in_floats, &s->made);
    s->moving = make_stage(opened, &s->made, DEPTH, s->options);
    for (int i = 0; i < OBJECTS; ++i) {
        s->is_there[i] = true;
        s->is_visible[i] = true;
    }
    update_moving(opened, s->moving);
}

static void close_stage(stage *s)
{
    svo_moving_destroy(&s->moving);
    actors_destroy(&s->made);
}

/* Adds an object with the least number that is free. */
static void add_object(const fixture *opened, stage *s, uint64_t *seed)
{
    double transform[12];
    uint32_t object = 0;
    uint32_t number = 77;
    while (s->is_there[object]) {
        ++object;
    }
    random_transform(seed, transform);
    succeed(opened, svo_moving_add(s->moving, &s->made.objects[object].mesh, transform, &number));
    assert_int_equal(number, object);
    s->is_there[object] = true;
    s->is_visible[object] = true;
}

static uint32_t count_shown(const stage *s)
{
    uint32_t count = 1;
    for (int i = 0; i < OBJECTS; ++i) {
        count += s->is_there[i] && s->is_visible[i] ? 1 : 0;
    }
    return count;
}

/* Gives an object random vertices: its triangles are torn apart. */
static void tear(const fixture *opened, stage *s, uint32_t object, uint64_t seed)
{
    svo_mesh torn = s->made.objects[object].mesh;
    float *positions = malloc(torn.vertex_count * 12);
    assert_non_null(positions);
    for (size_t i = 0; i < torn.vertex_count * 3; ++i) {
        positions[i] = (float)random_unit(&seed);
    }
    torn.positions = positions;
    succeed(opened, svo_moving_set_vertices(s->moving, object, &torn));
    free(positions);
}

/* ---- results ---- */

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
        succeed(opened, svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(actual), RAYS, flags,
                                            &(svo_submit){.queue = opened->queue}));
        succeed(opened, svo_trace_triangles(svo_tree_target(whole), svo_in_host(rays), svo_in_host(expected), RAYS,
                                            flags, &(svo_submit){.queue = opened->queue}));
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
    succeed(opened, svo_tree_nearest(tree, svo_in_host(points), svo_in_host(actual), POINTS,
                                     &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_tree_nearest(whole, svo_in_host(points), svo_in_host(expected), POINTS,
                                     &(svo_submit){.queue = opened->queue}));
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
    svo_tree *whole = build_whole(opened, s->moving, DEPTH, &s->options);
    svo_tree *tree = svo_moving_tree(s->moving);
    const uint64_t bytes = info_of_tree(tree).ray_bytes;
    compare_rays(opened, tree, whole, seed);
    if (s->options.edge > 2.0) {
        compare_points(opened, tree, whole, seed);
    }
    assert_int_equal(info_of_tree(tree).ray_bytes, bytes); /* no other BVH was made */
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
        add_object(opened, s, seed);
    } else if (act == 0) {
        s->is_visible[object] = !s->is_visible[object];
        succeed(opened, svo_moving_show(s->moving, object, s->is_visible[object]));
    } else if (act == 1) {
        succeed(opened, svo_moving_remove(s->moving, object));
        s->is_there[object] = false;
    } else if (act == 2) {
        succeed(opened, svo_moving_set_vertices(s->moving, object, &s->made.objects[object].mesh));
    } else if (act == 3 && s->made.floats[0] != NULL) {
        tear(opened, s, object, *seed);
    } else {
        random_transform(seed, transform);
        succeed(opened, svo_moving_set_transform(s->moving, object, transform));
    }
}

/* Updates; also without waiting, while the tree before is traced. Then room for new pairs may be missing at first. */
static void update_somehow(const fixture *opened, const stage *s, bool is_enqueued, uint64_t seed)
{
    if (is_enqueued) {
        svo_tree *tree = svo_moving_tree(s->moving);
        succeed(opened, svo_moving_update(s->moving, &(svo_submit){.queue = opened->queue}, NULL));
        const svo_moving_bvh_report report = make_bvh(opened, s, SVO_BVH_BEST, 0.5F);
        assert_int_equal(report.refit + report.made, 0);
        compare_rays(opened, tree, tree, seed);
        const svo_status status = svo_moving_finish(s->moving, NULL);
        assert_true(status == SVO_OK || status == SVO_CAPACITY_EXCEEDED);
    }
    update_moving(opened, s->moving);
}

static void compare_moves(const fixture *opened, uint64_t seed, int moves, bool in_floats, double edge)
{
    static const float ratios[] = {0.0F, 0.5F, FLT_MAX};
    stage s;
    print_message("seed %llu\n", (unsigned long long)seed);
    open_stage(opened, seed, in_floats, edge, &s);
    for (int i = 0; i < moves; ++i) {
        const uint32_t shown = count_shown(&s);
        const svo_bvh_quality quality = i % 4 == 1 ? SVO_BVH_FAST : SVO_BVH_BEST;
        const svo_moving_bvh_report report = make_bvh(opened, &s, quality, ratios[i % 3]);
        assert_int_equal(report.kept + report.refit + report.made, shown);
        compare(opened, &s, seed);
        for (uint32_t k = random_below(&seed, 4) + 1; k > 0; --k) {
            play(opened, &s, &seed);
        }
        update_somehow(opened, &s, i % 3 == 1, seed);
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

/* Adds many objects with a few triangles; half of them lie in one place. */
static void add_many(const fixture *opened, stage *s, uint32_t many, uint64_t *seed)
{
    for (uint32_t i = 0; i < many; ++i) {
        double transform[12];
        uint32_t object = 0;
        svo_mesh few = s->made.objects[0].mesh;
        few.triangle_count = 2;
        random_transform(seed, transform);
        succeed(opened, svo_moving_add(s->moving, &few, i < many / 2 ? transform : NULL, &object));
    }
}

/* Several levels of common nodes. Then all objects are refit at once, small and large ones. */
static void many_objects_can_be_traced(void **state)
{
    enum { MANY = 150 };
    const fixture opened = fixture_cl_of_group(state);
    uint64_t seed = 5;
    stage s;
    open_stage(&opened, seed, true, 6.0, &s);
    add_many(&opened, &s, MANY, &seed);
    update_moving(&opened, s.moving);
    assert_int_equal(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F).made, MANY + OBJECTS + 1);
    compare(&opened, &s, seed);
    for (uint32_t i = 0; i < MANY + OBJECTS; ++i) {
        double transform[12];
        random_transform(&seed, transform);
        succeed(&opened, svo_moving_set_transform(s.moving, i, transform));
    }
    update_moving(&opened, s.moving);
    assert_int_equal(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX).refit, MANY + OBJECTS);
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
    open_stage(&opened, 6, true, 6.0, &s);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 0, 0, 6);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 6, 0, 0);

    succeed(&opened, svo_moving_set_transform(s.moving, 1, moved));
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 5, 1, 0);

    succeed(&opened, svo_moving_show(s.moving, 0, 0)); /* the triangles of the others have other numbers */
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 5, 0, 0);
    compare(&opened, &s, 6);

    succeed(&opened, svo_moving_show(s.moving, 0, 1));
    tear(&opened, &s, 2, 7);
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.5F), 4, 0, 2);

    succeed(&opened, svo_moving_set_transform(s.moving, 3, far)); /* its box crosses a face of the grid */
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 5, 0, 1);
    compare(&opened, &s, 8);

    succeed(&opened, svo_moving_remove(s.moving, 3)); /* the tree still has it */
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 6, 0, 0);
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 5, 0, 0);
    compare(&opened, &s, 9);
    close_stage(&s);
}

/* The BVHs' buffers are replaced by larger ones while an object is hidden. Then it is shown, and refit. */
static void a_hidden_object_keeps_its_bvh(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double moved[12] = {0.2, 0, 0, 0.3, 0, 0.2, 0, 0.4, 0, 0, 0.2, 0.5};
    uint64_t seed = 11;
    stage s;
    open_stage(&opened, seed, true, 6.0, &s);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 0, 0, 6);
    succeed(&opened, svo_moving_show(s.moving, 0, 0));
    add_many(&opened, &s, 40, &seed);
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 5, 0, 40);

    succeed(&opened, svo_moving_show(s.moving, 0, 1));
    succeed(&opened, svo_moving_set_transform(s.moving, 0, moved));
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 45, 1, 0);
    compare(&opened, &s, seed);
    close_stage(&s);
}

/* A row of small triangles, in an order of steps: neighbors in the mesh are neighbors in space if it is 1. Other arrays
   are those of the static mesh. */
static svo_mesh row_of_triangles(const stage *s, size_t step, float *positions)
{
    svo_mesh row = s->made.room.mesh;
    row.positions = positions;
    row.indices = NULL;
    row.triangle_materials = NULL;
    row.triangle_count = row.vertex_count / 3;
    row.vertex_count = row.triangle_count * 3;
    for (size_t i = 0; i < row.triangle_count; ++i) {
        const float x = (float)(i * step % row.triangle_count) / (float)row.triangle_count;
        const float corners[9] = {x, 0.1F, 0.1F, x + 0.01F, 0.1F, 0.2F, x, 0.2F, 0.1F};
        memcpy(&positions[9 * i], corners, sizeof corners);
    }
    return row;
}

/* Neither a turn nor a stretch makes a BVH bad; a row in disorder does. */
static void a_bad_refit_is_made_anew(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double turned[12] = {0, -2, 0, 0.5, 2, 0, 0, 0, 0, 0, 2, 0.5};
    uint32_t object = 0;
    stage s;
    open_stage(&opened, 9, true, 6.0, &s);
    float *positions = malloc(s.made.room.mesh.vertex_count * 12);
    assert_non_null(positions);
    svo_mesh row = row_of_triangles(&s, 1, positions);
    succeed(&opened, svo_moving_add(s.moving, &row, NULL, &object));
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 0, 0, 7);

    succeed(&opened, svo_moving_set_transform(s.moving, object, turned));
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 1.1F), 6, 1, 0);

    row = row_of_triangles(&s, 37, positions);
    succeed(&opened, svo_moving_set_vertices(s.moving, object, &row));
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 6, 0, 1);
    compare(&opened, &s, 9);

    row = row_of_triangles(&s, 1, positions);
    succeed(&opened, svo_moving_set_vertices(s.moving, object, &row));
    update_moving(&opened, s.moving);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, FLT_MAX), 6, 1, 0);
    compare(&opened, &s, 10);
    free(positions);
    close_stage(&s);
}

/* A BVH of the whole tree that was asked for meanwhile gives way. */
static void a_whole_bvh_can_be_replaced(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    stage s;
    open_stage(&opened, 7, true, 6.0, &s);
    succeed(&opened, svo_tree_make_bvh(svo_moving_tree(s.moving), SVO_BVH_FAST, opened.queue));
    const uint64_t whole_bytes = info_of_tree(svo_moving_tree(s.moving)).ray_bytes;
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 0, 0, 6);
    assert_true(info_of_tree(svo_moving_tree(s.moving)).ray_bytes != whole_bytes);
    succeed(&opened, svo_tree_make_bvh(svo_moving_tree(s.moving), SVO_BVH_FAST, opened.queue));
    assert_int_equal(info_of_tree(svo_moving_tree(s.moving)).ray_bytes, whole_bytes);
    assert_report(make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F), 6, 0, 0);
    compare(&opened, &s, 1);
    close_stage(&s);
}

/* A scene copies the tree and its BVH, of which it has no other. */
static void instances_have_the_same_hits(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_instance instance = {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    svo_scene_options options = SVO_SCENE_OPTIONS_INIT;
    svo_scene *scene = NULL;
    svo_ray rays[RAYS];
    svo_scene_triangle_hit actual[RAYS];
    svo_hit expected[RAYS];
    stage s;
    open_stage(&opened, 11, true, 6.0, &s);
    (void)make_bvh(&opened, &s, SVO_BVH_BEST, 0.0F);
    svo_tree *tree = svo_moving_tree(s.moving);
    options.trees = &tree;
    options.tree_count = 1;
    options.instances = &instance;
    options.instance_count = 1;
    options.need = SVO_NEED_RAYS;
    random_rays(11, rays);
    succeed(&opened, svo_scene_create(opened.device, &options, opened.queue, &scene));
    succeed(&opened, svo_trace_triangles(svo_scene_target(scene), svo_in_host(rays), svo_in_host(actual), RAYS,
                                         SVO_SCENE_CLOSEST, &(svo_submit){.queue = opened.queue}));
    succeed(&opened, svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(expected), RAYS,
                                         SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened.queue}));
    for (int i = 0; i < RAYS; ++i) {
        assert_int_equal(actual[i].triangle, expected[i].triangle);
    }
    svo_scene_destroy(&scene);
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
    open_stage(&opened, 8, true, 6.0, &s);
    assert_int_equal(svo_moving_make_bvh(NULL, SVO_BVH_BEST, 0.0F, opened.queue, NULL), SVO_INVALID_ARGUMENT);
    assert_fails(&opened, svo_moving_make_bvh(s.moving, (svo_bvh_quality)2, 0.0F, opened.queue, NULL), "quality 2");
    assert_fails(&opened, svo_moving_make_bvh(s.moving, SVO_BVH_BEST, -1.0F, opened.queue, NULL), "cost_ratio -1");
    assert_fails(&opened, svo_moving_make_bvh(s.moving, SVO_BVH_BEST, NAN, opened.queue, NULL), "cost_ratio");
    assert_fails(&opened, svo_moving_make_bvh(s.moving, SVO_BVH_BEST, 0.0F, opened.queue, &small), "struct_size");
    assert_int_equal(info_of_tree(svo_moving_tree(s.moving)).ray_bytes, 0);
    svo_moving_options options = s.options;
    options.need = SVO_NEED_NONE;
    svo_moving *other = make_moving(&opened, &s.made.room.mesh, DEPTH, options);
    assert_fails(&opened, svo_moving_make_bvh(other, SVO_BVH_BEST, 0.0F, opened.queue, NULL), "SVO_NEED_RAYS");
    svo_moving_destroy(&other);
    options.need = SVO_NEED_RAYS;
    options.coverage = SVO_COVERAGE_THIN;
    other = make_moving(&opened, &s.made.room.mesh, DEPTH, options);
    assert_fails(&opened, svo_moving_make_bvh(other, SVO_BVH_BEST, 0.0F, opened.queue, NULL), "thin");
    svo_moving_destroy(&other);
    close_stage(&s);
}

/* ---- memory ---- */

static void update_with_bvh(const fixture *opened, svo_moving *moving)
{
    update_moving(opened, moving);
    succeed(opened, svo_moving_make_bvh(moving, SVO_BVH_BEST, 0.0F, NULL, NULL));
}

static uint64_t ray_bytes_of(const svo_moving *moving)
{
    return info_of_tree(svo_moving_tree(moving)).ray_bytes;
}

static void memory_is_flat(void **state)
{
    (void)state;
    check_memory_is_flat(1000, update_with_bvh, ray_bytes_of);
}

TEST_GROUP(moving_rays)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_the_whole_bvh),
        cmocka_unit_test(hits_are_the_same_at_the_grids_faces),
        cmocka_unit_test(hits_are_the_same_in_doubles),
        cmocka_unit_test(many_objects_can_be_traced),
        cmocka_unit_test(only_what_changed_is_refit_or_made),
        cmocka_unit_test(a_hidden_object_keeps_its_bvh),
        cmocka_unit_test(a_bad_refit_is_made_anew),
        cmocka_unit_test(a_whole_bvh_can_be_replaced),
        cmocka_unit_test(instances_have_the_same_hits),
        cmocka_unit_test(wrong_calls_are_refused),
        cmocka_unit_test(memory_is_flat),
    };
    return cmocka_run_group_tests_name("moving_rays", tests, fixture_group_setup, fixture_group_teardown);
}
