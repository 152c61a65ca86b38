/* SPDX-License-Identifier: MIT */
/*
 * Projected areas of scenes that move: after each update the tree is that of a full build, and triangles count from one
 * side exactly while the scene's mesh is closed, which may take several objects. Light follows.
 */
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
#include "support/solid_meshes.h"
#include "support/suite.h"

#define DEPTH 5
#define EDGE  16.0

/* A closed ball, a box without its last face, and that face. Together they are closed where the latter two fit. */
enum { BALL, BOX, LID, KINDS };

typedef struct solids {
    parts room, shapes[KINDS];
    svo_mesh meshes[KINDS];
} solids;

typedef struct stage {
    solids made;
    svo_moving_options options;
    svo_moving *moving;
    bool visible[KINDS];
    double shift[KINDS];
} stage;

/* Gives each triangle vertices of its own. */
static void split(parts *shape)
{
    double *positions = malloc(shape->triangle_count * 9 * sizeof *positions);
    assert_non_null(positions);
    for (size_t i = 0; i < shape->triangle_count * 3; ++i) {
        memcpy(positions + 3 * i, shape->positions + (size_t)shape->indices[i] * 3, 3 * sizeof *positions);
        shape->indices[i] = (uint32_t)i;
    }
    free(shape->positions);
    shape->positions = positions;
    shape->vertex_count = shape->triangle_count * 3;
}

static void solids_create(solids *out)
{
    const double center[3] = {2, 2, 2};
    *out = (solids){.room = {.vertex_count = 0}};
    parts_add_cube(&out->room, 0.25, EDGE - 0.25, true, -1);
    parts_add_sphere(&out->shapes[BALL], center, 2.3, 4);
    split(&out->shapes[BALL]);
    parts_add_cube(&out->shapes[BOX], 1, 5, false, 5);
    parts_add_cube(&out->shapes[LID], 1, 5, false, -1);
    for (int i = 0; i < KINDS; ++i) {
        out->meshes[i] = parts_mesh(&out->shapes[i]);
    }
    out->meshes[LID].indices += 30; /* the face that the box lacks comes last */
    out->meshes[LID].triangle_count = 2;
}

static void solids_destroy(solids *made)
{
    parts_free(&made->room);
    for (int i = 0; i < KINDS; ++i) {
        parts_free(&made->shapes[i]);
    }
}

static void place(const fixture *opened, stage *on, uint32_t object, double shift)
{
    const double transform[12] = {1, 0, 0, shift, 0, 1, 0, 0.3 * shift, 0, 0, 1, 0.7 * shift};
    succeed(opened, svo_moving_set_transform(on->moving, object, transform));
    on->shift[object] = shift;
}

static void show(const fixture *opened, stage *on, uint32_t object, bool visible)
{
    succeed(opened, svo_moving_show(on->moving, object, visible));
    on->visible[object] = visible;
}

static void stage_create(const fixture *opened, svo_moving_options options, stage *out)
{
    *out = (stage){.options = options};
    out->options.edge = EDGE;
    out->options.max_area = 100 * EDGE * EDGE;
    solids_create(&out->made);
    const svo_mesh room = parts_mesh(&out->made.room);
    out->moving = make_moving(opened, &room, DEPTH, out->options);
    for (uint32_t i = 0; i < KINDS; ++i) {
        uint32_t object = KINDS;
        succeed(opened, svo_moving_add(out->moving, &out->made.meshes[i], NULL, &object));
        assert_int_equal(object, i);
        out->visible[i] = true;
    }
}

static void stage_destroy(stage *made)
{
    svo_moving_destroy(&made->moving);
    solids_destroy(&made->made);
}

static bool should_be_closed(const stage *on)
{
    return on->visible[BOX] == on->visible[LID] && (!on->visible[BOX] || on->shift[BOX] == on->shift[LID]);
}

/* Whether some leaf shows more to one side than to the other. */
static bool is_one_sided(const outcome *tree)
{
    bool found = false;
    for (size_t i = 0; i < (size_t)tree->info.leaf_count * 6; i += 2) {
        found = found || tree->arrays.areas[i] != tree->arrays.areas[i + 1];
    }
    return found;
}

/* Updates without waiting in between; where the room was too small, the next update has enough. */
static void update_later(const fixture *opened, svo_moving *moving)
{
    succeed(opened, svo_moving_update(moving, &(svo_submit){.queue = opened->queue}, NULL));
    svo_status status = svo_moving_finish(moving, NULL);
    if (status == SVO_CAPACITY_EXCEEDED) {
        succeed(opened, svo_moving_update(moving, &(svo_submit){.queue = opened->queue}, NULL));
        status = svo_moving_finish(moving, NULL);
    }
    succeed(opened, status);
}

