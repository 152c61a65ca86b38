/* SPDX-License-Identifier: MIT */
/*
 * Scenes that move: after each update the tree is that of a full build of the scene's mesh, byte for byte, and so is
 * its light; objects come, go, hide and leave the grid; what is refused or does not fit leaves the tree as it was;
 * memory is flat.
 */
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
#include "support/fixture.h"
#include "support/suite.h"

static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/* ---- equality ---- */

static const uint32_t everything = SVO_NEED_ALL;

/* One of the objects moves, hides, appears or gets other vertices. */
static void play(const fixture *opened, svo_moving *moving, const actors *of, uint64_t *seed, bool *visible)
{
    double transform[12];
    const uint32_t object = random_below(seed, OBJECTS);
    const uint32_t act = random_below(seed, 8);
    if (act == 0) {
        visible[object] = !visible[object];
        succeed(opened, svo_moving_show(moving, object, visible[object]));
    } else if (act == 1) {
        succeed(opened, svo_moving_set_vertices(moving, object, &of->objects[object].mesh));
    } else {
        random_transform(seed, transform);
        succeed(opened, svo_moving_set_transform(moving, object, transform));
    }
}

static void compare_moves(const fixture *opened, uint64_t seed, int moves, unsigned depth, svo_moving_options options)
{
    actors made;
    bool visible[OBJECTS] = {true, true, true, true, true};
    actors_create(seed, 120, seed % 2 == 0, &made);
    options.max_area = 40.0;
    svo_moving *moving = make_stage(opened, &made, depth, options);
    update_moving(opened, moving);
    compare_moving(opened, moving, depth, &options);
    for (int i = 0; i < moves; ++i) {
        for (uint32_t k = random_below(&seed, 3) + 1; k > 0; --k) {
            play(opened, moving, &made, &seed, visible);
        }
        update_moving(opened, moving);
        compare_moving(opened, moving, depth, &options);
    }
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

static void a_hundred_moves_equal_full_builds(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .edge = 1.0};
    compare_moves(&opened, 4, 100, 6, options);
}

static void every_kind_of_request_can_move(void **state)
{
    static const uint32_t needs[] = {SVO_NEED_NONE,
                                     SVO_NEED_DEFAULT,
                                     SVO_NEED_RAYS,
                                     SVO_NEED_MATERIAL,
                                     SVO_NEED_NORMAL | SVO_NEED_MATERIAL,
                                     SVO_NEED_COLOR | SVO_NEED_RAYS};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        const svo_moving_options options = {.need = needs[i],
                                            .coverage = (svo_coverage)(i % 3),
                                            .weights = (svo_weights)((i + i / 3) % 3),
                                            .payload_level = (uint32_t)i % 4,
                                            .origin = {-0.1, 0.0, 0.2},
                                            .edge = 0.9};
        compare_moves(&opened, 70 + i, 4, i == 4 ? 1 : 7, options);
    }
}

/* Materials, textures and colors of all alphas; with payload that needs their colors, and without. */
static void pairs_are_dropped_while_objects_move(void **state)
{
    static const uint32_t needs[] = {SVO_NEED_ALL, SVO_NEED_NONE, SVO_NEED_NORMAL | SVO_NEED_RAYS};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        const svo_moving_options options = {.need = needs[i],
                                            .weights = i == 1 ? SVO_WEIGHTS_CENTER : SVO_WEIGHTS_AREA,
                                            .edge = 1.0,
                                            .drop_alpha = 0.3};
        compare_moves(&opened, 90 + i, 4, 6, options);
    }
}

/* Long codes, and a grid finer than 2^20 units. */
static void deep_grids_can_move(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .origin = {0.4, 0.4, 0.4}, .edge = 60.0};
    compare_moves(&opened, 11, 3, 11, options);
    compare_moves(&opened, 12, 3, 13, options);
}

/* The room lies outside the grid, and the objects leave it one after the other. */
static void all_may_leave_the_grid(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .origin = {10, 10, 10}, .edge = 1.0, .max_area = 40.0};
    const double away[12] = {1, 0, 0, -4, 0, 1, 0, 0, 0, 0, 1, 0};
    const double inside[12] = {0.5, 0, 0, 10.2, 0, 0.5, 0, 10.2, 0, 0, 0.5, 10.1};
    svo_moving_object info = SVO_MOVING_OBJECT_INIT;
    actors made;
    actors_create(8, 60, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 5, options);
    update_moving(&opened, moving);
    compare_moving(&opened, moving, 5, &options);
    for (uint32_t step = 0; step < 2 * OBJECTS; ++step) {
        const bool leaves = step >= OBJECTS;
        const uint32_t object = step % OBJECTS;
        succeed(&opened, svo_moving_set_transform(moving, object, leaves ? away : inside));
        update_moving(&opened, moving);
        compare_moving(&opened, moving, 5, &options);
        succeed(&opened, svo_moving_get_object(moving, object, &info));
        assert_int_equal(info.outside_triangles, leaves ? info.triangles - info.refused_triangles : 0);
        assert_true(leaves == (info.fragments == 0));
    }
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

