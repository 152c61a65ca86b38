/* SPDX-License-Identifier: MIT */
/*
 * Plans: their figures for a mesh are correct, data that is not requested is neither in the plan nor in the tree, and
 * arguments out of range are refused with a message that names function, argument, value and limit.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "support/compare_tree.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

static svo_plan_info plan_info(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_plan_options options)
{
    options.struct_size = sizeof options;
    svo_plan *plan = NULL;
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    if (svo_plan_create(opened->device, mesh, depth, &options, &plan) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
    svo_plan_get_info(plan, &info);
    svo_plan_destroy(&plan);
    assert_null(plan);
    return info;
}

static void the_estimate_predicts_the_fragments(void **state)
{
    static const char *const specs[] = {"statue:120000", "statue:20000", "terrain:100000", "knot", "needles:5000"};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        scene *made = fixture_scene(specs[i]);
        for (unsigned depth = 7; depth <= (suite_is_long() ? 9 : 8); ++depth) {
            built actual;
            fixture_build(opened, scene_mesh(made), depth, &(svo_plan_options){.need = SVO_NEED_NONE}, &actual);
            const double expected = actual.plan.expected_fragments;
            const double ratio = (double)actual.report.fragments / expected;
            print_message("%s at depth %u: %.0f fragments expected, ratio of actual to expected %.4f\n", specs[i],
                          depth, expected, ratio);
            assert_true(ratio > 0.97 && ratio < 1.03);
            assert_int_equal(actual.report.reruns, 0);
            built_destroy(&actual);
        }
        scene_destroy(&made);
    }
}

static void plan_figures_are_correct(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        owned_mesh made;
        random_mesh(seed, 300, 0.0, &made);
        for (size_t i = 0; i < 300; ++i) { /* every vertex is used */
            made.indices[i * 3] = (uint32_t)i * 3;
        }
        const svo_plan_options options = {.edge = seed % 2 == 0 ? 0.0 : 1.7, .origin = {-0.3, 0.1, 0.2}};
        const oracle_positions positions = {made.positions, made.mesh.vertex_count, NULL, 300};
        oracle_grid grid;
        assert_true(options.edge > 0.0 ? oracle_grid_given(options.origin, options.edge, 20, &grid)
                                       : oracle_grid_fit(&positions, 20, &grid));
        const svo_plan_info info = plan_info(opened, &made.mesh, 7, options);
        assert_int_equal(info.depth, 7);
        assert_int_equal(info.snap_bits, 20);
        assert_int_equal(info.triangles, 300);
        assert_int_equal(info.refused_triangles, 0);
        assert_true(info.edge == grid.edge && info.scale == grid.scale);
        assert_true(info.grid_ms >= 0.0);
        owned_mesh_free(&made);
    }
}

/* The edge of a fitted grid is that of the reference; as a grid of the caller's it is the same grid. */
static void fitted_grids_can_be_given(void **state)
{
    const fixture *opened = fixture_of_group(state);
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        owned_mesh made;
        oracle_grid grid;
        random_mesh(seed, 4, 0.0, &made);
        const oracle_positions positions = {made.positions, made.mesh.vertex_count, made.indices, 4};
        assert_true(oracle_grid_fit(&positions, 20, &grid));
        const svo_plan_info info = plan_info(opened, &made.mesh, 3, (svo_plan_options){0});
        if (info.edge != grid.edge || info.scale != grid.scale) {
            fail_msg("seed %u: edge %a, expected %a, scale %a, expected %a", (unsigned)seed, info.edge, grid.edge,
                     info.scale, grid.scale);
        }
        svo_plan_options given = {.edge = info.edge};
        memcpy(given.origin, info.origin, sizeof given.origin);
        const svo_plan_info again = plan_info(opened, &made.mesh, 3, given);
        assert_memory_equal(again.origin, info.origin, sizeof info.origin);
        assert_true(again.edge == info.edge && again.scale == info.scale);
        assert_int_equal(again.outside_triangles, 0);
        owned_mesh_free(&made);
    }
}

/* The largest extent, a little less than a power of two, makes a unit of 1. */
static void integer_meshes_fit_whole_units(void **state)
{
    static const float positions[] = {0, 0, 0, 1048575, 12345, 77, 5, 1048575, 654321};
    const svo_mesh mesh = {.struct_size = sizeof mesh, .positions = positions, .vertex_count = 3, .triangle_count = 1};
    const svo_plan_info info = plan_info(fixture_of_group(state), &mesh, 9, (svo_plan_options){0});
    assert_true(info.scale == 1.0);
}

