/* SPDX-License-Identifier: MIT */
/*
 * Plans whose mesh moves: after an update they make the trees of new plans, byte for byte; updates allocate, compile
 * and wait for nothing; what no longer fits is reported, and other trees stay.
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

#include "support/attributed_mesh.h"
#include "support/counting.h"
#include "support/enqueued.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/memory_ledger.h"
#include "support/suite.h"

enum { MOVES = 3 };

/* ---- a mesh that moves ---- */

/* Random positions and normals of one mesh after the other; all else is the first's. */
typedef struct moving {
    attributed_mesh first, at[MOVES];
    float *floats; /* NULL: positions are doubles */
    svo_mesh mesh; /* as it is now */
} moving;

static void take_floats(moving *m, const double *positions)
{
    for (size_t i = 0; i < m->mesh.vertex_count * 3 && m->floats != NULL; ++i) {
        m->floats[i] = (float)positions[i];
        m->mesh.positions = m->floats;
        m->mesh.positions_double = NULL;
    }
}

static void moving_create(uint64_t seed, size_t triangles, double reach, bool in_floats, moving *out)
{
    attributed_mesh_create(seed, triangles, reach, &out->first);
    for (int i = 0; i < MOVES; ++i) {
        attributed_mesh_create(seed * 31 + 7 + (uint64_t)i, triangles, reach, &out->at[i]);
    }
    out->mesh = out->first.mesh;
    out->mesh.struct_size = sizeof out->mesh;
    out->floats = in_floats ? malloc(out->mesh.vertex_count * 3 * sizeof *out->floats) : NULL;
    assert_true(!in_floats || out->floats != NULL);
    take_floats(out, out->first.base.positions);
}

static void moving_destroy(moving *m)
{
    free(m->floats);
    attributed_mesh_destroy(&m->first);
    for (int i = 0; i < MOVES; ++i) {
        attributed_mesh_destroy(&m->at[i]);
    }
}

/* Moves the mesh; move: below MOVES. Some triangles become segments and points, some are not finite or far away. */
static void move_to(moving *m, int move)
{
    attributed_mesh *to = &m->at[move];
    double *positions = to->base.positions;
    const size_t vertices = m->mesh.vertex_count;
    for (size_t v = 0; v + 9 < vertices; v += 97) {
        memcpy(positions + (v + 1) * 3, positions + v * 3, 3 * sizeof *positions);
        positions[(v + 4) * 3] = v % 2 == 0 ? (double)NAN : 1e9;
        positions[(v + 7) * 3 + 1] += 3.0;
    }
    m->mesh.positions_double = positions;
    m->mesh.normals = to->normals;
    take_floats(m, positions);
}

/* ---- trees ---- */

static svo_plan_options updatable(uint32_t need)
{
    return (svo_plan_options){.struct_size = sizeof(svo_plan_options),
                              .need = need,
                              .edge = 1.0,
                              .updatable = 1,
                              .fragment_capacity = 1 << 20,
                              .worst_case_nodes = 1};
}

typedef struct outcome {
    char hash[SVO_HASH_TEXT_BYTES];
    svo_tree_info info;
} outcome;

static outcome outcome_of(const fixture *opened, svo_tree *tree)
{
    outcome found = {.info = SVO_TREE_INFO_INIT};
    succeed(opened, svo_tree_download(tree, opened->queue));
    succeed(opened, svo_tree_hash(tree, SVO_HASH_ALL, found.hash));
    succeed(opened, svo_tree_get_info(tree, &found.info));
    return found;
}

static outcome build_now(const fixture *opened, svo_plan *plan)
{
    svo_tree *tree = NULL;
    succeed(opened, svo_build(plan, opened->frontend, opened->queue, &tree, NULL));
    const outcome found = outcome_of(opened, tree);
    svo_tree_destroy(&tree);
    return found;
}

static outcome build_of_new_plan(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_plan_options options)
{
    svo_plan *plan = make_plan(opened, mesh, depth, options);
    const outcome found = build_now(opened, plan);
    svo_plan_destroy(&plan);
    return found;
}

static outcome enqueue_and_finish(const fixture *opened, svo_workspace *workspace, svo_tree *tree)
{
    succeed(opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_tree_finish(tree, opened->queue, 0, NULL));
    return outcome_of(opened, tree);
}

static void assert_same(const outcome *actual, const outcome *expected)
{
    assert_string_equal(actual->hash, expected->hash);
    assert_int_equal(actual->info.refused_triangles, expected->info.refused_triangles);
    assert_int_equal(actual->info.list_triangle_count, expected->info.list_triangle_count);
    assert_int_equal(actual->info.fragments, expected->info.fragments);
}

/* ---- equality ---- */

