/* SPDX-License-Identifier: MIT */
/*
 * The path of CPUs and the path of GPUs on one device: other kernels, and the same trees, hits and pictures, byte for
 * byte. Tests that run again with SVOCL_TEST_PATH=gpu compare with references what the kernels of GPUs make.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/device.h"
#include "support/attributed_mesh.h"
#include "support/info_of.h"
#include "support/ray_check.h"
#include "support/suite.h"

#define RAYS         1024
#define PICTURE_SIDE 61 /* no multiple of a tile */

typedef struct both {
    fixture cpu, gpu;
} both;

static int open_both(void **state)
{
    static both opened;
    fixture_open_cl(&(fixture_options){.path = SVO_PATH_CPU}, &opened.cpu);
    fixture_open_cl(&(fixture_options){.path = SVO_PATH_GPU}, &opened.gpu);
    *state = &opened;
    return 0;
}

static int close_both(void **state)
{
    both *opened = *state;
    fixture_close(&opened->cpu);
    fixture_close(&opened->gpu);
    return 0;
}

/* ---- kernels ---- */

/* Whether a program of the plan is compiled with the define. */
static bool plan_defines(const fixture *opened, const svo_mesh *mesh, const char *define)
{
    bool found = false;
    svo_plan *plan = NULL;
    const svo_plan_options options = {.struct_size = sizeof options, .need = SVO_NEED_COLOR};
    assert_int_equal(svo_plan_create(opened->device, mesh, 6, &options, &plan), SVO_OK);
    for (size_t i = 0; i < info_of_plan(plan).kernels_count; ++i) {
        svo_kernels_info info = SVO_KERNELS_INFO_INIT;
        assert_int_equal(svo_plan_get_kernels(plan, i, &info), SVO_OK);
        found = found || strstr(info.defines, define) != NULL;
    }
    svo_plan_destroy(&plan);
    return found;
}

static void each_path_has_its_kernels(void **state)
{
    static const char *const defines[] = {"-DSVO_ONE_WORKER", "-DSVO_COLUMN_LANES"};
    const both *opened = *state;
    attributed_mesh made;
    attributed_mesh_create(1, 100, 0.1, &made);
    for (size_t i = 0; i < sizeof defines / sizeof defines[0]; ++i) {
        assert_true(plan_defines(&opened->cpu, &made.mesh, defines[i]));
        assert_false(plan_defines(&opened->gpu, &made.mesh, defines[i]));
    }
    assert_false(plan_defines(&opened->gpu, &made.mesh, "-DSVO_PAIR_LANES"));
    attributed_mesh_destroy(&made);
}

/* ---- trees ---- */

static void trees_are_the_same(void **state)
{
    const both *opened = *state;
    const struct {
        svo_plan_options options;
        unsigned depth;
        size_t triangles;
        double reach;
    } rows[] = {
        {{.builder = SVO_BUILDER_CL, .need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_MATERIAL},
         6,
         200,
         0.1},
        {{.builder = SVO_BUILDER_SORTED, .need = SVO_NEED_COLOR | SVO_NEED_RAYS | SVO_NEED_FILL}, 6, 100, 0.1},
        {{.weights = SVO_WEIGHTS_CENTER, .need = SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA}, 5, 50, 0.4},
        {{.weights = SVO_WEIGHTS_UNIFORM, .coverage = SVO_COVERAGE_THIN, .need = SVO_NEED_COLOR}, 7, 50, 0.01},
        {{.coverage = SVO_COVERAGE_CLOSED, .place = SVO_PLACE_DEVICE, .need = SVO_NEED_COLOR}, 5, 50, 0.9},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        attributed_mesh made;
        built by_cpu;
        built by_gpu;
        attributed_mesh_create(20 + i, rows[i].triangles, rows[i].reach, &made);
        fixture_build(&opened->cpu, &made.mesh, rows[i].depth, &rows[i].options, &by_cpu);
        fixture_build(&opened->gpu, &made.mesh, rows[i].depth, &rows[i].options, &by_gpu);
        if (strcmp(by_cpu.hash, by_gpu.hash) != 0) {
            fail_msg("row %zu: %s by the path of CPUs, %s by that of GPUs", i, by_cpu.hash, by_gpu.hash);
        }
        built_destroy(&by_cpu);
        built_destroy(&by_gpu);
        attributed_mesh_destroy(&made);
    }
}

