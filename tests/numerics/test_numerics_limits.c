/* SPDX-License-Identifier: MIT */
/*
 * The catalog of ill-conditioned and extreme cases, at the limits: capacities (T10), repeatability (T15), and the
 * limits of 32 bits: a build that cannot fit is refused with the figures before anything is allocated.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/compare_tree.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

#define NEED_ALL (SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS)

static const svo_coverage coverages[] = {SVO_COVERAGE_HALF_OPEN, SVO_COVERAGE_CLOSED, SVO_COVERAGE_THIN};
enum { COVERAGES = sizeof coverages / sizeof coverages[0] };

/*
 * T10 capacity.
 */

/* Capacities of 0 (the estimate), one, one too few, exactly enough and one more give the same tree, with the fewest
   possible reruns. */
static void check_capacities(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_coverage coverage)
{
    svo_plan_options options = {.need = NEED_ALL, .coverage = coverage, .edge = 1.0};
    built expected;
    fixture_build(opened, mesh, depth, &options, &expected);
    assert_build_is_exact(mesh, &options, &expected);
    const uint64_t exact_count = expected.report.fragments;
    const uint64_t room = exact_count + expected.report.undecided;
    const uint64_t capacities[] = {0, 1, exact_count - 1, room, room + 1};
    for (size_t i = 0; i < sizeof capacities / sizeof capacities[0]; ++i) {
        options.fragment_capacity = capacities[i];
        built actual;
        fixture_build(opened, mesh, depth, &options, &actual);
        assert_string_equal(actual.hash, expected.hash);
        assert_int_equal(actual.report.fragments, exact_count);
        if (i > 0) {
            assert_int_equal(actual.report.reruns, capacities[i] < exact_count ? 1 : 0);
        }
        built_destroy(&actual);
    }
    built_destroy(&expected);
}

static void t10_any_capacity_gives_the_whole_tree(void **state)
{
    for (uint64_t seed = 1; seed <= 2; ++seed) {
        print_message("seed %llu\n", (unsigned long long)seed);
        owned_mesh made;
        static const double corner[3] = {0.2, 0.3, 0.4};
        if (seed == 1) {
            random_mesh(seed, 150, 0.0, &made);
        } else {
            random_dust(seed, 60, corner, 0.01, &made);
        }
        for (unsigned c = 0; c < COVERAGES; ++c) {
            check_capacities(fixture_of_group(state), &made.mesh, seed == 1 ? 6 : 11, coverages[c]);
        }
        owned_mesh_free(&made);
    }
}

/*
 * T15 repeatability.
 */

/* Fisher-Yates shuffle; from[t]: the former index of triangle t. */
static void permute(uint64_t seed, owned_mesh *made, uint32_t *from)
{
    uint64_t state = seed;
    const size_t count = made->mesh.triangle_count;
    for (size_t t = 0; t < count; ++t) {
        from[t] = (uint32_t)t;
    }
    for (size_t t = count; t-- > 1;) {
        const size_t other = random_below(&state, (uint32_t)t + 1);
        const uint32_t kept = from[t];
        from[t] = from[other];
        from[other] = kept;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const uint32_t index = made->indices[t * 3 + corner];
            made->indices[t * 3 + corner] = made->indices[other * 3 + corner];
            made->indices[other * 3 + corner] = index;
        }
    }
}

static int compare_ids(const void *left, const void *right)
{
    const uint32_t a = *(const uint32_t *)left;
    const uint32_t b = *(const uint32_t *)right;
    return (a > b) - (a < b);
}

/* A tree's lists with ids of the mesh before its permutation; from: NULL without one. Allocated by malloc. */
static uint32_t *original_lists(const built *tree, const uint32_t *from)
{
    uint32_t *ids = malloc((tree->info.list_count + 1) * sizeof *ids);
    assert_non_null(ids);
    for (size_t i = 0; i < tree->info.list_count; ++i) {
        const uint32_t id = tree->arrays.triangle_ids[tree->arrays.list[i]];
        ids[i] = from != NULL ? from[id] : id;
    }
    for (size_t leaf = 0; leaf < tree->info.leaf_count; ++leaf) {
        const uint32_t *begin = tree->arrays.list_begin + leaf;
        qsort(ids + begin[0], begin[1] - begin[0], sizeof *ids, compare_ids);
    }
    return ids;
}