/* The builds of an updated plan, blocking and enqueued, of a new one, and of a new one that cannot be updated. */
static void compare_moves(const fixture *opened, moving *m, unsigned depth, svo_plan_options options)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_plan *plan = make_plan(opened, &m->mesh, depth, options);
    svo_workspace *workspace = make_workspace(opened, plan);
    svo_tree *trees[2] = {make_tree(opened, workspace), make_tree(opened, workspace)};
    succeed(opened, svo_plan_get_info(plan, &info));
    options.weight_log2 = info.weight_log2;
    for (int i = 0; i < MOVES; ++i) {
        svo_plan_options fixed = options;
        fixed.updatable = 0;
        move_to(m, i);
        succeed(opened, svo_plan_update(plan, &m->mesh, &(svo_submit){.queue = opened->queue}));
        const outcome enqueued = enqueue_and_finish(opened, workspace, trees[i % 2]);
        const outcome blocking = build_now(opened, plan);
        const outcome renewed = build_of_new_plan(opened, &m->mesh, depth, options);
        const outcome separate = build_of_new_plan(opened, &m->mesh, depth, fixed);
        assert_same(&enqueued, &renewed);
        assert_same(&blocking, &renewed);
        assert_same(&separate, &renewed);
    }
    svo_tree_destroy(&trees[0]);
    svo_tree_destroy(&trees[1]);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
}

static void updated_plans_equal_new_ones(void **state)
{
    static const unsigned depths[] = {2, 6, 8};
    const fixture opened = fixture_cl_of_group(state);
    for (int coverage = 0; coverage <= SVO_COVERAGE_THIN; ++coverage) {
        for (size_t d = 0; d < sizeof depths / sizeof depths[0]; ++d) {
            moving m;
            svo_plan_options options = updatable(SVO_NEED_ALL);
            options.coverage = (svo_coverage)coverage;
            moving_create(11 + d, 300, 0.3, d % 2 == 0, &m);
            compare_moves(&opened, &m, depths[d], options);
            moving_destroy(&m);
        }
    }
}

static void every_kind_of_request_can_move(void **state)
{
    static const uint32_t needs[] = {SVO_NEED_NONE, SVO_NEED_DEFAULT, SVO_NEED_RAYS, SVO_NEED_MATERIAL,
                                     SVO_NEED_NORMAL};
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        moving m;
        svo_plan_options options = updatable(needs[i]);
        options.weights = (svo_weights)(i % 3);
        moving_create(70 + i, 130, 0.2, true, &m);
        compare_moves(&opened, &m, 7, options);
        moving_destroy(&m);
    }
}

/* Grids finer than 2^20 units, views of 2^13 columns, and triangles of many tiles. */
static void deep_grids_can_move(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    moving m;
    moving_create(5, 12, 0.0, false, &m);
    for (size_t i = 0; i < m.mesh.vertex_count * 3; ++i) {
        m.first.base.positions[i] *= 0.008;
        for (int k = 0; k < MOVES; ++k) {
            m.at[k].base.positions[i] *= 0.008;
        }
    }
    compare_moves(&opened, &m, 14, updatable(SVO_NEED_RAYS));
    moving_destroy(&m);
}

/* ---- buffers ---- */

/* Positions and normals between other bytes, at an odd offset. */
static void buffers_move_the_mesh(void **state)
{
    enum { STRIDE = 29, OFFSET = 5 };
    const fixture opened = fixture_cl_of_group(state);
    svo_plan_options options = updatable(SVO_NEED_RAYS | SVO_NEED_NORMAL | SVO_NEED_COLOR);
    options.weight_log2 = 20;
    moving m;
    moving_create(3, 200, 0.1, true, &m);
    move_to(&m, 0);
    const size_t bytes = OFFSET + STRIDE * m.mesh.vertex_count;
    uint8_t *packed = calloc(1, bytes);
    assert_non_null(packed);
    cl_mem memory = clCreateBuffer(info_of_device(opened.device).context, CL_MEM_READ_WRITE, bytes, NULL, NULL);
    assert_non_null(memory);
    svo_plan *plan = make_plan(&opened, &m.mesh, 6, options);
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *tree = make_tree(&opened, workspace);
    svo_mesh_buffers buffers = {.struct_size = sizeof buffers,
                                .vertex_count = m.mesh.vertex_count,
                                .triangle_count = m.mesh.triangle_count,
                                .positions = {.memory = memory, .offset_bytes = OFFSET, .stride_bytes = STRIDE},
                                .normals = {.memory = memory, .offset_bytes = OFFSET + 13, .stride_bytes = STRIDE}};
    for (int i = 0; i < MOVES; ++i) {
        cl_event written = NULL;
        move_to(&m, i);
        for (size_t v = 0; v < m.mesh.vertex_count; ++v) {
            memcpy(packed + OFFSET + STRIDE * v, m.mesh.positions + v * 3, 12);
            memcpy(packed + OFFSET + STRIDE * v + 13, m.mesh.normals + v * 3, 12);
        }
        assert_int_equal(clEnqueueWriteBuffer(opened.queue, memory, CL_FALSE, 0, bytes, packed, 0, NULL, &written),
                         CL_SUCCESS);
        succeed(&opened, svo_plan_update_from_buffers(
                             plan, &buffers, &(svo_submit){.queue = opened.queue, .num_wait = 1, .wait = &written}));
        const outcome actual = enqueue_and_finish(&opened, workspace, tree);
        const outcome expected = build_of_new_plan(&opened, &m.mesh, 6, options);
        assert_same(&actual, &expected);
        clReleaseEvent(written);
    }
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    clReleaseMemObject(memory);
    free(packed);
    moving_destroy(&m);
}

