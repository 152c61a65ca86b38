/* SPDX-License-Identifier: MIT */
/*
 * Work that a scene or a request does not need is left out: it is neither allocated nor compiled, the plan lists it
 * with a reason, and the requested results do not change by a bit. Each test builds the same nodes twice, with and
 * without that work, each time with a separate device handle.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "sheet_mesh.h"
#include "support/info_of.h"
#include "support/measured.h"
#include "support/payload_reference.h"
#include "support/suite.h"
#include "svocl/io.h"

#define DEPTH 8

static const uint8_t some_color[4] = {10, 200, 99, 255};
static const uint8_t white[4] = {255, 255, 255, 255};

/* On the grid that the sheet is designed for. */
static svo_plan_options asking_for(uint32_t need)
{
    return (svo_plan_options){.struct_size = sizeof(svo_plan_options), .need = need, .edge = 1.0};
}

static void build_sheet(const sheet_mesh *sheet, uint32_t need, measured *out)
{
    const svo_plan_options options = asking_for(need);
    measured_build(&sheet->mesh, DEPTH, &options, out);
}

/* Checks that less leaves it out and full does not. */
static void assert_only_less_leaves_out(const measured *less, const measured *full, const char *what)
{
    if (measured_left_out(less, what) == NULL) {
        fail_msg("%s is not left out", what);
    }
    if (measured_left_out(full, what) != NULL) {
        fail_msg("%s is left out where it is needed: %s", what, measured_left_out(full, what));
    }
}

/* Checks that full has the buffer and less does not. */
static void assert_only_full_has_buffer(const measured *less, const measured *full, const char *name)
{
    if (measured_buffer(less, name) != NULL || measured_buffer(full, name) == NULL) {
        fail_msg("buffer %s: %s", name, measured_buffer(full, name) == NULL ? "neither has it" : "it is not left out");
    }
}

static void assert_only_full_has_define(const measured *less, const measured *full, const char *define)
{
    if (measured_has_define(less, define) || !measured_has_define(full, define)) {
        fail_msg("define %s: less has%s, full has%s", define, less->defines, full->defines);
    }
}

static void assert_only_full_has_kernel(const measured *less, const measured *full, const char *name)
{
    if (measured_has_kernel(less, name) || !measured_has_kernel(full, name)) {
        fail_msg("kernel %s: less has %s, full has %s", name, less->kernels, full->kernels);
    }
}

/* Checks that the stages that run are those of the plan. */
static void assert_stages_are_planned(const svo_mesh *mesh, uint32_t need)
{
    svo_plan_options options = asking_for(need);
    svo_plan *plan = NULL;
    measured made;
    measured_build(mesh, DEPTH, &options, &made);
    assert_int_equal(svo_plan_create(made.opened.device, mesh, DEPTH, &options, &plan), SVO_OK);
    for (svo_stage stage = SVO_STAGE_GRID; stage < SVO_STAGE_COUNT; ++stage) {
        const int ran = made.result.report.stage_times[stage].clock != NULL;
        if ((svo_plan_has_stage(plan, stage) != 0) != ran) {
            fail_msg("need %u: stage %s %s", need, svo_name(SVO_NAME_STAGE, stage),
                     ran ? "ran unplanned" : "did not run");
        }
    }
    svo_plan_destroy(&plan);
    measured_destroy(&made);
}

/* Each need alone and all others without it, all and none: every pair of needs is there with both, either and neither
   of them. */
static void stages_that_do_not_run(void **state)
{
    (void)state;
    sheet_mesh sheet;
    sheet_make(SHEET_LARGE, 1.0, &sheet);
    for (uint32_t bit = 1; bit <= SVO_NEED_PROJECTED_AREA; bit <<= 1) {
        assert_stages_are_planned(&sheet.mesh, bit);
        assert_stages_are_planned(&sheet.mesh, SVO_NEED_ALL & ~bit);
    }
    assert_stages_are_planned(&sheet.mesh, SVO_NEED_ALL);
    assert_stages_are_planned(&sheet.mesh, SVO_NEED_NONE);
}

static void lists_and_their_packing(void **state)
{
    (void)state;
    static const char *const buffers[] = {"list",         "list_spare",       "long_leaves", "vertices",   "indices",
                                          "triangle_ids", "positions_double", "list_begin",  "list_counts"};
    sheet_mesh sheet;
    measured full;
    measured less;
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    build_sheet(&sheet, SVO_NEED_RAYS, &full);
    build_sheet(&sheet, SVO_NEED_NONE, &less);
    assert_same_results(&less, &full);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | FEWER_TREE_BYTES | FEWER_KERNELS | OTHER_DEFINES);
    assert_only_less_leaves_out(&less, &full, "leaf lists");
    assert_only_less_leaves_out(&less, &full, "packing");
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        assert_only_full_has_buffer(&less, &full, buffers[i]);
    }
    assert_only_full_has_kernel(&less, &full, "svo_k_scatter");
    assert_only_full_has_kernel(&less, &full, "svo_k_scan_lists_add");
    measured_destroy(&less);
    measured_destroy(&full);
}

