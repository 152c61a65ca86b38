/* SPDX-License-Identifier: MIT */
/*
 * What a solid carries and where it goes: color and material of the interior, rays, files; and the trees and arguments
 * that are refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/tree.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/solid_meshes.h"
#include "support/suite.h"
#include "svocl/io.h"

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

/* A grid from 0, 0, 0 on of voxels one unit wide. */
static svo_plan_options unit_grid(unsigned depth, svo_coverage coverage)
{
    return (svo_plan_options){.need = SVO_NEED_RAYS, .coverage = coverage, .edge = (double)(1u << depth)};
}

/* ---- what a solid carries ---- */

/* A cube of one material in a mesh of two, colored. */
static void build_painted(const fixture *opened, uint32_t need, uint32_t payload_level, built *out)
{
    static const svo_material materials[] = {{{10, 20, 30, 255}, SVO_NO_TEXTURE}, {{200, 0, 0, 255}, SVO_NO_TEXTURE}};
    uint16_t triangle_materials[12];
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 2.5, 13.5, false, -1);
    svo_mesh mesh = parts_mesh(&made);
    for (size_t t = 0; t < 12; ++t) {
        triangle_materials[t] = (uint16_t)(t % 2);
    }
    mesh.materials = materials;
    mesh.material_count = 2;
    mesh.triangle_materials = triangle_materials;
    svo_plan_options plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    plan.need |= need;
    plan.payload_level = payload_level;
    fixture_build(opened, &mesh, 4, &plan, out);
    parts_free(&made);
}

/* The leaf of a voxel in an expanded tree, or UINT32_MAX. */
static uint32_t leaf_at(const svo_tree *tree, uint32_t x, uint32_t y, uint32_t z)
{
    const uint32_t cell[3] = {x, y, z};
    svo_node node;
    return svo_tree_find_cell(tree, 4, cell, &node) == SVO_OK && node.level == 4 ? node.index : UINT32_MAX;
}