/* ---- nothing allocated, compiled or waited for ---- */

static svo_mesh one_triangle(const float positions[9])
{
    return (svo_mesh){.struct_size = sizeof(svo_mesh), .positions = positions, .vertex_count = 3, .triangle_count = 1};
}

/* An update and a build wait for an event that comes last: a call that waited would not return. */
static void updates_allocate_compile_and_wait_for_nothing(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    cl_int error = CL_SUCCESS;
    moving m;
    moving_create(9, 250, 0.1, true, &m);
    svo_plan *plan = make_plan(&opened, &m.mesh, 6, updatable(SVO_NEED_ALL));
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *tree = make_tree(&opened, workspace);
    move_to(&m, 0);
    cl_event go = clCreateUserEvent(info_of_device(opened.device).context, &error);
    assert_int_equal(error, CL_SUCCESS);
    cl_event moved = NULL;
    counting_begin();
    succeed(&opened,
            svo_plan_update(plan, &m.mesh,
                            &(svo_submit){.queue = opened.queue, .num_wait = 1, .wait = &go, .event = &moved}));
    succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
    succeed(&opened, svo_plan_update(plan, &m.mesh, &(svo_submit){.queue = opened.queue}));
    const counted figures = counting_read();
    assert_int_equal(clSetUserEventStatus(go, CL_COMPLETE), CL_SUCCESS);
    succeed(&opened, svo_tree_finish(tree, opened.queue, 0, NULL));
    assert_int_equal(figures.buffers, 0);
    assert_int_equal(figures.sub_buffers, 0);
    assert_int_equal(figures.programs, 0);
    assert_int_equal(figures.builds, 0);
    assert_int_equal(figures.waits, 0);
    clReleaseEvent(moved);
    clReleaseEvent(go);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    moving_destroy(&m);
}

static void memory_is_flat(void **state)
{
    enum { UPDATES = 10000, WARM = 100 };
    (void)state;
    const svo_device_options options = {.struct_size = sizeof options, .memory = &ledger_callbacks};
    float positions[9] = {0.1F, 0.1F, 0.1F, 0.3F, 0.1F, 0.1F, 0.1F, 0.4F, 0.1F};
    const svo_mesh mesh = one_triangle(positions);
    fixture opened = {.device = NULL};
    uint64_t blocks = 0;
    assert_int_equal(svo_device_create_default(&options, &opened.device, NULL), SVO_OK);
    assert_int_equal(svo_frontend_create_cl(opened.device, &opened.cl), SVO_OK);
    opened.frontend = opened.cl;
    opened.queue =
        clCreateCommandQueue(info_of_device(opened.device).context, info_of_device(opened.device).device, 0, NULL);
    svo_plan *plan = make_plan(&opened, &mesh, 3, updatable(SVO_NEED_RAYS));
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *trees[2] = {make_tree(&opened, workspace), make_tree(&opened, workspace)};
    for (int i = 0; i < UPDATES; ++i) {
        positions[0] = 0.1F + (float)(i % 64) / 128.0F;
        succeed(&opened, svo_plan_update(plan, &mesh, &(svo_submit){.queue = opened.queue}));
        if (i % 50 == 0) { /* also waits, so that positions may change */
            succeed(&opened, svo_build_enqueue(workspace, trees[i / 50 % 2], &(svo_submit){.queue = opened.queue}));
            succeed(&opened, svo_tree_finish(trees[i / 50 % 2], opened.queue, 0, NULL));
        }
        if (i == WARM) {
            counting_begin();
            ledger_begin(LEDGER_NEVER);
            blocks = ledger_end().live_blocks;
        }
    }
    assert_int_equal(ledger_end().live_blocks, blocks);
    assert_null(ledger_end().wrong);
    assert_int_equal(counting_read().buffers, 0);
    assert_int_equal(counting_read().sub_buffers, 0);
    assert_int_equal(counting_read().builds, 0);
    svo_tree_destroy(&trees[0]);
    svo_tree_destroy(&trees[1]);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    fixture_close(&opened);
}

/* ---- order ---- */