/* The sorted list already has the order of the lists: no copy is packed, and kernels/stages/pack.cl is not compiled. */
static void the_packing_copy_of_sorted_lists(void **state)
{
    (void)state;
    static const char *const buffers[] = {"list_spare", "list_counts", "long_leaves"};
    static const char *const kernels[] = {"svo_k_count", "svo_k_scatter", "svo_k_sort_short", "svo_k_sort_long"};
    svo_plan_options options = asking_for(SVO_NEED_RAYS);
    sheet_mesh sheet;
    measured full;
    measured less;
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    measured_build(&sheet.mesh, DEPTH, &options, &full);
    options.builder = SVO_BUILDER_SORTED;
    measured_build(&sheet.mesh, DEPTH, &options, &less);
    assert_same_results(&less, &full);
    assert_string_equal(less.result.hash, full.result.hash);
    assert_only_less_leaves_out(&less, &full, "packing");
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; ++i) {
        assert_only_full_has_buffer(&less, &full, buffers[i]);
    }
    for (size_t i = 0; i < sizeof kernels / sizeof kernels[0]; ++i) {
        assert_only_full_has_kernel(&less, &full, kernels[i]);
    }
    measured_destroy(&less);
    measured_destroy(&full);
}

/* A payload, its array, and a kernel that this payload needs, alone or with others. */
static const struct payload {
    svo_need bit;
    const char *name, *array, *define, *kernel;
} payloads[] = {{SVO_NEED_COLOR, "color", "colors", "SVO_COLOR", "svo_k_filter"},
                {SVO_NEED_NORMAL, "normal", "normals", "SVO_NORMAL", "svo_k_filter"},
                {SVO_NEED_MATERIAL, "material", "materials", "SVO_MATERIAL", "svo_k_material_merge"},
                {SVO_NEED_FILL, "fill", "fills", "SVO_FILL", "svo_k_filter"}};
enum { PAYLOADS = sizeof payloads / sizeof payloads[0] };

static void assert_without_payload(const measured *less, const measured *full, const struct payload *which)
{
    assert_same_results(less, full);
    assert_only_less_leaves_out(less, full, which->name);
    assert_only_full_has_buffer(less, full, which->array);
    assert_only_full_has_define(less, full, which->define);
}

/* No payload compared with one. The fill needs less memory than the nodes needed before. */
static void compare_with_none(const measured *none, const measured *alone, const struct payload *which)
{
    const unsigned peak = which->bit != SVO_NEED_FILL ? FEWER_PEAK_BYTES : 0;
    assert_without_payload(none, alone, which);
    assert_takes_less(none, alone, FEWER_TREE_BYTES | FEWER_KERNELS | OTHER_DEFINES | peak);
    assert_only_full_has_kernel(none, alone, which->kernel);
    assert_only_full_has_buffer(none, alone, "records");
    assert_only_less_leaves_out(none, alone, "mesh attributes");
}

/* One payload compared with all, including lists. */
static void compare_with_all(const measured *alone, const measured *all, const struct payload *which)
{
    for (size_t i = 0; i < PAYLOADS; ++i) {
        if (&payloads[i] != which) {
            assert_without_payload(alone, all, &payloads[i]);
        }
    }
    assert_takes_less(alone, all, FEWER_PEAK_BYTES | FEWER_TREE_BYTES | FEWER_KERNELS | OTHER_DEFINES);
}

static void each_payload(void **state)
{
    (void)state;
    sheet_mesh sheet;
    measured none;
    measured all;
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    build_sheet(&sheet, SVO_NEED_NONE, &none);
    build_sheet(&sheet, SVO_NEED_ALL, &all);
    for (size_t i = 0; i < PAYLOADS; ++i) {
        measured alone;
        build_sheet(&sheet, (uint32_t)payloads[i].bit, &alone);
        compare_with_none(&none, &alone, &payloads[i]);
        compare_with_all(&alone, &all, &payloads[i]);
        measured_destroy(&alone);
    }
    measured_destroy(&all);
    measured_destroy(&none);
}