static void interior_has_the_stated_color_and_material(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const uint32_t need =
        (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL;
    const svo_solid_options options = {.struct_size = sizeof options, .color = {1, 2, 3, 4}, .material = 7};
    svo_compact *solid = NULL;
    svo_tree *full = NULL;
    svo_tree_arrays arrays = SVO_TREE_ARRAYS_INIT;
    built tree;
    build_painted(&opened, need, 0, &tree);
    succeed(&opened, svo_solid_create(tree.tree, &options, opened.queue, &solid, NULL));
    succeed(&opened, svo_compact_expand(solid, opened.queue, &full));
    succeed(&opened, svo_tree_download(full, opened.queue));
    assert_int_equal(svo_tree_get_arrays(full, &arrays), SVO_OK);
    for (uint32_t i = 0; i < 16 * 16 * 16; ++i) {
        const uint32_t at[3] = {i % 16, i / 16 % 16, i / 256};
        bool inside = true;
        bool held = true;
        for (int axis = 0; axis < 3; ++axis) {
            inside = inside && at[axis] > 2 && at[axis] < 13;
            held = held && at[axis] >= 2 && at[axis] <= 13;
        }
        const uint32_t leaf = leaf_at(full, at[0], at[1], at[2]);
        const uint32_t surface = leaf_at(tree.tree, at[0], at[1], at[2]);
        assert_int_equal(leaf != UINT32_MAX, held);
        assert_int_equal(surface != UINT32_MAX, held && !inside);
        if (inside) {
            const int16_t zero[3] = {0, 0, 0};
            assert_memory_equal(arrays.colors + leaf * 4, options.color, 4);
            assert_int_equal(arrays.materials[leaf], 7);
            assert_memory_equal(arrays.normals + leaf * 3, zero, sizeof zero);
            assert_int_equal(arrays.fills[leaf], 0);
        } else if (held) {
            assert_memory_equal(arrays.colors + leaf * 4, tree.arrays.colors + surface * 4, 4);
            assert_int_equal(arrays.materials[leaf], tree.arrays.materials[surface]);
            assert_memory_equal(arrays.normals + leaf * 3, tree.arrays.normals + surface * 3, 6);
            assert_int_equal(arrays.fills[leaf], tree.arrays.fills[surface]);
        }
    }
    assert_memory_equal(arrays.colors, tree.arrays.colors, 4); /* the root's stays that of the surface */
    svo_tree_destroy(&full);
    svo_compact_destroy(&solid);
    built_destroy(&tree);
}

/* White cubes: payload that is the same everywhere stays one element if the interior is white too. */
static void constant_payload_stays_constant_if_it_can(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_solid_options options = SVO_SOLID_OPTIONS_INIT;
    svo_plan_options plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    parts made = {.vertex_count = 0};
    built tree;
    plan.need |= (uint32_t)SVO_NEED_COLOR;
    parts_add_cube(&made, 2.5, 13.5, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    fixture_build(&opened, &mesh, 4, &plan, &tree);
    assert_int_equal(tree.info.constant, SVO_NEED_COLOR);
    for (int white = 0; white < 2; ++white) {
        svo_compact_info info = SVO_COMPACT_INFO_INIT;
        svo_compact *solid = NULL;
        options.color[0] = options.color[1] = options.color[2] = options.color[3] = white != 0 ? 0 : 9;
        succeed(&opened, svo_solid_create(tree.tree, &options, opened.queue, &solid, NULL));
        assert_int_equal(svo_compact_get_info(solid, &info), SVO_OK);
        assert_int_equal(info.need, SVO_NEED_COLOR);
        assert_int_equal(info.constant, white != 0 ? SVO_NEED_COLOR : 0);
        assert_int_equal(info.bytes[SVO_COMPACT_COLORS], 4 * (white != 0 ? 1 : info.inner_count + info.leaf_count));
        svo_compact_destroy(&solid);
    }
    built_destroy(&tree);
    parts_free(&made);
}

/* Rays see a solid as they see all of its voxels; files keep it. */
static void solids_are_traced_and_saved(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const char path[] = "test_solid.tmp";
    const svo_solid_options options = {.struct_size = sizeof options, .color = {1, 2, 3, 4}, .material = 1};
    enum { RAYS = 400 };
    svo_ray rays[RAYS];
    svo_voxel_hit hits[RAYS];
    svo_voxel_hit full_hits[RAYS];
    uint64_t seed = 9;
    svo_compact *solid = NULL;
    svo_compact *loaded = NULL;
    svo_compact *flat = NULL;
    svo_tree *full = NULL;
    svo_message message = {""};
    char hashes[2][SVO_HASH_TEXT_BYTES];
    unsigned inside = 0;
    built tree;
    build_painted(&opened, SVO_NEED_COLOR, 0, &tree);
    succeed(&opened, svo_solid_create(tree.tree, &options, opened.queue, &solid, NULL));
    succeed(&opened, svo_compact_expand(solid, opened.queue, &full));
    succeed(&opened, svo_compact_create(opened.device, full, NULL, opened.queue, &flat));
    for (int i = 0; i < RAYS; ++i) {
        rays[i] = (svo_ray){.t_max = 100.0F};
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = (float)(random_unit(&seed) * 16.0);
            rays[i].direction[axis] = (float)(random_unit(&seed) - 0.5);
        }
    }
    succeed(&opened, svo_trace_voxels(svo_compact_target(solid), svo_in_host(rays), svo_in_host(hits), RAYS, 0.0F, 0,
                                      &(svo_submit){.queue = opened.queue}));
    succeed(&opened, svo_trace_voxels(svo_compact_target(flat), svo_in_host(rays), svo_in_host(full_hits), RAYS, 0.0F,
                                      0, &(svo_submit){.queue = opened.queue}));
    for (int i = 0; i < RAYS; ++i) {
        assert_int_equal(hits[i].node == SVO_NO_NODE, full_hits[i].node == SVO_NO_NODE);
        assert_true(hits[i].node == SVO_NO_NODE || hits[i].t == full_hits[i].t);
        inside += hits[i].node != SVO_NO_NODE && hits[i].level < 4 ? 1 : 0;
    }
    assert_true(inside > 10);
    succeed(&opened, svo_compact_download(solid, opened.queue));
    succeed(&opened, svo_compact_hash(solid, hashes[0]));
    if (svo_compact_save(solid, svo_to_path(path), NULL, &message) != SVO_OK ||
        svo_compact_load(svo_from_path(path), NULL, &loaded, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    (void)remove(path);
    assert_int_equal(svo_compact_hash(loaded, hashes[1]), SVO_OK);
    assert_string_equal(hashes[0], hashes[1]);
    svo_tree_destroy(&full);
    svo_compact_destroy(&loaded);
    svo_compact_destroy(&flat);
    svo_compact_destroy(&solid);
    built_destroy(&tree);
}

/* A tree from a file has all that is needed, once it is on a device. */
static void trees_from_files_are_filled(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const char path[] = "test_solid_tree.tmp";
    svo_message message = {""};
    svo_compact *solids[2] = {NULL, NULL};
    char hashes[2][SVO_HASH_TEXT_BYTES];
    svo_tree *loaded = NULL;
    built tree;
    build_painted(&opened, SVO_NEED_COLOR, 0, &tree);
    if (svo_tree_save(tree.tree, svo_to_path(path), NULL, &message) != SVO_OK ||
        svo_tree_load(svo_from_path(path), NULL, &loaded, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    (void)remove(path);
    assert_int_equal(svo_solid_create(loaded, NULL, NULL, &solids[1], NULL), SVO_NOT_ON_DEVICE);
    succeed(&opened, svo_tree_upload(loaded, opened.device, opened.queue));
    succeed(&opened, svo_solid_create(tree.tree, NULL, opened.queue, &solids[0], NULL));
    succeed(&opened, svo_solid_create(loaded, NULL, opened.queue, &solids[1], NULL));
    for (int i = 0; i < 2; ++i) {
        succeed(&opened, svo_compact_download(solids[i], opened.queue));
        succeed(&opened, svo_compact_hash(solids[i], hashes[i]));
        svo_compact_destroy(&solids[i]);
    }
    assert_string_equal(hashes[0], hashes[1]);
    svo_tree_destroy(&loaded);
    built_destroy(&tree);
}

/* ---- refusals ---- */

static void refuse(const fixture *opened, svo_tree *tree, const svo_solid_options *options, const char *message)
{
    svo_compact *solid = NULL;
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    assert_int_equal(svo_solid_create(tree, options, opened->queue, &solid, &info), SVO_INVALID_ARGUMENT);
    assert_null(solid);
    assert_int_equal(info.surface_voxels, 0);
    if (strstr(svo_device_message(opened->device), message) == NULL) {
        fail_msg("'%s' does not say '%s'", svo_device_message(opened->device), message);
    }
}

static void refuse_build(const fixture *opened, const svo_mesh *mesh, svo_plan_options plan, const char *message)
{
    built tree;
    fixture_build(opened, mesh, 4, &plan, &tree);
    refuse(opened, tree.tree, NULL, message);
    built_destroy(&tree);
}

static void trees_that_do_not_say_what_is_inside_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    parts made = {.vertex_count = 0};
    parts_add_cube(&made, 2.5, 13.5, false, -1);
    const svo_mesh mesh = parts_mesh(&made);
    svo_plan_options plan = unit_grid(4, SVO_COVERAGE_THIN);
    refuse_build(&opened, &mesh, plan, "coverage is thin");
    plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    plan.need = SVO_NEED_COLOR;
    refuse_build(&opened, &mesh, plan, "holds no leaf lists");
    plan.need = (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_COLOR;
    plan.payload_level = 2;
    refuse_build(&opened, &mesh, plan, "payload does not begin at level 0");
    plan = unit_grid(4, SVO_COVERAGE_HALF_OPEN);
    plan.origin[2] = 5;
    refuse_build(&opened, &mesh, plan, "2 triangles lie outside the tree's grid");
    plan.origin[2] = -3;
    refuse_build(&opened, &mesh, plan, "2 triangles lie outside the tree's grid");
    const double lean[4][3] = {{3, 3, 3}, {6, 3, 3}, {3, 6, 3}, {4, 4, 40}};
    parts beyond = {.vertex_count = 0};
    parts_add_tetrahedron(&beyond, lean);
    const svo_mesh reaches = parts_mesh(&beyond);
    refuse_build(&opened, &reaches, unit_grid(4, SVO_COVERAGE_HALF_OPEN), "3 triangles reach outside the tree's grid");
    parts_free(&beyond);
    parts_free(&made);
}

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_solid_options options = SVO_SOLID_OPTIONS_INIT;
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    svo_compact *solid = NULL;
    built tree;
    build_painted(&opened, 0, 0, &tree);
    assert_int_equal(svo_solid_create(NULL, NULL, NULL, &solid, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_solid_create(tree.tree, NULL, NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    options.rule = (svo_solid_rule)3;
    refuse(&opened, tree.tree, &options, "svo_solid_create: options.rule 3 is not in 0 .. 2");
    options = (svo_solid_options){.struct_size = sizeof options, .material = 65535};
    refuse(&opened, tree.tree, &options, "svo_solid_create: options.material 65535 is above 65534");
    options = (svo_solid_options){.struct_size = 3};
    refuse(&opened, tree.tree, &options, "struct_size");
    info.struct_size = 8;
    assert_int_equal(svo_solid_create(tree.tree, NULL, NULL, &solid, &info), SVO_INVALID_ARGUMENT);
    assert_null(solid);
    fixture other;
    fixture_open_cl(&(fixture_options){.share = SVO_GL_SHARE_AUTO}, &other);
    assert_int_equal(svo_solid_create(tree.tree, NULL, other.queue, &solid, NULL), SVO_INVALID_ARGUMENT);
    assert_null(solid);
    fixture_close(&other);
    const uint64_t inner_count = tree.tree->info.inner_count;
    tree.tree->info.inner_count = UINT64_C(0x80000000);
    assert_int_equal(svo_solid_create(tree.tree, NULL, opened.queue, &solid, NULL), SVO_UNSUPPORTED);
    assert_non_null(strstr(svo_device_message(opened.device), "2147483648 inner nodes are above 2147483647"));
    assert_null(solid);
    tree.tree->info.inner_count = inner_count;
    assert_string_equal(svo_name(SVO_NAME_SOLID_RULE, SVO_SOLID_WINDING), "winding");
    assert_string_equal(svo_name(SVO_NAME_SOLID_RULE, SVO_SOLID_PARITY), "parity");
    assert_string_equal(svo_name(SVO_NAME_SOLID_RULE, SVO_SOLID_GENERALIZED), "generalized");
    assert_string_equal(svo_name(SVO_NAME_SOLID_RULE, (svo_solid_rule)7), "unknown rule");
    built_destroy(&tree);
}

TEST_GROUP(solid_use)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interior_has_the_stated_color_and_material),
        cmocka_unit_test(constant_payload_stays_constant_if_it_can),
        cmocka_unit_test(solids_are_traced_and_saved),
        cmocka_unit_test(trees_from_files_are_filled),
        cmocka_unit_test(trees_that_do_not_say_what_is_inside_are_refused),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests_name("solid_use", tests, fixture_group_setup, fixture_group_teardown);
}