/* Updates and builds go to two queues, and none is waited for before the end: each build has the mesh of its turn. */
static void commands_are_ordered_whatever_the_queues(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = updatable(SVO_NEED_RAYS);
    cl_command_queue other =
        clCreateCommandQueue(info_of_device(opened.device).context, info_of_device(opened.device).device,
                             CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, NULL);
    float positions[MOVES][9];
    svo_tree *trees[MOVES];
    for (int i = 0; i < MOVES * 9; ++i) {
        positions[i / 9][i % 9] = (float)((i * 37 + 11) % 64) / 64.0F;
    }
    const svo_mesh first = one_triangle(positions[0]);
    svo_plan *plan = make_plan(&opened, &first, 7, options);
    svo_workspace *workspace = make_workspace(&opened, plan);
    for (int i = 0; i < MOVES; ++i) {
        const svo_mesh mesh = one_triangle(positions[i]);
        trees[i] = make_tree(&opened, workspace);
        succeed(&opened, svo_plan_update(plan, &mesh, &(svo_submit){.queue = i % 2 == 0 ? other : opened.queue}));
        succeed(&opened,
                svo_build_enqueue(workspace, trees[i], &(svo_submit){.queue = i % 2 == 0 ? opened.queue : other}));
    }
    for (int i = 0; i < MOVES; ++i) {
        const svo_mesh mesh = one_triangle(positions[i]);
        succeed(&opened, svo_tree_finish(trees[i], opened.queue, 0, NULL));
        const outcome actual = outcome_of(&opened, trees[i]);
        const outcome expected = build_of_new_plan(&opened, &mesh, 7, options);
        assert_same(&actual, &expected);
        svo_tree_destroy(&trees[i]);
    }
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    clReleaseCommandQueue(other);
}

/* ---- what does not fit ---- */

/* A triangle grows; the figures that are reported suffice, and the other tree keeps its content. large: the triangle
   has more columns than a tile, and its tiles do not fit either. */
static void check_capacity(const fixture *opened, bool large)
{
    float positions[9] = {0.1F, 0.1F, 0.1F, 0.101F, 0.1F, 0.1F, 0.1F, 0.101F, 0.1F};
    const float far = large ? 1.0F : 0.13F;
    const svo_mesh mesh = one_triangle(positions);
    svo_plan_options options = updatable(SVO_NEED_RAYS);
    options.fragment_capacity = 16;
    svo_plan *plan = make_plan(opened, &mesh, large ? 10 : 8, options);
    svo_workspace *workspace = make_workspace(opened, plan);
    svo_tree *trees[2] = {make_tree(opened, workspace), make_tree(opened, workspace)};
    svo_build_report report = {.struct_size = sizeof report};
    const outcome before = enqueue_and_finish(opened, workspace, trees[0]);
    positions[3] = positions[7] = far;
    succeed(opened, svo_plan_update(plan, &mesh, NULL));
    succeed(opened, svo_build_enqueue(workspace, trees[1], &(svo_submit){.queue = opened->queue}));
    assert_int_equal(svo_tree_finish(trees[1], opened->queue, 0, &report), SVO_CAPACITY_EXCEEDED);
    const outcome after = outcome_of(opened, trees[0]);
    assert_same(&after, &before);
    options.fragment_capacity = report.fragments;
    svo_plan *larger = make_plan(opened, &mesh, large ? 10 : 8, options);
    svo_workspace *roomy = make_workspace(opened, larger);
    svo_tree *tree = make_tree(opened, roomy);
    const outcome fits = enqueue_and_finish(opened, roomy, tree);
    options.updatable = 0;
    const outcome expected = build_of_new_plan(opened, &mesh, large ? 10 : 8, options);
    assert_same(&fits, &expected);
    const outcome grown = build_now(opened, plan); /* a blocking build grows its list */
    assert_same(&grown, &expected);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&roomy);
    svo_plan_destroy(&larger);
    svo_tree_destroy(&trees[0]);
    svo_tree_destroy(&trees[1]);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
}

static void what_does_not_fit_is_reported_and_other_trees_stay(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    check_capacity(&opened, false);
    check_capacity(&opened, true);
}

static void a_mesh_may_outgrow_its_unit_of_weight(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    float positions[9] = {0.0F, 0.0F, 0.5F, 0.25F, 0.0F, 0.5F, 0.0F, 0.25F, 0.5F};
    const svo_mesh mesh = one_triangle(positions);
    svo_plan_options options = updatable(SVO_NEED_FILL | SVO_NEED_NORMAL);
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    svo_tree *tree = NULL;
    options.max_area = 0.04;
    svo_plan *plan = make_plan(&opened, &mesh, 12, options);
    positions[3] = positions[7] = 1.0F;
    succeed(&opened, svo_plan_update(plan, &mesh, NULL));
    assert_int_equal(svo_build(plan, opened.frontend, opened.queue, &tree, NULL), SVO_CAPACITY_EXCEEDED);
    assert_non_null(strstr(svo_device_message(opened.device), "max_area"));
    svo_plan_destroy(&plan);
    assert_int_equal(svo_plan_create(opened.device, &mesh, 12, &options, &plan), SVO_CAPACITY_EXCEEDED);
    options.max_area = 0.5;
    plan = make_plan(&opened, &mesh, 12, options);
    succeed(&opened, svo_plan_get_info(plan, &info));
    assert_true(fabs(info.area * sqrt(3.0) - 0.5) < 1e-5); /* one projection has all of it */
    assert_in_range(info.weight_log2, 13, 30);
    svo_plan_destroy(&plan);
}

