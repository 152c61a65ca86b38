/* SPDX-License-Identifier: MIT */
/*
 * The OpenCL front end against the exact references, on the ill-conditioned rows of the catalog. Needs no OpenGL.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "core/device.h"
#include "scenes.h"
#include "shared/layout.h"
#include "support/compare_tree.h"
#include "support/meshes.h"
#include "support/suite.h"

#define NEED_ALL (SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS)

static const svo_coverage coverages[] = {SVO_COVERAGE_HALF_OPEN, SVO_COVERAGE_CLOSED, SVO_COVERAGE_THIN};
#define COVERAGES (sizeof coverages / sizeof coverages[0])

static void check_exact(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                        svo_build_report *report)
{
    built actual;
    fixture_build(opened, mesh, depth, options, &actual);
    assert_string_equal(actual.report.frontend, "cl");
    assert_string_equal(actual.report.share, "none");
    assert_build_is_exact(mesh, options, &actual);
    *report = actual.report;
    built_destroy(&actual);
}

/* All kinds of triangles, on the fitted grid and on one that they reach far out of: every class, both code lengths. */
static void random_meshes_are_exact(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint64_t seed = 1; seed <= (suite_is_long() ? 24 : 12); ++seed) {
        const unsigned depth = 1 + (unsigned)seed % 7;
        const svo_plan_options options = {
            .need = SVO_NEED_RAYS, .coverage = coverages[seed % COVERAGES], .edge = seed % 2 == 0 ? 0.0 : 1.0};
        svo_build_report report;
        owned_mesh made;
        print_message("seed %llu\n", (unsigned long long)seed);
        random_mesh(seed, 200, seed % 4 == 1 ? 300.0 : seed % 4 == 3 ? 0.5 : 0.0, &made);
        check_exact(&opened, &made.mesh, depth, &options, &report);
        owned_mesh_free(&made);
    }
}

/* T3 and T9: needles and small triangles at every depth. */
static void t9_every_depth_is_exact(void **state)
{
    static const double corner[3] = {0.493, 0.249, 0.121};
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned depth = SVO_DEPTH_MIN; depth <= SVO_DEPTH_MAX; ++depth) {
        for (size_t i = suite_is_long() ? 0 : depth % COVERAGES; i < COVERAGES; i += suite_is_long() ? 1 : COVERAGES) {
            const double width = 24.0 / (double)(1u << depth);
            const svo_plan_options options = {.need = SVO_NEED_RAYS, .coverage = coverages[i], .edge = 1.0};
            svo_build_report report;
            owned_mesh made;
            random_dust(depth, 60, corner, width < 0.5 ? width : 0.5, &made);
            check_exact(&opened, &made.mesh, depth, &options, &report);
            owned_mesh_free(&made);
        }
    }
    for (uint64_t seed = 1; seed <= 3; ++seed) {
        const svo_plan_options options = {.need = SVO_NEED_RAYS, .coverage = coverages[seed - 1]};
        svo_build_report report;
        owned_mesh made;
        random_needles(seed, 100, &made);
        check_exact(&opened, &made.mesh, 8, &options, &report);
        owned_mesh_free(&made);
    }
}

/* T7: triangles across the whole grid, which are split into tiles, and small ones; in one chunk, and in chunks smaller
   than the triangles. */
static void t7_large_triangles_are_cut_into_tiles(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        uint64_t random = seed;
        svo_build_report report;
        owned_mesh made;
        random_dust(seed, 2000, (const double[3]){0, 0, 0}, 1.0, &made);
        for (size_t i = 0; i < made.mesh.triangle_count * 9; ++i) {
            const double first = made.positions[i / 9 * 9 + i % 3];
            made.positions[i] = i < 27 ? random_unit(&random) * 1.2 - 0.1 : first + random_unit(&random) * 0.004;
        }
        const svo_plan_options options = {.need = SVO_NEED_RAYS,
                                          .coverage = coverages[seed % COVERAGES],
                                          .edge = 1.0,
                                          .chunk_bytes = seed % 2 == 0 ? 0 : 65536};
        check_exact(&opened, &made.mesh, 8, &options, &report);
        assert_in_range(report.list_chunks, seed % 2 == 0 ? 1 : 2, seed % 2 == 0 ? 1 : 1000);
        owned_mesh_free(&made);
    }
}