/* A triangle so small that it is in few leaves at any depth. */
static void rays_have_a_deepest_depth(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static const float corners[9] = {1, 1, 1, 1.0001F, 1, 1, 1, 1.0001F, 1};
    const svo_mesh speck = {.struct_size = sizeof speck, .positions = corners, .vertex_count = 3, .triangle_count = 1};
    const svo_plan_options options = {.struct_size = sizeof options, .origin = {0, 0, 0}, .edge = 4096};
    svo_plan *plan = NULL;
    assert_int_equal(svo_plan_create(opened->device, &speck, 5, &options, &plan), SVO_OK);
    assert_int_equal(info_of_plan(plan).ray_depth, 12);
    svo_plan_destroy(&plan);
}

static void refused_and_outside_triangles_are_counted(void **state)
{
    static const double positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 9, 9, 9, 9, 8, 9, 8, 9, 9, NAN, 0, 0, 1e9, 0, 0};
    static const uint32_t indices[] = {0, 1, 2, 3, 4, 5, 0, 1, 6, 0, 1, 99, 0, 1, 7, 3, 4, 7, 2, 1, 0};
    const fixture *opened = fixture_of_group(state);
    const svo_mesh mesh = {.struct_size = sizeof mesh,
                           .positions_double = positions,
                           .vertex_count = 8,
                           .indices = indices,
                           .triangle_count = 7};
    const svo_plan_info caller = plan_info(opened, &mesh, 5, (svo_plan_options){.edge = 2.0});
    assert_int_equal(caller.triangles, 7);
    assert_int_equal(caller.refused_triangles, 3); /* NaN; index 99; a corner at 1e9 */
    assert_int_equal(caller.outside_triangles, 2); /* 3 4 5 and, however far, 3 4 7 */
    const svo_plan_info fitted = plan_info(opened, &mesh, 5, (svo_plan_options){0});
    assert_int_equal(fitted.refused_triangles, 2);
    assert_int_equal(fitted.outside_triangles, 0);
    assert_true(fitted.edge > 1e9 && fitted.edge < 1.000002e9);
}