/* ---- arguments ---- */

static void wrong_requests_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    float positions[9] = {0};
    const svo_mesh mesh = one_triangle(positions);
    const svo_plan_options right = updatable(SVO_NEED_NONE);
    svo_plan *plan = NULL;
    svo_plan_options wrong[6] = {right, right, right, right, right, right};
    wrong[0].edge = 0.0;
    wrong[1].place = SVO_PLACE_HOST;
    wrong[2].max_area = -1.0;
    wrong[3].max_area = (double)INFINITY;
    wrong[4].weight_log2 = 12;
    wrong[5].weight_log2 = 31;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        assert_int_equal(svo_plan_create(opened.device, &mesh, 5, &wrong[i], &plan), SVO_INVALID_ARGUMENT);
    }
    svo_mesh empty = mesh;
    empty.triangle_count = 0;
    assert_int_equal(svo_plan_create(opened.device, &empty, 5, &right, &plan), SVO_INVALID_ARGUMENT);
    /* A unit of weight that a plan's mesh may not have. */
    svo_plan_options fine = {.struct_size = sizeof fine, .need = SVO_NEED_NORMAL, .edge = 1.0, .weight_log2 = 60};
    assert_int_equal(svo_plan_create(opened.device, &mesh, 5, &fine, &plan), SVO_INVALID_ARGUMENT);
    assert_null(plan);
}

static void wrong_updates_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    float positions[9] = {0};
    float normals[9] = {0};
    double doubles[9] = {0};
    svo_mesh mesh = one_triangle(positions);
    svo_plan_options fixed = {.struct_size = sizeof fixed, .edge = 1.0};
    mesh.normals = normals;
    svo_plan *plan = make_plan(&opened, &mesh, 5, updatable(SVO_NEED_NORMAL));
    svo_plan *other = make_plan(&opened, &mesh, 5, fixed);
    svo_mesh wrong[4] = {mesh, mesh, mesh, mesh};
    wrong[0].vertex_count = 2;
    wrong[1].triangle_count = 2;
    wrong[2].positions = NULL;
    wrong[2].positions_double = doubles;
    wrong[3].normals = NULL;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        assert_int_equal(svo_plan_update(plan, &wrong[i], NULL), SVO_INVALID_ARGUMENT);
    }
    assert_int_equal(svo_plan_update(NULL, &mesh, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_plan_update(plan, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_plan_update(other, &mesh, NULL), SVO_INVALID_ARGUMENT);
    const svo_mesh_buffers none = {.struct_size = sizeof none, .vertex_count = 3, .triangle_count = 1};
    assert_int_equal(svo_plan_update_from_buffers(plan, &none, &(svo_submit){.queue = opened.queue}),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_plan_count(plan, opened.frontend, opened.queue), SVO_UNSUPPORTED);
    succeed(&opened, svo_plan_update(plan, &mesh, NULL)); /* none of it has done harm */
    svo_plan_destroy(&plan);
    svo_plan_destroy(&other);
}

/* After an update that failed midway the plan has no mesh, until another succeeds. */
static void a_failed_update_takes_the_mesh_away(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    float positions[9] = {0.1F, 0.1F, 0.1F, 0.3F, 0.1F, 0.1F, 0.1F, 0.4F, 0.1F};
    const svo_mesh mesh = one_triangle(positions);
    svo_plan *plan = make_plan(&opened, &mesh, 5, updatable(SVO_NEED_NONE));
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *tree = make_tree(&opened, workspace);
    const outcome before = enqueue_and_finish(&opened, workspace, tree);
    for (size_t launch = 0; launch < 4; ++launch) {
        svo_tree *none = NULL;
        counting_fail_launch(launch);
        assert_int_equal(svo_plan_update(plan, &mesh, &(svo_submit){.queue = opened.queue}), SVO_CL_ERROR);
        assert_int_equal(svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}),
                         SVO_INVALID_ARGUMENT);
        assert_int_equal(svo_build(plan, opened.frontend, opened.queue, &none, NULL), SVO_INVALID_ARGUMENT);
        assert_null(none);
    }
    succeed(&opened, svo_plan_update(plan, &mesh, &(svo_submit){.queue = opened.queue}));
    const outcome after = enqueue_and_finish(&opened, workspace, tree);
    assert_same(&after, &before);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
}

