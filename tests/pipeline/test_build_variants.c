/* SPDX-License-Identifier: MIT */
/*
 * Every configuration builds the same tree: share paths, contexts, queues, 64-bit integers in one word or two, chunks
 * of any size, lists that were too small at first, repeated runs, other orders and forms of the same triangles. The
 * tests compare hashes, and compare one tree of each group with the exact references.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "support/compare_tree.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

#define NEED_ALL (SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS)

static const svo_plan_options everything = {.need = NEED_ALL};

/* The tree that all others must equal, and its build's input. */
typedef struct baseline {
    scene *scene;
    const svo_mesh *mesh;
    unsigned depth;
    char hash[SVO_HASH_TEXT_BYTES];
} baseline;

static void make_baseline(void **state, const char *spec, unsigned depth, baseline *out)
{
    const fixture *opened = fixture_of_group(state);
    *out = (baseline){.scene = fixture_scene(spec), .depth = depth};
    out->mesh = scene_mesh(out->scene);
    built actual;
    fixture_build(opened, out->mesh, depth, &everything, &actual);
    assert_build_is_exact(out->mesh, &everything, &actual);
    memcpy(out->hash, actual.hash, sizeof out->hash);
    built_destroy(&actual);
}

/* Builds and compares the hash; returns the build's report in *report. */
static void assert_same(const fixture *opened, const baseline *expected, const svo_plan_options *options,
                        svo_build_report *report)
{
    built actual;
    fixture_build(opened, expected->mesh, expected->depth, options, &actual);
    assert_string_equal(actual.hash, expected->hash);
    *report = actual.report;
    built_destroy(&actual);
}

/* The same with a context, a share path, a queue and an integer width of its own. */
static void assert_same_with(void **state, const fixture_options *options, svo_build_report *report)
{
    baseline expected;
    make_baseline(state, "atrium", 7, &expected);
    fixture other;
    fixture_open(options, &other);
    assert_same(&other, &expected, &everything, report);
    fixture_close(&other);
    scene_destroy(&expected.scene);
}

static void check_share(void **state, svo_gl_share share)
{
    svo_build_report report;
    assert_same_with(state, &(fixture_options){.share = share}, &report);
    assert_string_equal(report.share, svo_name(SVO_NAME_GL_SHARE, share));
}

static void host_share_gives_the_same_tree(void **state)
{
    check_share(state, SVO_GL_SHARE_HOST);
}

static void copy_share_gives_the_same_tree(void **state)
{
    check_share(state, SVO_GL_SHARE_COPY);
}

static void check_context(void **state, svo_gl_context_kind kind)
{
    static const svo_gl_share shares[] = {SVO_GL_SHARE_AUTO, SVO_GL_SHARE_COPY};
    for (size_t i = 0; i < 2; ++i) {
        svo_build_report report;
        assert_same_with(state, &(fixture_options){.context = 1 + (unsigned)kind, .share = shares[i]}, &report);
    }
}

static void surfaceless_context_gives_the_same_tree(void **state)
{
    check_context(state, SVO_GL_SURFACELESS);
}

static void egl_device_context_gives_the_same_tree(void **state)
{
    check_context(state, SVO_GL_EGL_DEVICE);
}

static void osmesa_context_gives_the_same_tree(void **state)
{
    check_context(state, SVO_GL_OSMESA);
}

static void check_queue(void **state, cl_command_queue_properties properties, const char *clock)
{
    static const svo_gl_share shares[] = {SVO_GL_SHARE_AUTO, SVO_GL_SHARE_COPY};
    for (size_t i = 0; i < 2; ++i) {
        svo_build_report report;
        assert_same_with(state, &(fixture_options){.queue_properties = properties, .share = shares[i]}, &report);
        assert_string_equal(report.stage_times[SVO_STAGE_SUBDIVIDE].clock, clock);
        assert_string_equal(report.stage_times[SVO_STAGE_FILTER].clock, clock);
        assert_string_equal(report.stage_times[SVO_STAGE_VOXELIZE].clock, "wall");
    }
}

static void in_order_queue_gives_the_same_tree(void **state)
{
    check_queue(state, 0, "wall");
}

static void out_of_order_queue_gives_the_same_tree(void **state)
{
    check_queue(state, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, "wall");
}