static void objects_come_and_go(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .edge = 1.0, .max_area = 40.0};
    svo_moving_object info = SVO_MOVING_OBJECT_INIT;
    svo_moving_info scene = SVO_MOVING_INFO_INIT;
    uint32_t object = 0;
    actors made;
    actors_create(6, 80, false, &made);
    svo_moving *moving = make_stage(&opened, &made, 6, options);
    update_moving(&opened, moving);
    succeed(&opened, svo_moving_remove(moving, 1));
    succeed(&opened, svo_moving_remove(moving, 3));
    assert_int_equal(svo_moving_remove(moving, 3), SVO_INVALID_ARGUMENT);
    update_moving(&opened, moving);
    compare_moving(&opened, moving, 6, &options);
    succeed(&opened, svo_moving_remove(moving, 2)); /* its number goes to another before the update */
    succeed(&opened, svo_moving_add(moving, &made.objects[0].mesh, identity, &object));
    assert_int_equal(object, 1);
    succeed(&opened, svo_moving_add(moving, &made.objects[4].mesh, NULL, &object));
    assert_int_equal(object, 2);
    update_moving(&opened, moving);
    compare_moving(&opened, moving, 6, &options);
    succeed(&opened, svo_moving_get_info(moving, &scene));
    assert_int_equal(scene.object_count, 4);
    succeed(&opened, svo_moving_show(moving, 0, 0));
    succeed(&opened, svo_moving_get_object(moving, 1, &info));
    assert_int_equal(info.first_triangle, made.room.mesh.triangle_count);
    update_moving(&opened, moving);
    compare_moving(&opened, moving, 6, &options);
    for (uint32_t i = 0; i < OBJECTS; ++i) {
        (void)svo_moving_remove(moving, i);
    }
    update_moving(&opened, moving);
    compare_moving(&opened, moving, 6, &options);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* An update without a change does nothing; one that is reported says what it did. */
static void reports_count_what_changed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = SVO_NEED_NORMAL, .edge = 1.0, .max_area = 40.0};
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    svo_moving_object before = SVO_MOVING_OBJECT_INIT;
    svo_moving_object after = SVO_MOVING_OBJECT_INIT;
    actors made;
    actors_create(10, 80, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 6, options);
    update_moving(&opened, moving);
    const svo_tree *tree = svo_moving_tree(moving);
    succeed(&opened, svo_moving_update(moving, &(svo_submit){.queue = opened.queue}, &report));
    assert_int_equal(report.changed_objects, 0);
    assert_ptr_equal(svo_moving_tree(moving), tree);
    succeed(&opened, svo_moving_get_object(moving, 0, &before));
    succeed(&opened, svo_moving_set_transform(moving, 0, identity));
    succeed(&opened, svo_moving_show(moving, 4, 0));
    succeed(&opened, svo_moving_get_object(moving, 4, &after));
    const uint64_t hidden = after.fragments;
    succeed(&opened, svo_moving_update(moving, &(svo_submit){.queue = opened.queue}, &report));
    succeed(&opened, svo_moving_get_object(moving, 0, &after));
    assert_int_equal(report.changed_objects, 2);
    assert_int_equal(report.changed_fragments, before.fragments + after.fragments + hidden);
    assert_true(report.total_ms > 0.0);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* ---- light ---- */

/* The digest of the light of a tree, from a lamp and a sky. */
static void digest_light(const fixture *opened, svo_tree *tree, svo_light_form form, char text[SVO_HASH_TEXT_BYTES])
{
    const svo_light_source lamp = {
        .kind = SVO_SOURCE_POINT, .position = {0.5F, 0.45F, 0.4F}, .value = {3.0F, 2.0F, 1.0F}};
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .sources = &lamp, .source_count = 1, .sky = {0.1F, 0.2F, 0.3F}};
    const svo_light_options options = {.struct_size = sizeof options, .form = form};
    svo_light_info info = SVO_LIGHT_INFO_INIT;
    svo_light *light = NULL;
    succeed(opened, svo_light_create(tree, &options, opened->queue, &light));
    succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
    succeed(opened, svo_light_get_info(light, &info));
    assert_true(info.photon_hits > 0);
    succeed(opened, svo_light_hash(light, opened->queue, text));
    svo_light_destroy(&light);
}

