/* SPDX-License-Identifier: MIT */
/*
 * Updates of scenes that move, without waiting: once finished, the tree is that of a full build, byte for byte; nothing
 * waits before; wait events hold an update back, and the tree before stays until then; what has too little room, or
 * fails, leaves that tree; memory is flat.
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
#include "support/counting.h"
#include "support/enqueued.h"
#include "support/info_of.h"
#include "support/suite.h"

static const uint32_t everything = SVO_NEED_ALL;
static const double small[12] = {0.01, 0, 0, 0.5, 0, 0.01, 0, 0.5, 0, 0, 0.01, 0.5};
static const double large[12] = {0.9, 0, 0, 0, 0, 0.9, 0, 0, 0, 0, 0.9, 0};

static void enqueue(const fixture *opened, svo_moving *moving, cl_command_queue queue)
{
    counting_begin();
    succeed(opened, svo_moving_update(moving, &(svo_submit){.queue = queue}, NULL));
    assert_int_equal(counting_read().waits, 0);
}

/* Updates without waiting. Where the room was too small, the next update has enough. Returns whether that was so. */
static bool update_later(const fixture *opened, svo_moving *moving, cl_command_queue queue)
{
    enqueue(opened, moving, queue);
    const svo_status status = svo_moving_finish(moving, NULL);
    if (status == SVO_CAPACITY_EXCEEDED) {
        enqueue(opened, moving, queue);
        succeed(opened, svo_moving_finish(moving, NULL));
        return true;
    }
    succeed(opened, status);
    return false;
}

static cl_command_queue make_unordered(const fixture *opened)
{
    cl_int error = CL_SUCCESS;
    cl_command_queue queue =
        clCreateCommandQueue(info_of_device(opened->device).context, info_of_device(opened->device).device,
                             CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
    assert_int_equal(error, CL_SUCCESS);
    return queue;
}

/* ---- equality ---- */

/* One of the objects moves, hides or appears; sometimes it goes and comes back. */
static void play(const fixture *opened, svo_moving *moving, const actors *of, uint64_t *seed, bool *visible)
{
    double transform[12];
    uint32_t object = random_below(seed, OBJECTS);
    const uint32_t act = random_below(seed, 8);
    random_transform(seed, transform);
    if (act == 0) {
        visible[object] = !visible[object];
        succeed(opened, svo_moving_show(moving, object, visible[object]));
    } else if (act == 1) {
        succeed(opened, svo_moving_remove(moving, object));
        succeed(opened, svo_moving_add(moving, &of->objects[object].mesh, transform, &object));
        visible[object] = true;
    } else {
        succeed(opened, svo_moving_set_transform(moving, object, transform));
    }
}

static void compare_moves(const fixture *opened, uint64_t seed, int moves, unsigned depth, svo_moving_options options)
{
    actors made;
    bool visible[OBJECTS] = {true, true, true, true, true};
    int too_small = 0;
    cl_command_queue unordered = make_unordered(opened);
    actors_create(seed, 120, seed % 2 == 0, &made);
    options.max_area = 40.0;
    svo_moving *moving = make_stage(opened, &made, depth, options);
    for (int i = 0; i < moves; ++i) {
        too_small += update_later(opened, moving, i % 2 == 0 ? opened->queue : unordered) ? 1 : 0;
        compare_moving(opened, moving, depth, &options);
        for (uint32_t k = random_below(&seed, 3) + 1; k > 0; --k) {
            play(opened, moving, &made, &seed, visible);
        }
    }
    assert_true(too_small <= (moves + 1) / 2);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
    clReleaseCommandQueue(unordered);
}

static void enqueued_moves_equal_full_builds(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .edge = 1.0};
    compare_moves(&opened, 4, 20, 6, options);
}

static void every_kind_of_request_can_be_enqueued(void **state)
{
    static const uint32_t needs[] = {SVO_NEED_NONE, SVO_NEED_RAYS, SVO_NEED_MATERIAL, SVO_NEED_COLOR | SVO_NEED_NORMAL};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        const svo_moving_options options = {.need = needs[i],
                                            .coverage = (svo_coverage)(i % 3),
                                            .weights = (svo_weights)(i % 3),
                                            .payload_level = (uint32_t)i % 3,
                                            .origin = {-0.1, 0.0, 0.2},
                                            .edge = 0.9};
        compare_moves(&opened, 70 + i, 3, i == 1 ? 1 : 7, options);
    }
    compare_moves(&opened, 14, 3, 6, (svo_moving_options){.need = everything, .edge = 1.0, .drop_alpha = 0.3});
    compare_moves(&opened, 12, 3, 11, (svo_moving_options){.need = everything, .origin = {0.4, 0.4, 0.4}, .edge = 60});
}

