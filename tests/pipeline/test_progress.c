/* SPDX-License-Identifier: MIT */
/*
 * Progress and cancellation: fractions never fall and end at 1, the tree is the same with a callback, and a call that
 * is stopped at any of its callbacks says so, leaves nothing behind, and can be made again.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "scenes.h"
#include "support/attributed_mesh.h"
#include "support/counting.h"
#include "support/fixture.h"
#include "support/suite.h"

/* What a callback has seen, and when it stops the call. */
typedef struct watcher {
    size_t calls;
    size_t stops_at; /* the call that it stops, counted from 1; 0: none */
    double first, last;
    bool falls;
    uint32_t stages; /* bits */
} watcher;

static int watch(void *user, svo_stage stage, double fraction)
{
    watcher *seen = user;
    seen->first = seen->calls == 0 ? fraction : seen->first;
    seen->falls = seen->falls || (seen->calls > 0 && fraction < seen->last);
    seen->last = fraction;
    seen->stages |= 1u << stage;
    ++seen->calls;
    return seen->calls == seen->stops_at;
}

static void assert_whole(const watcher *seen)
{
    assert_true(seen->calls >= 2);
    assert_false(seen->falls);
    assert_true(seen->first == 0.0);
    assert_true(seen->last == 1.0);
}

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

static void assert_canceled(const fixture *opened, svo_status status, const char *function)
{
    const char *message = svo_device_message(opened->device);
    if (status != SVO_CANCELED) {
        fail_msg("%s instead of SVO_CANCELED: %s", svo_name(SVO_NAME_STATUS, status), message);
    }
    assert_memory_equal(message, function, strlen(function));
    assert_non_null(strstr(message, ": the progress callback stopped the call in stage "));
}

typedef svo_status builder(const fixture *opened, svo_plan *plan, svo_tree **out);

static svo_status build_blocking(const fixture *opened, svo_plan *plan, svo_tree **out)
{
    return svo_build(plan, opened->frontend, opened->queue, out, NULL);
}

static void hash_of(const fixture *opened, svo_tree *tree, char hash[SVO_HASH_TEXT_BYTES])
{
    succeed(opened, svo_tree_download(tree, opened->queue));
    succeed(opened, svo_tree_hash(tree, SVO_HASH_ALL, hash));
}

/* A plan whose creation is watched too. */
static svo_plan *watched_plan(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_plan_options options,
                              watcher *seen)
{
    svo_plan *plan = NULL;
    *seen = (watcher){0};
    options.struct_size = sizeof options;
    options.progress = watch;
    options.progress_user = seen;
    succeed(opened, svo_plan_create(opened->device, mesh, depth, &options, &plan));
    assert_whole(seen);
    assert_int_equal(seen->stages, 1u << SVO_STAGE_GRID);
    return plan;
}

/* Builds without a callback, with one, and stopped at every call of it. */
static void check_builds(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                         builder *build)
{
    char expected[SVO_HASH_TEXT_BYTES];
    char actual[SVO_HASH_TEXT_BYTES];
    svo_tree *tree = NULL;
    watcher seen;
    svo_plan *plan = watched_plan(opened, mesh, depth, *options, &seen);
    svo_plan_set_progress(plan, NULL, NULL);
    succeed(opened, build(opened, plan, &tree));
    hash_of(opened, tree, expected);
    svo_tree_destroy(&tree);
    seen = (watcher){0};
    svo_plan_set_progress(plan, watch, &seen);
    succeed(opened, build(opened, plan, &tree));
    assert_whole(&seen);
    hash_of(opened, tree, actual);
    assert_string_equal(actual, expected);
    svo_tree_destroy(&tree);
    const size_t calls = seen.calls;
    for (size_t stop = 1; stop <= calls; ++stop) {
        seen = (watcher){.stops_at = stop};
        counting_begin();
        assert_canceled(opened, build(opened, plan, &tree), "svo_");
        assert_null(tree);
        assert_int_equal(seen.calls, stop);
        assert_int_equal(counting_read().live_buffers, 0);
    }
    svo_plan_set_progress(plan, NULL, NULL);
    succeed(opened, build(opened, plan, &tree));
    hash_of(opened, tree, actual);
    assert_string_equal(actual, expected);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
}

static void builds_report_and_stop(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const svo_plan_options requests[] = {
        {.need = SVO_NEED_ALL},
        {.need = SVO_NEED_ALL, .builder = SVO_BUILDER_SORTED},
        {.need = SVO_NEED_ALL, .chunk_bytes = 65536}, /* several chunks */
        {.need = SVO_NEED_MATERIAL | SVO_NEED_COLOR, .fragment_capacity = 100}, /* a list that grows */
        {.need = SVO_NEED_NONE}};
    attributed_mesh made;
    attributed_mesh_create(6, 100, 0.1, &made);
    for (size_t i = 0; i < sizeof requests / sizeof requests[0]; ++i) {
        check_builds(&opened, &made.mesh, 6, &requests[i], build_blocking);
    }
    attributed_mesh_destroy(&made);
}

#ifdef HAVE_GL
static svo_status build_in_gl(const fixture *opened, svo_plan *plan, svo_tree **out)
{
    return svo_gl_build(opened->gl, plan, opened->queue, out, NULL);
}

