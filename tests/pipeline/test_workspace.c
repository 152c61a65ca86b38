/* SPDX-License-Identifier: MIT */
/*
 * Enqueued builds: they give the same trees as svo_build, bit for bit, in preallocated memory, and report if there is
 * too little of it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/tree.h"
#include "scenes.h"
#include "support/counting.h"
#include "support/enqueued.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

static const uint32_t needs[] = {
    SVO_NEED_NONE, SVO_NEED_DEFAULT, SVO_NEED_RAYS, SVO_NEED_MATERIAL, SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_FILL,
    SVO_NEED_ALL};
enum { NEEDS = sizeof needs / sizeof needs[0] };

static void hash_of(const fixture *opened, svo_tree *tree, char hash[SVO_HASH_TEXT_BYTES])
{
    succeed(opened, svo_tree_download(tree, opened->queue));
    succeed(opened, svo_tree_hash(tree, SVO_HASH_ALL, hash));
}

/* The hash of an enqueued build and its counts. */
static void enqueue_and_hash(const fixture *opened, svo_plan *plan, int trim, built *out)
{
    svo_workspace *workspace = make_workspace(opened, plan);
    *out = (built){.tree = make_tree(opened, workspace), .report.struct_size = sizeof out->report};
    succeed(opened, svo_build_enqueue(workspace, out->tree, &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_tree_finish(out->tree, opened->queue, trim, &out->report));
    svo_workspace_destroy(&workspace);
    out->info = (svo_tree_info)SVO_TREE_INFO_INIT;
    svo_tree_get_info(out->tree, &out->info);
    hash_of(opened, out->tree, out->hash);
    out->arrays = (svo_tree_arrays)SVO_TREE_ARRAYS_INIT;
    svo_tree_get_arrays(out->tree, &out->arrays);
}

static void assert_same(const built *actual, const built *expected)
{
    assert_string_equal(actual->hash, expected->hash);
    assert_memory_equal(actual->info.level_begin, expected->info.level_begin, sizeof expected->info.level_begin);
    assert_int_equal(actual->info.fragments, expected->info.fragments);
    assert_int_equal(actual->info.list_count, expected->info.list_count);
    assert_int_equal(actual->info.vertex_count, expected->info.vertex_count);
    assert_int_equal(actual->info.list_triangle_count, expected->info.list_triangle_count);
    assert_int_equal(actual->info.constant, expected->info.constant);
    assert_int_equal(actual->report.fragments, expected->report.fragments);
}

/* Bytes of a tree's buffer on the device. */
static size_t held_bytes(const svo_tree *tree, svo_tree_buffer which)
{
    size_t bytes = 0;
    const cl_mem buffer = svo_tree_get_buffer(tree, which);
    if (buffer != NULL) {
        clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    }
    return bytes;
}

static void compare_with_build(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_plan_options options)
{
    built expected;
    fixture_build(opened, mesh, depth, &options, &expected);
    for (int trim = 0; trim < 2; ++trim) {
        svo_plan *plan = make_plan(opened, mesh, depth, options);
        built actual;
        enqueue_and_hash(opened, plan, trim, &actual);
        assert_same(&actual, &expected);
        for (svo_tree_buffer i = 0; i < SVO_TREE_BUFFER_COUNT && trim != 0; ++i) {
            assert_int_equal(held_bytes(actual.tree, i), held_bytes(expected.tree, i));
        }
        svo_tree_destroy(&actual.tree);
        svo_plan_destroy(&plan);
    }
    built_destroy(&expected);
}

static void enqueued_builds_make_the_same_trees(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const char *const scenes[] = {"cornell", "knot:3000", "dust:2000", "needles:200"};
    for (size_t s = 0; s < sizeof scenes / sizeof scenes[0]; ++s) {
        struct scene *made = fixture_scene(scenes[s]);
        for (size_t i = 0; i < NEEDS; ++i) {
            compare_with_build(&opened, scene_mesh(made), 6, (svo_plan_options){.need = needs[i]});
        }
        scene_destroy(&made);
    }
}

static void deep_grids_thin_and_closed_coverage_and_all_weights(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:300");
    const svo_mesh *mesh = scene_mesh(made);
    const uint32_t payload = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS;
    compare_with_build(&opened, mesh, 11, (svo_plan_options){.need = payload});
    compare_with_build(&opened, mesh, 1, (svo_plan_options){.need = payload});
    compare_with_build(&opened, mesh, 7, (svo_plan_options){.need = payload, .coverage = SVO_COVERAGE_THIN});
    compare_with_build(&opened, mesh, 7, (svo_plan_options){.need = payload, .coverage = SVO_COVERAGE_CLOSED});
    compare_with_build(&opened, mesh, 7, (svo_plan_options){.need = payload, .weights = SVO_WEIGHTS_UNIFORM});
    compare_with_build(&opened, mesh, 7, (svo_plan_options){.need = payload, .weights = SVO_WEIGHTS_CENTER});
    compare_with_build(&opened, mesh, 7, (svo_plan_options){.need = payload, .worst_case_nodes = 1});
    scene_destroy(&made);
}

/* The OpenGL front end draws while the build is enqueued. */
static void opengl_can_produce_the_fragments(void **state)
{
    const fixture *opened = fixture_of_group(state);
    struct scene *made = fixture_scene("cornell");
    compare_with_build(opened, scene_mesh(made), 6, (svo_plan_options){.need = SVO_NEED_ALL});
    svo_plan *plan = make_plan(opened, scene_mesh(made), 6, (svo_plan_options){.fragment_capacity = 1});
    svo_workspace *workspace = make_workspace(opened, plan);
    svo_tree *tree = make_tree(opened, workspace);
    svo_build_report report = {.struct_size = sizeof report};
    succeed(opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened->queue}));
    assert_int_equal(svo_tree_finish(tree, opened->queue, 1, &report), SVO_CAPACITY_EXCEEDED);
    assert_in_range(report.fragments, 1000, UINT32_MAX);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    scene_destroy(&made);
}

