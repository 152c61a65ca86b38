/* SPDX-License-Identifier: MIT */
/*
 * The limits that a device handle is given: bytes of device memory, refused beforehand and while capacities grow, and
 * threads.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "core/memory.h"
#include "support/attributed_mesh.h"
#include "support/counting.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

enum { DEPTH = 7 };

/* A device of the group's context with a budget. */
static svo_device *limited_device(const fixture *opened, uint64_t max_bytes)
{
    const svo_device_options options = {.struct_size = sizeof options, .max_device_bytes = max_bytes};
    svo_device *device = NULL;
    svo_message message = {""};
    if (svo_device_create(info_of_device(opened->device).context, info_of_device(opened->device).device, &options,
                          &device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return device;
}

static void succeed(const svo_device *device, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(device));
    }
}

/* The call ran out of the budget. words: of the message. */
static void assert_refused(const svo_device *device, svo_status status, const char *words)
{
    const char *message = svo_device_message(device);
    if (status != SVO_OUT_OF_DEVICE_MEMORY) {
        fail_msg("%s instead of SVO_OUT_OF_DEVICE_MEMORY: %s", svo_name(SVO_NAME_STATUS, status), message);
    }
    if (strstr(message, words) == NULL || strstr(message, "max_device_bytes") == NULL) {
        fail_msg("\"%s\" names neither \"%s\" nor the limit", message, words);
    }
}

static svo_plan *plan_of(svo_device *device, const svo_mesh *mesh, uint64_t fragment_capacity)
{
    const svo_plan_options options = {.struct_size = sizeof options,
                                      .need = SVO_NEED_COLOR | SVO_NEED_RAYS,
                                      .fragment_capacity = fragment_capacity,
                                      .edge = 1.0};
    svo_plan *plan = NULL;
    succeed(device, svo_plan_create(device, mesh, DEPTH, &options, &plan));
    return plan;
}

/* What a build of the plan takes, at most and in the end. */
static void measure_build(const fixture *opened, const svo_mesh *mesh, uint64_t *peak_bytes, uint64_t *tree_bytes,
                          char hash[SVO_HASH_TEXT_BYTES])
{
    svo_tree *tree = NULL;
    svo_plan *plan = plan_of(opened->device, mesh, 0);
    *peak_bytes = info_of_plan(plan).peak_bytes;
    succeed(opened->device, svo_build(plan, NULL, NULL, &tree, NULL));
    *peak_bytes = info_of_plan(plan).peak_bytes > *peak_bytes ? info_of_plan(plan).peak_bytes : *peak_bytes;
    *tree_bytes = info_of_plan(plan).tree_bytes;
    succeed(opened->device, svo_tree_download(tree, NULL));
    succeed(opened->device, svo_tree_hash(tree, SVO_HASH_ALL, hash));
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
}

static void a_plan_above_the_budget_is_refused_beforehand(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    attributed_mesh made;
    attributed_mesh_create(6, 300, 0.1, &made);
    svo_plan *plan = plan_of(opened.device, &made.mesh, 0);
    const uint64_t predicted_bytes = info_of_plan(plan).peak_bytes;
    svo_plan_destroy(&plan);
    char words[128];
    snprintf(words, sizeof words, "svo_build: the scene needs about %s at depth %d", svo_i_bytes(predicted_bytes).text,
             (int)DEPTH);
    svo_device *device = limited_device(&opened, predicted_bytes - 1);
    svo_tree *tree = NULL;
    plan = plan_of(device, &made.mesh, 0);
    counting_begin();
    assert_refused(device, svo_build(plan, NULL, NULL, &tree, NULL), words);
    assert_null(tree);
    assert_int_equal(counting_read().buffers, 0);
    assert_int_equal(counting_read().programs, 0);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    attributed_mesh_destroy(&made);
}