/* ---- events that fail ---- */

/* PoCL aborts where an event fails that commands wait for, so one is said to have failed. */
static struct {
    cl_event failed; /* NULL: none */
    cl_event waited[4]; /* what the newest marker waits for that waits for anything */
    cl_uint waited_count;
} watched;

/* NOLINTBEGIN(readability-identifier-naming): names of the linker */
cl_int __real_clGetEventInfo(cl_event event, cl_event_info name, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetEventInfo(cl_event event, cl_event_info name, size_t bytes, void *value, size_t *needed);
cl_int __wrap_clGetEventInfo(cl_event event, cl_event_info name, size_t bytes, void *value, size_t *needed)
{
    const cl_int error = __real_clGetEventInfo(event, name, bytes, value, needed);
    if (error == CL_SUCCESS && event == watched.failed && name == CL_EVENT_COMMAND_EXECUTION_STATUS) {
        *(cl_int *)value = CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST;
    }
    return error;
}

cl_int __real_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint count, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint count, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueMarkerWithWaitList(cl_command_queue queue, cl_uint count, const cl_event *wait, cl_event *event)
{
    if (count > 0) {
        const size_t most = sizeof watched.waited / sizeof watched.waited[0];
        watched.waited_count = count;
        memcpy(watched.waited, wait, (count < most ? count : most) * sizeof *wait);
    }
    return __real_clEnqueueMarkerWithWaitList(queue, count, wait, event);
}
/* NOLINTEND(readability-identifier-naming) */

static void assert_waited_for(cl_event expected)
{
    assert_int_equal(watched.waited_count, 1);
    assert_ptr_equal(watched.waited[0], expected);
}

/* An update that failed, as after an event of the caller's that did, is waited for by nothing. The one before it, which
   may still run, is. */
static void nothing_waits_for_a_failed_update(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float positions[9] = {0.1F, 0.1F, 0.1F, 0.3F, 0.1F, 0.1F, 0.1F, 0.4F, 0.1F};
    const svo_mesh mesh = one_triangle(positions);
    const svo_plan_options options = updatable(SVO_NEED_NONE);
    svo_plan *plan = make_plan(&opened, &mesh, 5, options);
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *tree = make_tree(&opened, workspace);
    const cl_event gate = clCreateUserEvent(info_of_device(opened.device).context, NULL);
    cl_event held = NULL;
    cl_event failed = NULL;
    succeed(&opened,
            svo_plan_update(plan, &mesh,
                            &(svo_submit){.queue = opened.queue, .num_wait = 1, .wait = &gate, .event = &held}));
    succeed(&opened, svo_plan_update(plan, &mesh, &(svo_submit){.queue = opened.queue, .event = &failed}));
    assert_waited_for(held);
    watched.failed = failed;
    succeed(&opened, svo_plan_update(plan, &mesh, &(svo_submit){.queue = opened.queue}));
    assert_waited_for(held);
    assert_int_equal(clSetUserEventStatus(gate, CL_COMPLETE), CL_SUCCESS);
    succeed(&opened, svo_plan_update(plan, &mesh, &(svo_submit){.queue = opened.queue}));
    const outcome actual = enqueue_and_finish(&opened, workspace, tree);
    const outcome expected = build_of_new_plan(&opened, &mesh, 5, options);
    assert_same(&actual, &expected);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    watched.failed = NULL;
    clReleaseEvent(held);
    clReleaseEvent(failed);
    clReleaseEvent(gate);
}

/* The same for builds in a workspace. */
static void nothing_waits_for_a_failed_build(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const float positions[9] = {0.1F, 0.1F, 0.1F, 0.3F, 0.1F, 0.1F, 0.1F, 0.4F, 0.1F};
    const svo_mesh mesh = one_triangle(positions);
    svo_plan *plan = make_plan(&opened, &mesh, 5, updatable(SVO_NEED_NONE));
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *trees[2] = {make_tree(&opened, workspace), make_tree(&opened, workspace)};
    cl_event failed = NULL;
    succeed(&opened, svo_build_enqueue(workspace, trees[0], &(svo_submit){.queue = opened.queue, .event = &failed}));
    succeed(&opened, svo_tree_finish(trees[0], opened.queue, 0, NULL));
    watched.failed = failed;
    watched.waited_count = 0;
    succeed(&opened, svo_build_enqueue(workspace, trees[1], &(svo_submit){.queue = opened.queue}));
    for (cl_uint i = 0; i < watched.waited_count; ++i) {
        assert_ptr_not_equal(watched.waited[i], failed);
    }
    succeed(&opened, svo_tree_finish(trees[1], opened.queue, 0, NULL));
    watched.failed = NULL;
    svo_tree_destroy(&trees[0]);
    svo_tree_destroy(&trees[1]);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    clReleaseEvent(failed);
}

/* ---- rays ---- */

enum { RAY_COUNT = 500 };

static void make_rays(svo_ray rays[RAY_COUNT])
{
    uint64_t random = 4;
    for (int r = 0; r < RAY_COUNT; ++r) {
        for (int axis = 0; axis < 3; ++axis) {
            rays[r].origin[axis] = (float)(random_unit(&random) * 2.0 - 0.5);
            rays[r].direction[axis] = (float)(random_unit(&random) - 0.5);
        }
        rays[r].t_min = 0.0F;
        rays[r].t_max = INFINITY;
    }
}

/* The hits of the tree's rays are those of a new plan's; returns how many there are. */
static unsigned compare_hits(const fixture *opened, svo_tree *tree, const svo_mesh *mesh, svo_plan_options options)
{
    static svo_ray rays[RAY_COUNT];
    static svo_hit hits[2][RAY_COUNT];
    svo_plan *plan = make_plan(opened, mesh, 6, options);
    svo_tree *anew = NULL;
    unsigned found = 0;
    make_rays(rays);
    succeed(opened, svo_build(plan, opened->frontend, opened->queue, &anew, NULL));
    succeed(opened, svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits[0]), RAY_COUNT,
                                        SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_trace_triangles(svo_tree_target(anew), svo_in_host(rays), svo_in_host(hits[1]), RAY_COUNT,
                                        SVO_TRACE_CLOSEST, &(svo_submit){.queue = opened->queue}));
    for (int r = 0; r < RAY_COUNT; ++r) {
        hits[0][r].count = hits[1][r].count = 0; /* leaves visited depend on the BVH */
        assert_memory_equal(&hits[0][r], &hits[1][r], sizeof hits[0][r]);
        found += hits[0][r].triangle != SVO_NO_TRIANGLE ? 1 : 0;
    }
    svo_tree_destroy(&anew);
    svo_plan_destroy(&plan);
    return found;
}