/* The last object leaves a grid in which there is nothing else, and returns. */
static void a_scene_may_become_empty(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .origin = {10, 10, 10}, .edge = 1.0, .max_area = 40.0};
    const double inside[12] = {0.5, 0, 0, 10.2, 0, 0.5, 0, 10.2, 0, 0, 0.5, 10.1};
    const double away[12] = {1, 0, 0, -4, 0, 1, 0, 0, 0, 0, 1, 0};
    uint32_t object = 0;
    actors made;
    actors_create(8, 60, true, &made);
    svo_moving *moving = make_moving(&opened, &made.room.mesh, 5, options);
    succeed(&opened, svo_moving_add(moving, &made.objects[1].mesh, inside, &object));
    for (int i = 0; i < 4; ++i) {
        (void)update_later(&opened, moving, opened.queue);
        compare_moving(&opened, moving, 5, &options);
        succeed(&opened, svo_moving_set_transform(moving, object, i % 2 == 0 ? away : inside));
    }
    succeed(&opened, svo_moving_show(moving, object, 0));
    (void)update_later(&opened, moving, opened.queue);
    compare_moving(&opened, moving, 5, &options);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

static void reports_count_what_changed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = SVO_NEED_NORMAL, .edge = 1.0, .max_area = 40.0};
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    svo_moving_object before = SVO_MOVING_OBJECT_INIT;
    svo_moving_object after = SVO_MOVING_OBJECT_INIT;
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    actors made;
    actors_create(10, 80, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 6, options);
    update_moving(&opened, moving);
    const svo_tree *tree = svo_moving_tree(moving);
    enqueue(&opened, moving, opened.queue); /* nothing has changed */
    succeed(&opened, svo_moving_finish(moving, &report));
    assert_int_equal(report.changed_objects, 0);
    assert_ptr_equal(svo_moving_tree(moving), tree);
    succeed(&opened, svo_moving_get_object(moving, 0, &before));
    succeed(&opened, svo_moving_set_transform(moving, 0, small));
    enqueue(&opened, moving, opened.queue);
    succeed(&opened, svo_moving_finish(moving, &report));
    succeed(&opened, svo_moving_get_object(moving, 0, &after));
    succeed(&opened, svo_moving_get_info(moving, &info));
    assert_int_equal(report.changed_objects, 1);
    assert_int_equal(report.changed_fragments, before.fragments + after.fragments);
    assert_int_equal(report.fragments, info.fragments);
    assert_true(report.total_ms > 0.0);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* ---- events ---- */

static cl_int status_of(cl_event event)
{
    cl_int status = CL_QUEUED;
    assert_int_equal(clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, NULL),
                     CL_SUCCESS);
    return status;
}

/* Until the caller's event has come, the update has not happened and the tree before is what it was. */
static void an_update_waits_for_events(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .edge = 1.0, .max_area = 40.0};
    cl_command_queue unordered = make_unordered(&opened);
    actors made;
    actors_create(4, 80, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 6, options);
    update_moving(&opened, moving);
    const outcome before = outcome_of(&opened, svo_moving_tree(moving));
    for (int i = 0; i < 2; ++i) {
        cl_event gate = clCreateUserEvent(info_of_device(opened.device).context, NULL);
        cl_event done = NULL;
        succeed(&opened, svo_moving_set_transform(moving, 1, i == 0 ? small : large));
        counting_begin();
        succeed(&opened,
                svo_moving_update(
                    moving, &(svo_submit){.queue = unordered, .num_wait = 1, .wait = &gate, .event = &done}, NULL));
        assert_int_equal(counting_read().waits, 0);
        assert_true(status_of(done) > CL_COMPLETE);
        const outcome during = outcome_of(&opened, svo_moving_tree(moving));
        if (i == 0) {
            assert_same(&during, &before);
        }
        assert_true(status_of(done) > CL_COMPLETE);
        assert_int_equal(clSetUserEventStatus(gate, CL_COMPLETE), CL_SUCCESS);
        if (svo_moving_finish(moving, NULL) == SVO_CAPACITY_EXCEEDED) {
            (void)update_later(&opened, moving, unordered);
        }
        assert_int_equal(status_of(done), CL_COMPLETE);
        compare_moving(&opened, moving, 6, &options);
        clReleaseEvent(done);
        clReleaseEvent(gate);
    }
    svo_moving_destroy(&moving);
    actors_destroy(&made);
    clReleaseCommandQueue(unordered);
}