/* Projected areas alone sum up no levels. Beside a color of uniform weights they need clipping, and the color stays. */
static void projected_areas(void **state)
{
    (void)state;
    static const char *const buffers[] = {"heads", "areas", "records", "vertices", "vertex_remainders"};
    sheet_mesh sheet;
    measured less;
    measured full;
    svo_plan_options options = asking_for(SVO_NEED_PROJECTED_AREA);
    options.weights = SVO_WEIGHTS_UNIFORM;
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    build_sheet(&sheet, SVO_NEED_NONE, &less);
    measured_build(&sheet.mesh, DEPTH, &options, &full);
    assert_same_results(&less, &full);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | FEWER_TREE_BYTES | FEWER_KERNELS | OTHER_DEFINES);
    assert_only_less_leaves_out(&less, &full, "mesh attributes");
    assert_only_less_leaves_out(&less, &full, "projected area");
    assert_only_full_has_define(&less, &full, "SVO_AREAS");
    const bool lanes = fixture_has_pair_lanes(&full.opened);
    assert_only_full_has_kernel(&less, &full, lanes ? "svo_k_gather_level" : "svo_k_gather_pairs");
    assert_false(measured_has_kernel(&full, "svo_k_filter"));
    for (size_t i = lanes ? 0 : 1; i < sizeof buffers / sizeof buffers[0]; ++i) { /* single pairs have no heads */
        assert_only_full_has_buffer(&less, &full, buffers[i]);
    }
    assert_null(measured_buffer(&full, "weights"));
    measured_destroy(&full);
    measured_destroy(&less);
    options.need = SVO_NEED_COLOR;
    measured_build(&sheet.mesh, DEPTH, &options, &less);
    options.need |= SVO_NEED_PROJECTED_AREA;
    measured_build(&sheet.mesh, DEPTH, &options, &full);
    assert_same_results(&less, &full);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | FEWER_TREE_BYTES | FEWER_KERNELS | OTHER_DEFINES);
    assert_only_less_leaves_out(&less, &full, "clipping");
    assert_only_full_has_buffer(&less, &full, "areas");
    assert_only_full_has_buffer(&less, &full, "vertices");
    assert_only_full_has_kernel(&less, &full, "svo_k_round_areas");
    measured_destroy(&full);
    measured_destroy(&less);
}

