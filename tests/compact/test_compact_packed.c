/* SPDX-License-Identifier: MIT */
/*
 * Compact trees with packed payload: they expand to the tree that they were made of, kernels draw its pictures and
 * those of scenes without unpacking it, and wrong calls are refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "support/fixture.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "voxel_mesh.h"

#define PAYLOAD \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL)

static void succeed(const fixture *opened, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened->device));
    }
}

/* A surface whose colors are noise on shades; alpha as asked for. */
static void build_surface(const fixture *opened, unsigned depth, bool is_clear, built *out)
{
    const uint32_t edge = 1u << depth;
    voxel *voxels = calloc((size_t)edge * edge, sizeof *voxels);
    uint64_t seed = 9;
    voxel_mesh made;
    assert_non_null(voxels);
    for (uint32_t i = 0; i < edge * edge; ++i) {
        voxel *one = &voxels[i];
        const uint32_t x = i % edge;
        const uint32_t y = i / edge;
        one->cell[0] = x;
        one->cell[1] = y;
        one->cell[2] = (x + 2 * y) % edge / 3 + edge / 3;
        one->normal[2] = 1.0F;
        one->normal[x / 8 % 2] = 0.3F;
        for (unsigned channel = 0; channel < 3; ++channel) {
            one->rgba[channel] = (uint8_t)(40 + x * 3 % 90 + 20 * channel + random_below(&seed, 12));
        }
        one->rgba[3] = is_clear ? (uint8_t)(y / 4 * 16) : 255;
        one->material = (uint16_t)(x / 8 % VOXEL_MATERIALS);
        one->width = 0.5;
    }
    voxel_mesh_make(voxels, (size_t)edge * edge, depth, &made);
    made.options.need = PAYLOAD;
    fixture_build(opened, &made.mesh, depth, &made.options, out);
    voxel_mesh_free(&made);
    free(voxels);
}

static svo_compact *make(const fixture *opened, const svo_tree *tree, svo_form form)
{
    const svo_compact_options options = {.struct_size = sizeof options, .form = form};
    svo_compact *made = NULL;
    succeed(opened, svo_compact_create(opened->device, tree, &options, opened->queue, &made));
    return made;
}

/* With packed payload in place of the other. */
static void pack(const fixture *opened, svo_compact **compact, const svo_pack_options *options)
{
    svo_compact *packed = NULL;
    succeed(opened, svo_compact_pack(*compact, options, opened->queue, &packed));
    svo_compact_destroy(compact);
    *compact = packed;
}

static svo_compact_info describe(const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    assert_int_equal(svo_compact_get_info(compact, &info), SVO_OK);
    return info;
}

static void hash_expanded(const fixture *opened, svo_compact *compact, char text[SVO_HASH_TEXT_BYTES])
{
    svo_tree *tree = NULL;
    succeed(opened, svo_compact_expand(compact, opened->queue, &tree));
    succeed(opened, svo_tree_download(tree, opened->queue));
    assert_int_equal(svo_tree_hash(tree, SVO_HASH_ALL, text), SVO_OK);
    svo_tree_destroy(&tree);
}

/* Packed on the device alone, with host arrays too, and of those alone: the same arrays, and the same tree. */
static void packed_trees_expand_to_the_same_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    built tree;
    build_surface(&opened, 6, true, &tree);
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        char expected[SVO_HASH_TEXT_BYTES];
        char got[SVO_HASH_TEXT_BYTES];
        char hashes[2][SVO_HASH_TEXT_BYTES];
        svo_compact *plain = make(&opened, tree.tree, (svo_form)form);
        hash_expanded(&opened, plain, expected);
        const svo_compact_info before = describe(plain);
        for (int turn = 0; turn < 2; ++turn) {
            svo_compact *packed = make(&opened, tree.tree, (svo_form)form);
            if (turn == 1) {
                succeed(&opened, svo_compact_download(packed, opened.queue));
            }
            pack(&opened, &packed, NULL);
            pack(&opened, &packed, NULL); /* nothing is left to do */
            succeed(&opened, svo_compact_download(packed, opened.queue));
            const svo_compact_info after = describe(packed);
            assert_int_equal(after.packed, PAYLOAD & ~after.constant);
            assert_true(after.total_bytes < before.total_bytes * 3 / 4);
            assert_int_equal(svo_compact_hash(packed, hashes[turn]), SVO_OK);
            hash_expanded(&opened, packed, got);
            assert_string_equal(got, expected);
            svo_compact_destroy(&packed);
        }
        assert_string_equal(hashes[0], hashes[1]);
        svo_compact_destroy(&plain);
    }
    built_destroy(&tree);
}