/* ---- reports ---- */

static void assert_fails(const fixture *opened, svo_status actual, svo_status expected, const char *words)
{
    assert_int_equal(actual, expected);
    if (strstr(svo_device_message(opened->device), words) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", svo_device_message(opened->device), words);
    }
}

/* How often an update waits that moves an object. */
static uint64_t count_waits(const fixture *opened, svo_moving *moving, const svo_submit *submit,
                            svo_moving_report *report)
{
    succeed(opened, svo_moving_set_transform(moving, 1, small));
    counting_begin();
    succeed(opened, svo_moving_update(moving, submit, report));
    return counting_read().waits;
}

/* On the caller's queue, after the caller's events. Between stages waits only who wants their times. */
static void an_update_with_a_report_waits(void **state)
{
    enum { LARGE_BYTES = 64 << 20 };
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .edge = 1.0, .max_area = 40.0};
    const cl_uint byte = 1;
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    cl_event first = NULL;
    cl_event done = NULL;
    cl_command_queue unordered = make_unordered(&opened);
    cl_mem buffer = clCreateBuffer(info_of_device(opened.device).context, CL_MEM_READ_WRITE, LARGE_BYTES, NULL, NULL);
    actors made;
    actors_create(4, 80, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 6, options);
    assert_non_null(buffer);
    assert_true(count_waits(&opened, moving, NULL, NULL) > 0); /* the other objects come too */
    const uint64_t waits = count_waits(&opened, moving, NULL, NULL);
    assert_true(count_waits(&opened, moving, NULL, &report) > waits);
    assert_int_equal(clEnqueueFillBuffer(opened.queue, buffer, &byte, sizeof byte, 0, LARGE_BYTES, 0, NULL, &first),
                     CL_SUCCESS);
    assert_int_equal(clFlush(opened.queue), CL_SUCCESS);
    report = (svo_moving_report)SVO_MOVING_REPORT_INIT;
    const svo_submit submit = {.queue = unordered, .num_wait = 1, .wait = &first, .event = &done};
    assert_true(count_waits(&opened, moving, &submit, &report) > waits);
    assert_int_equal(status_of(first), CL_COMPLETE);
    assert_int_equal(status_of(done), CL_COMPLETE);
    assert_int_equal(report.changed_objects, 1);
    assert_true(report.changed_fragments > 0 && report.total_ms > 0 && report.nodes_ms > 0);
    assert_fails(&opened, svo_moving_finish(moving, NULL), SVO_INVALID_ARGUMENT, "no update is in flight");
    compare_moving(&opened, moving, 6, &options);
    clReleaseEvent(first);
    clReleaseEvent(done);
    clReleaseMemObject(buffer);
    clReleaseCommandQueue(unordered);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* The update is then not made, or stays in flight. */
static void a_report_of_no_size_is_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = SVO_NEED_NORMAL, .edge = 1.0, .max_area = 40.0};
    const svo_submit submit = {.queue = opened.queue};
    svo_moving_report report = {.struct_size = 4};
    actors made;
    actors_create(3, 60, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 5, options);
    const svo_tree *tree = svo_moving_tree(moving);
    assert_fails(&opened, svo_moving_update(moving, &submit, &report), SVO_INVALID_ARGUMENT,
                 "svo_moving_update: report.struct_size is 4");
    assert_fails(&opened, svo_moving_update(moving, NULL, &report), SVO_INVALID_ARGUMENT,
                 "svo_moving_update: report.struct_size is 4");
    assert_ptr_equal(svo_moving_tree(moving), tree);
    enqueue(&opened, moving, opened.queue);
    assert_fails(&opened, svo_moving_finish(moving, &report), SVO_INVALID_ARGUMENT,
                 "svo_moving_finish: report.struct_size is 4");
    succeed(&opened, svo_moving_finish(moving, NULL));
    compare_moving(&opened, moving, 5, &options);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* ---- failures ---- */