static void light_is_that_of_full_builds(void **state)
{
    enum { UPDATES = 3, DEPTH = 6 };
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .edge = 1.0, .max_area = 40.0};
    uint64_t seed = 20;
    actors made;
    actors_create(20, 80, true, &made);
    svo_moving *moving = make_stage(&opened, &made, DEPTH, options);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        char before[SVO_HASH_TEXT_BYTES] = "";
        for (uint32_t i = 0; i < UPDATES; ++i) {
            char actual[SVO_HASH_TEXT_BYTES], expected[SVO_HASH_TEXT_BYTES];
            double transform[12];
            random_transform(&seed, transform);
            succeed(&opened, svo_moving_set_transform(moving, i, transform));
            update_moving(&opened, moving);
            svo_tree *whole = build_whole(&opened, moving, DEPTH, &options);
            digest_light(&opened, svo_moving_tree(moving), (svo_light_form)form, actual);
            digest_light(&opened, whole, (svo_light_form)form, expected);
            assert_string_equal(actual, expected);
            assert_string_not_equal(actual, before); /* it follows what moves */
            memcpy(before, actual, sizeof before);
            svo_tree_destroy(&whole);
        }
    }
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* ---- failures ---- */

static void assert_fails(const fixture *opened, svo_status actual, svo_status expected, const char *words)
{
    assert_int_equal(actual, expected);
    if (strstr(svo_device_message(opened->device), words) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", svo_device_message(opened->device), words);
    }
}

static void wrong_transforms_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = SVO_NEED_NONE, .edge = 1.0};
    const double flat[12] = {1, 2, 0, 0, 2, 4, 0, 0, 0, 0, 1, 0};
    const double none[12] = {0};
    double infinite[12] = {1, 0, 0, (double)INFINITY, 0, 1, 0, 0, 0, 0, 1, 0};
    uint32_t object = 0;
    actors made;
    actors_create(2, 60, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 4, options);
    update_moving(&opened, moving);
    const svo_tree *tree = svo_moving_tree(moving);
    assert_fails(&opened, svo_moving_set_transform(moving, 3, flat), SVO_INVALID_ARGUMENT, "object 3 is flat");
    assert_fails(&opened, svo_moving_set_transform(moving, 2, none), SVO_INVALID_ARGUMENT, "object 2 is flat");
    assert_fails(&opened, svo_moving_set_transform(moving, 1, infinite), SVO_INVALID_ARGUMENT,
                 "object 1 is not finite");
    assert_fails(&opened, svo_moving_set_transform(moving, 1, NULL), SVO_INVALID_ARGUMENT, "object 1 is NULL");
    assert_fails(&opened, svo_moving_set_transform(moving, 5, identity), SVO_INVALID_ARGUMENT, "no object 5");
    assert_fails(&opened, svo_moving_add(moving, &made.objects[0].mesh, flat, &object), SVO_INVALID_ARGUMENT,
                 "object 5 is flat");
    update_moving(&opened, moving);
    assert_ptr_equal(svo_moving_tree(moving), tree); /* nothing had moved */
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

