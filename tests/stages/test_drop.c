/* SPDX-License-Identifier: MIT */
/*
 * Pairs with an alpha below svo_plan_options.drop_alpha are left out: those that the payload's second reference names,
 * and no other, with every attribute, by both kinds of kernels, all front ends and builders, in chunks, enqueued, and
 * where the mesh moves. Closed forms; meshes whose alpha is nowhere too little, for which nothing is done.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "scenes.h"
#include "support/attributed_mesh.h"
#include "support/enqueued.h"
#include "support/payload_reference.h"
#include "support/suite.h"

#define NEED_PAYLOAD \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL)

/* ---- the reference ---- */

/* Builds, and compares with the reference; adds the numbers of pairs that were left out and that remain. */
static void check(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                  uint64_t counts[2])
{
    built actual;
    exact expected;
    exact_create(mesh, depth, options, &expected);
    const size_t dropped = payload_drop_pairs(mesh, options->weights, options->drop_alpha, &expected);
    fixture_build(opened, mesh, depth, options, &actual);
    assert_int_equal(actual.report.dropped, dropped);
    assert_int_equal(actual.report.fragments, expected.pairs.count);
    assert_int_equal(actual.info.fragments, expected.pairs.count);
    assert_tree_is_exact(&actual, &expected);
    assert_payload_is_exact(mesh, &expected, &actual);
    counts[0] += dropped;
    counts[1] += expected.pairs.count;
    exact_destroy(&expected);
    built_destroy(&actual);
}

static void check_on_path(svo_path path)
{
    static const double alphas[] = {0.1, 1.0 / 255.0, 0.5, 0.02, 64.0 / 255.0, 0.3};
    static const uint32_t needs[] = {NEED_PAYLOAD, SVO_NEED_ALL, SVO_NEED_NONE, SVO_NEED_NORMAL, SVO_NEED_RAYS};
    fixture opened;
    uint64_t counts[2] = {0, 0};
    fixture_open_cl(&(fixture_options){.path = path}, &opened);
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        attributed_mesh made;
        const svo_weights weights = seed % 5 == 1 ? SVO_WEIGHTS_AREA : (svo_weights)(seed % 3);
        const double far = seed % 9 == 0 ? -30.0 : 0.0; /* so that codes have all their bits */
        const svo_plan_options options = {.need = weights == SVO_WEIGHTS_AREA ? needs[seed % 5] : needs[2 + seed % 3],
                                          .weights = weights,
                                          .edge = seed % 9 == 0 ? 32.0 : (double)(1 - seed % 2),
                                          .origin = {far, far, far},
                                          .coverage = (svo_coverage)(seed / 3 % 3),
                                          .builder = (svo_builder)(seed / 2 % 2),
                                          .chunk_bytes = seed % 4 == 0 ? 16384 : 0,
                                          .place = seed % 7 == 0 ? SVO_PLACE_DEVICE : SVO_PLACE_DEFAULT,
                                          .drop_alpha = alphas[seed % 6]};
        print_message("seed %llu\n", (unsigned long long)seed);
        attributed_mesh_create(seed, seed % 4 == 3 ? 3 : 300, seed % 8 == 0 ? 5.0 : 0.0, &made);
        made.mesh.colors = seed % 3 == 0 ? NULL : made.mesh.colors;
        made.mesh.texture_count = seed % 6 == 0 ? 0 : made.mesh.texture_count;
        check(&opened, &made.mesh, seed % 9 == 0 ? 11 : 3 + (unsigned)seed % 4, &options, counts);
        attributed_mesh_destroy(&made);
    }
    fixture_close(&opened);
    assert_in_range(counts[0], 10000, UINT32_MAX);
    assert_in_range(counts[1], 10000, UINT32_MAX);
}

static void the_reference_leaves_out_the_same_pairs(void **state)
{
    (void)state;
    check_on_path(SVO_PATH_CPU);
}

static void nor_does_the_path_of_gpus_differ(void **state)
{
    (void)state;
    check_on_path(SVO_PATH_GPU);
}

/* ---- one result ---- */

static void assert_same(const built *actual, const built *expected, const char *what)
{
    if (strcmp(actual->hash, expected->hash) != 0 || actual->report.dropped != expected->report.dropped ||
        actual->report.fragments != expected->report.fragments) {
        fail_msg("%s: %s, %llu pairs, %llu dropped, not %s, %llu, %llu", what, actual->hash,
                 (unsigned long long)actual->report.fragments, (unsigned long long)actual->report.dropped,
                 expected->hash, (unsigned long long)expected->report.fragments,
                 (unsigned long long)expected->report.dropped);
    }
}