static void default_need_follows_the_mesh(void **state)
{
    static const float three[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint8_t colors[12] = {0};
    static const svo_material material = {{1, 2, 3, 4}, SVO_NO_TEXTURE};
    const fixture *opened = fixture_of_group(state);
    svo_mesh mesh = {.struct_size = sizeof mesh, .positions = three, .vertex_count = 3, .triangle_count = 1};
    /* Normals of triangles, where the mesh has none. */
    assert_int_equal(plan_info(opened, &mesh, 3, (svo_plan_options){0}).need, SVO_NEED_NORMAL);
    mesh.normals = three;
    assert_int_equal(plan_info(opened, &mesh, 3, (svo_plan_options){0}).need, SVO_NEED_NORMAL);
    mesh.colors = colors;
    assert_int_equal(plan_info(opened, &mesh, 3, (svo_plan_options){0}).need, SVO_NEED_NORMAL | SVO_NEED_COLOR);
    mesh.normals = NULL;
    mesh.colors = NULL;
    mesh.materials = &material;
    mesh.material_count = 1;
    assert_int_equal(plan_info(opened, &mesh, 3, (svo_plan_options){0}).need, SVO_NEED_NORMAL | SVO_NEED_COLOR);
    assert_int_equal(plan_info(opened, &mesh, 3, (svo_plan_options){.need = SVO_NEED_NONE}).need, 0);
    assert_int_equal(plan_info(opened, &mesh, 3, (svo_plan_options){.need = SVO_NEED_RAYS}).need, SVO_NEED_RAYS);
}

static bool has_buffer(const svo_buffer_info *buffers, size_t count, const char *name)
{
    for (size_t i = 0; i < count; ++i) {
        if (strcmp(buffers[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

/* The buffers that depend on the request; all others always exist. */
static const struct {
    const char *name;
    uint32_t needs; /* needed for any of these */
} optional_buffers[] = {
    {"list_begin", SVO_NEED_RAYS | SVO_NEED_MATERIAL},
    {"list", SVO_NEED_RAYS},
    {"list_counts", SVO_NEED_RAYS | SVO_NEED_MATERIAL},
    {"list_spare", SVO_NEED_RAYS},
    {"long_leaves", SVO_NEED_RAYS},
    {"triangle_ids", SVO_NEED_RAYS},
    {"positions", SVO_NEED_RAYS},
    {"vertices", SVO_NEED_ALL},
    {"vertex_remainders", SVO_NEED_ALL & ~(uint32_t)SVO_NEED_RAYS},
    {"indices", SVO_NEED_ALL},
    {"cursors", SVO_NEED_ALL},
    {"heads", SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_FILL | SVO_NEED_PROJECTED_AREA},
    {"weights", SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_FILL},
    {"records", SVO_NEED_ALL & ~(uint32_t)SVO_NEED_RAYS},
    {"material_records", SVO_NEED_COLOR},
    {"materials", SVO_NEED_MATERIAL},
    {"entries", SVO_NEED_MATERIAL},
    {"entry_begins", SVO_NEED_MATERIAL},
    {"entry_counts", SVO_NEED_MATERIAL},
    {"fills", SVO_NEED_FILL},
    {"areas", SVO_NEED_PROJECTED_AREA},
    {"color_sums", SVO_NEED_COLOR},
    {"colors", SVO_NEED_COLOR},
    {"vertex_colors", SVO_NEED_COLOR},
    {"normal_sums", SVO_NEED_NORMAL},
    {"normals", SVO_NEED_NORMAL},
    {"vertex_normals", SVO_NEED_NORMAL},
};

static void assert_plan_has_what_is_needed(const svo_buffer_info *buffers, size_t count, uint32_t need)
{
    static const char *const always[] = {"mesh_items",       "mesh_tiles",  "counters",    "fragments",
                                         "blocks",           "block_ranks", "state",       "child_mask_pool",
                                         "first_child_pool", "child_mask",  "first_child", "partials"};
    size_t expected_count = sizeof always / sizeof always[0];
    for (size_t i = 0; i < sizeof always / sizeof always[0]; ++i) {
        assert_true(has_buffer(buffers, count, always[i]));
    }
    /* Under these names where the voxelizer alone reads them. */
    assert_int_equal(has_buffer(buffers, count, "mesh_vertices"), !has_buffer(buffers, count, "vertices"));
    assert_int_equal(has_buffer(buffers, count, "mesh_indices"), !has_buffer(buffers, count, "indices"));
    /* The mesh as given decides some voxels, and rays meet it. */
    assert_int_equal(has_buffer(buffers, count, "mesh_positions"), !has_buffer(buffers, count, "positions"));
    expected_count += has_buffer(buffers, count, "positions") ? 0 : 1;
    expected_count += has_buffer(buffers, count, "vertices") ? 0 : 1;
    expected_count += has_buffer(buffers, count, "indices") ? 0 : 1;
    for (size_t i = 0; i < sizeof optional_buffers / sizeof optional_buffers[0]; ++i) {
        const bool needed = (need & optional_buffers[i].needs) != 0;
        if (has_buffer(buffers, count, optional_buffers[i].name) != needed) {
            fail_msg("need %u: buffer %s is %s", need, optional_buffers[i].name, needed ? "missing" : "not needed");
        }
        expected_count += needed ? 1 : 0;
    }
    assert_int_equal(count, expected_count);
}

/* Size of a payload array on the device. */
static uint64_t payload_bytes(const svo_tree_info *info, uint32_t need, svo_need bit, uint64_t element_bytes)
{
    const uint64_t count = (info->constant & (uint32_t)bit) != 0 ? 1 : info->node_count;
    return (need & (uint32_t)bit) != 0 ? count * element_bytes : 0;
}

/* The tree has exactly the requested arrays, with the sizes that the header documents. */
static void assert_tree_has_what_is_needed(const built *actual, uint32_t need)
{
    const svo_tree_info *info = &actual->info;
    const bool rays = (need & SVO_NEED_RAYS) != 0;
    const uint64_t bytes[SVO_TREE_BUFFER_COUNT] = {
        [SVO_TREE_CHILD_MASK] = info->inner_count,
        [SVO_TREE_FIRST_CHILD] = info->inner_count * 4,
        [SVO_TREE_COLORS] = payload_bytes(info, need, SVO_NEED_COLOR, 4),
        [SVO_TREE_NORMALS] = payload_bytes(info, need, SVO_NEED_NORMAL, 6),
        [SVO_TREE_LIST_BEGIN] = rays ? (info->leaf_count + 1) * 4 : 0,
        [SVO_TREE_LIST] = rays ? info->fragments * 4 : 0,
        [SVO_TREE_VERTICES] = rays ? info->vertex_count * 12 : 0,
        [SVO_TREE_INDICES] = rays ? info->list_triangle_count * 12 : 0,
        [SVO_TREE_TRIANGLE_IDS] = rays ? info->list_triangle_count * 4 : 0,
        [SVO_TREE_MATERIALS] = payload_bytes(info, need, SVO_NEED_MATERIAL, 2),
        [SVO_TREE_FILLS] = payload_bytes(info, need, SVO_NEED_FILL, 2),
        [SVO_TREE_AREAS] = (need & SVO_NEED_PROJECTED_AREA) != 0 ? info->leaf_count * 12 : 0,
        [SVO_TREE_POSITIONS] = rays ? info->vertex_count * 12 : 0,
    };
    const void *const arrays[SVO_TREE_BUFFER_COUNT] = {
        actual->arrays.child_mask, actual->arrays.first_child,     actual->arrays.colors,
        actual->arrays.normals,    actual->arrays.list_begin,      actual->arrays.list,
        actual->arrays.vertices,   actual->arrays.indices,         actual->arrays.triangle_ids,
        actual->arrays.materials,  actual->arrays.fills,           actual->arrays.areas,
        actual->arrays.positions,  actual->arrays.positions_double};
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const cl_mem buffer = svo_tree_get_buffer(actual->tree, (svo_tree_buffer)i);
        size_t held_bytes = 0;
        if (buffer != NULL) {
            clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof held_bytes, &held_bytes, NULL);
        }
        if (held_bytes != bytes[i] || (arrays[i] != NULL) != (bytes[i] > 0)) {
            fail_msg("need %u: %s has %zu bytes, not %llu", need, svo_name(SVO_NAME_TREE_BUFFER, (svo_tree_buffer)i),
                     held_bytes, (unsigned long long)bytes[i]);
        }
    }
}

static size_t predicted_buffers(const fixture *opened, const svo_mesh *mesh, const svo_plan_options *asked,
                                svo_buffer_info buffers[FIXTURE_BUFFERS_MAX])
{
    svo_plan_options options = *asked;
    options.struct_size = sizeof options;
    svo_plan *plan = NULL;
    assert_int_equal(svo_plan_create(opened->device, mesh, 7, &options, &plan), SVO_OK);
    const size_t count = info_of_plan(plan).buffer_count;
    assert_in_range(count, 1, FIXTURE_BUFFERS_MAX);
    uint64_t total_bytes = 0;
    for (size_t i = 0; i < count; ++i) {
        buffers[i] = (svo_buffer_info)SVO_BUFFER_INFO_INIT;
        assert_int_equal(svo_plan_get_buffer(plan, i, &buffers[i]), SVO_OK);
        assert_in_range(buffers[i].count, 1, 2);
        total_bytes += buffers[i].bytes;
    }
    assert_in_range(info_of_plan(plan).peak_bytes, 1, total_bytes);
    svo_plan_destroy(&plan);
    return count;
}

/* If nothing had to grow: the same buffers in the same order, within the predicted sizes. */
static void assert_prediction_holds(const built *actual, const svo_buffer_info *predicted)
{
    assert_int_equal(actual->report.reruns, 0);
    for (size_t i = 0; i < actual->buffer_count; ++i) {
        assert_string_equal(predicted[i].name, actual->buffers[i].name);
        assert_int_equal(predicted[i].count, actual->buffers[i].count);
        if (predicted[i].bytes < actual->buffers[i].bytes) {
            fail_msg("%s: %llu bytes, %llu planned", predicted[i].name, (unsigned long long)actual->buffers[i].bytes,
                     (unsigned long long)predicted[i].bytes);
        }
    }
}

/* Colors that differ between vertices, allocated by malloc; the scene's own are all white. */
static uint8_t *varied_colors(size_t vertex_count)
{
    uint8_t *colors = malloc(vertex_count * 4);
    assert_non_null(colors);
    for (size_t i = 0; i < vertex_count * 4; ++i) {
        colors[i] = (uint8_t)(i * 37 % 251);
    }
    return colors;
}

/* Whether a mask is tried: none and all, each need alone and all others without it. So every pair of needs is there
   with both, either and neither of them. */
static bool is_tried(uint32_t bits)
{
    const uint32_t missing = SVO_NEED_ALL & ~bits;
    return (bits & (bits - 1)) == 0 || (missing & (missing - 1)) == 0;
}

static void unrequested_data_is_absent(void **state)
{
    const fixture by_cl = fixture_cl_of_group(state);
    const fixture *opened = &by_cl;
    if (!fixture_has_pair_lanes(opened)) {
        print_message("the table is of builds with lanes of pairs, which this device does not have\n");
        skip();
    }
    scene *made = fixture_scene("cornell");
    svo_mesh mesh = *scene_mesh(made);
    uint8_t *colors = varied_colors(mesh.vertex_count);
    mesh.colors = colors;
    char nodes_hash[SVO_HASH_TEXT_BYTES] = "";
    for (uint32_t bits = 0; bits <= SVO_NEED_ALL; ++bits) {
        if (!is_tried(bits)) {
            continue;
        }
        const uint32_t need = bits == 0 ? (uint32_t)SVO_NEED_NONE : bits;
        const svo_plan_options options = {.need = need, .place = SVO_PLACE_HOST};
        built actual;
        fixture_build(opened, &mesh, 7, &options, &actual);
        assert_int_equal(actual.plan.need, bits);
        assert_int_equal(actual.info.need, bits);
        if (bits == 0) {
            memcpy(nodes_hash, actual.nodes_hash, sizeof nodes_hash);
        }
        assert_string_equal(actual.nodes_hash, nodes_hash);
        assert_tree_has_what_is_needed(&actual, bits);
        assert_plan_has_what_is_needed(actual.buffers, actual.buffer_count, bits);
        assert_int_equal(actual.report.stage_times[SVO_STAGE_PACK].clock != NULL,
                         (bits & (SVO_NEED_RAYS | SVO_NEED_MATERIAL)) != 0);
        assert_int_equal(actual.report.stage_times[SVO_STAGE_FILTER].clock != NULL,
                         (bits & ~(uint32_t)SVO_NEED_RAYS) != 0);
        assert_int_equal(actual.report.stage_times[SVO_STAGE_LINK].clock != NULL,
                         (bits & (SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_FILL | SVO_NEED_PROJECTED_AREA)) != 0);
        svo_buffer_info predicted[FIXTURE_BUFFERS_MAX] = {{0}};
        const size_t count = predicted_buffers(opened, &mesh, &options, predicted);
        assert_plan_has_what_is_needed(predicted, count, bits);
        assert_prediction_holds(&actual, predicted);
        built_destroy(&actual);
    }
    free(colors);
    scene_destroy(&made);
}

/* The sorted builder's buffers match the prediction too. */
static void the_sorted_builder_keeps_to_its_plan(void **state)
{
    const fixture by_cl = fixture_cl_of_group(state);
    const fixture *opened = &by_cl;
    scene *made = fixture_scene("cornell");
    for (uint32_t bits = 0; bits <= SVO_NEED_ALL; ++bits) {
        if (!is_tried(bits)) {
            continue;
        }
        const svo_plan_options options = {.need = bits == 0 ? (uint32_t)SVO_NEED_NONE : bits,
                                          .builder = SVO_BUILDER_SORTED};
        built actual;
        svo_buffer_info predicted[FIXTURE_BUFFERS_MAX] = {{0}};
        fixture_build(opened, scene_mesh(made), 7, &options, &actual);
        assert_tree_has_what_is_needed(&actual, bits);
        assert_int_equal(predicted_buffers(opened, scene_mesh(made), &options, predicted), actual.buffer_count);
        assert_prediction_holds(&actual, predicted);
        built_destroy(&actual);
    }
    scene_destroy(&made);
}

static void assert_refused(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                           const char *const words[])
{
    svo_plan *plan = NULL;
    const svo_status status = svo_plan_create(opened->device, mesh, depth, options, &plan);
    const char *message = svo_device_message(opened->device);
    print_message("%s\n", message);
    assert_int_equal(status, SVO_INVALID_ARGUMENT);
    assert_null(plan);
    assert_ptr_equal(strstr(message, "svo_plan_create: "), message);
    assert_null(strchr(message, '\n'));
    for (size_t i = 0; words[i] != NULL; ++i) {
        if (strstr(message, words[i]) == NULL) {
            fail_msg("'%s' does not contain '%s'", message, words[i]);
        }
    }
}

#define WORDS(...)        \
    (const char *const[]) \
    {                     \
        __VA_ARGS__, NULL \
    }

static const float corner_positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const svo_mesh small_mesh = {
    .struct_size = sizeof small_mesh, .positions = corner_positions, .vertex_count = 3, .triangle_count = 1};

static void depths_out_of_range_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    assert_refused(opened, &small_mesh, 0, NULL, WORDS("depth 0", "1 .. 16"));
    assert_refused(opened, &small_mesh, 17, NULL, WORDS("depth 17", "1 .. 16"));
    assert_refused(opened, &small_mesh, UINT32_MAX, NULL, WORDS("depth 4294967295", "1 .. 16"));
}

static void options_out_of_range_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_plan_options options = {.struct_size = sizeof options + 8};
    assert_refused(opened, &small_mesh, 5, &options, WORDS("options.struct_size"));
    options.struct_size = 0;
    assert_refused(opened, &small_mesh, 5, &options, WORDS("options.struct_size", "0"));
    static const uint32_t bad_needs[] = {64, 0x80000000u, (uint32_t)SVO_NEED_NONE | SVO_NEED_COLOR, 0x3fffffffu};
    for (size_t i = 0; i < 4; ++i) {
        options = (svo_plan_options){.struct_size = sizeof options, .need = bad_needs[i]};
        assert_refused(opened, &small_mesh, 5, &options, WORDS("options.need 0x"));
    }
    options = (svo_plan_options){.struct_size = sizeof options, .builder = (svo_builder)2};
    assert_refused(opened, &small_mesh, 5, &options, WORDS("options.builder 2", "0 .. 1"));
    options = (svo_plan_options){.struct_size = sizeof options, .weights = (svo_weights)3};
    assert_refused(opened, &small_mesh, 5, &options, WORDS("options.weights 3", "0 .. 2"));
    options = (svo_plan_options){.struct_size = sizeof options, .need = SVO_NEED_FILL, .weights = SVO_WEIGHTS_CENTER};
    assert_refused(opened, &small_mesh, 5, &options, WORDS("fill", "options.weights is center"));
    static const double bad_edges[] = {-1.0, -0x1p-1074, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < 5; ++i) {
        options = (svo_plan_options){.struct_size = sizeof options, .edge = bad_edges[i]};
        assert_refused(opened, &small_mesh, 5, &options, WORDS("options.edge"));
    }
    static const double bad_origins[] = {NAN, INFINITY, -INFINITY};
    static const char *const origin_names[] = {"options.origin[0]", "options.origin[1]", "options.origin[2]"};
    for (size_t i = 0; i < 3; ++i) {
        options = (svo_plan_options){.struct_size = sizeof options, .edge = 1.0};
        options.origin[i] = bad_origins[i];
        assert_refused(opened, &small_mesh, 5, &options, WORDS(origin_names[i]));
    }
    static const uint64_t bad_chunks[] = {1, 8, 16383};
    for (size_t i = 0; i < 3; ++i) {
        options = (svo_plan_options){.struct_size = sizeof options, .chunk_bytes = bad_chunks[i]};
        assert_refused(opened, &small_mesh, 5, &options, WORDS("options.chunk_bytes", "16384"));
    }
    static const int bad_coverages[] = {-1, 3, 1 << 20};
    for (size_t i = 0; i < 3; ++i) {
        options = (svo_plan_options){.struct_size = sizeof options, .coverage = (svo_coverage)bad_coverages[i]};
        assert_refused(opened, &small_mesh, 5, &options, WORDS("options.coverage", "0 .. 2"));
    }
    options = (svo_plan_options){.struct_size = sizeof options, .fragment_capacity = UINT64_C(1) << 32};
    assert_refused(opened, &small_mesh, 5, &options, WORDS("options.fragment_capacity 4294967296", "above 4294901759"));
    options = (svo_plan_options){.struct_size = sizeof options, .edge = 1e-320};
    assert_refused(opened, &small_mesh, 5, &options, WORDS("edge"));
}

static void meshes_out_of_range_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_mesh mesh = small_mesh;
    mesh.struct_size = 0;
    assert_refused(opened, &mesh, 5, NULL, WORDS("mesh.struct_size"));
    mesh = small_mesh;
    mesh.positions = NULL;
    assert_refused(opened, &mesh, 5, NULL, WORDS("positions", "3"));
    const double positions_double[9] = {0};
    mesh = small_mesh;
    mesh.positions_double = positions_double;
    assert_refused(opened, &mesh, 5, NULL, WORDS("positions", "3"));
    mesh = small_mesh;
    mesh.vertex_count = (size_t)1 << 32;
    assert_refused(opened, &mesh, 5, NULL, WORDS("4294967296", "2^32"));
    mesh = small_mesh;
    mesh.triangle_count = (size_t)1 << 32;
    assert_refused(opened, &mesh, 5, NULL, WORDS("4294967296", "2^32"));
    const svo_material material = {{0}, SVO_NO_TEXTURE};
    mesh = small_mesh;
    mesh.materials = &material;
    mesh.material_count = 65536;
    assert_refused(opened, &mesh, 5, NULL, WORDS("65536", "65535"));
    mesh.materials = NULL;
    mesh.material_count = 1;
    assert_refused(opened, &mesh, 5, NULL, WORDS("materials"));
    mesh = small_mesh;
    mesh.texture_count = 1;
    assert_refused(opened, &mesh, 5, NULL, WORDS("textures"));
}

static void textures_out_of_range_are_refused(void **state)
{
    static const uint8_t texels[16] = {0};
    static const svo_texture bad[] = {{texels, 0, 1, SVO_WRAP_REPEAT, SVO_WRAP_REPEAT},
                                      {texels, 1, 0, SVO_WRAP_REPEAT, SVO_WRAP_REPEAT},
                                      {texels, 16385, 1, SVO_WRAP_REPEAT, SVO_WRAP_REPEAT},
                                      {texels, 1, 16385, SVO_WRAP_REPEAT, SVO_WRAP_REPEAT},
                                      {NULL, 2, 2, SVO_WRAP_REPEAT, SVO_WRAP_REPEAT}};
    static const char *const sizes[] = {"0 x 1", "1 x 0", "16385 x 1", "1 x 16385", "2 x 2"};
    const fixture *opened = fixture_of_group(state);
    for (size_t i = 0; i < 5; ++i) {
        const svo_texture textures[2] = {{texels, 2, 2, SVO_WRAP_CLAMP, SVO_WRAP_MIRROR}, bad[i]};
        svo_mesh mesh = small_mesh;
        mesh.textures = textures;
        mesh.texture_count = 2;
        assert_refused(opened, &mesh, 5, NULL, WORDS("texture 1", sizes[i], "16384"));
    }
}

static void null_arguments_of_a_plan_are_refused(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_plan *plan = NULL;
    assert_int_equal(svo_plan_create(NULL, &small_mesh, 5, NULL, &plan), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_plan_create(opened->device, NULL, 5, NULL, &plan), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "mesh"));
    assert_int_equal(svo_plan_create(opened->device, &small_mesh, 5, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "out"));
    assert_null(plan);
    svo_plan_destroy(NULL);
    svo_plan_destroy(&plan);
    svo_tree *tree = NULL;
    svo_tree_destroy(NULL);
    svo_tree_destroy(&tree);
}