/* No triangle; a point; a triangle that meets no voxel with thin coverage. */
static void empty_and_tiny_meshes(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const float point[9] = {0.3F, 0.3F, 0.3F, 0.3F, 0.3F, 0.3F, 0.3F, 0.3F, 0.3F};
    const svo_mesh one = {.struct_size = sizeof one, .positions = point, .vertex_count = 3, .triangle_count = 1};
    const svo_mesh none = {.struct_size = sizeof none};
    for (size_t i = 0; i < NEEDS; ++i) {
        compare_with_build(&opened, &none, 5, (svo_plan_options){.need = needs[i]});
        compare_with_build(&opened, &one, 5, (svo_plan_options){.need = needs[i], .edge = 1.0});
        compare_with_build(&opened, &one, 5,
                           (svo_plan_options){.need = needs[i], .edge = 1.0, .coverage = SVO_COVERAGE_THIN});
    }
}

/* svo_workspace_create and svo_workspace_make_tree make all allocations, with the sizes that they report. */
static void enqueuing_allocates_nothing(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("cornell");
    for (size_t i = 0; i < NEEDS; ++i) {
        svo_plan *plan = make_plan(&opened, scene_mesh(made), 6, (svo_plan_options){.need = needs[i]});
        svo_workspace *workspace = make_workspace(&opened, plan); /* compiles */
        svo_workspace_destroy(&workspace);
        counting_begin();
        workspace = make_workspace(&opened, plan);
        svo_workspace_info info = SVO_WORKSPACE_INFO_INIT;
        svo_workspace_get_info(workspace, &info);
        assert_int_equal(counting_read().live_bytes, info.scratch_bytes);
        svo_tree *tree = make_tree(&opened, workspace);
        assert_int_equal(counting_read().live_bytes, info.scratch_bytes + info.tree_bytes);
        const counted before = counting_read();
        for (int round = 0; round < 2; ++round) {
            succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
            succeed(&opened, svo_tree_finish(tree, opened.queue, 0, NULL));
        }
        const counted after = counting_read();
        assert_int_equal(after.buffers, before.buffers);
        assert_int_equal(after.sub_buffers, before.sub_buffers);
        assert_int_equal(after.programs, 0);
        svo_tree_destroy(&tree);
        svo_workspace_destroy(&workspace);
        assert_int_equal(counting_read().live_bytes, 0);
        svo_plan_destroy(&plan);
    }
    scene_destroy(&made);
}

/* Many builds of two trees with one workspace on an out-of-order queue, some of them pending at the same time; the
   first waits for a user event. */
static void builds_of_a_workspace_are_ordered(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:2000");
    const svo_plan_options options = {.need = SVO_NEED_ALL};
    const cl_context context = info_of_device(opened.device).context;
    cl_command_queue queues[2];
    for (int i = 0; i < 2; ++i) {
        queues[i] = clCreateCommandQueue(context, info_of_device(opened.device).device,
                                         CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE | CL_QUEUE_PROFILING_ENABLE, NULL);
        assert_non_null(queues[i]);
    }
    built expected;
    fixture_build(&opened, scene_mesh(made), 6, &options, &expected);
    svo_plan *plan = make_plan(&opened, scene_mesh(made), 6, options);
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *trees[2] = {make_tree(&opened, workspace), make_tree(&opened, workspace)};
    for (int round = 0; round < 2; ++round) {
        cl_event gate = clCreateUserEvent(context, NULL);
        cl_event done[2] = {NULL, NULL};
        cl_int first_status = CL_COMPLETE;
        for (int i = 0; i < 2; ++i) {
            succeed(&opened, svo_build_enqueue(
                                 workspace, trees[i],
                                 &(svo_submit){.queue = queues[i], .num_wait = 1, .wait = &gate, .event = &done[i]}));
        }
        clGetEventInfo(done[0], CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof first_status, &first_status, NULL);
        assert_true(first_status > CL_COMPLETE);
        clSetUserEventStatus(gate, CL_COMPLETE);
        assert_int_equal(clWaitForEvents(2, done), CL_SUCCESS);
        for (int i = 1; i >= 0; --i) {
            char hash[SVO_HASH_TEXT_BYTES];
            svo_build_report report = {.struct_size = sizeof report};
            succeed(&opened, svo_tree_finish(trees[i], queues[i], 0, &report));
            hash_of(&opened, trees[i], hash);
            assert_string_equal(hash, expected.hash);
            assert_string_equal(report.stage_times[SVO_STAGE_SUBDIVIDE].clock, "cl-event");
            assert_true(report.stage_times[SVO_STAGE_VOXELIZE].ms > 0.0);
            assert_true(report.stage_times[SVO_STAGE_FILTER].ms > 0.0);
            clReleaseEvent(done[i]);
        }
        clReleaseEvent(gate);
    }
    svo_workspace_destroy(&workspace);
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(svo_build_enqueue(workspace, trees[i], &(svo_submit){.queue = queues[i]}),
                         SVO_INVALID_ARGUMENT);
        svo_tree_destroy(&trees[i]);
        clReleaseCommandQueue(queues[i]);
    }
    svo_plan_destroy(&plan);
    built_destroy(&expected);
    scene_destroy(&made);
}