static long file_bytes(const svo_tree *tree, const char *path)
{
    svo_message message = {""};
    if (svo_tree_save(tree, svo_to_path(path), NULL, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const long bytes = ftell(file);
    assert_int_equal(fclose(file), 0);
    return bytes;
}

#define CHUNK_ENTRY_BYTES 40

/* The file shrinks by as many bytes as the tree, and by the entries of the chunks below the first, and loads as a tree
   with the same hash. */
static void assert_file_is_smaller(const measured *less, const measured *full, size_t element_bytes)
{
    char path[64];
    svo_message message = {""};
    svo_tree *loaded = NULL;
    char hash[SVO_HASH_TEXT_BYTES];
    snprintf(path, sizeof path, "test_leave_out_%p.svo", (const void *)less);
    const long whole = file_bytes(full->result.tree, path);
    const long bytes = file_bytes(less->result.tree, path);
    assert_int_equal(whole - bytes, (less->result.info.node_count - 1) * element_bytes +
                                        (size_t)less->result.info.depth * CHUNK_ENTRY_BYTES);
    if (svo_tree_load(svo_from_path(path), NULL, &loaded, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    assert_int_equal(svo_tree_hash(loaded, SVO_HASH_ALL, hash), SVO_OK);
    assert_string_equal(hash, full->result.hash);
    svo_tree_destroy(&loaded);
    assert_int_equal(remove(path), 0);
}

/* A payload that is uniform in the scene; full has a speck that differs, with too little weight to change a node. */
static void assert_stored_once(const sheet_mesh *less_sheet, const sheet_mesh *full_sheet, svo_need bit,
                               svo_tree_buffer array, size_t element_bytes)
{
    measured less;
    measured full;
    char what[32];
    build_sheet(less_sheet, (uint32_t)bit, &less);
    build_sheet(full_sheet, (uint32_t)bit, &full);
    snprintf(what, sizeof what, "%s per node", svo_name(SVO_NAME_NEED, bit));
    assert_int_equal(less.result.info.constant, bit);
    assert_int_equal(less.result.plan.constant, bit);
    assert_int_equal(full.result.info.constant, 0);
    assert_same_results(&less, &full);
    assert_string_equal(less.result.hash, full.result.hash);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | FEWER_TREE_BYTES | FEWER_KERNELS | OTHER_DEFINES);
    assert_only_less_leaves_out(&less, &full, what);
    assert_int_equal(measured_array_bytes(&less, array), element_bytes);
    assert_int_equal(measured_array_bytes(&full, array), full.result.info.node_count * element_bytes);
    assert_int_equal(full.tree_bytes - less.tree_bytes, (full.result.info.node_count - 1) * element_bytes);
    assert_file_is_smaller(&less, &full, element_bytes);
    measured_destroy(&full);
    measured_destroy(&less);
}

static void one_color_is_stored_once(void **state)
{
    (void)state;
    sheet_mesh less;
    sheet_mesh full;
    sheet_make(SHEET_SPECK, 1.0, &less);
    memcpy(less.materials[1].rgba, white, sizeof white);
    sheet_make(SHEET_SPECK, 1.0, &full);
    memcpy(full.materials[1].rgba, white, sizeof white);
    sheet_set_color(&less, some_color, false);
    sheet_set_color(&full, some_color, true);
    assert_stored_once(&less, &full, SVO_NEED_COLOR, SVO_TREE_COLORS, 4);
}

static void one_normal_is_stored_once(void **state)
{
    (void)state;
    static const float normal[3] = {3.0F, -4.0F, 12.0F};
    sheet_mesh less;
    sheet_mesh full;
    sheet_make(SHEET_SPECK, 1.0, &less);
    sheet_make(SHEET_SPECK, 1.0, &full);
    sheet_set_normal(&less, normal, false);
    sheet_set_normal(&full, normal, true);
    assert_stored_once(&less, &full, SVO_NEED_NORMAL, SVO_TREE_NORMALS, 6);
}

static void one_material_is_stored_once(void **state)
{
    (void)state;
    sheet_mesh less;
    sheet_mesh full;
    sheet_make(SHEET_SPECK, 1.0, &less);
    sheet_make(SHEET_SPECK, 1.0, &full);
    sheet_set_material(&less, 1, false);
    sheet_set_material(&full, 1, true);
    assert_stored_once(&less, &full, SVO_NEED_MATERIAL, SVO_TREE_MATERIALS, 2);
}

/* Without leaves all payload is zero, stored as one element each. */
static void payload_of_an_empty_tree_is_stored_once(void **state)
{
    (void)state;
    sheet_mesh sheet;
    measured made;
    static const uint8_t zeros[8] = {0};
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    sheet.mesh.triangle_count = 0;
    build_sheet(&sheet, SVO_NEED_ALL & ~(uint32_t)SVO_NEED_FILL, &made);
    assert_int_equal(made.result.info.constant, SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_MATERIAL);
    assert_memory_equal(made.result.arrays.colors, zeros, 4);
    assert_memory_equal(made.result.arrays.normals, zeros, 6);
    assert_memory_equal(made.result.arrays.materials, zeros, 2);
    measured_destroy(&made);
}

/* Uniform vertex colors become part of the materials, which differ and may be textured. */
static void uniform_vertex_colors(void **state)
{
    (void)state;
    for (uint32_t textured = 0; textured < 2; ++textured) {
        sheet_mesh less_sheet;
        sheet_mesh full_sheet;
        measured less;
        measured full;
        sheet_make(SHEET_SPECK, 1.0, &less_sheet);
        sheet_make(SHEET_SPECK, 1.0, &full_sheet);
        sheet_set_color(&less_sheet, some_color, false);
        sheet_set_color(&full_sheet, some_color, true);
        less_sheet.materials[1].texture_index = textured != 0 ? 0 : SVO_NO_TEXTURE;
        full_sheet.materials[1].texture_index = less_sheet.materials[1].texture_index;
        build_sheet(&less_sheet, SVO_NEED_COLOR, &less);
        build_sheet(&full_sheet, SVO_NEED_COLOR, &full);
        assert_same_results(&less, &full);
        assert_int_equal(less.result.info.constant, 0);
        assert_takes_less(&less, &full, FEWER_PEAK_BYTES | SAME_PEAK_BYTES | OTHER_DEFINES);
        assert_only_less_leaves_out(&less, &full, "vertex colors");
        assert_only_full_has_buffer(&less, &full, "vertex_colors");
        assert_only_full_has_define(&less, &full, "SVO_VERTEX_COLOR");
        measured_destroy(&full);
        measured_destroy(&less);
    }
}

/* In a mesh without normals, triangles use their own. In the sheet these are equal, so one vertex is moved. */
static void missing_vertex_normals(void **state)
{
    (void)state;
    sheet_mesh sheet;
    measured less;
    measured full;
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    sheet.positions[2] += 0.001;
    build_sheet(&sheet, SVO_NEED_NORMAL, &full);
    sheet.mesh.normals = NULL;
    build_sheet(&sheet, SVO_NEED_NORMAL, &less);
    assert_string_equal(less.result.nodes_hash, full.result.nodes_hash);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | SAME_PEAK_BYTES | OTHER_DEFINES);
    assert_only_less_leaves_out(&less, &full, "vertex normals");
    assert_only_full_has_buffer(&less, &full, "vertex_normals");
    assert_only_full_has_define(&less, &full, "SVO_VERTEX_NORMAL");
    measured_destroy(&full);
    measured_destroy(&less);
}

/* The mesh has a texture, and the only triangle that uses it is refused, or is a speck. */
static void textures_without_accepted_triangles(void **state)
{
    (void)state;
    sheet_mesh less_sheet;
    sheet_mesh full_sheet;
    measured less;
    measured full;
    sheet_make(SHEET_REFUSED, 1.0, &less_sheet);
    sheet_make(SHEET_SPECK, 1.0, &full_sheet);
    sheet_set_material(&less_sheet, 0, true);
    sheet_set_material(&full_sheet, 0, true);
    full_sheet.materials[1] = (svo_material){{255, 255, 255, 255}, 1};
    less_sheet.materials[1] = full_sheet.materials[1];
    build_sheet(&less_sheet, SVO_NEED_COLOR, &less);
    build_sheet(&full_sheet, SVO_NEED_COLOR, &full);
    assert_same_results(&less, &full);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | OTHER_DEFINES);
    assert_only_less_leaves_out(&less, &full, "textures");
    assert_only_less_leaves_out(&less, &full, "texture coordinates");
    assert_only_full_has_buffer(&less, &full, "texels");
    assert_only_full_has_buffer(&less, &full, "uvs");
    assert_only_full_has_define(&less, &full, "SVO_TEXTURE");
    measured_destroy(&full);
    measured_destroy(&less);
}

/* Of two textures, the small one is used by the whole sheet, the large one by a speck or by nothing. */
static void unused_textures_beside_a_used_one(void **state)
{
    (void)state;
    sheet_mesh less_sheet;
    sheet_mesh full_sheet;
    measured less;
    measured full;
    sheet_make(SHEET_ALONE, 1.0, &less_sheet);
    sheet_make(SHEET_SPECK, 1.0, &full_sheet);
    less_sheet.materials[0].texture_index = 0;
    less_sheet.materials[1] = (svo_material){{255, 255, 255, 255}, 1};
    memcpy(full_sheet.materials, less_sheet.materials, sizeof full_sheet.materials);
    sheet_set_material(&less_sheet, 0, false);
    sheet_set_material(&full_sheet, 0, true);
    build_sheet(&less_sheet, SVO_NEED_COLOR, &less);
    build_sheet(&full_sheet, SVO_NEED_COLOR, &full);
    assert_same_results(&less, &full);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES);
    assert_only_less_leaves_out(&less, &full, "unused textures");
    assert_int_equal(measured_buffer(&less, "texels")->bytes, SHEET_SMALL_TEXELS * 4);
    assert_int_equal(measured_buffer(&full, "texels")->bytes, (SHEET_SMALL_TEXELS + SHEET_LARGE_TEXELS) * 4);
    assert_null(measured_left_out(&less, "textures"));
    assert_null(measured_left_out(&less, "texture coordinates"));
    measured_destroy(&full);
    measured_destroy(&less);
}