/* T10: lists with a capacity of one fragment, of all but one, and of exactly all. */
static void t10_lists_grow_to_the_exact_need(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (unsigned depth = 6; depth <= 11; depth += 5) {
        owned_mesh made;
        built expected;
        random_mesh(depth, depth == 6 ? 150 : 2, 0.0, &made); /* large triangles */
        fixture_build(&opened, &made.mesh, depth, &(svo_plan_options){.need = NEED_ALL}, &expected);
        const uint64_t needed = expected.report.fragments;
        const uint64_t room = needed + expected.report.undecided;
        const uint64_t capacities[] = {1, needed - 1, room, room + 1};
        for (size_t i = 0; i < 4; ++i) {
            const svo_plan_options options = {.need = NEED_ALL, .fragment_capacity = capacities[i]};
            built actual;
            fixture_build(&opened, &made.mesh, depth, &options, &actual);
            assert_string_equal(actual.hash, expected.hash);
            assert_int_equal(actual.report.fragments, needed);
            assert_int_equal(actual.report.reruns, capacities[i] < needed ? 1 : 0);
            built_destroy(&actual);
        }
        built_destroy(&expected);
        owned_mesh_free(&made);
    }
}

/* Segments that run steeply along an axis outside the grid, so that their bounds inside the grid do not show their
   direction. */
static void steep_segments_beyond_the_grid_are_exact(void **state)
{
    static const double ends[][3] = {{8, 8, 400}, {400, 8, 8}, {8, 400, 8}, {-300, 7, -2}, {1.5, 1.5, -511}};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; ++i) {
        for (size_t c = 0; c < COVERAGES; ++c) {
            const double positions[9] = {0, 0, 0, ends[i][0], ends[i][1], ends[i][2], 0, 0, 0};
            const svo_mesh mesh = {
                .struct_size = sizeof mesh, .positions_double = positions, .vertex_count = 3, .triangle_count = 1};
            const svo_plan_options options = {.need = SVO_NEED_RAYS, .coverage = coverages[c], .edge = 1.0};
            svo_build_report report;
            check_exact(&opened, &mesh, 7, &options, &report);
        }
    }
}

static uint64_t bytes_of(const built *actual, const char *name)
{
    for (size_t i = 0; i < actual->buffer_count; ++i) {
        if (strcmp(actual->buffers[i].name, name) == 0) {
            return actual->buffers[i].bytes;
        }
    }
    return 0;
}

/* The plan's list has the front end's buffers, its time is measured on the device, and its kernels are compiled
   before. */
static void buffers_and_times_are_reported(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    scene *made = fixture_scene("knot:2000");
    built actual;
    const svo_mesh *mesh = scene_mesh(made);
    fixture_build(&opened, mesh, 8, &(svo_plan_options){.need = SVO_NEED_NONE}, &actual);
    assert_int_equal(bytes_of(&actual, "mesh_vertices"), mesh->vertex_count * 12);
    assert_int_equal(bytes_of(&actual, "mesh_indices"), mesh->triangle_count * 12);
    assert_int_equal(bytes_of(&actual, "mesh_items"), mesh->triangle_count * sizeof(svo_draw_item));
    assert_true(bytes_of(&actual, "fragments") >= actual.report.fragments * 8);
    assert_true(bytes_of(&actual, "counters") > 0);
    assert_string_equal(actual.report.stage_times[SVO_STAGE_VOXELIZE].clock, "cl-event");
    assert_true(actual.report.stage_times[SVO_STAGE_VOXELIZE].ms > 0.0);
    built_destroy(&actual);
    scene_destroy(&made);
}