/* Whichever launch fails, the call returns at once, although the commands enqueued before it wait for an event that is
   not set yet. These commands do no harm. */
static void a_failed_enqueue_does_not_block(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:500");
    const svo_plan_options options = {.need = SVO_NEED_DEFAULT | SVO_NEED_RAYS};
    size_t failed = 0;
    int all = 0;
    built expected;
    fixture_build(&opened, scene_mesh(made), 5, &options, &expected);
    svo_plan *plan = make_plan(&opened, scene_mesh(made), 5, options);
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *tree = make_tree(&opened, workspace);
    while (all == 0) {
        cl_event gate = clCreateUserEvent(info_of_device(opened.device).context, NULL);
        counting_begin();
        counting_fail_launch(failed);
        const svo_status status =
            svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue, .num_wait = 1, .wait = &gate});
        all = counting_read().failed_launches == 0;
        assert_int_equal(status, all != 0 ? SVO_OK : SVO_CL_ERROR);
        if (all == 0) {
            assert_non_null(strstr(svo_device_message(opened.device), "CL_INVALID_KERNEL_ARGS"));
            assert_int_equal(svo_tree_finish(tree, opened.queue, 0, NULL), SVO_INVALID_ARGUMENT);
            succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
            ++failed;
        }
        clSetUserEventStatus(gate, CL_COMPLETE);
        succeed(&opened, svo_tree_finish(tree, opened.queue, 0, NULL));
        clReleaseEvent(gate);
        char hash[SVO_HASH_TEXT_BYTES];
        hash_of(&opened, tree, hash);
        assert_string_equal(hash, expected.hash);
    }
    assert_true(failed > 12); /* launches of a build */
    /* The last enqueue fails, and tree and workspace are destroyed right after it. */
    counting_fail_launch(failed / 2);
    assert_int_equal(svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}), SVO_CL_ERROR);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    built_destroy(&expected);
    scene_destroy(&made);
}

/* Measuring does not change a plan, nor does a workspace that cannot be created. */
static void a_plan_is_unchanged_until_a_workspace_exists(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:500");
    svo_plan *plan = make_plan(&opened, scene_mesh(made), 5, (svo_plan_options){.need = SVO_NEED_DEFAULT});
    const uint64_t peak = info_of_plan(plan).peak_bytes;
    const cl_mem small = clCreateBuffer(info_of_device(opened.device).context, CL_MEM_READ_WRITE, 16, NULL, NULL);
    const svo_workspace_options given = {.struct_size = sizeof given, .scratch = small};
    svo_workspace *workspace = NULL;
    svo_workspace_info info = SVO_WORKSPACE_INFO_INIT;
    succeed(&opened, svo_workspace_measure(plan, opened.frontend, &info));
    assert_int_equal(info_of_plan(plan).peak_bytes, peak);
    assert_int_equal(svo_workspace_measure(plan, NULL, &info), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_workspace_create(plan, opened.frontend, opened.queue, &given, &workspace),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(info_of_plan(plan).peak_bytes, peak);
    workspace = make_workspace(&opened, plan);
    assert_int_not_equal(info_of_plan(plan).peak_bytes, peak);
    svo_workspace_destroy(&workspace);
    clReleaseMemObject(small);
    svo_plan_destroy(&plan);
    scene_destroy(&made);
}

/* A list that is too short by one, and by many; nodes that do not fit. The reported capacities suffice, and those of
   fragments are above the number by undecided ones at most. */
static void insufficient_capacity_reports_the_required_figures(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:2000");
    svo_plan_options options = {.need = SVO_NEED_ALL};
    built expected;
    fixture_build(&opened, scene_mesh(made), 6, &options, &expected);
    const uint64_t exact = expected.info.fragments;
    const uint64_t capacities[] = {1, exact / 2, exact - 1};
    uint64_t suffices = exact;
    for (size_t i = 0; i < sizeof capacities / sizeof capacities[0]; ++i) {
        options.fragment_capacity = capacities[i];
        svo_plan *plan = make_plan(&opened, scene_mesh(made), 6, options);
        svo_workspace *workspace = make_workspace(&opened, plan);
        svo_tree *tree = make_tree(&opened, workspace);
        svo_build_report report = {.struct_size = sizeof report};
        succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
        assert_int_equal(svo_tree_finish(tree, opened.queue, 1, &report), SVO_CAPACITY_EXCEEDED);
        assert_in_range(report.fragments, exact, exact + exact / 100);
        assert_in_range(report.inner_nodes, expected.info.inner_count, UINT32_MAX);
        suffices = report.fragments;
        char figure[32];
        (void)snprintf(figure, sizeof figure, "%llu", (unsigned long long)suffices);
        assert_non_null(strstr(svo_device_message(opened.device), figure));
        svo_tree_destroy(&tree);
        svo_workspace_destroy(&workspace);
        svo_plan_destroy(&plan);
    }
    options.fragment_capacity = suffices;
    compare_with_build(&opened, scene_mesh(made), 6, options);
    built_destroy(&expected);
    scene_destroy(&made);
}

/* Tiny triangles across the corners of a lattice: many voxels each, where the estimate expects little more than one. */
static void insufficient_node_capacity_is_reported(void **state)
{
    static const float corners[9] = {1.0F, -1.0F, 0.5F, -1.0F, 1.0F, 0.5F, 0.25F, 0.5F, -1.0F};
    enum { COUNT = 15 * 15 * 15 };
    const fixture opened = fixture_cl_of_group(state);
    float *positions = calloc((size_t)COUNT * 9, sizeof *positions);
    assert_non_null(positions);
    for (int i = 0; i < COUNT * 9; ++i) {
        static const int strides[3] = {1, 15, 225};
        const int at = 1 + i / 9 / strides[i % 3] % 15;
        positions[i] = (float)at / 16.0F + corners[i % 9] * 1e-4F;
    }
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions = positions, .vertex_count = (size_t)COUNT * 3, .triangle_count = COUNT};
    svo_plan_options options = {.need = SVO_NEED_NONE, .edge = 1.0, .fragment_capacity = 8 * COUNT};
    svo_plan *plan = make_plan(&opened, &mesh, 8, options);
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *tree = make_tree(&opened, workspace);
    svo_build_report report = {.struct_size = sizeof report};
    succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
    assert_int_equal(svo_tree_finish(tree, opened.queue, 1, &report), SVO_CAPACITY_EXCEEDED);
    assert_in_range(report.fragments, 2 * COUNT, 8 * COUNT); /* the list was large enough */
    svo_build_state outcome;
    assert_int_equal(clEnqueueReadBuffer(opened.queue, svo_tree_get_buffer(tree, SVO_TREE_BUILD_STATE), CL_TRUE, 0,
                                         sizeof outcome, &outcome, 0, NULL, NULL),
                     CL_SUCCESS);
    assert_in_range(outcome.overflow, 1, 7); /* the level that did not fit */
    assert_int_equal(outcome.fragments_low, report.fragments);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    options.worst_case_nodes = 1;
    compare_with_build(&opened, &mesh, 8, options);
    free(positions);
}