static void assert_same_lists(const built *actual, const uint32_t *from, const built *expected)
{
    assert_int_equal(actual->info.list_count, expected->info.list_count);
    assert_memory_equal(actual->arrays.list_begin, expected->arrays.list_begin,
                        (expected->info.leaf_count + 1) * sizeof(uint32_t));
    uint32_t *a = original_lists(actual, from);
    uint32_t *b = original_lists(expected, NULL);
    assert_memory_equal(a, b, expected->info.list_count * sizeof *a);
    free(b);
    free(a);
}

static void assert_same_payload(const built *actual, const built *expected)
{
    assert_memory_equal(actual->arrays.colors, expected->arrays.colors, expected->info.node_count * 4);
    assert_memory_equal(actual->arrays.normals, expected->arrays.normals,
                        expected->info.node_count * 3 * sizeof(int16_t));
}

/* test_threads covers threads; test_build_variants covers share paths, contexts, queues and chunks with half-open
   voxels. */
static void t15_permuted_triangles_and_share_paths_give_the_same_tree(void **state)
{
    static const svo_gl_share shares[] = {SVO_GL_SHARE_AUTO, SVO_GL_SHARE_COPY};
    for (unsigned i = 0; i < COVERAGES * 2u; ++i) {
        const uint64_t seed = 60 + i;
        print_message("seed %llu, %s, share path %s\n", (unsigned long long)seed,
                      svo_name(SVO_NAME_COVERAGE, coverages[i / 2]), svo_name(SVO_NAME_GL_SHARE, shares[i % 2]));
        const svo_plan_options options = {.need = NEED_ALL, .coverage = coverages[i / 2]};
        fixture other;
        owned_mesh made;
        built expected;
        built again;
        built permuted;
        uint32_t from[300];
        random_mesh(seed, 300, 0.0, &made);
        fixture_build(fixture_of_group(state), &made.mesh, 6, &options, &expected);
        fixture_open(&(fixture_options){.share = shares[i % 2]}, &other);
        fixture_build(&other, &made.mesh, 6, &options, &again);
        assert_string_equal(again.hash, expected.hash);
        permute(seed, &made, from);
        fixture_build(&other, &made.mesh, 6, &options, &permuted);
        assert_string_equal(permuted.nodes_hash, expected.nodes_hash);
        assert_same_payload(&permuted, &expected);
        assert_same_lists(&permuted, from, &expected);
        built_destroy(&permuted);
        built_destroy(&again);
        built_destroy(&expected);
        fixture_close(&other);
        owned_mesh_free(&made);
    }
}

/*
 * The limits of 32 bits.
 */

/* The build is refused without allocating anything; the message contains these words. */
static void assert_build_refused(const fixture *opened, svo_plan *plan, const char *words)
{
    svo_tree *tree = NULL;
    svo_build_report report = {.struct_size = sizeof report};
    const svo_status status = svo_build(plan, svo_gl_frontend(opened->gl), opened->queue, &tree, &report);
    const char *message = svo_device_message(opened->device);
    print_message("%s\n", message);
    assert_int_equal(status, SVO_OUT_OF_DEVICE_MEMORY);
    assert_null(tree);
    assert_null(report.stage_times[SVO_STAGE_VOXELIZE].clock);
    if (strstr(message, "svo_build: ") != message || strstr(message, words) == NULL) {
        fail_msg("'%s' does not contain '%s'", message, words);
    }
}