static void build_and_compare(const fixture *opened, const svo_mesh *mesh, svo_plan_options options,
                              const built *expected, const char *what)
{
    built actual;
    fixture_build(opened, mesh, 6, &options, &actual);
    assert_same(&actual, expected, what);
    built_destroy(&actual);
}

/* twice: the second build finds the memory of the first. */
static void enqueue_and_compare(const fixture *opened, const svo_mesh *mesh, svo_plan_options options,
                                const built *expected, const char *what)
{
    svo_plan *plan = make_plan(opened, mesh, 6, options);
    svo_workspace *workspace = make_workspace(opened, plan);
    svo_tree *tree = make_tree(opened, workspace);
    for (unsigned i = 0; i < 2; ++i) {
        built actual = {.report = SVO_BUILD_REPORT_INIT};
        succeed(opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened->queue}));
        succeed(opened, svo_tree_finish(tree, opened->queue, 0, &actual.report));
        succeed(opened, svo_tree_download(tree, opened->queue));
        svo_tree_hash(tree, 0, actual.hash);
        assert_same(&actual, expected, what);
    }
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
}

static void all_ways_to_build_make_one_tree(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const fixture by_cl = fixture_cl_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_ALL, .edge = 1.0, .drop_alpha = 0.25};
    svo_plan_options other = options;
    attributed_mesh made;
    built expected;
    attributed_mesh_create(77, 500, 0.0, &made);
    fixture_build(&by_cl, &made.mesh, 6, &options, &expected);
    assert_in_range(expected.report.dropped, 1000, UINT32_MAX);
    build_and_compare(opened, &made.mesh, options, &expected, "OpenGL's front end");
    other.chunk_bytes = 16384;
    build_and_compare(&by_cl, &made.mesh, other, &expected, "chunks");
    build_and_compare(opened, &made.mesh, other, &expected, "chunks by OpenGL");
    other.builder = SVO_BUILDER_SORTED;
    build_and_compare(&by_cl, &made.mesh, other, &expected, "sorted chunks");
    other = options;
    other.place = SVO_PLACE_DEVICE;
    build_and_compare(&by_cl, &made.mesh, other, &expected, "a plan by kernels");
    other.fragment_capacity = 100;
    build_and_compare(&by_cl, &made.mesh, other, &expected, "a list that grows");
    enqueue_and_compare(&by_cl, &made.mesh, options, &expected, "enqueued");
    enqueue_and_compare(opened, &made.mesh, options, &expected, "enqueued, by OpenGL");
    built_destroy(&expected);
    attributed_mesh_destroy(&made);
}

/* The words of an enqueued build whose list has too little room. */
static void overflow(const fixture *opened, const svo_mesh *mesh, double drop_alpha, char words[512])
{
    svo_plan *plan =
        make_plan(opened, mesh, 6, (svo_plan_options){.edge = 1.0, .drop_alpha = drop_alpha, .fragment_capacity = 100});
    svo_workspace *workspace = make_workspace(opened, plan);
    svo_tree *tree = make_tree(opened, workspace);
    succeed(opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened->queue}));
    assert_int_equal(svo_tree_finish(tree, opened->queue, 0, NULL), SVO_CAPACITY_EXCEEDED);
    (void)snprintf(words, 512, "%s", svo_device_message(opened->device));
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
}

/* There must be room for all pairs, dropped ones included. */
static void lists_that_do_not_fit_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    attributed_mesh made;
    char all[512];
    char some[512];
    attributed_mesh_create(77, 500, 0.0, &made);
    overflow(&opened, &made.mesh, 0.0, all);
    overflow(&opened, &made.mesh, 0.25, some);
    assert_string_equal(some, all);
    attributed_mesh_destroy(&made);
}