/* Two workspaces use one buffer of the caller, one after the other, at different offsets. */
static void the_caller_may_provide_scratch(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("cornell");
    built expected;
    fixture_build(&opened, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_ALL}, &expected);
    svo_plan *plan = make_plan(&opened, scene_mesh(made), 6, (svo_plan_options){.need = SVO_NEED_ALL});
    svo_workspace_info info = SVO_WORKSPACE_INFO_INIT;
    succeed(&opened, svo_workspace_measure(plan, opened.frontend, &info));
    assert_in_range(info.scratch_bytes, 1, info_of_plan(plan).peak_bytes);
    const uint64_t offset = 3 * info.scratch_alignment;
    cl_mem scratch = clCreateBuffer(info_of_device(opened.device).context, CL_MEM_READ_WRITE,
                                    (size_t)(offset + info.scratch_bytes), NULL, NULL);
    assert_non_null(scratch);
    svo_workspace_options options = {.struct_size = sizeof options, .scratch = scratch};
    for (int turn = 0; turn < 2; ++turn) {
        options.offset_bytes = turn == 0 ? 0 : offset;
        svo_workspace *workspace = NULL;
        succeed(&opened, svo_workspace_create(plan, opened.frontend, opened.queue, &options, &workspace));
        svo_tree *tree = make_tree(&opened, workspace);
        succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
        succeed(&opened, svo_tree_finish(tree, opened.queue, 1, NULL));
        char hash[SVO_HASH_TEXT_BYTES];
        hash_of(&opened, tree, hash);
        assert_string_equal(hash, expected.hash);
        svo_tree_destroy(&tree);
        svo_workspace_destroy(&workspace);
    }
    svo_workspace *workspace = NULL;
    options.offset_bytes = offset + info.scratch_alignment; /* too few bytes after it */
    assert_int_equal(svo_workspace_create(plan, opened.frontend, opened.queue, &options, &workspace),
                     SVO_INVALID_ARGUMENT);
    options.offset_bytes = 1; /* not aligned */
    assert_int_equal(svo_workspace_create(plan, opened.frontend, opened.queue, &options, &workspace),
                     SVO_INVALID_ARGUMENT);
    assert_null(workspace);
    clReleaseMemObject(scratch);
    svo_plan_destroy(&plan);
    built_destroy(&expected);
    scene_destroy(&made);
}