/* Elements on the host, from any place on, are those of the arrays before. */
static void payload_is_read_on_the_host(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    built tree;
    build_surface(&opened, 5, true, &tree);
    svo_compact *plain = make(&opened, tree.tree, SVO_FORM_SHARED);
    svo_compact *packed = make(&opened, tree.tree, SVO_FORM_SHARED);
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    svo_compact_arrays held = SVO_COMPACT_ARRAYS_INIT;
    succeed(&opened, svo_compact_download(plain, opened.queue));
    succeed(&opened, svo_compact_get_arrays(plain, &arrays));
    pack(&opened, &packed, NULL);
    assert_int_equal(svo_compact_read_payload(packed, SVO_COMPACT_COLORS, 0, 0, NULL), SVO_INVALID_ARGUMENT);
    succeed(&opened, svo_compact_download(packed, opened.queue));
    succeed(&opened, svo_compact_get_arrays(packed, &held));
    assert_null(held.colors);
    assert_null(held.normals);
    assert_non_null(held.packed[0]);
    assert_non_null(held.packed[1]);
    const uint64_t count = describe(packed).payload_count;
    for (uint64_t i = 0; i < count; ++i) {
        uint8_t color[4];
        uint8_t same[4];
        int16_t normal[3];
        assert_int_equal(svo_compact_read_payload(packed, SVO_COMPACT_COLORS, i, 1, color), SVO_OK);
        assert_int_equal(svo_compact_read_payload(plain, SVO_COMPACT_COLORS, i, 1, same), SVO_OK);
        assert_int_equal(svo_compact_read_payload(packed, SVO_COMPACT_NORMALS, i, 1, normal), SVO_OK);
        assert_memory_equal(color, arrays.colors + 4 * i, sizeof color);
        assert_memory_equal(same, color, sizeof color);
        assert_memory_equal(normal, arrays.normals + 3 * i, sizeof normal);
    }
    assert_int_equal(svo_compact_read_payload(packed, SVO_COMPACT_COLORS, count, 1, &held), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_read_payload(packed, SVO_COMPACT_COLORS, 1, UINT64_MAX, &held), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_read_payload(packed, SVO_COMPACT_NODES, 0, 1, &held), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_read_payload(NULL, SVO_COMPACT_COLORS, 0, 1, &held), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_read_payload(packed, SVO_COMPACT_COLORS, 0, 1, NULL), SVO_INVALID_ARGUMENT);
    svo_compact_destroy(&plain);
    svo_compact_destroy(&packed);
    built_destroy(&tree);
}

/* ---- pictures ---- */

enum { WIDTH = 64, HEIGHT = 48 };

static void draw(const fixture *opened, svo_target target, svo_render_options *options, uint8_t *pixels)
{
    succeed(opened, svo_render(target, options, svo_in_host(pixels), &(svo_submit){.queue = opened->queue}));
}