/* Trees count as long as they live. */
static void a_budget_holds_for_all_that_lives(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    attributed_mesh made;
    uint64_t peak_bytes = 0;
    uint64_t tree_bytes = 0;
    char expected[SVO_HASH_TEXT_BYTES];
    char actual[SVO_HASH_TEXT_BYTES];
    attributed_mesh_create(6, 300, 0.1, &made);
    measure_build(&opened, &made.mesh, &peak_bytes, &tree_bytes, expected);
    const uint64_t max_bytes = peak_bytes + tree_bytes + tree_bytes / 2;
    svo_device *device = limited_device(&opened, max_bytes);
    svo_tree *trees[3] = {NULL};
    svo_plan *plan = plan_of(device, &made.mesh, 0);
    counting_begin();
    succeed(device, svo_build(plan, NULL, NULL, &trees[0], NULL));
    succeed(device, svo_build(plan, NULL, NULL, &trees[1], NULL));
    assert_in_range(counting_read().peak_bytes, peak_bytes / 2, max_bytes);
    assert_refused(device, svo_build(plan, NULL, NULL, &trees[2], NULL), "svo_build: the scene needs about ");
    svo_tree_destroy(&trees[0]);
    succeed(device, svo_build(plan, NULL, NULL, &trees[0], NULL));
    succeed(device, svo_tree_download(trees[0], NULL));
    succeed(device, svo_tree_hash(trees[0], SVO_HASH_ALL, actual));
    assert_string_equal(actual, expected);
    svo_tree_destroy(&trees[0]);
    svo_tree_destroy(&trees[1]);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    attributed_mesh_destroy(&made);
}

/* The prediction is too low by far: the list, of which a hundred fragments were expected, grows beyond the budget. */
static void a_list_does_not_grow_beyond_the_budget(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    owned_mesh corners;
    svo_tree *tree = NULL;
    corner_mesh(24, &corners); /* many times the fragments of the estimate */
    svo_plan *plan = plan_of(opened.device, &corners.mesh, 100);
    const uint64_t max_bytes = info_of_plan(plan).peak_bytes;
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    succeed(opened.device, svo_build(plan, NULL, NULL, &tree, &report));
    assert_true(report.reruns > 0);
    assert_true(info_of_plan(plan).peak_bytes > max_bytes);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    svo_device *device = limited_device(&opened, max_bytes);
    plan = plan_of(device, &corners.mesh, 100);
    counting_begin();
    assert_refused(device, svo_build(plan, NULL, NULL, &tree, NULL), "svo_build: buffer ");
    assert_null(tree);
    assert_int_equal(counting_read().live_buffers, 0);
    assert_in_range(counting_read().peak_bytes, 1, max_bytes);
    svo_plan_destroy(&plan);
    svo_device_destroy(&device);
    owned_mesh_free(&corners);
}

static void workspaces_keep_to_the_budget(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    attributed_mesh made;
    svo_workspace *workspace = NULL;
    svo_workspace_info info = SVO_WORKSPACE_INFO_INIT;
    attributed_mesh_create(6, 300, 0.1, &made);
    svo_plan *plan = plan_of(opened.device, &made.mesh, 0);
    succeed(opened.device, svo_workspace_measure(plan, opened.frontend, &info));
    svo_plan_destroy(&plan);
    for (int fits = 0; fits < 2; ++fits) {
        svo_device *device = limited_device(&opened, info.scratch_bytes + info.tree_bytes - 1 + (fits ? 4096u : 0u));
        svo_frontend *frontend = NULL;
        svo_tree *trees[2] = {NULL, NULL};
        succeed(device, svo_frontend_create_cl(device, &frontend));
        plan = plan_of(device, &made.mesh, 0);
        counting_begin();
        const svo_status status = svo_workspace_create(plan, frontend, opened.queue, NULL, &workspace);
        if (fits) {
            succeed(device, status);
            succeed(device, svo_workspace_make_tree(workspace, &trees[0]));
            assert_refused(device, svo_workspace_make_tree(workspace, &trees[1]), "svo_workspace_make_tree: buffer ");
        } else {
            assert_refused(device, status, "svo_workspace_create: the scene needs about ");
            assert_int_equal(counting_read().buffers, 0);
        }
        svo_tree_destroy(&trees[0]);
        svo_workspace_destroy(&workspace);
        svo_plan_destroy(&plan);
        svo_frontend_destroy(&frontend);
        svo_device_destroy(&device);
    }
    attributed_mesh_destroy(&made);
}