static void counting_first_makes_the_list_exact(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:2000");
    built expected;
    fixture_build(&opened, scene_mesh(made), 7, &(svo_plan_options){.need = SVO_NEED_ALL}, &expected);
    svo_plan *plan = make_plan(&opened, scene_mesh(made), 7, (svo_plan_options){.need = SVO_NEED_ALL});
    const uint64_t before = info_of_plan(plan).peak_bytes;
    succeed(&opened, svo_plan_count(plan, opened.frontend, opened.queue));
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan_get_info(plan, &info);
    const uint64_t room = info.fragments;
    assert_in_range(room, expected.info.fragments, expected.info.fragments + expected.report.undecided);
    assert_true(info_of_plan(plan).peak_bytes < before);
    unsigned exact = 0;
    unsigned bounds = 0;
    for (size_t i = 0; i < info_of_plan(plan).buffer_count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        svo_plan_get_buffer(plan, i, &buffer);
        for (size_t k = 0; k < expected.buffer_count; ++k) {
            if (strcmp(expected.buffers[k].name, buffer.name) == 0 && buffer.certainty == SVO_BYTES_EXACT &&
                strcmp(buffer.name, "fragments") != 0) {
                assert_in_range(buffer.bytes, expected.buffers[k].bytes,
                                expected.buffers[k].bytes + expected.report.undecided * 8);
                ++exact;
            } else if (strcmp(expected.buffers[k].name, buffer.name) == 0 && buffer.certainty == SVO_BYTES_BOUND) {
                assert_true(buffer.bytes >= expected.buffers[k].bytes);
                ++bounds;
            }
        }
        if (strcmp(buffer.name, "fragments") == 0) {
            assert_int_equal(buffer.bytes, room * 8);
            assert_int_equal(buffer.certainty, SVO_BYTES_EXACT);
        }
    }
    assert_in_range(exact, 10, 40);
    assert_in_range(bounds, 2, 10);
    built actual;
    enqueue_and_hash(&opened, plan, 1, &actual);
    assert_same(&actual, &expected);
    svo_tree_destroy(&actual.tree);
    svo_plan_destroy(&plan);
    built_destroy(&expected);
    scene_destroy(&made);
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("cube");
    svo_plan *plan = make_plan(&opened, scene_mesh(made), 4, (svo_plan_options){0});
    svo_plan *sorted = make_plan(&opened, scene_mesh(made), 4, (svo_plan_options){.builder = SVO_BUILDER_SORTED});
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_workspace *unmade = NULL;
    svo_tree *tree = make_tree(&opened, workspace);
    const svo_workspace_options wrong_size = {.struct_size = 1};
    assert_int_equal(svo_workspace_create(NULL, opened.frontend, opened.queue, NULL, &unmade), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_workspace_create(plan, NULL, opened.queue, NULL, &unmade), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_workspace_create(plan, opened.frontend, opened.queue, &wrong_size, &unmade),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_workspace_create(sorted, opened.frontend, opened.queue, NULL, &unmade), SVO_UNSUPPORTED);
    assert_null(unmade);
    assert_int_equal(svo_tree_finish(tree, opened.queue, 0, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_build_enqueue(workspace, NULL, &(svo_submit){.queue = opened.queue}), SVO_INVALID_ARGUMENT);
    assert_int_equal(
        svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue, .num_wait = 1, .wait = NULL}),
        SVO_INVALID_ARGUMENT);
    succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
    assert_int_equal(svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_download(tree, opened.queue), SVO_INVALID_ARGUMENT);
    succeed(&opened, svo_tree_finish(tree, opened.queue, 1, NULL));
    assert_int_equal(svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}), SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&tree);
    tree = make_tree(&opened, workspace); /* destroyed with its build in flight */
    succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
    svo_tree_destroy(&tree);
    tree = make_tree(&opened, workspace); /* its workspace is destroyed with its build in flight */
    succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
    svo_workspace_destroy(&workspace);
    assert_int_equal(svo_tree_finish(tree, opened.queue, 1, NULL), SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_workspace_destroy(NULL);
    svo_plan_destroy(&sorted);
    svo_plan_destroy(&plan);
    scene_destroy(&made);
}

/* ---- trees without content ---- */

static void expect_refusal(const fixture *opened, svo_status status, const char *function, const char *words)
{
    const char *message = svo_device_message(opened->device);
    if (status != SVO_INVALID_ARGUMENT || strncmp(message, function, strlen(function)) != 0 ||
        strstr(message, words) == NULL) {
        fail_msg("%s: %s, '%s' instead of '%s'", function, svo_name(SVO_NAME_STATUS, status), message, words);
    }
}