static uint64_t device_bytes(const fixture *opened)
{
    cl_ulong bytes = 0;
    clGetDeviceInfo(info_of_device(opened->device).device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    return bytes;
}

/* Squares across a grid of 65536^3: above 2^32 fragments, and below that but with too many bytes. */
static void make_squares(size_t count, owned_mesh *out)
{
    static const double corners[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    random_mesh(1, count * 2, 0.0, out);
    for (size_t v = 0; v < count * 6; ++v) {
        out->positions[v * 3] = corners[v % 6][0];
        out->positions[v * 3 + 1] = corners[v % 6][1];
        out->positions[v * 3 + 2] = v / 6 % 2 == 0 ? 0.0 : 0.5;
        out->indices[v] = (uint32_t)v;
    }
}

static svo_plan *plan_of(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options)
{
    svo_plan *plan = NULL;
    if (svo_plan_create(opened->device, mesh, depth, options, &plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
    return plan;
}

static void more_than_2_to_the_32_fragments_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    owned_mesh made;
    make_squares(1, &made);
    for (unsigned c = 0; c < COVERAGES; ++c) {
        const svo_plan_options options = {
            .struct_size = sizeof options, .need = SVO_NEED_NONE, .coverage = coverages[c]};
        svo_plan *plan = plan_of(opened, &made.mesh, 16, &options);
        svo_plan_info info = SVO_PLAN_INFO_INIT;
        svo_plan_get_info(plan, &info);
        assert_true(info.expected_fragments >= 0x1p32 && info.expected_fragments < 0x1.01p32);
        assert_build_refused(opened, plan, "at depth 16, above 2^32 - 1");
        svo_plan_destroy(&plan);
    }
    owned_mesh_free(&made);
}

/* One triangle less: the count fits into 32 bits, but the bytes do not fit into the device's memory. */
static void sizes_above_the_device_limit_are_refused_before_allocation(void **state)
{
    const fixture *opened = fixture_of_group(state);
    owned_mesh made;
    make_squares(1, &made);
    made.mesh.triangle_count = 1;
    svo_plan *plan = plan_of(opened, &made.mesh, 16, NULL);
    if (info_of_plan(plan).peak_bytes <= device_bytes(opened)) {
        svo_plan_destroy(&plan);
        owned_mesh_free(&made);
        print_message("skipped: the device has enough memory for it\n");
        skip();
    }
    char need[32];
    (void)snprintf(need, sizeof need, "needs about %.1f GiB at depth 16",
                   (double)info_of_plan(plan).peak_bytes / 0x1p30);
    assert_build_refused(opened, plan, need);
    /* The failed build did not change the plan: the next one fails with the same message. */
    assert_build_refused(opened, plan, need);
    svo_plan_destroy(&plan);
    owned_mesh_free(&made);
}

/* A capacity demands memory: one that exceeds the device's memory is refused too. */
static void capacities_of_2_to_the_31_are_refused_where_they_do_not_fit(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static const double positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions_double = positions, .vertex_count = 3, .triangle_count = 1};
    const svo_plan_options options = {.struct_size = sizeof options, .fragment_capacity = UINT64_C(0xf0000000)};
    svo_plan *plan = plan_of(opened, &mesh, 11, &options);
    if (info_of_plan(plan).peak_bytes <= device_bytes(opened)) {
        svo_plan_destroy(&plan);
        print_message("skipped: the device has enough memory for it\n");
        skip();
    }
    assert_build_refused(opened, plan, "bytes");
    svo_plan_destroy(&plan);
}

/* A chunk is never larger than the device's largest allocation, whatever size is requested. Lists split into small
   chunks represent those that are too large for one. */
static void lists_are_split_at_the_largest_allocation(void **state)
{
    const fixture *opened = fixture_of_group(state);
    owned_mesh made;
    random_mesh(70, 150, 0.0, &made);
    for (unsigned c = 0; c < COVERAGES; ++c) {
        svo_plan_options options = {.need = NEED_ALL, .coverage = coverages[c], .chunk_bytes = UINT64_MAX};
        built whole;
        built cut;
        fixture_build(opened, &made.mesh, 7, &options, &whole);
        options.chunk_bytes = 16384;
        fixture_build(opened, &made.mesh, 7, &options, &cut);
        assert_int_equal(whole.report.list_chunks, 1);
        assert_in_range(cut.report.list_chunks, whole.report.fragments * 8 / 16384, UINT32_MAX);
        assert_string_equal(cut.hash, whole.hash);
        built_destroy(&cut);
        built_destroy(&whole);
    }
    owned_mesh_free(&made);
}

TEST_GROUP(numerics_limits)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t10_any_capacity_gives_the_whole_tree),
        cmocka_unit_test(t15_permuted_triangles_and_share_paths_give_the_same_tree),
        cmocka_unit_test(more_than_2_to_the_32_fragments_are_refused),
        cmocka_unit_test(sizes_above_the_device_limit_are_refused_before_allocation),
        cmocka_unit_test(capacities_of_2_to_the_31_are_refused_where_they_do_not_fit),
        cmocka_unit_test(lists_are_split_at_the_largest_allocation),
    };
    return cmocka_run_group_tests_name("numerics_limits", tests, fixture_group_setup, fixture_group_teardown);
}