static void arguments_of_a_build_are_checked(void **state)
{
    const fixture *opened = fixture_of_group(state);
    svo_frontend *frontend = svo_gl_frontend(opened->gl);
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    assert_int_equal(svo_plan_create(opened->device, &small_mesh, 5, NULL, &plan), SVO_OK);
    assert_int_equal(svo_build(NULL, frontend, opened->queue, &tree, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_build(plan, frontend, opened->queue, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "out"));
    svo_build_report report = {.struct_size = 1};
    assert_int_equal(svo_build(plan, frontend, opened->queue, &tree, &report), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(opened->device), "report.struct_size is 1"));
    assert_null(tree);
    svo_plan_destroy(&plan);

    svo_device *other = NULL;
    assert_int_equal(svo_device_create_default(NULL, &other, NULL), SVO_OK);
    assert_int_equal(svo_plan_create(other, &small_mesh, 5, NULL, &plan), SVO_OK);
    assert_int_equal(svo_build(plan, frontend, opened->queue, &tree, NULL), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(other), "queue is of another context"));
    assert_int_equal(svo_build(plan, frontend, NULL, &tree, NULL), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(other), "frontend is of another device"));
    assert_null(tree);
    svo_plan_destroy(&plan);
    svo_device_destroy(&other);
}

/* ---- grids by the width of a voxel ---- */