/* Moves the mesh to one of its places as it is, and all that depends on it. Returns what that allocated. */
static counted follow(const fixture *opened, moving *m, int move, svo_plan *plan, svo_workspace *workspace,
                      svo_tree *tree)
{
    take_floats(m, m->at[move].base.positions);
    counting_begin();
    succeed(opened, svo_plan_update(plan, &m->mesh, &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened->queue}));
    succeed(opened, svo_tree_refit_bvh(tree, &(svo_submit){.queue = opened->queue}));
    const counted figures = counting_read();
    succeed(opened, svo_tree_finish(tree, opened->queue, 0, NULL));
    return figures;
}

/* A mesh, its plan and a tree with a BVH. */
typedef struct traced {
    moving m;
    svo_plan_options options;
    svo_plan *plan;
    svo_workspace *workspace;
    svo_tree *tree;
} traced;

static void traced_create(const fixture *opened, traced *out)
{
    moving_create(21, 400, 0.0, true, &out->m);
    out->options = updatable(SVO_NEED_RAYS);
    out->options.edge = 1.5;
    out->plan = make_plan(opened, &out->m.mesh, 6, out->options);
    out->workspace = make_workspace(opened, out->plan);
    out->tree = make_tree(opened, out->workspace);
    (void)enqueue_and_finish(opened, out->workspace, out->tree);
}

static void traced_destroy(traced *t)
{
    svo_tree_destroy(&t->tree);
    svo_workspace_destroy(&t->workspace);
    svo_plan_destroy(&t->plan);
    moving_destroy(&t->m);
}

static void a_refit_bvh_has_the_hits_of_a_new_one(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    traced t;
    traced_create(&opened, &t);
    succeed(&opened, svo_tree_make_bvh(t.tree, SVO_BVH_BEST, opened.queue));
    const uint64_t bytes = info_of_tree(t.tree).ray_bytes;
    for (int i = 0; i < MOVES; ++i) {
        const counted figures = follow(&opened, &t.m, i, t.plan, t.workspace, t.tree);
        assert_int_equal(figures.buffers, 0);
        assert_int_equal(figures.builds, 0);
        assert_int_equal(figures.waits, 0);
        assert_in_range(compare_hits(&opened, t.tree, &t.m.mesh, t.options), 50, RAY_COUNT);
        assert_int_equal(info_of_tree(t.tree).ray_bytes, bytes);
    }
    traced_destroy(&t);
}