static void wrong_meshes_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.struct_size = sizeof options, .edge = 1.0};
    svo_moving_options wrong = options;
    svo_moving *moving = NULL;
    uint32_t object = 0;
    actors made;
    actors_create(2, 60, true, &made);
    const svo_mesh *room = &made.room.mesh;
    wrong.edge = 0.0;
    assert_fails(&opened, svo_moving_create(opened.device, room, 4, &wrong, NULL, &moving), SVO_INVALID_ARGUMENT,
                 "edge");
    wrong = options;
    wrong.need = SVO_NEED_FILL;
    wrong.weights = SVO_WEIGHTS_UNIFORM;
    assert_fails(&opened, svo_moving_create(opened.device, room, 4, &wrong, NULL, &moving), SVO_INVALID_ARGUMENT,
                 "svo_moving_create: options.need has fill, which requires weights area");
    assert_fails(&opened, svo_moving_create(opened.device, room, 4, NULL, NULL, &moving), SVO_INVALID_ARGUMENT,
                 "options is NULL");
    assert_fails(&opened, svo_moving_create(opened.device, room, 17, &options, NULL, &moving), SVO_INVALID_ARGUMENT,
                 "depth 17");
    moving = make_moving(&opened, room, 4, options);
    svo_mesh mesh = made.objects[0].mesh;
    mesh.normals = NULL;
    assert_fails(&opened, svo_moving_add(moving, &mesh, NULL, &object), SVO_INVALID_ARGUMENT, "normals");
    mesh = made.objects[0].mesh;
    mesh.colors = NULL;
    assert_fails(&opened, svo_moving_add(moving, &mesh, NULL, &object), SVO_INVALID_ARGUMENT, "colors");
    mesh = made.objects[0].mesh;
    mesh.triangle_count = 0;
    assert_fails(&opened, svo_moving_add(moving, &mesh, NULL, &object), SVO_INVALID_ARGUMENT, "svo_moving_add");
    succeed(&opened, svo_moving_add(moving, &made.objects[0].mesh, NULL, &object));
    mesh = made.objects[0].mesh;
    --mesh.vertex_count;
    assert_fails(&opened, svo_moving_set_vertices(moving, object, &mesh), SVO_INVALID_ARGUMENT, "vertices");
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* The tree stays what it was until the scene fits again. */
static void what_does_not_fit_leaves_the_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const double large[12] = {0.9, 0, 0, 0, 0, 0.9, 0, 0, 0, 0, 0.9, 0};
    const double small[12] = {0.01, 0, 0, 0.5, 0, 0.01, 0, 0.5, 0, 0, 0.01, 0.5};
    for (int by_area = 0; by_area < 2; ++by_area) {
        svo_moving_options options = {.need = everything, .edge = 1.0, .max_area = 40.0};
        svo_moving_info info = SVO_MOVING_INFO_INIT;
        uint32_t object = 0;
        actors made;
        actors_create(2, 100, true, &made);
        svo_moving *moving = make_moving(&opened, &made.room.mesh, 6, options);
        succeed(&opened, svo_moving_get_info(moving, &info));
        if (by_area) {
            options.max_area = info.area * 1.01;
        } else {
            options.fragment_capacity = info.fragments + 2000;
        }
        svo_moving_destroy(&moving);
        moving = make_moving(&opened, &made.room.mesh, 6, options);
        for (int i = 0; i < 40; ++i) {
            succeed(&opened, svo_moving_add(moving, &made.objects[4].mesh, small, &object));
        }
        update_moving(&opened, moving);
        const outcome before = outcome_of(&opened, svo_moving_tree(moving));
        for (uint32_t i = 0; i < 40; ++i) {
            succeed(&opened, svo_moving_set_transform(moving, i, large));
        }
        assert_fails(&opened, svo_moving_update(moving, NULL, NULL), SVO_CAPACITY_EXCEEDED,
                     by_area ? "max_area" : "fragment_capacity");
        const outcome after = outcome_of(&opened, svo_moving_tree(moving));
        assert_same(&after, &before);
        for (uint32_t i = 0; i < 40; ++i) {
            succeed(&opened, svo_moving_set_transform(moving, i, small));
        }
        update_moving(&opened, moving);
        compare_moving(&opened, moving, 6, &options);
        svo_moving_destroy(&moving);
        actors_destroy(&made);
    }
}

/* ---- memory ---- */

static uint64_t nothing_else(const svo_moving *moving)
{
    (void)moving;
    return 0;
}

/* Over ten thousand updates where SVOCL_LONG_TESTS is set (tools/dev long). */
static void memory_is_flat(void **state)
{
    (void)state;
    check_memory_is_flat(suite_is_long() ? 10000 : 3000, update_moving, nothing_else);
}

TEST_GROUP(moving)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hundred_moves_equal_full_builds),
        cmocka_unit_test(every_kind_of_request_can_move),
        cmocka_unit_test(pairs_are_dropped_while_objects_move),
        cmocka_unit_test(deep_grids_can_move),
        cmocka_unit_test(all_may_leave_the_grid),
        cmocka_unit_test(objects_come_and_go),
        cmocka_unit_test(reports_count_what_changed),
        cmocka_unit_test(light_is_that_of_full_builds),
        cmocka_unit_test(wrong_transforms_are_refused),
        cmocka_unit_test(wrong_meshes_are_refused),
        cmocka_unit_test(what_does_not_fit_leaves_the_tree),
        cmocka_unit_test(memory_is_flat),
    };
    return cmocka_run_group_tests_name("moving", tests, fixture_group_setup, fixture_group_teardown);
}