/* Random triangles within a box that lies anywhere; returns the far ends of what they use. */
static void random_box(uint64_t *seed, double positions[9], double low[3], double high[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        const double begin = (double)random_below(seed, 2000) / 7.0 - 140.0;
        const double width = (double)random_below(seed, 1000) / 9.0;
        for (int corner = 0; corner < 3; ++corner) {
            positions[3 * corner + axis] = begin + width * corner / 2.0;
        }
        low[axis] = begin;
        high[axis] = positions[6 + axis];
    }
}

/* The grid is that of the definition: on multiples, around the mesh, and half of it would not hold the mesh. */
static void voxels_have_the_width_that_is_asked_for(void **state)
{
    static const double widths[] = {1.0, 0.25, 0.1, 1.0 / 3.0, 3.7, 0.011};
    const fixture *opened = fixture_of_group(state);
    uint64_t seed = 41;
    for (int i = 0; i < 300; ++i) {
        double positions[9], low[3], high[3], origin[3], edge = 0.0;
        unsigned depth = 0;
        bool half_suffices = true;
        const double width = widths[i % 6];
        random_box(&seed, positions, low, high);
        const svo_mesh mesh = {
            .struct_size = sizeof mesh, .positions_double = positions, .vertex_count = 3, .triangle_count = 1};
        assert_int_equal(svo_mesh_voxel_grid(&mesh, width, origin, &edge, &depth, NULL), SVO_OK);
        assert_true(edge == ldexp(width, (int)depth));
        for (int axis = 0; axis < 3; ++axis) {
            assert_true(origin[axis] == round(origin[axis] / width) * width);
            assert_true(origin[axis] <= low[axis] && origin[axis] + 1.000001 * width > low[axis]);
            assert_true((long double)high[axis] < (long double)origin[axis] + (long double)edge);
            half_suffices = half_suffices && high[axis] < origin[axis] + 0.499999 * edge;
        }
        assert_true(depth == 1 || !half_suffices);
        const svo_plan_options options = {
            .origin = {origin[0], origin[1], origin[2]}, .edge = edge, .need = SVO_NEED_NONE};
        assert_int_equal(plan_info(opened, &mesh, depth, options).outside_triangles, 0);
    }
}

