/* SPDX-License-Identifier: MIT */
/*
 * A blocking build waits where the host needs a count, and once at its end. It waits after each stage only where
 * someone asks for times that the queue does not take, or to be told of the progress. The tree is the same. Each array
 * of the mesh is uploaded once, and no upload is waited for. Whoever writes to a buffer has the write's event: a
 * blocking write alone may return before the bytes are there, as that of Intel's driver for CPUs does below a kilobyte.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "core/device.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/suite.h"

#define ARRAYS_MAX 16

static struct {
    unsigned waits, writes, blocking_writes;
    unsigned writes_without_event;
    const void *large[ARRAYS_MAX]; /* where large uploads come from */
    unsigned large_count;
} calls;

/* More than a record of counts or parameters. */
static const size_t large_bytes = 1024;

/* NOLINTBEGIN(readability-identifier-naming) */
cl_int __real_clWaitForEvents(cl_uint count, const cl_event *events);
cl_int __wrap_clWaitForEvents(cl_uint count, const cl_event *events);
cl_int __real_clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                   const void *data, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                   const void *data, cl_uint num_wait, const cl_event *wait, cl_event *event);

cl_int __wrap_clWaitForEvents(cl_uint count, const cl_event *events)
{
    ++calls.waits;
    return __real_clWaitForEvents(count, events);
}

cl_int __wrap_clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                   const void *data, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    ++calls.writes;
    calls.blocking_writes += blocking != CL_FALSE ? 1 : 0;
    calls.writes_without_event += event == NULL ? 1 : 0;
    if (bytes > large_bytes && calls.large_count < ARRAYS_MAX) {
        calls.large[calls.large_count++] = data;
    }
    return __real_clEnqueueWriteBuffer(queue, buffer, blocking, offset, bytes, data, num_wait, wait, event);
}
/* NOLINTEND(readability-identifier-naming) */

#define DEPTH 6
/* After the voxelizer, at the end, and when the queue is let go. */
#define WAITS_MAX 3

/* What one build is asked for. */
typedef struct request {
    cl_command_queue_properties queue_properties;
    bool wants_times, wants_progress;
} request;

static int go_on(void *user, svo_stage stage, double fraction)
{
    (void)user;
    (void)stage;
    (void)fraction;
    return 0;
}

/* Builds twice, since the first build compiles, and leaves the calls of the second. */
static void count_build(const request *asked, svo_build_report *report, char hash[SVO_HASH_TEXT_BYTES])
{
    const svo_plan_options options = {.struct_size = sizeof options,
                                      .need = SVO_NEED_ALL,
                                      .progress = asked->wants_progress ? go_on : NULL,
                                      .place = SVO_PLACE_HOST};
    fixture opened;
    scene *knot = fixture_scene("knot:2000");
    svo_plan *plan = NULL;
    fixture_open_cl(&(fixture_options){.queue_properties = asked->queue_properties}, &opened);
    assert_int_equal(svo_plan_create(opened.device, scene_mesh(knot), DEPTH, &options, &plan), SVO_OK);
    for (int i = 0; i < 2; ++i) {
        svo_tree *tree = NULL;
        memset(&calls, 0, sizeof calls);
        const svo_status status = svo_build(plan, opened.cl, opened.queue, &tree, asked->wants_times ? report : NULL);
        const unsigned waits = calls.waits;
        if (status != SVO_OK) {
            fail_msg("%s", svo_device_message(opened.device));
        }
        assert_int_equal(svo_tree_download(tree, opened.queue), SVO_OK);
        assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, hash), SVO_OK);
        calls.waits = waits; /* the download waits too */
        svo_tree_destroy(&tree);
    }
    svo_plan_destroy(&plan);
    scene_destroy(&knot);
    fixture_close(&opened);
}