/* Updatable plans make all payload per node, so their trees are compared with each other. */
static void plans_whose_mesh_moves_leave_them_out(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_plan_options options = {
        .need = NEED_PAYLOAD, .edge = 1.0, .drop_alpha = 0.25, .weight_log2 = 20, .updatable = 1};
    attributed_mesh made;
    attributed_mesh from;
    built expected;
    attributed_mesh_create(78, 500, 0.0, &made);
    attributed_mesh_create(78, 500, 0.0, &from);
    for (size_t i = 0; i < from.mesh.vertex_count * 3; ++i) {
        ((double *)(uintptr_t)from.mesh.positions_double)[i] *= 0.5;
    }
    fixture_build(&opened, &made.mesh, 6, &options, &expected);
    assert_in_range(expected.report.dropped, 1000, UINT32_MAX);
    svo_plan_options roomy = options;
    roomy.fragment_capacity = 100000;
    roomy.worst_case_nodes = 1;
    svo_plan *plan = make_plan(&opened, &from.mesh, 6, roomy);
    svo_workspace *workspace = make_workspace(&opened, plan);
    svo_tree *tree = make_tree(&opened, workspace);
    built actual = {.report = SVO_BUILD_REPORT_INIT};
    succeed(&opened, svo_plan_update(plan, &made.mesh, NULL));
    succeed(&opened, svo_build_enqueue(workspace, tree, &(svo_submit){.queue = opened.queue}));
    succeed(&opened, svo_tree_finish(tree, opened.queue, 1, &actual.report));
    succeed(&opened, svo_tree_download(tree, opened.queue));
    svo_tree_hash(tree, 0, actual.hash);
    assert_same(&actual, &expected, "an updated plan");
    svo_tree_destroy(&tree);
    svo_workspace_destroy(&workspace);
    svo_plan_destroy(&plan);
    built_destroy(&expected);
    attributed_mesh_destroy(&from);
    attributed_mesh_destroy(&made);
}

/* ---- closed forms ---- */

/* A square across the grid, between voxel planes, with u from 0 to 1 along x. */
typedef struct square {
    float positions[12], uvs[8];
    uint8_t colors[16];
    uint32_t indices[6];
    svo_material material;
    svo_texture texture;
    uint8_t texels[8];
    svo_mesh mesh;
} square;

static void square_make(uint8_t left, uint8_t right, uint8_t of_material, square *out)
{
    static const float positions[12] = {0.0F, 0.0F, 0.51F, 1.0F, 0.0F, 0.51F, 1.0F, 1.0F, 0.51F, 0.0F, 1.0F, 0.51F};
    static const float uvs[8] = {0.0F, 0.0F, 1.0F, 0.0F, 1.0F, 1.0F, 0.0F, 1.0F};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    const uint8_t texels[8] = {200, 10, 20, left, 30, 40, 250, right};
    memset(out, 0, sizeof *out);
    memcpy(out->positions, positions, sizeof positions);
    memcpy(out->uvs, uvs, sizeof uvs);
    memcpy(out->indices, indices, sizeof indices);
    memcpy(out->texels, texels, sizeof texels);
    memset(out->colors, 255, sizeof out->colors);
    out->material = (svo_material){{255, 255, 255, of_material}, 0};
    out->texture = (svo_texture){out->texels, 2, 1, SVO_WRAP_CLAMP, SVO_WRAP_CLAMP};
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions = out->positions,
                           .uvs = out->uvs,
                           .indices = out->indices,
                           .vertex_count = 4,
                           .triangle_count = 2,
                           .materials = &out->material,
                           .material_count = 1,
                           .textures = &out->texture,
                           .texture_count = 1};
}

static void build_square(const fixture *opened, const svo_mesh *mesh, double alpha, built *out)
{
    const svo_plan_options options = {.need = SVO_NEED_COLOR, .edge = 1.0, .drop_alpha = alpha};
    fixture_build(opened, mesh, 5, &options, out);
}

/* Between the texels' centers, at a quarter and three quarters, alpha grows evenly: half of it is in the middle. */
static void a_square_half_of_which_shows_loses_the_other_half(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    square made;
    built whole;
    built half;
    square_make(0, 255, 255, &made);
    build_square(&opened, &made.mesh, 0.0, &whole);
    build_square(&opened, &made.mesh, 0.5, &half);
    assert_int_equal(whole.info.leaf_count, 1024);
    assert_int_equal(half.info.leaf_count, 512);
    assert_int_equal(half.arrays.child_mask[0] & 0x55, 0); /* nothing at low x */
    assert_int_equal(half.report.dropped + half.report.fragments, whole.report.fragments);
    built_destroy(&half);
    built_destroy(&whole);
}