/* Uniform weights do not depend on where in its voxel a triangle lies: the result equals the reference. */
static void clipping_with_uniform_weights(void **state)
{
    (void)state;
    sheet_mesh sheet;
    measured less;
    measured full;
    exact expected;
    svo_plan_options options = asking_for(SVO_NEED_COLOR);
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    measured_build(&sheet.mesh, DEPTH, &options, &full);
    options.weights = SVO_WEIGHTS_UNIFORM;
    measured_build(&sheet.mesh, DEPTH, &options, &less);
    exact_create(&sheet.mesh, DEPTH, &options, &expected);
    assert_tree_is_exact(&less.result, &expected);
    assert_payload_is_exact(&sheet.mesh, &expected, &less.result);
    exact_destroy(&expected);
    assert_string_equal(less.result.nodes_hash, full.result.nodes_hash);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | OTHER_DEFINES);
    assert_only_less_leaves_out(&less, &full, "clipping");
    assert_only_full_has_buffer(&less, &full, "vertices");
    assert_only_full_has_define(&less, &full, "SVO_WEIGHTS_AREA");
    measured_destroy(&full);
    measured_destroy(&less);
}

/* Squares inside one voxel each, with and without a triangle across two of those voxels. */
static void overlap_test_of_small_triangles(void **state)
{
    (void)state;
    const svo_plan_options options = asking_for(SVO_NEED_NONE);
    sheet_mesh sheet;
    measured less;
    measured full;
    sheet_make(SHEET_ALONE, 0.5, &sheet);
    measured_build(&sheet.mesh, 7, &options, &less);
    sheet_make(SHEET_BRIDGE, 0.5, &sheet);
    measured_build(&sheet.mesh, 7, &options, &full);
    assert_string_equal(less.result.nodes_hash, full.result.nodes_hash);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | OTHER_DEFINES);
    assert_only_full_has_define(&full, &less, "SVO_NO_TEST");
    assert_only_full_has_define(&less, &full, "SVO_NARROW");
    assert_false(measured_has_define(&less, "SVO_WIDE"));
    assert_non_null(measured_left_out(&less, "overlap test"));
    assert_non_null(measured_left_out(&full, "overlap test")); /* for the squares */
    assert_int_equal(less.programs, 2);
    measured_destroy(&full);
    measured_destroy(&less);
}