static void profiling_queue_gives_the_same_tree(void **state)
{
    check_queue(state, CL_QUEUE_PROFILING_ENABLE, "cl-event");
}

static void out_of_order_profiling_queue_gives_the_same_tree(void **state)
{
    check_queue(state, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE | CL_QUEUE_PROFILING_ENABLE, "cl-event");
}

/* Every triangle class and both code lengths, with two-word integers in the shaders. */
static void two_word_integers_give_the_same_tree(void **state)
{
    svo_build_report report;
    assert_same_with(state, &(fixture_options){.no_int64 = 1}, &report);
    fixture other;
    fixture_open(&(fixture_options){.no_int64 = 1}, &other);
    owned_mesh made;
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        random_mesh(seed, 200, seed % 2 == 0 ? 0.0 : 300.0, &made);
        const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = 1.0};
        built actual;
        fixture_build(&other, &made.mesh, 4 + (unsigned)seed, &options, &actual);
        assert_build_is_exact(&made.mesh, &options, &actual);
        built_destroy(&actual);
        owned_mesh_free(&made);
    }
    random_mesh(12, 3, 0.0, &made);
    built actual;
    fixture_build(&other, &made.mesh, 11, &(svo_plan_options){.need = SVO_NEED_RAYS}, &actual);
    assert_build_is_exact(&made.mesh, NULL, &actual);
    built_destroy(&actual);
    owned_mesh_free(&made);
    fixture_close(&other);
}

static void repeated_runs_give_the_same_tree(void **state)
{
    baseline expected;
    make_baseline(state, "statue:20000", 8, &expected);
    for (unsigned run = 0; run < 10; ++run) {
        svo_build_report report;
        assert_same(fixture_of_group(state), &expected, &everything, &report);
        assert_int_equal(report.reruns, 0);
    }
    scene_destroy(&expected.scene);
}

/* A plan can be used for several builds. */
static void a_plan_can_be_built_twice(void **state)
{
    const fixture *opened = fixture_of_group(state);
    baseline expected;
    make_baseline(state, "knot:2000", 7, &expected);
    const svo_plan_options options = {.struct_size = sizeof options, .need = NEED_ALL, .fragment_capacity = 1};
    svo_plan *plan = NULL;
    assert_int_equal(svo_plan_create(opened->device, expected.mesh, expected.depth, &options, &plan), SVO_OK);
    uint64_t peak_bytes = 0;
    for (unsigned run = 0; run < 3; ++run) {
        svo_tree *tree = NULL;
        char hash[SVO_HASH_TEXT_BYTES];
        assert_int_equal(svo_build(plan, svo_gl_frontend(opened->gl), opened->queue, &tree, NULL), SVO_OK);
        assert_int_equal(svo_tree_download(tree, opened->queue), SVO_OK);
        assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, hash), SVO_OK);
        assert_string_equal(hash, expected.hash);
        svo_tree_destroy(&tree);
        assert_int_equal(info_of_plan(plan).peak_bytes, run == 0 ? info_of_plan(plan).peak_bytes : peak_bytes);
        peak_bytes = info_of_plan(plan).peak_bytes;
    }
    svo_plan_destroy(&plan);
    scene_destroy(&expected.scene);
}

static void chunks_of_any_size_give_the_same_tree(void **state)
{
    static const uint64_t sizes_bytes[] = {16384, 16388, 50000, 262144, 1u << 22, UINT64_C(1) << 40};
    baseline expected;
    make_baseline(state, "statue:20000", 8, &expected);
    for (size_t i = 0; i < sizeof sizes_bytes / sizeof sizes_bytes[0]; ++i) {
        const svo_plan_options options = {.need = NEED_ALL, .chunk_bytes = sizes_bytes[i]};
        svo_build_report report;
        assert_same(fixture_of_group(state), &expected, &options, &report);
        print_message("chunks of %llu bytes: %u, %u reruns\n", (unsigned long long)sizes_bytes[i], report.list_chunks,
                      report.reruns);
        /* No chunk is larger than requested, and the list does not fit into fewer. */
        assert_in_range(report.list_chunks, (report.fragments * 8 + sizes_bytes[i] - 1) / sizes_bytes[i], 1000);
        assert_int_equal(report.list_chunks > 1, sizes_bytes[i] < report.fragments * 8);
    }
    scene_destroy(&expected.scene);
}