/* A texel of 128 under a material of 128 shows 64 (64.25, rounded). */
static void an_alpha_that_is_just_enough_stays(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    square made;
    square_make(128, 128, 128, &made);
    const struct {
        double alpha;
        uint64_t leaves;
    } rows[] = {{64.0 / 255.0, 1024}, {0.25, 1024}, {64.001 / 255.0, 0}, {65.0 / 255.0, 0}, {1.0, 0}, {1e-9, 1024}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        built actual;
        build_square(&opened, &made.mesh, rows[i].alpha, &actual);
        assert_int_equal(actual.info.leaf_count, rows[i].leaves);
        built_destroy(&actual);
    }
}

static void alpha_of_vertices_counts(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    square made;
    built actual;
    square_make(255, 255, 255, &made);
    made.mesh.colors = made.colors;
    made.colors[3] = made.colors[15] = 0; /* at low x; so alpha grows from there */
    build_square(&opened, &made.mesh, 0.75, &actual);
    assert_int_equal(actual.info.leaf_count, 256);
    built_destroy(&actual);
}

/* As of a mesh outside the grid: one root, no leaves, zeros. */
static void nothing_that_shows_is_an_empty_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const uint32_t needs[] = {SVO_NEED_ALL, SVO_NEED_NONE, SVO_NEED_COLOR, SVO_NEED_RAYS};
    static const double far[3] = {5.0, 5.0, 5.0};
    square made;
    square_make(255, 255, 76, &made);
    made.mesh.texture_count = 0;
    for (size_t i = 0; i < 4; ++i) {
        for (svo_builder builder = SVO_BUILDER_CL; builder <= SVO_BUILDER_SORTED; ++builder) {
            built actual;
            built outside;
            svo_plan_options options = {.need = needs[i], .edge = 1.0, .drop_alpha = 0.5, .builder = builder};
            fixture_build(&opened, &made.mesh, 4, &options, &actual);
            assert_int_equal(actual.info.leaf_count, 0);
            assert_int_equal(actual.info.node_count, 1);
            assert_int_equal(actual.report.fragments, 0);
            assert_true(actual.report.dropped > 0);
            options.drop_alpha = 0.0;
            memcpy(options.origin, far, sizeof far);
            fixture_build(&opened, &made.mesh, 4, &options, &outside);
            assert_int_equal(actual.arrays.child_mask[0], outside.arrays.child_mask[0]);
            assert_true(actual.arrays.colors == NULL || memcmp(actual.arrays.colors, outside.arrays.colors, 4) == 0);
            built_destroy(&outside);
            built_destroy(&actual);
        }
    }
}

/* ---- meshes whose alpha is enough ---- */

static bool has_kernels(const svo_plan *plan, const char *name)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    assert_int_equal(svo_plan_get_info(plan, &info), SVO_OK);
    for (size_t i = 0; i < info.kernels_count; ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        assert_int_equal(svo_plan_get_kernels(plan, i, &kernels), SVO_OK);
        if (strcmp(kernels.name, name) == 0) {
            return true;
        }
    }
    return false;
}

static const char *reason_of(const svo_plan *plan, const char *what)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    assert_int_equal(svo_plan_get_info(plan, &info), SVO_OK);
    for (size_t i = 0; i < info.left_out_count; ++i) {
        svo_left_out entry = SVO_LEFT_OUT_INIT;
        assert_int_equal(svo_plan_get_left_out(plan, i, &entry), SVO_OK);
        if (strcmp(entry.what, what) == 0) {
            return entry.reason;
        }
    }
    return NULL;
}

static void assert_planned(const fixture *opened, const svo_mesh *mesh, svo_plan_options options, bool drops)
{
    svo_plan *plan = make_plan(opened, mesh, 5, options);
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    assert_int_equal(svo_plan_get_info(plan, &info), SVO_OK);
    assert_int_equal(info.drops_pairs, drops ? 1 : 0);
    assert_int_equal(svo_plan_has_stage(plan, SVO_STAGE_DROP) != 0, drops);
    assert_int_equal(has_kernels(plan, "drop"), drops);
    assert_int_equal(reason_of(plan, "pairs to drop") != NULL, !drops && options.drop_alpha > 0.0);
    svo_plan_destroy(&plan);
}

