/* SPDX-License-Identifier: MIT */
/* .bt files byte by byte: what OctoMap's library writes of the same voxels, and damage. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "support/suite.h"
#include "svocl/voxel_files.h"
#include "vox_bytes.h"

#define NAME  "map"
#define MAGIC "# Octomap OcTree binary file\n"

static int append(void *user, const void *bytes, size_t count)
{
    bytes_put(user, bytes, count);
    return 0;
}

/* Level by level the only child is an inner one, 15 times: that of the world's middle at first, then the other way. */
static void put_way(byte_list *file, unsigned levels)
{
    for (unsigned level = 0; level < levels; ++level) {
        const unsigned child = level == 0 ? 7 : 0;
        const uint32_t bits = 3u << 2 * child;
        bytes_put_u8(file, (uint8_t)bits);
        bytes_put_u8(file, (uint8_t)(bits >> 8));
    }
}

static byte_list map_of(const char *size, unsigned levels, uint16_t last)
{
    byte_list file = {0};
    bytes_put_text(&file, MAGIC "# made by svocl\n#\nid OcTree\nsize ");
    bytes_put_text(&file, size);
    bytes_put_text(&file, "\nres 0.5\ndata\n");
    put_way(&file, levels);
    bytes_put_u8(&file, (uint8_t)last);
    bytes_put_u8(&file, (uint8_t)(last >> 8));
    return file;
}

/* Writes voxels from the origin on, with their axes as they are. */
static byte_list write_voxels(const svo_voxel *voxels, size_t count, double origin)
{
    byte_list file = {0};
    svo_voxels *list = NULL;
    const svo_voxels_source source = {.struct_size = sizeof source,
                                      .voxels = voxels,
                                      .voxel_count = count,
                                      .voxel_edge = 0.5,
                                      .origin = {origin, 0.0, 0.0}};
    assert_int_equal(svo_voxels_create(&source, &list, NULL), SVO_OK);
    assert_int_equal(svo_voxels_set_axes(list, SVO_AXES_KEEP), SVO_OK);
    assert_int_equal(svo_voxels_save(list, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_BT, NULL, NULL), SVO_OK);
    svo_voxels_destroy(&list);
    return file;
}

static void expect_bytes(byte_list file, byte_list expected)
{
    assert_int_equal(file.count, expected.count);
    assert_memory_equal(file.bytes, expected.bytes, file.count);
    bytes_free(&file);
    bytes_free(&expected);
}

static void test_bytes(void **state)
{
    (void)state;
    svo_voxel cube[8];
    const svo_voxel two[2] = {{.x = 0}, {.y = 1}};
    for (int i = 0; i < 8; ++i) {
        cube[i] = (svo_voxel){.x = i & 1, .y = i >> 1 & 1, .z = i >> 2};
    }
    expect_bytes(write_voxels(cube, 1, 0.0), map_of("17", 15, 2)); /* child 0 is occupied */
    expect_bytes(write_voxels(two, 2, 0.0), map_of("18", 15, 2 | 2 << 4)); /* children 0 and 2 */
    expect_bytes(write_voxels(cube, 8, 0.0), map_of("16", 14, 2)); /* eight are a leaf of the level above */
    /* A place between two is moved to the nearest. */
    const svo_voxel moved = {.x = -3};
    expect_bytes(write_voxels(&moved, 1, 1.6), map_of("17", 15, 2));
}

static svo_status load(const byte_list *file, uint64_t voxels_max, svo_voxels **voxels, svo_message *message)
{
    const svo_voxels_load_options options = {
        .struct_size = sizeof options, .axes = SVO_AXES_KEEP, .voxels_max = voxels_max};
    return svo_voxels_load(svo_from_memory(file->bytes, file->count, NAME), &options, voxels, NULL, message);
}