/* Of every form, whole or in part clear, exact or not: the bytes of the tree that it expands to. */
static void pictures_are_those_of_the_expanded_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (int turn = 0; turn < 2 * SVO_FORM_COUNT; ++turn) {
        static uint8_t expected[4 * WIDTH * HEIGHT];
        static uint8_t got[4 * WIDTH * HEIGHT];
        const svo_pack_options lossy = {.struct_size = sizeof lossy, .color_error = 9, .normal_bits = 6};
        svo_render_options options = SVO_RENDER_OPTIONS_INIT;
        svo_tree *expanded = NULL;
        built tree;
        build_surface(&opened, 6, turn % 2 == 1, &tree);
        options.width = WIDTH;
        options.height = HEIGHT;
        (void)svo_camera_fit(svo_tree_target(tree.tree), (float)WIDTH / HEIGHT, &options.camera);
        svo_compact *packed = make(&opened, tree.tree, (svo_form)(turn / 2));
        pack(&opened, &packed, turn % 4 < 2 ? &lossy : NULL);
        succeed(&opened, svo_compact_expand(packed, opened.queue, &expanded));
        for (int view = SVO_VIEW_SHADED; view <= SVO_VIEW_NORMAL; ++view) {
            options.view = (svo_render_view)view;
            draw(&opened, svo_tree_target(expanded), &options, expected);
            draw(&opened, svo_compact_target(packed), &options, got);
            assert_memory_equal(expected, got, sizeof got);
            if (turn % 4 >= 2) {
                draw(&opened, svo_tree_target(tree.tree), &options, expected);
                assert_memory_equal(expected, got, sizeof got);
            }
        }
        svo_tree_destroy(&expanded);
        svo_compact_destroy(&packed);
        built_destroy(&tree);
    }
}

enum { TREES = 4 };

static svo_scene *place(const fixture *opened, svo_compact *const trees[TREES])
{
    svo_instance instances[TREES];
    svo_scene *placed = NULL;
    for (uint32_t i = 0; i < TREES; ++i) {
        instances[i] = (svo_instance){i, {1, 0, 0, 1.2F * (float)i, 0, 1, 0.3F, 0, 0, 0, 1, 0}};
    }
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .tree_count = TREES,
                                       .compacts = trees,
                                       .instances = instances,
                                       .instance_count = TREES};
    succeed(opened, svo_scene_create(opened->device, &options, opened->queue, &placed));
    return placed;
}

/* A packed tree and, of its form, what it expands to. */
static void make_pair(const fixture *opened, const svo_tree *tree, svo_form form, const svo_pack_options *options,
                      svo_compact **packed, svo_compact **plain)
{
    svo_tree *expanded = NULL;
    *packed = make(opened, tree, form);
    pack(opened, packed, options);
    succeed(opened, svo_compact_expand(*packed, opened->queue, &expanded));
    *plain = make(opened, expanded, form);
    svo_tree_destroy(&expanded);
}

/* Trees with packed payload among others, whole or in part clear: the bytes of the scene of what they expand to. The
   normals of the second end at half of a word, behind which packed ones begin. */
static void scenes_draw_packed_trees(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_pack_options lossy = {.struct_size = sizeof lossy, .color_error = 9, .normal_bits = 6};
    const svo_pack_options colors = {.struct_size = sizeof colors, .leave_out = SVO_NEED_NORMAL};
    for (int turn = 0; turn < 2 * SVO_FORM_COUNT; ++turn) {
        static uint8_t expected[4 * WIDTH * HEIGHT];
        static uint8_t got[4 * WIDTH * HEIGHT];
        const svo_form form = (svo_form)(turn / 2);
        svo_compact *packed[TREES], *plain[TREES];
        svo_render_options options = {.struct_size = sizeof options, .width = WIDTH, .height = HEIGHT};
        svo_scene_info with_packed = SVO_SCENE_INFO_INIT;
        svo_scene_info without = SVO_SCENE_INFO_INIT;
        built small, large;
        build_surface(&opened, 4, turn % 2 == 1, &small);
        build_surface(&opened, 5, false, &large);
        make_pair(&opened, small.tree, form, &lossy, &packed[0], &plain[0]);
        packed[1] = plain[1] = make(&opened, small.tree, form);
        make_pair(&opened, large.tree, form, NULL, &packed[2], &plain[2]);
        make_pair(&opened, small.tree, form, &colors, &packed[3], &plain[3]);
        assert_int_equal(describe(packed[1]).payload_count % 2, 1);
        svo_scene *scenes[] = {place(&opened, plain), place(&opened, packed)};
        assert_int_equal(svo_scene_get_info(scenes[0], &without), SVO_OK);
        assert_int_equal(svo_scene_get_info(scenes[1], &with_packed), SVO_OK);
        assert_true(with_packed.tree_bytes < without.tree_bytes);
        (void)svo_camera_fit(svo_scene_target(scenes[0]), (float)WIDTH / HEIGHT, &options.camera);
        draw(&opened, svo_scene_target(scenes[0]), &options, expected);
        draw(&opened, svo_scene_target(scenes[1]), &options, got);
        assert_memory_equal(expected, got, sizeof got);
        for (int i = 0; i < TREES; ++i) {
            svo_compact_destroy(&packed[i]);
            if (i != 1) {
                svo_compact_destroy(&plain[i]);
            }
        }
        svo_scene_destroy(&scenes[0]);
        svo_scene_destroy(&scenes[1]);
        built_destroy(&small);
        built_destroy(&large);
    }
}