static void meshes_that_show_everywhere_pay_nothing(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const uint32_t needs[] = {SVO_NEED_ALL, SVO_NEED_NONE, SVO_NEED_NORMAL};
    square made;
    square_make(26, 255, 255, &made);
    for (size_t i = 0; i < 3; ++i) {
        svo_plan_options options = {.need = needs[i], .edge = 1.0};
        built before;
        built after;
        fixture_build(&opened, &made.mesh, 5, &options, &before);
        assert_planned(&opened, &made.mesh, options, false);
        options.drop_alpha = 0.1; /* 25.5 of 255 */
        assert_planned(&opened, &made.mesh, options, false);
        options.place = SVO_PLACE_DEVICE;
        assert_planned(&opened, &made.mesh, options, false);
        options.place = SVO_PLACE_DEFAULT;
        fixture_build(&opened, &made.mesh, 5, &options, &after);
        assert_string_equal(after.hash, before.hash);
        assert_int_equal(after.report.dropped, 0);
        assert_null(after.report.stage_times[SVO_STAGE_DROP].clock);
        assert_int_equal(after.buffer_count, before.buffer_count);
        for (size_t k = 0; k < after.buffer_count; ++k) {
            assert_string_equal(after.buffers[k].name, before.buffers[k].name);
            assert_int_equal(after.buffers[k].bytes, before.buffers[k].bytes);
        }
        options.drop_alpha = 0.11;
        assert_planned(&opened, &made.mesh, options, true);
        built_destroy(&after);
        built_destroy(&before);
    }
}

/* ---- what is refused ---- */

static void alphas_out_of_range_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const double wrong[] = {-0.1, 1.0001, -INFINITY, NAN};
    square made;
    square_make(0, 255, 255, &made);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        const svo_plan_options options = {.struct_size = sizeof options, .drop_alpha = wrong[i]};
        char text[128];
        svo_plan *plan = NULL;
        assert_int_equal(svo_plan_create(opened.device, &made.mesh, 5, &options, &plan), SVO_INVALID_ARGUMENT);
        (void)snprintf(text, sizeof text, "svo_plan_create: options.drop_alpha %g is not in 0 .. 1", wrong[i]);
        assert_string_equal(svo_device_message(opened.device), text);
    }
}

static void the_builder_of_opengl_refuses(void **state)
{
    const fixture *opened = fixture_of_group(state);
    square made;
    square_make(0, 255, 255, &made);
    svo_tree *tree = NULL;
    svo_plan *plan = make_plan(opened, &made.mesh, 5, (svo_plan_options){.edge = 1.0, .drop_alpha = 0.5});
    assert_int_equal(svo_gl_build(opened->gl, plan, opened->queue, &tree, NULL), SVO_UNSUPPORTED);
    assert_null(tree);
    assert_non_null(strstr(svo_device_message(opened->device), "gl-compute leaves no pairs out"));
    assert_non_null(strstr(svo_device_message(opened->device), "options.drop_alpha is 0.5"));
    svo_plan_destroy(&plan);
    built by_gl;
    built by_cl;
    square_make(255, 255, 255, &made);
    const svo_plan_options options = {.edge = 1.0, .drop_alpha = 0.5};
    fixture_build_in_gl(opened, &made.mesh, 5, &options, &by_gl);
    fixture_build(opened, &made.mesh, 5, &options, &by_cl);
    assert_string_equal(by_gl.hash, by_cl.hash);
    built_destroy(&by_cl);
    built_destroy(&by_gl);
}

TEST_GROUP(drop)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reference_leaves_out_the_same_pairs),
        cmocka_unit_test(all_ways_to_build_make_one_tree),
        cmocka_unit_test(lists_that_do_not_fit_are_refused),
        cmocka_unit_test(plans_whose_mesh_moves_leave_them_out),
        cmocka_unit_test(a_square_half_of_which_shows_loses_the_other_half),
        cmocka_unit_test(an_alpha_that_is_just_enough_stays),
        cmocka_unit_test(alpha_of_vertices_counts),
        cmocka_unit_test(nothing_that_shows_is_an_empty_tree),
        cmocka_unit_test(meshes_that_show_everywhere_pay_nothing),
        cmocka_unit_test(alphas_out_of_range_are_refused),
        cmocka_unit_test(the_builder_of_opengl_refuses),
    };
    const struct CMUnitTest on_gpus[] = {cmocka_unit_test(nor_does_the_path_of_gpus_differ)};
    return cmocka_run_group_tests_name("drop", tests, fixture_group_setup, fixture_group_teardown) +
           cmocka_run_group_tests_name("the path of GPUs", on_gpus, fixture_group_setup_unoptimized,
                                       fixture_group_teardown_unoptimized);
}