/* A device made with a limit of threads has as many compute units, and makes the same tree. */
static void threads_are_limited(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cl_uint units = 0;
    clGetDeviceInfo(info_of_device(opened.device).device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL);
    if (units < 2) {
        print_message("skipped: the device has one compute unit\n");
        skip();
    }
    attributed_mesh made;
    uint64_t bytes = 0;
    char expected[SVO_HASH_TEXT_BYTES];
    char actual[SVO_HASH_TEXT_BYTES];
    attributed_mesh_create(6, 300, 0.1, &made);
    measure_build(&opened, &made.mesh, &bytes, &bytes, expected);
    for (cl_uint threads = 1; threads <= units + 1; threads += units) {
        const svo_device_options options = {.struct_size = sizeof options, .max_threads = threads};
        fixture limited = {0};
        svo_message message = {""};
        const svo_status status = svo_device_create_default(&options, &limited.device, &message);
        if (status == SVO_UNSUPPORTED) {
            print_message("skipped: %s\n", message.text);
            attributed_mesh_destroy(&made);
            skip();
        }
        if (status != SVO_OK) {
            fail_msg("%s", message.text);
        }
        cl_uint limited_units = 0;
        clGetDeviceInfo(info_of_device(limited.device).device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof limited_units,
                        &limited_units, NULL);
        assert_int_equal(limited_units, threads < units ? threads : units);
        measure_build(&limited, &made.mesh, &bytes, &bytes, actual);
        assert_string_equal(actual, expected);
        svo_device_destroy(&limited.device);
    }
    attributed_mesh_destroy(&made);
}

/* PoCL's threads use a part of a device after the last release of its context, so a part outlives its handles. */
static void a_part_of_a_device_outlives_its_handles(void **state)
{
    (void)state;
    cl_device_id parts[2] = {NULL, NULL};
    for (int i = 0; i < 2; ++i) {
        const svo_device_options options = {.struct_size = sizeof options, .max_threads = 1};
        svo_device *device = NULL;
        svo_message message = {""};
        const svo_status status = svo_device_create_default(&options, &device, &message);
        if (status == SVO_UNSUPPORTED) {
            print_message("skipped: %s\n", message.text);
            skip();
        }
        if (status != SVO_OK) {
            fail_msg("%s", message.text);
        }
        parts[i] = info_of_device(device).device;
        svo_device_destroy(&device);
    }
    cl_uint units = 0;
    assert_ptr_equal(parts[0], parts[1]);
    assert_int_equal(clGetDeviceInfo(parts[0], CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, NULL), CL_SUCCESS);
    assert_int_equal(units, 1);
}

static void a_callers_device_takes_no_limit_of_threads(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_device_options options = {.struct_size = sizeof options, .max_threads = 1};
    svo_device *device = NULL;
    svo_message message = {""};
    assert_int_equal(svo_device_create(info_of_device(opened.device).context, info_of_device(opened.device).device,
                                       &options, &device, &message),
                     SVO_INVALID_ARGUMENT);
    assert_null(device);
    assert_non_null(strstr(message.text, "max_threads 1"));
}

TEST_GROUP(limits)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plan_above_the_budget_is_refused_beforehand),
        cmocka_unit_test(a_budget_holds_for_all_that_lives),
        cmocka_unit_test(a_list_does_not_grow_beyond_the_budget),
        cmocka_unit_test(workspaces_keep_to_the_budget),
        cmocka_unit_test(threads_are_limited),
        cmocka_unit_test(a_part_of_a_device_outlives_its_handles),
        cmocka_unit_test(a_callers_device_takes_no_limit_of_threads),
    };
    return cmocka_run_group_tests_name("limits", tests, fixture_group_setup, fixture_group_teardown);
}