/* A large triangle needs 64-bit line equations; one that reaches outside the grid needs 128-bit products. */
static void the_wider_overlap_tests(void **state)
{
    (void)state;
    static const struct {
        sheet_extra extra;
        const char *what;
    } wider[] = {{SHEET_LARGE, "64-bit overlap test"}, {SHEET_OUTSIDE, "128-bit products"}};
    const svo_plan_options options = asking_for(SVO_NEED_NONE);
    const unsigned depth = 11; /* where the large triangle is wider than SVO_NARROW_VOXELS */
    sheet_mesh sheet;
    measured less;
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    measured_build(&sheet.mesh, depth, &options, &less);
    assert_true(measured_has_define(&less, "SVO_NARROW"));
    assert_null(measured_left_out(&less, "overlap test"));
    assert_int_equal(less.programs, 3);
    for (size_t i = 0; i < 2; ++i) {
        measured full;
        sheet_make(wider[i].extra, 1.0, &sheet);
        measured_build(&sheet.mesh, depth, &options, &full);
        assert_string_equal(less.result.nodes_hash, full.result.nodes_hash);
        assert_takes_less(&less, &full, FEWER_PROGRAMS | FEWER_KERNELS | FEWER_PEAK_BYTES);
        assert_only_less_leaves_out(&less, &full, wider[i].what);
        assert_int_equal(measured_has_define(&full, "SVO_WIDE"), wider[i].extra == SHEET_OUTSIDE);
        assert_false(measured_has_define(&less, "SVO_WIDE"));
        measured_destroy(&full);
    }
    measured_destroy(&less);
}

/* Up to depth 10 a Morton code has 32 bits and a fragment 8 bytes instead of 12. The nodes of depth 10 are the upper
   nodes of depth 11. */
static void long_morton_codes(void **state)
{
    (void)state;
    svo_plan_options options = asking_for(SVO_NEED_NONE);
    options.fragment_capacity = 200000;
    sheet_mesh sheet;
    measured less;
    measured full;
    sheet_make(SHEET_ALONE, 1.0, &sheet);
    measured_build(&sheet.mesh, 10, &options, &less);
    measured_build(&sheet.mesh, 11, &options, &full);
    const svo_tree_info *info = &less.result.info;
    assert_memory_equal(info->level_begin, full.result.info.level_begin, 12 * sizeof(uint32_t));
    assert_memory_equal(less.result.arrays.child_mask, full.result.arrays.child_mask, info->inner_count);
    assert_memory_equal(less.result.arrays.first_child, full.result.arrays.first_child, info->inner_count * 4);
    assert_takes_less(&less, &full, FEWER_PEAK_BYTES | FEWER_TREE_BYTES | OTHER_DEFINES);
    assert_only_less_leaves_out(&less, &full, "64-bit Morton codes");
    assert_only_full_has_define(&less, &full, "SVO_CODE48");
    assert_int_equal(measured_buffer(&less, "fragments")->bytes, 8 * options.fragment_capacity);
    assert_int_equal(measured_buffer(&full, "fragments")->bytes, 12 * options.fragment_capacity);
    measured_destroy(&full);
    measured_destroy(&less);
}

/* Properties of a plan that is not built. */
typedef struct planned {
    bool is_wide; /* has the define SVO_WIDE */
    bool leaves_out_wide;
    bool leaves_out_opengl;
    size_t left_out_count;
} planned;