/* A vertex on a plane lies in the voxel above; what builds refuse has no place. */
static void far_planes_take_a_voxel(void **state)
{
    (void)state;
    static const struct {
        float high;
        double width;
        unsigned depth;
    } cases[] = {{1.0f, 0.25, 3}, {0.99f, 0.25, 2}, {65535.5f, 1.0, 16}, {0.0f, 1.0, 1}, {1e-3f, 5.0, 1}};
    float positions[] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, NAN, 1e9f, 0.0f};
    static const uint32_t indices[] = {0, 1, 2, 0, 1, 3, 0, 1, 9};
    const svo_mesh mesh = {
        .struct_size = sizeof mesh, .positions = positions, .vertex_count = 4, .indices = indices, .triangle_count = 3};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        double origin[3], edge = 0.0;
        unsigned depth = 0;
        positions[7] = cases[i].high;
        assert_int_equal(svo_mesh_voxel_grid(&mesh, cases[i].width, origin, &edge, &depth, NULL), SVO_OK);
        assert_int_equal(depth, cases[i].depth);
        assert_true(edge == ldexp(cases[i].width, (int)depth) && origin[0] == 0.0 && origin[1] == 0.0);
    }
}

static void assert_no_voxel_grid(const svo_mesh *mesh, double width, const char *words)
{
    double origin[3], edge = 0.0;
    unsigned depth = 0;
    svo_message message = {""};
    assert_int_equal(svo_mesh_voxel_grid(mesh, width, origin, &edge, &depth, &message), SVO_INVALID_ARGUMENT);
    if (strstr(message.text, words) == NULL) {
        fail_msg("'%s' has no '%s'", message.text, words);
    }
}