/* Every function that reads a tree refuses one without content. words: of the reason. */
static void expect_all_to_refuse(const fixture *opened, svo_tree *tree, cl_kernel kernel, const char *words)
{
    const svo_ray ray = {.direction = {0, 0, 1}, .t_max = 1};
    const svo_query_point point = {.max_distance = 1};
    const double corner[3] = {0, 0, 0};
    const uint32_t cell[3] = {0, 0, 0};
    cl_mem memory =
        clCreateBuffer(info_of_device(opened->device).context, CL_MEM_READ_WRITE, sizeof(svo_hit), NULL, NULL);
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    char hash[SVO_HASH_TEXT_BYTES];
    svo_render_options options = {.struct_size = sizeof options, .width = 8, .height = 8};
    uint8_t picture[8 * 8 * 4];
    double box[2][3];
    svo_hit hit;
    svo_nearest nearest;
    svo_grid grid;
    svo_node node;
    const svo_submit submit = {.queue = opened->queue};
    (void)svo_camera_fit(svo_tree_target(tree), 1.0F, &options.camera);
#define EXPECT(function, ...) expect_refusal(opened, function(__VA_ARGS__), #function, words)
    EXPECT(svo_tree_get_info, tree, &info);
    EXPECT(svo_tree_get_arrays, tree, &arrays);
    EXPECT(svo_tree_get_grid, tree, &grid);
    EXPECT(svo_tree_download, tree, opened->queue);
    EXPECT(svo_tree_upload, tree, opened->device, opened->queue);
    EXPECT(svo_tree_hash, tree, SVO_HASH_ALL, hash);
    EXPECT(svo_tree_find_cell, tree, 0, cell, &node);
    EXPECT(svo_tree_find_point, tree, corner, &node);
    EXPECT(svo_tree_find_node, tree, 0, &node);
    EXPECT(svo_tree_node_box, tree, 0, box[0], box[1]);
    EXPECT(svo_kernel_set_arguments, svo_tree_target(tree), kernel, 0);
    EXPECT(svo_tree_make_bvh, tree, SVO_BVH_FAST, opened->queue);
    EXPECT(svo_trace_triangles, svo_tree_target(tree), svo_in_host(&ray), svo_in_host(&hit), 1, SVO_TRACE_CLOSEST,
           &submit);
    EXPECT(svo_trace_triangles, svo_tree_target(tree), svo_in_buffer(memory), svo_in_buffer(memory), 1,
           SVO_TRACE_CLOSEST, &submit);
    EXPECT(svo_tree_nearest, tree, svo_in_host(&point), svo_in_host(&nearest), 1, &submit);
    EXPECT(svo_tree_nearest, tree, svo_in_buffer(memory), svo_in_buffer(memory), 1, &submit);
    for (svo_render_view view = SVO_VIEW_SHADED; view <= SVO_VIEW_TRIANGLES; ++view) {
        options.view = view;
        EXPECT(svo_render, svo_tree_target(tree), &options, svo_in_host(picture),
               &(svo_submit){.queue = opened->queue});
    }
#undef EXPECT
    assert_int_equal(tree->ray_bytes, 0);
    clReleaseMemObject(memory);
}

/* Neither before the first build, nor in flight, nor after a build that failed; afterwards all is as if no one had
   asked. */
static void trees_without_content_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:500");
    svo_plan_options options = {.need = SVO_NEED_ALL};
    const svo_ray ray = {.origin = {1.5F, 0.3F, -9.0F}, .direction = {0, 0, 1}, .t_max = 100};
    svo_hit hits[2];
    char hash[SVO_HASH_TEXT_BYTES];
    cl_kernel kernel = fixture_tree_kernel(info_of_device(opened.device).context, info_of_device(opened.device).device);
    built expected;
    fixture_build(&opened, scene_mesh(made), 5, &options, &expected);
    succeed(&opened, svo_trace_triangles(svo_tree_target(expected.tree), svo_in_host(&ray), svo_in_host(&hits[0]), 1,
                                         SVO_TRACE_COUNT, &(svo_submit){.queue = opened.queue}));
    svo_plan *plan = make_plan(&opened, scene_mesh(made), 5, options);
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *tree = make_tree(&opened, workspace);
    expect_all_to_refuse(&opened, tree, kernel, "nothing was built");

    cl_event gate = clCreateUserEvent(info_of_device(opened.device).context, NULL);
    for (int round = 0; round < 2; ++round) { /* the second time over the content of the first */
        succeed(&opened,
                svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue, .num_wait = 1, .wait = &gate}));
        expect_all_to_refuse(&opened, tree, kernel, "in flight; call svo_tree_finish");
        clSetUserEventStatus(gate, CL_COMPLETE);
        expect_all_to_refuse(&opened, tree, kernel, "in flight; call svo_tree_finish");
        succeed(&opened, svo_tree_finish(tree, opened.queue, 0, NULL));
        hash_of(&opened, tree, hash);
        assert_string_equal(hash, expected.hash);
        succeed(&opened, svo_kernel_set_arguments(svo_tree_target(tree), kernel, 0));
        succeed(&opened, svo_trace_triangles(svo_tree_target(tree), svo_in_host(&ray), svo_in_host(&hits[1]), 1,
                                             SVO_TRACE_COUNT, &(svo_submit){.queue = opened.queue}));
        assert_memory_equal(&hits[1], &hits[0], sizeof hits[0]);
        clReleaseEvent(gate);
        gate = clCreateUserEvent(info_of_device(opened.device).context, NULL);
    }
    clReleaseEvent(gate);
    counting_begin();
    counting_fail_launch(3);
    assert_int_equal(svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}), SVO_CL_ERROR);
    expect_all_to_refuse(&opened, tree, kernel, "last build failed");
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);

    options.fragment_capacity = 10;
    plan = make_plan(&opened, scene_mesh(made), 5, options);
    workspace = make_workspace(&opened, plan);
    tree = make_tree(&opened, workspace);
    succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
    assert_int_equal(svo_tree_finish(tree, opened.queue, 1, NULL), SVO_CAPACITY_EXCEEDED);
    expect_all_to_refuse(&opened, tree, kernel, "last build failed");
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    clReleaseKernel(kernel);
    built_destroy(&expected);
    scene_destroy(&made);
}

/* A tree whose build was in flight cannot be finished any more; one that was finished before lives on. Front end and
   plan may be gone by then, too. */