static void expect_refusal(byte_list file, svo_status status, const char *words)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    const svo_status got = load(&file, 1000, &voxels, &message);
    if (got != status || strstr(message.text, words) == NULL) {
        fail_msg("%s '%s', expected '%s'", svo_name(SVO_NAME_STATUS, got), message.text, words);
    }
    bytes_free(&file);
}

/* A leaf high up stands for all its voxels; free ones are none. */
static void test_reading(void **state)
{
    (void)state;
    svo_voxels *voxels = NULL;
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    svo_message message = {""};
    byte_list file = map_of("16", 13, 2 | 1 << 2); /* below level 13, a leaf is 4 voxels wide: one occupied, one free */
    if (load(&file, 64, &voxels, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
    assert_int_equal(info.voxel_count, 64);
    assert_true(info.voxel_edge == 0.5);
    for (int axis = 0; axis < 3; ++axis) {
        assert_int_equal(info.low[axis], 0);
        assert_int_equal(info.high[axis], 4);
    }
    svo_voxels_destroy(&voxels);
    assert_int_equal(load(&file, 63, &voxels, &message), SVO_INVALID_ARGUMENT);
    bytes_free(&file);
}

static void test_damage(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {{MAGIC "id OcTree\nsize 1\nres 1\n", "header: it ends without data"},
                 {MAGIC "id ColorOcTree\n", "header: 'ColorOcTree' is not OcTree"},
                 {MAGIC "size -1\n", "header: '-1' is no number of nodes"},
                 {MAGIC "res 0\n", "header: '0' is no width of voxels above 0"},
                 {MAGIC "res inf\n", "is no width of voxels above 0"},
                 {MAGIC "depth 3\n", "header: 'depth' is none of id, size, res, data"},
                 {MAGIC "size 1\ndata\n", "header: no res"},
                 {MAGIC "res 1\ndata\n", "header: no size"},
                 {MAGIC "size 1\nres 1\ndata\n?", "data: the file ends in a node, at byte"},
                 {MAGIC "size 0\nres 1\ndata\n?", "data: 0 nodes to byte"},
                 {MAGIC "size 4\nres 1\ndata\n\1\1", "data: 3 nodes"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        byte_list file = {0};
        bytes_put_text(&file, cases[i].text);
        expect_refusal(file, SVO_FILE_DAMAGED, cases[i].words);
    }
    expect_refusal(map_of("17", 15, 3), SVO_FILE_DAMAGED, "data: an inner node below level 15");
    expect_refusal(map_of("18", 15, 2), SVO_FILE_DAMAGED, "data: 17 nodes");
    expect_refusal(map_of("2", 0, 2), SVO_INVALID_ARGUMENT, "are above the limit of 1000 (voxels_max)");
}

/* Voxels that are too far out are refused before anything is written. */
static void test_extent(void **state)
{
    (void)state;
    byte_list file = {0};
    svo_voxels *list = NULL;
    svo_message message = {""};
    svo_voxel voxel = {.x = 32767, .y = -32768};
    svo_voxels_source source = {.struct_size = sizeof source, .voxels = &voxel, .voxel_count = 1};
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(svo_voxels_create(&source, &list, NULL), SVO_OK);
        assert_int_equal(svo_voxels_set_axes(list, SVO_AXES_KEEP), SVO_OK);
        const svo_status status =
            svo_voxels_save(list, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_BT, NULL, &message);
        assert_int_equal(status, i == 0 ? SVO_OK : SVO_INVALID_ARGUMENT);
        svo_voxels_destroy(&list);
        voxel.x += 1;
    }
    assert_non_null(strstr(message.text, "voxels 32768 .. 32768 along x are not in -32768 .. 32767"));
    bytes_free(&file);
}

TEST_GROUP(bt)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bytes),
        cmocka_unit_test(test_reading),
        cmocka_unit_test(test_damage),
        cmocka_unit_test(test_extent),
    };
    return cmocka_run_group_tests_name("bt", tests, NULL, NULL);
}