static void widths_of_no_grid_are_refused(void **state)
{
    (void)state;
    static const float positions[] = {0.0f, 0.0f, 0.0f, 65536.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
    svo_mesh mesh = {.struct_size = sizeof mesh, .positions = positions, .vertex_count = 3, .triangle_count = 1};
    svo_message message = {""};
    double origin[3], edge = 0.0;
    unsigned depth = 7;
    assert_no_voxel_grid(&mesh, 0.0, "svo_mesh_voxel_grid: voxel_edge 0 is not above 0, or too large");
    assert_no_voxel_grid(&mesh, -1.0, "voxel_edge -1");
    assert_no_voxel_grid(&mesh, NAN, "voxel_edge");
    assert_no_voxel_grid(&mesh, 1e305, "too large");
    assert_no_voxel_grid(&mesh, 1.0, "voxel_edge 1 makes 65537 voxels along x, above the limit of 65536 (depth 16)");
    assert_no_voxel_grid(NULL, 1.0, "mesh is NULL");
    const float far_away[] = {1e20f, 0.0f, 0.0f, 1e20f, 0.0f, 0.0f, 1e20f, 1.0f, 0.0f};
    mesh.positions = far_away;
    assert_no_voxel_grid(&mesh, 1.0, "voxel_edge 1 is too small for vertices at x = 1e+20");
    mesh.positions = NULL;
    assert_no_voxel_grid(&mesh, 1.0, "no positions");
    mesh.struct_size = 3;
    assert_no_voxel_grid(&mesh, 1.0, "mesh.struct_size");
    mesh.struct_size = sizeof mesh;
    assert_int_equal(svo_mesh_voxel_grid(&mesh, 1.0, NULL, &edge, &depth, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_mesh_voxel_grid(&mesh, 1.0, origin, NULL, &depth, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_mesh_voxel_grid(&mesh, 1.0, origin, &edge, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_mesh_voxel_grid: depth is NULL");
    mesh = (svo_mesh)SVO_MESH_INIT;
    assert_int_equal(svo_mesh_voxel_grid(&mesh, 0.5, origin, &edge, &depth, NULL), SVO_OK);
    assert_true(depth == 1 && edge == 1.0 && origin[0] == 0.0 && origin[1] == 0.0 && origin[2] == 0.0);
}

TEST_GROUP(plan)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_estimate_predicts_the_fragments),
        cmocka_unit_test(plan_figures_are_correct),
        cmocka_unit_test(fitted_grids_can_be_given),
        cmocka_unit_test(integer_meshes_fit_whole_units),
        cmocka_unit_test(voxels_have_the_width_that_is_asked_for),
        cmocka_unit_test(far_planes_take_a_voxel),
        cmocka_unit_test(widths_of_no_grid_are_refused),
        cmocka_unit_test(rays_have_a_deepest_depth),
        cmocka_unit_test(refused_and_outside_triangles_are_counted),
        cmocka_unit_test(default_need_follows_the_mesh),
        cmocka_unit_test(unrequested_data_is_absent),
        cmocka_unit_test(the_sorted_builder_keeps_to_its_plan),
        cmocka_unit_test(depths_out_of_range_are_refused),
        cmocka_unit_test(options_out_of_range_are_refused),
        cmocka_unit_test(meshes_out_of_range_are_refused),
        cmocka_unit_test(textures_out_of_range_are_refused),
        cmocka_unit_test(null_arguments_of_a_plan_are_refused),
        cmocka_unit_test(arguments_of_a_build_are_checked),
    };
    return cmocka_run_group_tests_name("plan", tests, fixture_group_setup, fixture_group_teardown);
}
