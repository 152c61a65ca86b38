/* SPDX-License-Identifier: MIT */
/*
 * The front end gl-hybrid gives the tree of the others, whatever part of the triangles it rasterizes: on every scene
 * and coverage, in chunks, with lists that are too small, on callers' grids, and for builds that do not wait.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>

#include "context/context.h"
#include "plan/arrays.h"
#include "plan/chunking.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

/* From all triangles that span voxels to none. */
static const uint32_t columns[] = {1, 6, 40, 64, 65, 700, UINT32_MAX};
#define COLUMNS (sizeof columns / sizeof columns[0])

/* A view of the group's fixture whose builds use gl-hybrid; close_hybrid. */
static fixture open_hybrid(const fixture *opened, svo_gl_share share, uint32_t most_columns)
{
    fixture made = *opened;
    const svo_gl_options options = {
        .struct_size = sizeof options, .raster = SVO_GL_RASTER_HYBRID, .share = share, .hybrid_columns = most_columns};
    made.gl = NULL;
    assert_int_equal(svo_gl_create(opened->device, opened->context, &options, &made.gl), SVO_OK);
    made.frontend = svo_gl_frontend(made.gl);
    assert_string_equal(svo_frontend_name(made.frontend), "gl-hybrid");
    return made;
}

static void close_hybrid(fixture *made)
{
    svo_gl_destroy(&made->gl);
}

/* Builds with every threshold. */
static void assert_one_tree(void **state, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options)
{
    const fixture by_cl = fixture_cl_of_group(state);
    built expected;
    fixture_build(&by_cl, mesh, depth, options, &expected);
    for (size_t i = 0; i < COLUMNS; ++i) {
        const svo_gl_share share = i % 2 == 0 ? SVO_GL_SHARE_AUTO : SVO_GL_SHARE_COPY;
        fixture by_both = open_hybrid(fixture_of_group(state), share, columns[i]);
        built actual;
        fixture_build(&by_both, mesh, depth, options, &actual);
        assert_string_equal(actual.report.frontend, "gl-hybrid");
        assert_int_equal(actual.report.fragments, expected.report.fragments);
        assert_string_equal(actual.hash, expected.hash);
        built_destroy(&actual);
        close_hybrid(&by_both);
    }
    built_destroy(&expected);
}

static void every_scene_and_coverage_gives_one_tree(void **state)
{
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        char spec[64];
        (void)snprintf(spec, sizeof spec, "%s:2000", scene_describe(i)->name);
        scene *made = fixture_scene(spec);
        const svo_plan_options options = {.need = SVO_NEED_RAYS, .coverage = (svo_coverage)(i % 3)};
        assert_one_tree(state, scene_mesh(made), 7, &options);
        scene_destroy(&made);
    }
}

/* Chunks, some of which have no large triangle; lists that grow; triangles that reach outside; codes of 48 bits. */
static void every_cut_gives_one_tree(void **state)
{
    scene *made = fixture_scene("atrium");
    assert_one_tree(state, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_NONE, .chunk_bytes = 20000});
    assert_one_tree(state, scene_mesh(made), 6, &(svo_plan_options){.need = SVO_NEED_NONE, .fragment_capacity = 9});
    scene_destroy(&made);
    owned_mesh random;
    random_mesh(3, 60, 0.0, &random);
    assert_one_tree(state, &random.mesh, 8, &(svo_plan_options){.need = SVO_NEED_ALL, .edge = 0.4});
    assert_one_tree(state, &random.mesh, 13, &(svo_plan_options){.need = SVO_NEED_RAYS, .edge = 30.0});
    owned_mesh_free(&random);
}

/* Vertices that OpenGL has drawn. */
static uint64_t drawn_vertices;
static void(APIENTRY *real_draw)(GLenum mode, GLint first, GLsizei count);

static void APIENTRY counting_draw(GLenum mode, GLint first, GLsizei count)
{
    drawn_vertices += (uint64_t)count;
    real_draw(mode, first, count);
}

/* What a build draws once its programs are compiled. */
static uint64_t vertices_of_build(const fixture *by_both, const svo_mesh *mesh)
{
    for (unsigned turn = 0; turn < 2; ++turn) {
        built finished;
        drawn_vertices = 0;
        fixture_build(by_both, mesh, 7, &(svo_plan_options){.need = SVO_NEED_NONE}, &finished);
        built_destroy(&finished);
    }
    return drawn_vertices;
}