static void too_little_room_is_told_and_grows(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .edge = 1.0, .max_area = 400.0};
    uint32_t object = 0;
    actors made;
    actors_create(2, 400, true, &made);
    svo_moving *moving = make_moving(&opened, &made.room.mesh, 7, options);
    succeed(&opened, svo_moving_add(moving, &made.objects[4].mesh, small, &object));
    update_moving(&opened, moving);
    const outcome before = outcome_of(&opened, svo_moving_tree(moving));
    succeed(&opened, svo_moving_set_transform(moving, object, large));
    enqueue(&opened, moving, opened.queue);
    assert_fails(&opened, svo_moving_finish(moving, NULL), SVO_CAPACITY_EXCEEDED, "object 0 has ");
    const outcome after = outcome_of(&opened, svo_moving_tree(moving));
    assert_same(&after, &before);
    assert_false(update_later(&opened, moving, opened.queue));
    compare_moving(&opened, moving, 7, &options);
    succeed(&opened, svo_moving_set_transform(moving, object, small)); /* room does not shrink */
    assert_false(update_later(&opened, moving, opened.queue));
    succeed(&opened, svo_moving_set_transform(moving, object, large));
    assert_false(update_later(&opened, moving, opened.queue));
    compare_moving(&opened, moving, 7, &options);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* The limits of the scene: the tree stays what it was until the scene fits again. */
static void what_does_not_fit_leaves_the_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (int by_area = 0; by_area < 2; ++by_area) {
        svo_moving_options options = {.need = everything, .edge = 1.0, .max_area = 40.0};
        svo_moving_info info = SVO_MOVING_INFO_INIT;
        actors made;
        uint32_t object = 0;
        actors_create(2, 100, true, &made);
        svo_moving *moving = make_moving(&opened, &made.room.mesh, 6, options);
        succeed(&opened, svo_moving_get_info(moving, &info));
        options.max_area = by_area ? info.area * 1.01 : options.max_area;
        options.fragment_capacity = by_area ? 0 : info.fragments + 2000;
        svo_moving_destroy(&moving);
        moving = make_moving(&opened, &made.room.mesh, 6, options);
        for (int i = 0; i < 10; ++i) {
            succeed(&opened, svo_moving_add(moving, &made.objects[4].mesh, large, &object));
        }
        const outcome before = outcome_of(&opened, svo_moving_tree(moving));
        for (int i = 0; i < 3; ++i) { /* too little room for the objects at first, perhaps */
            enqueue(&opened, moving, opened.queue);
            assert_int_equal(svo_moving_finish(moving, NULL), SVO_CAPACITY_EXCEEDED);
        }
        assert_non_null(strstr(svo_device_message(opened.device), by_area ? "max_area" : "fragment_capacity"));
        const outcome after = outcome_of(&opened, svo_moving_tree(moving));
        assert_same(&after, &before);
        for (uint32_t i = 0; i < 10; ++i) {
            succeed(&opened, svo_moving_set_transform(moving, i, small));
        }
        (void)update_later(&opened, moving, opened.queue);
        compare_moving(&opened, moving, 6, &options);
        svo_moving_destroy(&moving);
        actors_destroy(&made);
    }
}