static void check_chunks_against_exact(void **state, const svo_mesh *mesh, unsigned depth, unsigned least_reruns)
{
    const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = 1.0, .chunk_bytes = 16384};
    built actual;
    fixture_build(fixture_of_group(state), mesh, depth, &options, &actual);
    print_message("%zu triangles at depth %u: %u chunks, %u reruns\n", mesh->triangle_count, depth,
                  actual.report.list_chunks, actual.report.reruns);
    assert_in_range(actual.report.list_chunks, 2, UINT32_MAX);
    assert_in_range(actual.report.reruns, least_reruns, UINT32_MAX);
    assert_build_is_exact(mesh, &options, &actual);
    built_destroy(&actual);
}

/* Triangles that fill many chunks each are split into tiles, with short and with long codes. */
static void huge_triangles_are_split_into_tiles(void **state)
{
    static const double slanted[] = {0.01, 0.02, 0.97, 0.99, 0.03, 0.5, 0.4, 0.98, 0.02};
    static const double flat[] = {0.0, 0.0, 0.5, 2.5, 0.0, 0.5, 0.0, 2.5, 0.5};
    static const double outside[] = {-90.0, -200.0, 0.1, 80.0, 90.0, 0.3, 0.9, 300.0, 1.1};
    const double *const cases[] = {slanted, flat, outside};
    for (size_t i = 0; i < 3; ++i) {
        const svo_mesh mesh = {
            .struct_size = sizeof mesh, .positions_double = cases[i], .vertex_count = 3, .triangle_count = 1};
        check_chunks_against_exact(state, &mesh, 6 + (unsigned)i, 0);
    }
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions_double = slanted, .vertex_count = 3, .triangle_count = 1};
    const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = 8.0, .chunk_bytes = 100000};
    built actual;
    fixture_build(fixture_of_group(state), &mesh, 12, &options, &actual);
    assert_in_range(actual.report.list_chunks, 2, UINT32_MAX);
    assert_build_is_exact(&mesh, &options, &actual);
    built_destroy(&actual);
}

/* Triangles with several times the estimated fragments: the list grows, chunks are split, and the nodes are built
   again with more memory. */
static void lists_that_were_too_small_grow(void **state)
{
    owned_mesh made;
    corner_mesh(16, &made);
    check_chunks_against_exact(state, &made.mesh, 9, 1);
    const svo_plan_options options = {.need = SVO_NEED_RAYS, .edge = 1.0};
    for (unsigned depth = 6; depth <= SVO_DEPTH_MAX; depth += 2) {
        built actual;
        fixture_build(fixture_of_group(state), &made.mesh, depth, &options, &actual);
        assert_int_equal(actual.report.reruns, 2); /* the list, and the nodes */
        assert_int_equal(actual.report.fragments, 15 * 15 * 15 * 7);
        assert_build_is_exact(&made.mesh, &options, &actual);
        built_destroy(&actual);
    }
    owned_mesh_free(&made);
}

static void any_capacity_gives_the_same_tree(void **state)
{
    static const uint64_t capacities[] = {1, 2, 1000, 1u << 20, 1u << 24};
    baseline expected;
    make_baseline(state, "knot:5000", 8, &expected);
    for (size_t i = 0; i < sizeof capacities / sizeof capacities[0]; ++i) {
        const svo_plan_options options = {.need = NEED_ALL, .fragment_capacity = capacities[i]};
        svo_build_report report;
        assert_same(fixture_of_group(state), &expected, &options, &report);
        assert_int_equal(report.reruns, capacities[i] < report.fragments ? 1 : 0);
    }
    scene_destroy(&expected.scene);
}

static void shuffle_triangles(uint64_t seed, uint32_t *indices, size_t triangle_count)
{
    uint64_t state = seed;
    for (size_t t = triangle_count; t-- > 1;) {
        const size_t other = random_below(&state, (uint32_t)t + 1);
        for (unsigned corner = 0; corner < 3; ++corner) {
            const uint32_t kept = indices[t * 3 + corner];
            indices[t * 3 + corner] = indices[other * 3 + corner];
            indices[other * 3 + corner] = kept;
        }
    }
}