/* Thresholds between the first and the last divide the triangles, and OpenGL draws those of more columns. */
static void opengl_draws_the_large_triangles(void **state)
{
    const fixture *opened = fixture_of_group(state);
    scene *made = fixture_scene("atrium");
    svo_plan *plan = NULL;
    svo_i_chunking cut = {0};
    uint64_t before = UINT64_MAX;
    real_draw = opened->context->functions.DrawArrays;
    opened->context->functions.DrawArrays = counting_draw;
    assert_int_equal(svo_plan_create(opened->device, scene_mesh(made), 7, NULL, &plan), SVO_OK);
    assert_int_equal(svo_i_plan_copy_to_host(plan), SVO_OK);
    assert_int_equal(svo_i_chunking_create(plan, svo_i_chunk_bytes_max(plan, UINT64_MAX), &cut), SVO_OK);
    for (size_t i = 0; i < COLUMNS; ++i) {
        svo_i_rest rest;
        fixture by_both = open_hybrid(opened, SVO_GL_SHARE_AUTO, columns[i]);
        assert_int_equal(svo_i_rest_find(plan, &cut, columns[i], &rest), SVO_OK);
        assert_int_equal(rest.item_count + rest.others, plan->class_begin[SVO_I_CLASS_COUNT]);
        assert_true(rest.item_count <= before && (rest.item_count < before || i == 4));
        assert_true((rest.item_count > 0) == (columns[i] != UINT32_MAX));
        assert_int_equal(vertices_of_build(&by_both, scene_mesh(made)), 3 * (uint64_t)rest.item_count);
        before = rest.item_count;
        svo_i_rest_free(&rest);
        close_hybrid(&by_both);
    }
    opened->context->functions.DrawArrays = real_draw;
    svo_i_chunking_destroy(&cut);
    svo_plan_destroy(&plan);
    scene_destroy(&made);
}

/* By kernels alone, and so for plans whose mesh moves. */
static void builds_that_do_not_wait_give_one_tree(void **state)
{
    fixture by_both = open_hybrid(fixture_of_group(state), SVO_GL_SHARE_AUTO, 1);
    owned_mesh random;
    svo_plan *plan = NULL;
    svo_workspace *workspace = NULL;
    svo_tree *tree = NULL;
    built expected;
    char hash[SVO_HASH_TEXT_BYTES];
    random_mesh(4, 80, 0.0, &random);
    fixture_build(&by_both, &random.mesh, 6, &(svo_plan_options){.need = SVO_NEED_RAYS}, &expected);
    const svo_plan_options options = {
        .struct_size = sizeof options,
        .need = SVO_NEED_RAYS,
        .edge = expected.info.edge,
        .origin = {expected.info.origin[0], expected.info.origin[1], expected.info.origin[2]},
        .updatable = 1};
    assert_int_equal(svo_plan_create(by_both.device, &random.mesh, 6, &options, &plan), SVO_OK);
    assert_int_equal(svo_workspace_create(plan, by_both.frontend, by_both.queue, NULL, &workspace), SVO_OK);
    assert_int_equal(svo_workspace_make_tree(workspace, &tree), SVO_OK);
    assert_int_equal(svo_build_enqueue(workspace, tree, NULL), SVO_OK);
    assert_int_equal(svo_tree_finish(tree, NULL, 0, NULL), SVO_OK);
    assert_int_equal(svo_tree_download(tree, by_both.queue), SVO_OK);
    assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, hash), SVO_OK);
    assert_string_equal(hash, expected.hash);
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    built_destroy(&expected);
    owned_mesh_free(&random);
    close_hybrid(&by_both);
}

TEST_GROUP(hybrid)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_scene_and_coverage_gives_one_tree),
        cmocka_unit_test(every_cut_gives_one_tree),
        cmocka_unit_test(opengl_draws_the_large_triangles),
        cmocka_unit_test(builds_that_do_not_wait_give_one_tree),
    };
    return cmocka_run_group_tests_name("hybrid", tests, fixture_group_setup, fixture_group_teardown);
}