/* Without a refit, and where a triangle has left the grid, rays get a new BVH. */
static void rays_never_meet_an_outdated_bvh(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    traced t;
    traced_create(&opened, &t);
    succeed(&opened, svo_tree_make_bvh(t.tree, SVO_BVH_BEST, opened.queue));
    take_floats(&t.m, t.m.at[0].base.positions);
    succeed(&opened, svo_plan_update(t.plan, &t.m.mesh, NULL));
    (void)enqueue_and_finish(&opened, t.workspace, t.tree);
    (void)compare_hits(&opened, t.tree, &t.m.mesh, t.options);
    for (int k = 0; k < 9; ++k) {
        t.m.at[1].base.positions[k] += 7.0;
    }
    t.m.at[2].base.positions[5] = -0.5;
    for (int i = 1; i < MOVES; ++i) {
        (void)follow(&opened, &t.m, i, t.plan, t.workspace, t.tree);
        (void)compare_hits(&opened, t.tree, &t.m.mesh, t.options);
        if (i == 1) { /* the new BVH is of a mesh that was not all there */
            assert_int_equal(svo_tree_refit_bvh(t.tree, &(svo_submit){.queue = opened.queue}), SVO_INVALID_ARGUMENT);
            take_floats(&t.m, t.m.at[0].base.positions);
            succeed(&opened, svo_plan_update(t.plan, &t.m.mesh, NULL));
            (void)enqueue_and_finish(&opened, t.workspace, t.tree);
            succeed(&opened, svo_tree_make_bvh(t.tree, SVO_BVH_FAST, opened.queue));
        }
    }
    traced_destroy(&t);
}

static void wrong_refits_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    traced t;
    traced_create(&opened, &t);
    assert_int_equal(svo_tree_refit_bvh(NULL, &(svo_submit){.queue = opened.queue}), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_tree_refit_bvh(t.tree, &(svo_submit){.queue = opened.queue}), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened.device), "no BVH"));
    succeed(&opened, svo_tree_make_bvh(t.tree, SVO_BVH_BEST, opened.queue));
    succeed(&opened, svo_tree_refit_bvh(t.tree, &(svo_submit){.queue = opened.queue}));
    succeed(&opened, svo_build_enqueue(t.workspace, t.tree, &(svo_submit){.queue = opened.queue}));
    succeed(&opened, svo_tree_finish(t.tree, opened.queue, 1, NULL));
    assert_int_equal(svo_tree_refit_bvh(t.tree, &(svo_submit){.queue = opened.queue}), SVO_INVALID_ARGUMENT);
    traced_destroy(&t);
}

/* Whether the BVH cannot be refit for the mesh's doubles or for triangles outside the grid, with the figures. */
static void refits_are_refused_for_one_reason(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const char *const words[] = {
        "the BVH was made of 1200 vertices in doubles, and a refit needs floats",
        "the BVH was made of 399 of 400 triangles, some of which reach out of the grid"};
    for (int i = 0; i < 2; ++i) {
        traced t;
        moving_create(21, 400, 0.0, i == 1, &t.m);
        t.options = updatable(SVO_NEED_RAYS);
        t.options.edge = 1.5;
        for (int k = 0; i == 1 && k < 9; ++k) {
            t.m.floats[k] = k < 3 ? 7.0F : 1e30F; /* outside */
        }
        t.plan = make_plan(&opened, &t.m.mesh, 6, t.options);
        t.workspace = make_workspace(&opened, t.plan);
        t.tree = make_tree(&opened, t.workspace);
        (void)enqueue_and_finish(&opened, t.workspace, t.tree);
        succeed(&opened, svo_tree_make_bvh(t.tree, SVO_BVH_FAST, opened.queue));
        assert_int_equal(svo_tree_refit_bvh(t.tree, &(svo_submit){.queue = opened.queue}), SVO_INVALID_ARGUMENT);
        if (strstr(svo_device_message(opened.device), words[i]) == NULL) {
            fail_msg("\"%s\", expected \"%s\"", svo_device_message(opened.device), words[i]);
        }
        traced_destroy(&t);
    }
}

TEST_GROUP(update)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(updated_plans_equal_new_ones),
        cmocka_unit_test(every_kind_of_request_can_move),
        cmocka_unit_test(deep_grids_can_move),
        cmocka_unit_test(buffers_move_the_mesh),
        cmocka_unit_test(updates_allocate_compile_and_wait_for_nothing),
        cmocka_unit_test(memory_is_flat),
        cmocka_unit_test(commands_are_ordered_whatever_the_queues),
        cmocka_unit_test(what_does_not_fit_is_reported_and_other_trees_stay),
        cmocka_unit_test(a_mesh_may_outgrow_its_unit_of_weight),
        cmocka_unit_test(a_refit_bvh_has_the_hits_of_a_new_one),
        cmocka_unit_test(rays_never_meet_an_outdated_bvh),
        cmocka_unit_test(wrong_refits_are_refused),
        cmocka_unit_test(refits_are_refused_for_one_reason),
        cmocka_unit_test(wrong_requests_are_refused),
        cmocka_unit_test(wrong_updates_are_refused),
        cmocka_unit_test(a_failed_update_takes_the_mesh_away),
        cmocka_unit_test(nothing_waits_for_a_failed_update),
        cmocka_unit_test(nothing_waits_for_a_failed_build),
    };
    return cmocka_run_group_tests_name("update", tests, fixture_group_setup, fixture_group_teardown);
}