/* ---- errors ---- */

static void errors_are_told(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_pack_options options = {
        .struct_size = sizeof options, .leave_out = SVO_NEED_FILL, .color_error = 6, .normal_bits = 7};
    built tree;
    build_surface(&opened, 6, false, &tree);
    svo_compact *exact = make(&opened, tree.tree, SVO_FORM_IMPLIED);
    svo_compact *packed = make(&opened, tree.tree, SVO_FORM_IMPLIED);
    pack(&opened, &exact, NULL);
    pack(&opened, &packed, &options);
    const svo_compact_info before = describe(exact);
    const svo_compact_info after = describe(packed);
    for (int k = 0; k < SVO_PAYLOAD_COUNT; ++k) {
        assert_int_equal(before.largest_error[k], 0);
        assert_true(before.mean_error[k] == 0.0);
    }
    assert_int_equal(after.packed & SVO_NEED_FILL, 0);
    assert_int_equal(after.normal_bits, 7);
    assert_int_equal(before.normal_bits, 0);
    assert_in_range(after.largest_error[0], 1, 6);
    assert_true(after.mean_error[0] > 0.1 && after.mean_error[0] < 6.0);
    assert_in_range(after.largest_error[1], 1, 1000);
    assert_int_equal(after.largest_error[2], 0);
    assert_true(after.bytes[SVO_COMPACT_COLORS] < before.bytes[SVO_COMPACT_COLORS] * 2 / 3);
    svo_compact_destroy(&exact);
    svo_compact_destroy(&packed);
    built_destroy(&tree);
}

static void check_refused(const fixture *opened, svo_compact *compact, const svo_pack_options *options,
                          const char *message)
{
    svo_compact *packed = NULL;
    assert_int_equal(svo_compact_pack(compact, options, opened->queue, &packed), SVO_INVALID_ARGUMENT);
    assert_null(packed);
    assert_string_equal(svo_device_message(opened->device), message);
}

static void wrong_calls_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const size_t size = sizeof(svo_pack_options);
    built tree;
    build_surface(&opened, 4, false, &tree);
    svo_compact *compact = make(&opened, tree.tree, SVO_FORM_IMPLIED);
    check_refused(&opened, compact, &(svo_pack_options){.struct_size = size, .color_error = 256},
                  "svo_compact_pack: options.color_error 256 is not in 0 .. 255");
    check_refused(&opened, compact, &(svo_pack_options){.struct_size = size, .fill_error = 65536},
                  "svo_compact_pack: options.fill_error 65536 is not in 0 .. 65535");
    check_refused(&opened, compact, &(svo_pack_options){.struct_size = size, .normal_bits = 3},
                  "svo_compact_pack: options.normal_bits 3 is not 0 and not in 4 .. 8");
    check_refused(&opened, compact, &(svo_pack_options){.struct_size = size, .leave_out = 0x80000000u},
                  "svo_compact_pack: options.leave_out 0x80000000 has bits outside 0x3f");
    assert_int_equal(svo_compact_pack(NULL, NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_pack(compact, NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(describe(compact).packed, 0);
    svo_compact_destroy(&compact);
    built_destroy(&tree);
}

TEST_GROUP(compact_packed)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(packed_trees_expand_to_the_same_tree),
                                       cmocka_unit_test(payload_is_read_on_the_host),
                                       cmocka_unit_test(pictures_are_those_of_the_expanded_tree),
                                       cmocka_unit_test(scenes_draw_packed_trees),
                                       cmocka_unit_test(errors_are_told),
                                       cmocka_unit_test(wrong_calls_are_refused)};
    return cmocka_run_group_tests_name("compact_packed", tests, fixture_group_setup, fixture_group_teardown);
}