static void finishing_after_the_workspace_is_a_status(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:500");
    const svo_plan_options options = {.need = SVO_NEED_ALL};
    cl_kernel kernel = fixture_tree_kernel(info_of_device(opened.device).context, info_of_device(opened.device).device);
    built expected;
    fixture_build(&opened, scene_mesh(made), 5, &options, &expected);
    svo_frontend *frontend = NULL;
    succeed(&opened, svo_frontend_create_cl(opened.device, &frontend));
    svo_plan *plan = make_plan(&opened, scene_mesh(made), 5, options);
    svo_workspace *workspace = NULL;
    succeed(&opened, svo_workspace_create(plan, frontend, opened.queue, NULL, &workspace));
    svo_tree *trees[3] = {make_tree(&opened, workspace), make_tree(&opened, workspace), make_tree(&opened, workspace)};
    for (int i = 0; i < 2; ++i) {
        succeed(&opened, svo_build_enqueue(workspace, trees[i], &(svo_submit){.queue = opened.queue}));
    }
    succeed(&opened, svo_tree_finish(trees[0], opened.queue, 0, NULL));
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    svo_frontend_destroy(&frontend);
    svo_build_report report = SVO_BUILD_REPORT_INIT;
    for (int trim = 0; trim < 2; ++trim) {
        expect_refusal(&opened, svo_tree_finish(trees[1], opened.queue, trim, &report), "svo_tree_finish",
                       "workspace was destroyed");
        expect_refusal(&opened, svo_tree_finish(trees[2], opened.queue, trim, &report), "svo_tree_finish",
                       "no build is in flight");
    }
    expect_all_to_refuse(&opened, trees[1], kernel, "workspace was destroyed");
    char hash[SVO_HASH_TEXT_BYTES];
    hash_of(&opened, trees[0], hash);
    assert_string_equal(hash, expected.hash);
    for (int i = 0; i < 3; ++i) {
        svo_tree_destroy(&trees[i]);
    }
    clReleaseKernel(kernel);
    built_destroy(&expected);
    scene_destroy(&made);
}

/* ---- the outcome on the device ---- */

/* What a kernel makes of a build whose counts the host does not know yet. */
typedef struct seen_outcome {
    cl_uint overflow, inner_nodes, nodes, leaves, fragments_low, fragments_high;
} seen_outcome;

static const char outcome_kernel[] = "__kernel void look(__global const svo_build_state *state, uint depth,\n"
                                     "                   __global uint *seen)\n"
                                     "{\n"
                                     "    seen[0] = state->overflow;\n"
                                     "    seen[1] = state->level_begin[depth];\n"
                                     "    seen[2] = state->level_begin[depth + 1];\n"
                                     "    seen[3] = state->level_begin[depth + 1] - state->level_begin[depth];\n"
                                     "    seen[4] = state->fragments_low;\n"
                                     "    seen[5] = state->fragments_high;\n"
                                     "}\n";

static cl_kernel make_outcome_kernel(const fixture *opened)
{
    const char *sources[2] = {svo_kernel_source(svo_tree_target(NULL)), outcome_kernel};
    const cl_device_id device = info_of_device(opened->device).device;
    cl_program program = clCreateProgramWithSource(info_of_device(opened->device).context, 2, sources, NULL, NULL);
    assert_int_equal(clBuildProgram(program, 1, &device, svo_kernel_options(svo_tree_target(NULL)), NULL, NULL),
                     CL_SUCCESS);
    cl_kernel kernel = clCreateKernel(program, "look", NULL);
    clReleaseProgram(program);
    assert_non_null(kernel);
    return kernel;
}

/* Enqueues a build behind a closed gate and the kernel behind the build, opens the gate and reads what the kernel saw:
   the host learns the outcome from it, before svo_tree_finish. Returns what that says. */
static svo_status look_at_build(const fixture *opened, svo_plan *plan, cl_kernel kernel, unsigned depth,
                                seen_outcome *seen, svo_tree_info *info, svo_build_report *report)
{
    const cl_context context = info_of_device(opened->device).context;
    const cl_uint depth_argument = depth;
    const size_t one = 1;
    cl_event done = NULL;
    cl_event looked = NULL;
    svo_workspace *workspace = make_workspace(opened, plan);
    svo_tree *tree = make_tree(opened, workspace);
    const cl_mem outcome = svo_tree_get_buffer(tree, SVO_TREE_BUILD_STATE);
    cl_mem memory = clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof *seen, NULL, NULL);
    assert_non_null(outcome);
    assert_int_equal(clSetKernelArg(kernel, 0, sizeof(cl_mem), &outcome), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, 1, sizeof depth_argument, &depth_argument), CL_SUCCESS);
    assert_int_equal(clSetKernelArg(kernel, 2, sizeof(cl_mem), &memory), CL_SUCCESS);
    cl_event gate = clCreateUserEvent(context, NULL);
    if (opened->frontend != opened->cl) { /* a front end of OpenGL waits for the gate on the host */
        clSetUserEventStatus(gate, CL_COMPLETE);
    }
    succeed(opened,
            svo_build_enqueue(workspace, tree,
                              &(svo_submit){.queue = opened->queue, .num_wait = 1, .wait = &gate, .event = &done}));
    assert_ptr_equal(svo_tree_get_buffer(tree, SVO_TREE_BUILD_STATE), outcome);
    assert_int_equal(clEnqueueNDRangeKernel(opened->queue, kernel, 1, NULL, &one, &one, 1, &done, &looked), CL_SUCCESS);
    if (opened->frontend == opened->cl) {
        clSetUserEventStatus(gate, CL_COMPLETE);
    }
    assert_int_equal(clEnqueueReadBuffer(opened->queue, memory, CL_TRUE, 0, sizeof *seen, seen, 1, &looked, NULL),
                     CL_SUCCESS);
    *report = (svo_build_report)SVO_BUILD_REPORT_INIT;
    *info = (svo_tree_info)SVO_TREE_INFO_INIT;
    const svo_status status = svo_tree_finish(tree, opened->queue, 1, report);
    if (status == SVO_OK) {
        succeed(opened, svo_tree_get_info(tree, info));
        assert_ptr_equal(svo_tree_get_buffer(tree, SVO_TREE_BUILD_STATE), outcome);
    }
    clReleaseEvent(gate);
    clReleaseEvent(done);
    clReleaseEvent(looked);
    clReleaseMemObject(memory);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    return status;
}