static void builds_with_opengl_report_and_stop(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options requests[] = {{.need = SVO_NEED_COLOR | SVO_NEED_RAYS},
                                         {.need = SVO_NEED_DEFAULT, .chunk_bytes = 65536}};
    attributed_mesh made;
    attributed_mesh_create(6, 100, 0.1, &made);
    for (size_t i = 0; i < 2; ++i) {
        check_builds(opened, &made.mesh, 6, &requests[i], build_blocking);
        if (svo_gl_build_reason(opened->gl, requests[i].need)[0] == '\0') {
            check_builds(opened, &made.mesh, 6, &requests[i], build_in_gl);
        }
    }
    attributed_mesh_destroy(&made);
}
#endif

/* A callback divides large launches. The tree stays the same, and the fractions are spread over the build. */
static void large_launches_are_divided(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_COLOR, .struct_size = sizeof options, .place = SVO_PLACE_HOST};
    scene *made = fixture_scene("knot:600000");
    built expected;
    fixture_build(&opened, scene_mesh(made), 10, &options, &expected);
    watcher seen;
    svo_plan *plan = watched_plan(&opened, scene_mesh(made), 10, options, &seen);
    assert_true(seen.calls > 8); /* the host's work on many triangles is divided too */
    svo_tree *tree = NULL;
    char hash[SVO_HASH_TEXT_BYTES];
    seen = (watcher){0};
    counting_begin();
    succeed(&opened, svo_build(plan, opened.frontend, opened.queue, &tree, NULL));
    assert_whole(&seen);
    assert_true(seen.calls > 12);
    hash_of(&opened, tree, hash);
    assert_string_equal(hash, expected.hash);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    built_destroy(&expected);
    scene_destroy(&made);
}

static void plans_stop(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    watcher seen;
    scene *made = fixture_scene("knot:3000");
    svo_plan *plan = watched_plan(&opened, scene_mesh(made), 6, (svo_plan_options){0}, &seen);
    svo_plan_destroy(&plan);
    const size_t calls = seen.calls;
    for (size_t stop = 1; stop <= calls; ++stop) {
        seen = (watcher){.stops_at = stop};
        const svo_plan_options options = {.struct_size = sizeof options, .progress = watch, .progress_user = &seen};
        assert_canceled(&opened, svo_plan_create(opened.device, scene_mesh(made), 6, &options, &plan),
                        "svo_plan_create: ");
        assert_null(plan);
        assert_int_equal(seen.calls, stop);
    }
    scene_destroy(&made);
}

static void counts_stop_and_leave_the_plan(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    watcher seen;
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    scene *made = fixture_scene("knot:3000");
    svo_plan *plan = watched_plan(&opened, scene_mesh(made), 6, (svo_plan_options){0}, &seen);
    succeed(&opened, svo_plan_count(plan, opened.frontend, opened.queue)); /* compiles */
    seen = (watcher){0};
    succeed(&opened, svo_plan_count(plan, opened.frontend, opened.queue));
    assert_whole(&seen);
    const size_t calls = seen.calls;
    svo_plan_destroy(&plan);
    plan = watched_plan(&opened, scene_mesh(made), 6, (svo_plan_options){0}, &seen);
    for (size_t stop = 1; stop <= calls; ++stop) {
        seen = (watcher){.stops_at = stop};
        counting_begin();
        assert_canceled(&opened, svo_plan_count(plan, opened.frontend, opened.queue), "svo_plan_count: ");
        assert_int_equal(counting_read().live_buffers, 0);
        svo_plan_get_info(plan, &info);
        assert_int_equal(info.fragments, 0);
    }
    svo_plan_destroy(&plan);
    scene_destroy(&made);
}

/* A workspace compiles, which can be stopped; builds in it report nothing. */
static void workspaces_stop_while_they_compile(void **state)
{
    (void)state;
    fixture opened;
    fixture_open_cl(&(fixture_options){0}, &opened); /* a device of its own: nothing is compiled yet */
    watcher seen;
    scene *made = fixture_scene("cornell");
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    svo_plan *plan = watched_plan(&opened, scene_mesh(made), 5, (svo_plan_options){.need = SVO_NEED_COLOR}, &seen);
    for (size_t stop = 1; stop <= 3; ++stop) {
        seen = (watcher){.stops_at = stop};
        counting_begin();
        assert_canceled(&opened, svo_workspace_create(plan, opened.frontend, opened.queue, NULL, &workspace),
                        "svo_workspace_create: ");
        assert_int_equal(seen.stages, 1u << SVO_STAGE_COMPILE);
        assert_int_equal(counting_read().live_buffers, 0);
    }
    seen = (watcher){0};
    succeed(&opened, svo_workspace_create(plan, opened.frontend, opened.queue, NULL, &workspace));
    assert_whole(&seen);
    seen = (watcher){0};
    succeed(&opened, svo_workspace_make_tree(workspace, &tree));
    succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
    succeed(&opened, svo_tree_finish(tree, opened.queue, 0, NULL));
    assert_int_equal(seen.calls, 0);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    scene_destroy(&made);
    fixture_close(&opened);
}

TEST_GROUP(progress)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(builds_report_and_stop),
#ifdef HAVE_GL
        cmocka_unit_test(builds_with_opengl_report_and_stop),
#endif
        cmocka_unit_test(large_launches_are_divided),
        cmocka_unit_test(plans_stop),
        cmocka_unit_test(counts_stop_and_leave_the_plan),
        cmocka_unit_test(workspaces_stop_while_they_compile),
    };
    return cmocka_run_group_tests_name("progress", tests, fixture_group_setup, fixture_group_teardown);
}