static void permuted_triangles_give_the_same_nodes_and_payload(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL};
    scene *made = fixture_scene("knot:20000");
    svo_mesh mesh = *scene_mesh(made);
    built expected;
    fixture_build(opened, &mesh, 7, &options, &expected);
    uint32_t *indices = malloc(mesh.triangle_count * 3 * sizeof *indices);
    assert_non_null(indices);
    memcpy(indices, mesh.indices, mesh.triangle_count * 3 * sizeof *indices);
    mesh.indices = indices;
    mesh.triangle_materials = NULL;
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        shuffle_triangles(seed, indices, mesh.triangle_count);
        built actual;
        fixture_build(opened, &mesh, 7, &options, &actual);
        assert_string_equal(actual.nodes_hash, expected.nodes_hash);
        assert_string_equal(actual.hash, expected.hash);
        built_destroy(&actual);
    }
    free(indices);
    built_destroy(&expected);
    scene_destroy(&made);
}

/* Floats or doubles, with indices or without. */
static void forms_of_the_same_mesh_give_the_same_tree(void **state)
{
    const fixture *opened = fixture_of_group(state);
    const svo_plan_options options = {.need = SVO_NEED_NORMAL};
    scene *made = fixture_scene("terrain:5000");
    const svo_mesh *mesh = scene_mesh(made);
    built expected;
    fixture_build(opened, mesh, 8, &options, &expected);
    const size_t corner_count = mesh->triangle_count * 3;
    float *positions = malloc(corner_count * 3 * sizeof *positions);
    double *positions_double = malloc(corner_count * 3 * sizeof *positions_double);
    float *normals = malloc(corner_count * 3 * sizeof *normals);
    assert_non_null(positions);
    assert_non_null(positions_double);
    assert_non_null(normals);
    for (size_t i = 0; i < corner_count * 3; ++i) {
        positions[i] = mesh->positions[mesh->indices[i / 3] * 3 + i % 3];
        positions_double[i] = (double)positions[i];
        normals[i] = mesh->normals[mesh->indices[i / 3] * 3 + i % 3];
    }
    const svo_mesh forms[] = {{.positions = positions}, {.positions_double = positions_double}};
    for (size_t i = 0; i < 2; ++i) {
        svo_mesh form = forms[i];
        form.struct_size = sizeof form;
        form.vertex_count = corner_count;
        form.triangle_count = mesh->triangle_count;
        form.normals = normals;
        built actual;
        fixture_build(opened, &form, 8, &options, &actual);
        assert_string_equal(actual.hash, expected.hash);
        built_destroy(&actual);
    }
    free(normals);
    free(positions_double);
    free(positions);
    built_destroy(&expected);
    scene_destroy(&made);
}

TEST_GROUP(build_variants)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(host_share_gives_the_same_tree),
        cmocka_unit_test(copy_share_gives_the_same_tree),
        cmocka_unit_test(surfaceless_context_gives_the_same_tree),
        cmocka_unit_test(egl_device_context_gives_the_same_tree),
        cmocka_unit_test(osmesa_context_gives_the_same_tree),
        cmocka_unit_test(in_order_queue_gives_the_same_tree),
        cmocka_unit_test(out_of_order_queue_gives_the_same_tree),
        cmocka_unit_test(profiling_queue_gives_the_same_tree),
        cmocka_unit_test(out_of_order_profiling_queue_gives_the_same_tree),
        cmocka_unit_test(two_word_integers_give_the_same_tree),
        cmocka_unit_test(repeated_runs_give_the_same_tree),
        cmocka_unit_test(a_plan_can_be_built_twice),
        cmocka_unit_test(chunks_of_any_size_give_the_same_tree),
        cmocka_unit_test(huge_triangles_are_split_into_tiles),
        cmocka_unit_test(lists_that_were_too_small_grow),
        cmocka_unit_test(any_capacity_gives_the_same_tree),
        cmocka_unit_test(permuted_triangles_give_the_same_nodes_and_payload),
        cmocka_unit_test(forms_of_the_same_mesh_give_the_same_tree),
    };
    return cmocka_run_group_tests_name("build_variants", tests, fixture_group_setup, fixture_group_teardown);
}