static void queues_of_all_kinds_give_the_same_tree(void **state)
{
    static const cl_command_queue_properties kinds[] = {
        0, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE | CL_QUEUE_PROFILING_ENABLE};
    const fixture opened = fixture_cl_of_group(state);
    owned_mesh made;
    built expected;
    random_mesh(5, 300, 0.0, &made);
    const svo_plan_options options = {.need = NEED_ALL, .chunk_bytes = 65536};
    fixture_build(&opened, &made.mesh, 6, &options, &expected);
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        fixture other;
        built actual;
        fixture_open_cl(&(fixture_options){.queue_properties = kinds[i]}, &other);
        fixture_build(&other, &made.mesh, 6, &options, &actual);
        assert_string_equal(actual.hash, expected.hash);
        assert_string_equal(actual.report.stage_times[SVO_STAGE_VOXELIZE].clock,
                            (kinds[i] & CL_QUEUE_PROFILING_ENABLE) != 0 ? "cl-event" : "wall");
        built_destroy(&actual);
        fixture_close(&other);
    }
    built_destroy(&expected);
    owned_mesh_free(&made);
}

static void arguments_are_checked(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_frontend *none = NULL;
    assert_int_equal(svo_frontend_create_cl(NULL, &none), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_frontend_create_cl(opened.device, NULL), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened.device), "svo_frontend_create_cl: out"));
    svo_frontend_destroy(NULL);
    svo_frontend_destroy(&none);
    assert_string_equal(svo_frontend_name(opened.cl), "cl");
    assert_string_equal(svo_frontend_share(opened.cl), "none");
}

/* A few triangles do not justify the start of OpenGL, many do; the reason is reported in both cases. */
static void small_plans_need_no_opengl(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const struct {
        const char *scene;
        unsigned depth;
        int suffices;
    } cases[] = {{"cube", 5, 1}, {"cube", 9, 0}, {"knot:2000", 4, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        svo_message reason = {""};
        scene *made = fixture_scene(cases[i].scene);
        svo_plan *plan = NULL;
        assert_int_equal(svo_plan_create(opened.device, scene_mesh(made), cases[i].depth, NULL, &plan), SVO_OK);
        assert_int_equal(svo_frontend_cl_suffices(plan, NULL), cases[i].suffices);
        svo_frontend_cl_suffices(plan, &reason);
        print_message("%s\n", reason.text);
        assert_non_null(strstr(reason.text, cases[i].suffices ? "too few" : "enough"));
        svo_plan_destroy(&plan);
        scene_destroy(&made);
    }
}

static int setup_for_gpus(void **state)
{
    const int failed = fixture_group_setup_unoptimized(state);
    if (failed == 0) {
        fixture_open_cl(&(fixture_options){.queue_properties = CL_QUEUE_PROFILING_ENABLE, .path = SVO_PATH_GPU},
                        *state);
    }
    return failed;
}

TEST_GROUP(voxelize)
{
    const struct CMUnitTest on_gpus[] = {
        cmocka_unit_test(random_meshes_are_exact),
        cmocka_unit_test(t9_every_depth_is_exact),
        cmocka_unit_test(t7_large_triangles_are_cut_into_tiles),
        cmocka_unit_test(t10_lists_grow_to_the_exact_need),
        cmocka_unit_test(steep_segments_beyond_the_grid_are_exact),
    };
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_meshes_are_exact),
        cmocka_unit_test(t9_every_depth_is_exact),
        cmocka_unit_test(t7_large_triangles_are_cut_into_tiles),
        cmocka_unit_test(t10_lists_grow_to_the_exact_need),
        cmocka_unit_test(steep_segments_beyond_the_grid_are_exact),
        cmocka_unit_test(buffers_and_times_are_reported),
        cmocka_unit_test(queues_of_all_kinds_give_the_same_tree),
        cmocka_unit_test(arguments_are_checked),
        cmocka_unit_test(small_plans_need_no_opengl),
    };
    return cmocka_run_group_tests_name("voxelize", tests, fixture_group_setup, fixture_group_teardown) +
           cmocka_run_group_tests_name("the path of GPUs", on_gpus, setup_for_gpus, fixture_group_teardown_unoptimized);
}