static void look_at_builds(const fixture *opened, const svo_mesh *mesh, cl_kernel kernel)
{
    enum { DEPTH = 6 };
    seen_outcome seen;
    svo_tree_info info;
    svo_build_report report;
    uint64_t exact = 0;
    for (uint64_t capacity = 0; capacity < 3; ++capacity) { /* enough; far too little */
        svo_plan *plan = make_plan(opened, mesh, DEPTH,
                                   (svo_plan_options){.need = SVO_NEED_ALL, .fragment_capacity = capacity * 50});
        const svo_status status = look_at_build(opened, plan, kernel, DEPTH, &seen, &info, &report);
        assert_int_equal(status, capacity == 0 ? SVO_OK : SVO_CAPACITY_EXCEEDED);
        assert_int_equal(seen.overflow, capacity == 0 ? 0 : SVO_SHORT_LIST);
        assert_int_equal(seen.fragments_high, 0);
        assert_int_equal(seen.fragments_low, report.fragments);
        if (capacity == 0) {
            exact = report.fragments;
            assert_int_equal(seen.inner_nodes, info.inner_count);
            assert_int_equal(seen.nodes, info.node_count);
            assert_int_equal(seen.leaves, info.leaf_count);
        }
        assert_in_range(report.fragments, exact, exact + exact / 50); /* and undecided ones */
        svo_plan_destroy(&plan);
    }
    assert_true(exact > 1000);
}

/* A kernel behind an enqueued build knows whether it succeeded, and all counts, before the host does. */
static void kernels_read_the_outcome_of_a_build(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    struct scene *made = fixture_scene("knot:500");
    cl_kernel kernel = make_outcome_kernel(&opened);
    look_at_builds(&opened, scene_mesh(made), kernel);
    built blocking;
    fixture_build(&opened, scene_mesh(made), 4, NULL, &blocking);
    assert_null(svo_tree_get_buffer(blocking.tree, SVO_TREE_BUILD_STATE));
    built_destroy(&blocking);

    /* No triangle: a root without children. */
    const svo_mesh none = {.struct_size = sizeof none};
    seen_outcome seen;
    svo_tree_info info;
    svo_build_report report;
    svo_plan *plan = make_plan(&opened, &none, 3, (svo_plan_options){.need = SVO_NEED_RAYS});
    assert_int_equal(look_at_build(&opened, plan, kernel, 3, &seen, &info, &report), SVO_OK);
    assert_int_equal(seen.overflow, 0);
    assert_int_equal(seen.nodes, 1);
    assert_int_equal(seen.leaves, 0);
    assert_int_equal(seen.fragments_low, 0);
    svo_plan_destroy(&plan);
    clReleaseKernel(kernel);
    scene_destroy(&made);
}

static void kernels_read_the_outcome_of_a_build_drawn_by_opengl(void **state)
{
    const fixture *opened = fixture_of_group(state);
    struct scene *made = fixture_scene("knot:500");
    cl_kernel kernel = make_outcome_kernel(opened);
    look_at_builds(opened, scene_mesh(made), kernel);
    clReleaseKernel(kernel);
    scene_destroy(&made);
}

TEST_GROUP(workspace)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(enqueued_builds_make_the_same_trees),
        cmocka_unit_test(deep_grids_thin_and_closed_coverage_and_all_weights),
        cmocka_unit_test(opengl_can_produce_the_fragments),
        cmocka_unit_test(empty_and_tiny_meshes),
        cmocka_unit_test(enqueuing_allocates_nothing),
        cmocka_unit_test(builds_of_a_workspace_are_ordered),
        cmocka_unit_test(a_failed_enqueue_does_not_block),
        cmocka_unit_test(a_plan_is_unchanged_until_a_workspace_exists),
        cmocka_unit_test(insufficient_capacity_reports_the_required_figures),
        cmocka_unit_test(insufficient_node_capacity_is_reported),
        cmocka_unit_test(the_caller_may_provide_scratch),
        cmocka_unit_test(counting_first_makes_the_list_exact),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(trees_without_content_are_refused),
        cmocka_unit_test(finishing_after_the_workspace_is_a_status),
        cmocka_unit_test(kernels_read_the_outcome_of_a_build),
        cmocka_unit_test(kernels_read_the_outcome_of_a_build_drawn_by_opengl),
    };
    return cmocka_run_group_tests_name("workspace", tests, fixture_group_setup, fixture_group_teardown);
}