/* ---- rays and pictures ---- */

typedef struct traced {
    svo_hit closest[RAYS], any[RAYS], count[RAYS];
    uint8_t shaded[4 * PICTURE_SIDE * PICTURE_SIDE], normals[4 * PICTURE_SIDE * PICTURE_SIDE];
} traced;

static void draw(const fixture *opened, svo_tree *tree, svo_render_view view, uint8_t *rgba)
{
    svo_render_options options = {
        .struct_size = sizeof options, .width = PICTURE_SIDE, .height = PICTURE_SIDE, .view = view};
    (void)svo_camera_fit(svo_tree_target(tree), 1.0F, &options.camera);
    if (svo_render(svo_tree_target(tree), &options, svo_in_host(rgba), &(svo_submit){.queue = opened->queue}) !=
        SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
}

static traced *trace_all(const fixture *opened, const svo_mesh *mesh, const svo_ray *rays)
{
    built tree;
    traced *out = calloc(1, sizeof *out);
    assert_non_null(out);
    fixture_build(opened, mesh, 5, &(svo_plan_options){.need = SVO_NEED_COLOR | SVO_NEED_RAYS}, &tree);
    trace_rays(opened, &tree, rays, RAYS, 0, out->closest);
    for (size_t i = 0; i < RAYS; ++i) {
        out->closest[i].count = 0; /* leaves visited: each path has its order */
    }
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_ANY, out->any);
    trace_rays(opened, &tree, rays, RAYS, SVO_TRACE_COUNT, out->count);
    draw(opened, tree.tree, SVO_VIEW_SHADED, out->shaded);
    draw(opened, tree.tree, SVO_VIEW_NORMAL, out->normals);
    built_destroy(&tree);
    return out;
}

static size_t count_hits(const svo_hit *hits)
{
    size_t count = 0;
    for (size_t i = 0; i < RAYS; ++i) {
        count += hits[i].triangle != SVO_NO_TRIANGLE;
    }
    return count;
}

/* Pixels of two pictures that differ. */
static size_t count_differing(const uint8_t *one, const uint8_t *other)
{
    size_t count = 0;
    for (size_t i = 0; i < (size_t)PICTURE_SIDE * PICTURE_SIDE; ++i) {
        count += memcmp(one + 4 * i, other + 4 * i, 4) != 0 ? 1 : 0;
    }
    return count;
}

static void hits_and_pictures_are_the_same(void **state)
{
    const both *opened = *state;
    uint64_t random = 7;
    attributed_mesh made;
    attributed_mesh_create(3, 200, 0.1, &made);
    svo_ray *rays = calloc(RAYS, sizeof *rays);
    assert_non_null(rays);
    for (size_t i = 0; i < RAYS; ++i) {
        rays[i] = i % 2 == 0 || i == 0 ? random_ray(&random, 3.0) : rays[i - 1]; /* neighbors that are coherent */
    }
    traced *by_cpu = trace_all(&opened->cpu, &made.mesh, rays);
    traced *by_gpu = trace_all(&opened->gpu, &made.mesh, rays);
    assert_in_range(count_hits(by_cpu->closest), RAYS / 16, RAYS);
    assert_memory_equal(by_cpu->closest, by_gpu->closest, sizeof by_cpu->closest);
    for (size_t i = 0; i < RAYS; ++i) { /* which triangle shadows a ray is left open */
        assert_int_equal(by_cpu->any[i].triangle == SVO_NO_TRIANGLE, by_gpu->any[i].triangle == SVO_NO_TRIANGLE);
    }
    assert_memory_equal(by_cpu->count, by_gpu->count, sizeof by_cpu->count);
    /* Rays that go on behind what shows in part graze many voxels, at some of which rounding decides. */
    assert_in_range(count_differing(by_cpu->shaded, by_gpu->shaded), 0, PICTURE_SIDE * PICTURE_SIDE / 200);
    assert_memory_equal(by_cpu->normals, by_gpu->normals, sizeof by_cpu->normals);
    free(by_cpu);
    free(by_gpu);
    free(rays);
    attributed_mesh_destroy(&made);
}

TEST_GROUP(paths)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_path_has_its_kernels),
        cmocka_unit_test(trees_are_the_same),
        cmocka_unit_test(hits_and_pictures_are_the_same),
    };
    return cmocka_run_group_tests_name("paths", tests, open_both, close_both);
}