/* Returns whether the scene is closed. */
static bool update_and_compare(const fixture *opened, const stage *on, bool later)
{
    if (later) {
        update_later(opened, on->moving);
    } else {
        update_moving(opened, on->moving);
    }
    compare_moving(opened, on->moving, DEPTH, &on->options);
    const outcome tree = outcome_of(opened, svo_moving_tree(on->moving));
    assert_int_equal(is_one_sided(&tree), should_be_closed(on));
    return should_be_closed(on);
}

/* Something moves, hides, appears, or goes and comes back; box and lid often fit. Places reach outside the grid. */
static void play(const fixture *opened, stage *on, uint64_t *seed)
{
    uint32_t object = random_below(seed, KINDS);
    const double shift = -3.0 + 6.5 * random_below(seed, 3);
    switch (random_below(seed, 6)) {
    case 0:
        show(opened, on, object, !on->visible[object]);
        break;
    case 1:
        succeed(opened, svo_moving_remove(on->moving, object));
        succeed(opened, svo_moving_add(on->moving, &on->made.meshes[object], NULL, &object));
        on->visible[object] = true;
        on->shift[object] = 0.0;
        break;
    case 2:
    case 3:
        place(opened, on, BOX, shift);
        place(opened, on, LID, shift);
        break;
    default:
        place(opened, on, object, shift);
    }
}

static void compare_moves(const fixture *opened, svo_moving_options options, bool later)
{
    enum { MOVES = 16 };
    uint64_t seed = 3;
    int closed = 0;
    stage on;
    stage_create(opened, options, &on);
    for (int i = 0; i < MOVES; ++i) {
        closed += update_and_compare(opened, &on, later) ? 1 : 0;
        play(opened, &on, &seed);
    }
    assert_in_range(closed, MOVES / 4, MOVES - MOVES / 4);
    stage_destroy(&on);
}

static void areas_follow_what_closes_and_opens(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL |
                                                (uint32_t)SVO_NEED_PROJECTED_AREA};
    compare_moves(&opened, options, false);
    compare_moves(&opened, options, true);
}

static void areas_need_no_other_payload(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {
        .need = SVO_NEED_PROJECTED_AREA, .coverage = SVO_COVERAGE_CLOSED, .weights = SVO_WEIGHTS_UNIFORM};
    compare_moves(&opened, options, false);
    compare_moves(&opened, options, true);
}

/* What lies outside the grid counts, too, also where triangles outside share no vertices with those inside. */
static void parts_outside_the_grid_close_the_scene(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL |
                                                (uint32_t)SVO_NEED_PROJECTED_AREA};
    stage on;
    stage_create(&opened, options, &on);
    for (int i = 0; i < 4; ++i) {
        place(&opened, &on, BALL, i % 2 == 0 ? -3.0 : 12.0);
        assert_true(update_and_compare(&opened, &on, i >= 2));
    }
    place(&opened, &on, LID, -40.0);
    assert_false(update_and_compare(&opened, &on, false));
    place(&opened, &on, BOX, -40.0);
    assert_true(update_and_compare(&opened, &on, true));
    stage_destroy(&on);
}

/* The same in an updatable plan, as objects are: the tree is that of another plan. */
static void updatable_plans_see_what_lies_outside(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_plan_options options = {
        .need = SVO_NEED_PROJECTED_AREA, .origin = {2, 2, 2}, .edge = EDGE, .weight_log2 = 20, .updatable = 1};
    outcome trees[2];
    solids made;
    solids_create(&made);
    for (int i = 0; i < 2; ++i) {
        svo_tree *tree = NULL;
        svo_plan *plan = make_plan(&opened, &made.meshes[BALL], DEPTH, options);
        succeed(&opened, svo_build(plan, opened.frontend, opened.queue, &tree, NULL));
        trees[i] = outcome_of(&opened, tree);
        assert_true(is_one_sided(&trees[i]));
        svo_tree_destroy(&tree);
        svo_plan_destroy(&plan);
        options.updatable = 0;
    }
    assert_string_equal(trees[0].hash, trees[1].hash);
    solids_destroy(&made);
}