static planned plan_sheet(const sheet_mesh *sheet, unsigned depth, uint32_t need)
{
    const svo_plan_options options = asking_for(need);
    fixture opened;
    svo_plan *plan = NULL;
    planned seen = {.left_out_count = 0};
    fixture_open_cl(&(fixture_options){0}, &opened);
    assert_int_equal(svo_plan_create(opened.device, &sheet->mesh, depth, &options, &plan), SVO_OK);
    for (size_t i = 0; i < info_of_plan(plan).kernels_count; ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        svo_plan_get_kernels(plan, i, &kernels);
        seen.is_wide = seen.is_wide || strstr(kernels.defines, "SVO_WIDE") != NULL;
    }
    seen.left_out_count = info_of_plan(plan).left_out_count;
    for (size_t i = 0; i < seen.left_out_count; ++i) {
        svo_left_out entry = SVO_LEFT_OUT_INIT;
        svo_plan_get_left_out(plan, i, &entry);
        seen.leaves_out_wide = seen.leaves_out_wide || strcmp(entry.what, "128-bit products") == 0;
        seen.leaves_out_opengl = seen.leaves_out_opengl || strcmp(entry.what, "OpenGL") == 0;
    }
    svo_plan_destroy(&plan);
    fixture_close(&opened);
    return seen;
}

/* On grids finer than 2^20 units, a wide triangle needs 128-bit products at any position; a narrow one does not. */
static void products_of_128_bits_above_depth_12(void **state)
{
    (void)state;
    static const struct {
        sheet_extra extra;
        unsigned depth;
        bool needs_them;
    } cases[] = {{SHEET_ALONE, 12, false},   {SHEET_LARGE, 12, false}, {SHEET_OUTSIDE, 12, true},
                 {SHEET_ALONE, 13, false},   {SHEET_LARGE, 13, true},  {SHEET_OUTSIDE, 13, true},
                 {SHEET_REFUSED, 16, false}, {SHEET_LARGE, 16, true}};
    sheet_mesh sheet;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        sheet_make(cases[i].extra, cases[i].depth > 12 ? 0.0625 : 1.0, &sheet);
        const planned seen = plan_sheet(&sheet, cases[i].depth, SVO_NEED_NONE);
        if (seen.is_wide != cases[i].needs_them || seen.leaves_out_wide == cases[i].needs_them) {
            fail_msg("case %zu: the define is %spresent, and the products are %sleft out", i,
                     seen.is_wide ? "" : "not ", seen.leaves_out_wide ? "" : "not ");
        }
    }
}

/* A scene and a request that need everything: the plan leaves out nothing except OpenGL. */
static void nothing_that_is_needed(void **state)
{
    (void)state;
    sheet_mesh sheet;
    sheet_make(SHEET_OUTSIDE, 1.0, &sheet);
    sheet.materials[0].texture_index = 0;
    sheet.materials[1].texture_index = 1;
    const planned seen = plan_sheet(&sheet, 11, SVO_NEED_ALL);
    assert_true(seen.leaves_out_opengl);
    assert_int_equal(seen.left_out_count, 1);
}

/* From a level on, payload equals that of a tree with the payload of all levels. */
static void assert_has_rest_of_payload(const built *less, const built *full)
{
    const struct {
        const void *of_less, *of_full;
        size_t bytes;
    } arrays[] = {{less->arrays.colors, full->arrays.colors, 4},
                  {less->arrays.normals, full->arrays.normals, 6},
                  {less->arrays.materials, full->arrays.materials, 2},
                  {less->arrays.fills, full->arrays.fills, 2}};
    const size_t skipped = full->info.level_begin[less->info.payload_level];
    const size_t count = (size_t)full->info.node_count - skipped;
    assert_string_equal(less->nodes_hash, full->nodes_hash);
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i) {
        assert_memory_equal(arrays[i].of_less, (const char *)arrays[i].of_full + skipped * arrays[i].bytes,
                            count * arrays[i].bytes);
    }
}

/* With both builders, and with a list in chunks. */
static void unrequested_levels_of_payload(void **state)
{
    (void)state;
    static const uint32_t levels[] = {1, 4, DEPTH - 1, DEPTH};
    struct scene *made = fixture_scene("knot:3000");
    for (int method = 0; method < 3; ++method) {
        svo_plan_options options = asking_for(SVO_NEED_ALL & ~(uint32_t)SVO_NEED_RAYS);
        options.edge = 0.0;
        options.builder = method == 1 ? SVO_BUILDER_SORTED : SVO_BUILDER_CL;
        options.chunk_bytes = method == 2 ? 65536 : 0;
        measured full;
        options.payload_level = 0;
        measured_build(scene_mesh(made), DEPTH, &options, &full);
        for (size_t i = 0; i < sizeof levels / sizeof levels[0]; ++i) {
            measured less;
            options.payload_level = levels[i];
            measured_build(scene_mesh(made), DEPTH, &options, &less);
            assert_int_equal(less.result.info.payload_level, levels[i]);
            assert_has_rest_of_payload(&less.result, &full.result);
            assert_takes_less(&less, &full, levels[i] > 1 ? FEWER_TREE_BYTES : 0);
            assert_only_less_leaves_out(&less, &full, "filtered levels");
            measured_destroy(&less);
        }
        measured_destroy(&full);
    }
    scene_destroy(&made);
}