static void builds_wait_only_where_they_must(void **state)
{
    static const request requests[] = {
        {CL_QUEUE_PROFILING_ENABLE, true, false},
        {CL_QUEUE_PROFILING_ENABLE, false, false},
        {0, false, false},
        {CL_QUEUE_PROFILING_ENABLE, true, true},
        {0, true, false},
    };
    static const size_t few = 3; /* of them that wait for nothing but counts and the end */
    char first[SVO_HASH_TEXT_BYTES] = "";
    (void)state;
    for (size_t i = 0; i < sizeof requests / sizeof requests[0]; ++i) {
        const bool is_profiled = requests[i].queue_properties != 0;
        svo_build_report report = SVO_BUILD_REPORT_INIT;
        char hash[SVO_HASH_TEXT_BYTES];
        count_build(&requests[i], &report, hash);
        print_message("%zu: %u waits, %u writes\n", i, calls.waits, calls.writes);
        assert_int_equal(calls.blocking_writes, 0);
        assert_in_range(calls.waits, i < few ? 1 : WAITS_MAX + 1, i < few ? WAITS_MAX : 1000);
        if (requests[i].wants_times) {
            const char *clock = report.stage_times[SVO_STAGE_SUBDIVIDE].clock;
            assert_non_null(clock);
            assert_string_equal(clock, is_profiled ? "cl-event" : "wall");
            assert_true(report.stage_times[SVO_STAGE_SUBDIVIDE].ms > 0.0);
        }
        assert_string_equal(hash, i == 0 ? hash : first);
        (void)memcpy(first, hash, sizeof first);
    }
}

/* Large uploads of a plan and its first build on the path of GPUs. */
static unsigned count_uploads(const fixture *opened, const svo_mesh *mesh, svo_place place)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_ALL, .place = place};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    memset(&calls, 0, sizeof calls);
    assert_int_equal(svo_plan_create(opened->device, mesh, DEPTH, &options, &plan), SVO_OK);
    assert_int_equal(svo_build(plan, opened->cl, opened->queue, &tree, NULL), SVO_OK);
    for (unsigned i = 0; i < calls.large_count; ++i) {
        for (unsigned k = 0; k < i; ++k) {
            assert_ptr_not_equal(calls.large[i], calls.large[k]);
        }
    }
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return calls.large_count;
}

static void arrays_are_uploaded_once(void **state)
{
    (void)state;
    /* Of the host's plan: vertices, indices, items; triangle ids, positions; remainders, records, colors, normals. Of
       the mesh: positions, indices, normals, colors. */
    static const unsigned by_host = 9, by_device = 4;
    fixture opened;
    scene *knot = fixture_scene("knot:2000");
    fixture_open_cl(&(fixture_options){.path = SVO_PATH_GPU}, &opened);
    opened.device->tests_programs = false; /* whose inputs are no arrays of the mesh */
    assert_int_equal(count_uploads(&opened, scene_mesh(knot), SVO_PLACE_HOST), by_host);
    assert_int_equal(calls.blocking_writes, 0);
    assert_int_equal(count_uploads(&opened, scene_mesh(knot), SVO_PLACE_DEVICE), by_device);
    assert_in_range(calls.blocking_writes, 0, 1); /* a byte for each material */
    scene_destroy(&knot);
    fixture_close(&opened);
}

/* A scene writes its tables and instances, a call its input. */
static void a_write_has_an_event(void **state)
{
    static const svo_instance instance = {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    static const svo_ray ray = {.origin = {0.5F, 0.5F, -1.0F}, .direction = {0, 0, 1}, .t_max = 9};
    const svo_plan_options everything = {.struct_size = sizeof everything, .need = SVO_NEED_ALL};
    (void)state;
    svo_voxel_hit hit;
    svo_scene *made = NULL;
    built tree;
    fixture opened;
    scene *knot = fixture_scene("knot:500");
    fixture_open_cl(&(fixture_options){.queue_properties = CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE}, &opened);
    fixture_build(&opened, scene_mesh(knot), DEPTH, &everything, &tree);
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = &tree.tree,
                                       .instances = &instance,
                                       .tree_count = 1,
                                       .instance_count = 1};
    memset(&calls, 0, sizeof calls);
    assert_int_equal(svo_scene_create(opened.device, &options, opened.queue, &made), SVO_OK);
    assert_int_equal(svo_trace_voxels(svo_scene_target(made), svo_in_host(&ray), svo_in_host(&hit), 1, 0.0F, 0,
                                      &(svo_submit){.queue = opened.queue}),
                     SVO_OK);
    assert_true(calls.writes > 2);
    assert_int_equal(calls.writes_without_event, 0);
    svo_scene_destroy(&made);
    built_destroy(&tree);
    scene_destroy(&knot);
    fixture_close(&opened);
}

TEST_GROUP(waits)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(builds_wait_only_where_they_must),
                                       cmocka_unit_test(arrays_are_uploaded_once),
                                       cmocka_unit_test(a_write_has_an_event)};
    return cmocka_run_group_tests_name("waits", tests, NULL, NULL);
}