static void a_scene_in_flight_is_left_alone(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = SVO_NEED_NORMAL, .edge = 1.0, .max_area = 40.0};
    static const char words[] = "an update is in flight";
    uint32_t object = 0;
    actors made;
    actors_create(3, 60, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 5, options);
    assert_fails(&opened, svo_moving_finish(moving, NULL), SVO_INVALID_ARGUMENT, "no update is in flight");
    assert_int_equal(svo_moving_update(moving, &(svo_submit){.queue = opened.queue, .num_wait = 1, .wait = NULL}, NULL),
                     SVO_INVALID_ARGUMENT);
    enqueue(&opened, moving, opened.queue);
    assert_fails(&opened, svo_moving_set_transform(moving, 0, small), SVO_INVALID_ARGUMENT, words);
    assert_fails(&opened, svo_moving_set_vertices(moving, 0, &made.objects[0].mesh), SVO_INVALID_ARGUMENT, words);
    assert_fails(&opened, svo_moving_show(moving, 0, 0), SVO_INVALID_ARGUMENT, words);
    assert_fails(&opened, svo_moving_remove(moving, 0), SVO_INVALID_ARGUMENT, words);
    assert_fails(&opened, svo_moving_add(moving, &made.objects[0].mesh, NULL, &object), SVO_INVALID_ARGUMENT, words);
    assert_fails(&opened, svo_moving_update(moving, NULL, NULL), SVO_INVALID_ARGUMENT, words);
    assert_fails(&opened, svo_moving_update(moving, &(svo_submit){.queue = opened.queue}, NULL), SVO_INVALID_ARGUMENT,
                 words);
    succeed(&opened, svo_moving_finish(moving, NULL));
    compare_moving(&opened, moving, 5, &options);
    succeed(&opened, svo_moving_set_transform(moving, 0, small));
    enqueue(&opened, moving, opened.queue);
    svo_moving_destroy(&moving); /* waits */
    actors_destroy(&made);
}

/* Each launch of an update fails once. The scene is as before, and the next update succeeds. */
static void a_failure_leaves_the_tree(void **state)
{
    enum { LAUNCHES_MAX = 500, STEP = 11 };
    const fixture opened = fixture_cl_of_group(state);
    const svo_moving_options options = {.need = everything, .edge = 1.0, .max_area = 40.0};
    uint64_t failed = 1;
    size_t failures = 0;
    actors made;
    actors_create(3, 60, true, &made);
    svo_moving *moving = make_stage(&opened, &made, 4, options);
    update_moving(&opened, moving);
    const outcome before = outcome_of(&opened, svo_moving_tree(moving));
    for (size_t i = 0; i < LAUNCHES_MAX && failed > 0; i += STEP) {
        succeed(&opened, svo_moving_set_transform(moving, 1, large));
        succeed(&opened, svo_moving_show(moving, 2, 0));
        counting_begin();
        counting_fail_launch(i);
        const svo_status status = svo_moving_update(moving, &(svo_submit){.queue = opened.queue}, NULL);
        failed = counting_read().failed_launches;
        counting_begin();
        if (failed > 0) {
            assert_int_equal(status, SVO_CL_ERROR);
            const outcome after = outcome_of(&opened, svo_moving_tree(moving));
            assert_same(&after, &before);
            succeed(&opened, svo_moving_show(moving, 2, 1));
            ++failures;
        }
    }
    assert_true(failures > 4);
    if (svo_moving_finish(moving, NULL) != SVO_OK) {
        (void)update_later(&opened, moving, opened.queue);
    }
    compare_moving(&opened, moving, 4, &options);
    svo_moving_destroy(&moving);
    actors_destroy(&made);
}

/* ---- memory ---- */

static void update_and_finish(const fixture *opened, svo_moving *moving)
{
    cl_command_queue queue = make_unordered(opened);
    succeed(opened, svo_moving_update(moving, &(svo_submit){.queue = queue}, NULL));
    succeed(opened, svo_moving_finish(moving, NULL));
    clReleaseCommandQueue(queue);
}

static uint64_t buffers_of(const svo_moving *moving)
{
    (void)moving;
    return counting_read().live_buffers;
}

static void memory_is_flat(void **state)
{
    (void)state;
    counting_begin();
    check_memory_is_flat(2000, update_and_finish, buffers_of);
}

TEST_GROUP(moving_enqueue)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(enqueued_moves_equal_full_builds),  cmocka_unit_test(every_kind_of_request_can_be_enqueued),
        cmocka_unit_test(a_scene_may_become_empty),          cmocka_unit_test(reports_count_what_changed),
        cmocka_unit_test(an_update_waits_for_events),        cmocka_unit_test(an_update_with_a_report_waits),
        cmocka_unit_test(a_report_of_no_size_is_refused),    cmocka_unit_test(too_little_room_is_told_and_grows),
        cmocka_unit_test(what_does_not_fit_leaves_the_tree), cmocka_unit_test(a_scene_in_flight_is_left_alone),
        cmocka_unit_test(a_failure_leaves_the_tree),         cmocka_unit_test(memory_is_flat),
    };
    return cmocka_run_group_tests_name("moving_enqueue", tests, fixture_group_setup, fixture_group_teardown);
}