/* Such trees can be saved and loaded, but not rendered. */
static void levels_without_payload_in_files(void **state)
{
    (void)state;
    static const char path[] = "levels_without_payload.svo";
    svo_plan_options options = asking_for(SVO_NEED_COLOR);
    struct scene *made = fixture_scene("knot:300");
    svo_message message = {""};
    svo_tree *loaded = NULL;
    measured less;
    options.edge = 0.0;
    options.payload_level = 5;
    measured_build(scene_mesh(made), DEPTH, &options, &less);
    assert_int_equal(svo_tree_save(less.result.tree, svo_to_path(path), NULL, &message), SVO_OK);
    assert_int_equal(svo_tree_load(svo_from_path(path), NULL, &loaded, &message), SVO_OK);
    (void)remove(path);
    char hash[SVO_HASH_TEXT_BYTES];
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_get_info(loaded, &info);
    assert_int_equal(info.payload_level, 5);
    assert_int_equal(svo_tree_hash(loaded, SVO_HASH_ALL, hash), SVO_OK);
    assert_string_equal(hash, less.result.hash);
    uint8_t pixels[4];
    const svo_render_options picture = {
        .struct_size = sizeof picture, .width = 1, .height = 1, .camera = {.eye = {9, 9, 9}, .up = {0, 0, 1}}};
    assert_int_equal(svo_render(svo_tree_target(less.result.tree), &picture, svo_in_host(pixels),
                                &(svo_submit){.queue = less.opened.queue}),
                     SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&loaded);
    measured_destroy(&less);
    scene_destroy(&made);
}

/* On a device that has built trees, another payload compiles the filter's kernels alone, another build of the same
   needs none. Without the warm-up, scans of a small tree launch about as many work-items as it has fragments and
   nodes. */
static void kernels_and_launches_that_a_build_does_not_need(void **state)
{
    (void)state;
    static const uint32_t needs[] = {SVO_NEED_COLOR, SVO_NEED_COLOR | SVO_NEED_NORMAL, SVO_NEED_COLOR};
    static const uint64_t programs[] = {4, 1, 0};
    struct scene *made = fixture_scene("knot:300");
    fixture opened;
    fixture_open_cl(&(fixture_options){0}, &opened);
    const uint64_t lists = fixture_has_pair_lanes(&opened) ? 0 : 1; /* single pairs are gathered from sorted lists */
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        const svo_plan_options options = {.need = needs[i]};
        built actual;
        counting_begin();
        fixture_build(&opened, scene_mesh(made), 4, &options, &actual);
        assert_int_equal(counting_read().builds, programs[i] + (i == 0 ? lists : 0));
        if (i == 1) {
            assert_non_null(strstr(counting_options(0), "SVO_NORMAL"));
            assert_null(strstr(counting_kernels(0), "svo_k_make_nodes"));
        }
        if (i == 2) { /* 256 groups per scan were 131,072 items for the four levels */
            assert_in_range(counting_read().launched_items, 1, 40000);
        }
        built_destroy(&actual);
    }
    fixture_close(&opened);
    scene_destroy(&made);
}

TEST_GROUP(leave_out)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_and_launches_that_a_build_does_not_need),
        cmocka_unit_test(stages_that_do_not_run),
        cmocka_unit_test(lists_and_their_packing),
        cmocka_unit_test(the_packing_copy_of_sorted_lists),
        cmocka_unit_test(each_payload),
        cmocka_unit_test(projected_areas),
        cmocka_unit_test(one_color_is_stored_once),
        cmocka_unit_test(one_normal_is_stored_once),
        cmocka_unit_test(one_material_is_stored_once),
        cmocka_unit_test(payload_of_an_empty_tree_is_stored_once),
        cmocka_unit_test(uniform_vertex_colors),
        cmocka_unit_test(missing_vertex_normals),
        cmocka_unit_test(textures_without_accepted_triangles),
        cmocka_unit_test(unused_textures_beside_a_used_one),
        cmocka_unit_test(clipping_with_uniform_weights),
        cmocka_unit_test(overlap_test_of_small_triangles),
        cmocka_unit_test(the_wider_overlap_tests),
        cmocka_unit_test(long_morton_codes),
        cmocka_unit_test(products_of_128_bits_above_depth_12),
        cmocka_unit_test(unrequested_levels_of_payload),
        cmocka_unit_test(levels_without_payload_in_files),
        cmocka_unit_test(nothing_that_is_needed),
    };
    return cmocka_run_group_tests_name("leave_out", tests, NULL, NULL);
}