/* A lid that moves while it is hidden is elsewhere when it is shown again; other vertices count too. */
static void hidden_objects_move(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL |
                                                (uint32_t)SVO_NEED_PROJECTED_AREA};
    stage on;
    stage_create(&opened, options, &on);
    assert_true(update_and_compare(&opened, &on, false));
    show(&opened, &on, LID, false);
    place(&opened, &on, LID, 2.0);
    assert_false(update_and_compare(&opened, &on, false));
    show(&opened, &on, LID, true);
    assert_false(update_and_compare(&opened, &on, true));
    place(&opened, &on, BOX, 2.0);
    assert_true(update_and_compare(&opened, &on, true));
    on.made.shapes[LID].positions[3 * 7 + 2] += 1.0; /* of a corner of the lid */
    succeed(&opened, svo_moving_set_vertices(on.moving, LID, &on.made.meshes[LID]));
    on.shift[LID] = 3.0; /* it does not fit */
    assert_false(update_and_compare(&opened, &on, false));
    stage_destroy(&on);
}

static svo_light *make_light(const fixture *opened, svo_tree *tree, svo_light_form form)
{
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {8.0F, 13.0F, 9.0F}, .value = {3, 2, 1}};
    const svo_light_options options = {.struct_size = sizeof options, .form = form};
    const svo_light_setup setup = {.struct_size = sizeof setup, .sources = &lamp, .source_count = 1, .updatable = 1};
    svo_light *light = NULL;
    succeed(opened, svo_light_create(tree, &options, opened->queue, &light));
    succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
    return light;
}

/* Updates a light, after one object has changed, and compares it with a new one. */
static void update_light(const fixture *opened, const stage *on, svo_light *light, svo_light_form form)
{
    char actual[SVO_HASH_TEXT_BYTES], expected[SVO_HASH_TEXT_BYTES];
    svo_box boxes[3];
    size_t count = 0;
    svo_tree *tree = svo_moving_tree(on->moving);
    succeed(opened, svo_moving_get_changes(on->moving, boxes, 3, &count));
    assert_int_equal(count, 2); /* the lid and the grid */
    succeed(opened, svo_light_update(light, tree, boxes, count, opened->queue));
    svo_light *anew = make_light(opened, tree, form);
    succeed(opened, svo_light_hash(light, opened->queue, actual));
    succeed(opened, svo_light_hash(anew, opened->queue, expected));
    assert_string_equal(actual, expected);
    svo_light_destroy(&anew);
}

/* Opening and closing the scene change the opacity of leaves everywhere, far from what moved. */
static void light_follows_areas(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = SVO_NEED_ALL};
    stage on;
    stage_create(&opened, options, &on);
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        assert_true(update_and_compare(&opened, &on, false));
        svo_light *light = make_light(&opened, svo_moving_tree(on.moving), (svo_light_form)form);
        for (int i = 0; i < 4; ++i) {
            show(&opened, &on, LID, i % 2 == 1);
            assert_int_equal(update_and_compare(&opened, &on, i % 2 == 0), i % 2);
            update_light(&opened, &on, light, (svo_light_form)form);
        }
        svo_light_destroy(&light);
    }
    stage_destroy(&on);
}

/* Pairs take 16 bytes more, and only with areas. */
static void areas_are_left_out(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_moving_info info[2] = {SVO_MOVING_INFO_INIT, SVO_MOVING_INFO_INIT};
    solids made;
    solids_create(&made);
    const svo_mesh room = parts_mesh(&made.room);
    for (int i = 0; i < 2; ++i) {
        const svo_moving_options options = {.need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL |
                                                    (i == 0 ? 0 : (uint32_t)SVO_NEED_PROJECTED_AREA),
                                            .edge = EDGE};
        svo_moving *moving = make_moving(&opened, &room, DEPTH, options);
        succeed(&opened, svo_moving_get_info(moving, &info[i]));
        svo_moving_destroy(&moving);
    }
    assert_int_equal(info[1].fragments, info[0].fragments);
    assert_int_equal(info[1].list_bytes - info[0].list_bytes, 16 * info[0].fragments);
    solids_destroy(&made);
}

TEST_GROUP(moving_area)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_follow_what_closes_and_opens),
        cmocka_unit_test(areas_need_no_other_payload),
        cmocka_unit_test(parts_outside_the_grid_close_the_scene),
        cmocka_unit_test(updatable_plans_see_what_lies_outside),
        cmocka_unit_test(hidden_objects_move),
        cmocka_unit_test(light_follows_areas),
        cmocka_unit_test(areas_are_left_out),
    };
    return cmocka_run_group_tests_name("moving_area", tests, fixture_group_setup, fixture_group_teardown);
}
