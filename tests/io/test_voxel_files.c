/* SPDX-License-Identifier: MIT */
/*
 * What all formats of voxel files have in common: what is written is read again, the same voxels make the same bytes,
 * files that are cut off or changed are refused in one line or read. Points and cubes against a search through all
 * voxels.
 */
#include <dirent.h>
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/suite.h"
#include "svocl/voxel_files.h"
#include "vox_bytes.h"

#define NAME "file"

enum { DICE = 1000 };

static int append(void *user, const void *bytes, size_t byte_count)
{
    bytes_put(user, bytes, byte_count);
    return 0;
}

static svo_voxels *make(const svo_voxels_source *source)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    if (svo_voxels_create(source, &voxels, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return voxels;
}

static byte_list write_as(const svo_voxels *voxels, svo_voxel_format format, svo_voxels_save_info *info)
{
    byte_list file = {0};
    svo_message message = {""};
    if (svo_voxels_save(voxels, svo_to_callback(append, &file), format, info, &message) != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_VOXEL_FORMAT, format), message.text);
    }
    return file;
}

static svo_voxels *read_back(const byte_list *file, svo_voxel_file_info *info)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    if (svo_voxels_load(svo_from_memory(file->bytes, file->count, NAME), NULL, &voxels, info, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return voxels;
}

static svo_voxels_info info_of(const svo_voxels *voxels)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
    return info;
}

/* Whether two lists have the same voxels in the world: the same least corner, bit for bit, and the same places from
   there on. Then their trees are the same. */
static void expect_same(const svo_voxels *a, const svo_voxels *b, bool colors, bool materials)
{
    const svo_voxels_info left = info_of(a);
    const svo_voxels_info right = info_of(b);
    assert_int_equal(left.voxel_count, right.voxel_count);
    assert_true(left.voxel_edge == right.voxel_edge);
    for (int axis = 0; axis < 3; ++axis) {
        const double one = left.origin[axis] + left.low[axis] * left.voxel_edge;
        const double other = right.origin[axis] + right.low[axis] * right.voxel_edge;
        if (one != other) {
            fail_msg("axis %d begins at %.17g and %.17g", axis, one, other);
        }
    }
    for (uint64_t i = 0; i < left.voxel_count; ++i) {
        const svo_voxel *one = &svo_voxels_get(a)[i];
        const svo_voxel *other = &svo_voxels_get(b)[i];
        assert_int_equal(one->x - left.low[0], other->x - right.low[0]);
        assert_int_equal(one->y - left.low[1], other->y - right.low[1]);
        assert_int_equal(one->z - left.low[2], other->z - right.low[2]);
        assert_true(!colors || memcmp(one->rgba, other->rgba, 4) == 0);
        assert_true(!materials || one->material == other->material);
    }
}

/* A random number below a limit. */
static uint32_t roll(uint32_t *seed, uint32_t limit)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) % limit;
}

/* Voxels within a box, with so many materials that each have one color, from material 1 on. */
static svo_voxels *random_voxels(uint32_t seed, const int32_t low[3], const uint32_t extent[3], uint32_t materials)
{
    svo_voxel *voxels = calloc(DICE, sizeof *voxels);
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    assert_non_null(voxels);
    for (int i = 0; i < DICE; ++i) {
        const uint32_t material = 1 + roll(&seed, materials);
        voxels[i] = (svo_voxel){.x = low[0] + (int32_t)roll(&seed, extent[0]),
                                .y = low[1] + (int32_t)roll(&seed, extent[1]),
                                .z = low[2] + (int32_t)roll(&seed, extent[2]),
                                .rgba = {(uint8_t)(material * 7), (uint8_t)(material >> 3), (uint8_t)material, 255},
                                .material = (uint16_t)material};
    }
    source.voxels = voxels;
    source.voxel_count = DICE;
    svo_voxels *made = make(&source);
    free(voxels);
    return made;
}

static const int32_t corner[3] = {-300, 5, -20};
static const uint32_t small_box[3] = {11, 7, 13};
static const uint32_t large_box[3] = {700, 300, 20};

static void check_round_trip(const svo_voxels *voxels, svo_voxel_format format, bool colors, bool materials)
{
    svo_voxels_save_info saved = SVO_VOXELS_SAVE_INFO_INIT;
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    byte_list file = write_as(voxels, format, &saved);
    byte_list again = write_as(voxels, format, NULL);
    assert_int_equal(file.count, saved.bytes);
    assert_int_equal(file.count, again.count);
    assert_memory_equal(file.bytes, again.bytes, file.count);
    svo_voxels *read = read_back(&file, &info);
    assert_int_equal(info.format, format);
    expect_same(voxels, read, colors, materials);
    svo_voxels_destroy(&read);
    bytes_free(&file);
    bytes_free(&again);
}

static bool has_svx(void)
{
    static const uint8_t zip[] = {'P', 'K', 3, 4};
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    return svo_voxels_load(svo_from_memory(zip, sizeof zip, NAME), NULL, &voxels, NULL, &message) != SVO_UNSUPPORTED;
}

static bool has_nvdb(void)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    return svo_voxels_load(svo_from_memory("NanoVDB", 7, NAME), NULL, &voxels, NULL, &message) != SVO_UNSUPPORTED;
}

static bool has_vdb(void)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    return svo_voxels_load(svo_from_memory(" BDV\0\0\0\0", 8, NAME), NULL, &voxels, NULL, &message) != SVO_UNSUPPORTED;
}

static void test_round_trips(void **state)
{
    (void)state;
    svo_voxels *small = random_voxels(1, corner, small_box, 255);
    svo_voxels *large = random_voxels(2, corner, large_box, 40);
    check_round_trip(small, SVO_VOXEL_FORMAT_VOX, true, true);
    check_round_trip(large, SVO_VOXEL_FORMAT_VOX, true, true);
    check_round_trip(small, SVO_VOXEL_FORMAT_BINVOX, false, false);
    check_round_trip(large, SVO_VOXEL_FORMAT_BINVOX, false, false);
    check_round_trip(small, SVO_VOXEL_FORMAT_BT, false, false);
    check_round_trip(large, SVO_VOXEL_FORMAT_BT, false, false);
    if (has_svx()) {
        check_round_trip(small, SVO_VOXEL_FORMAT_SVX, true, true);
        check_round_trip(large, SVO_VOXEL_FORMAT_SVX, true, true);
    }
    if (has_nvdb()) {
        check_round_trip(small, SVO_VOXEL_FORMAT_NVDB, true, true);
        check_round_trip(large, SVO_VOXEL_FORMAT_NVDB, true, true);
    }
    if (has_vdb()) {
        check_round_trip(small, SVO_VOXEL_FORMAT_VDB, true, true);
        check_round_trip(large, SVO_VOXEL_FORMAT_VDB, true, true);
    }
    svo_voxels_destroy(&small);
    svo_voxels_destroy(&large);
}

/* World positions that are no whole numbers survive in the formats that hold them. */
static void test_world_positions(void **state)
{
    (void)state;
    const svo_voxel voxels[] = {{.x = 3, .rgba = {255, 255, 255, 255}},
                                {.y = 9, .z = -2, .rgba = {255, 255, 255, 255}}};
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = voxels;
    source.voxel_count = 2;
    source.voxel_edge = 0.1;
    source.origin[0] = -1.0 / 3.0;
    source.origin[2] = 1e6;
    svo_voxels *list = make(&source);
    const double low[3] = {-1.0 / 3.0, 0.0, 1e6 - 2 * 0.1};
    const svo_voxel_format formats[] = {SVO_VOXEL_FORMAT_BINVOX, SVO_VOXEL_FORMAT_SVX};
    for (int i = 0; i < (has_svx() ? 2 : 1); ++i) {
        byte_list file = write_as(list, formats[i], NULL);
        svo_voxels *read = read_back(&file, NULL);
        const svo_voxels_info info = info_of(read);
        assert_true(info.voxel_edge == 0.1);
        assert_memory_equal(info.origin, low, sizeof low);
        assert_int_equal(info.voxel_count, 2);
        svo_voxels_destroy(&read);
        bytes_free(&file);
    }
    svo_voxels_destroy(&list);
}

static void test_no_voxels(void **state)
{
    (void)state;
    const svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    svo_voxels *empty = make(&source);
    check_round_trip(empty, SVO_VOXEL_FORMAT_VOX, true, true);
    check_round_trip(empty, SVO_VOXEL_FORMAT_BINVOX, true, true);
    check_round_trip(empty, SVO_VOXEL_FORMAT_BT, true, true);
    if (has_svx()) {
        check_round_trip(empty, SVO_VOXEL_FORMAT_SVX, true, true);
    }
    if (has_nvdb()) {
        check_round_trip(empty, SVO_VOXEL_FORMAT_NVDB, true, true);
    }
    byte_list obj = write_as(empty, SVO_VOXEL_FORMAT_OBJ, NULL);
    byte_list ply = write_as(empty, SVO_VOXEL_FORMAT_PLY, NULL);
    bytes_free(&obj);
    bytes_free(&ply);
    svo_voxels_destroy(&empty);
}

/* ---- .vox ---- */

static void test_large_boxes_become_models(void **state)
{
    (void)state;
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    svo_voxels_save_info saved = SVO_VOXELS_SAVE_INFO_INIT;
    svo_voxels *large = random_voxels(3, corner, large_box, 255);
    byte_list file = write_as(large, SVO_VOXEL_FORMAT_VOX, &saved);
    svo_voxels *read = read_back(&file, &info);
    assert_int_equal(saved.models, 6); /* 700 x 300 x 20 in blocks of 256 */
    assert_int_equal(info.models, 6);
    assert_int_equal(info.instances, 6);
    assert_int_equal(info.rotated_instances, 0);
    assert_int_equal(saved.color_error, 0);
    svo_voxels_destroy(&read);
    svo_voxels_destroy(&large);
    bytes_free(&file);
}

/* All properties of materials come back, also of materials that no voxel has. */
static void test_properties_are_kept(void **state)
{
    (void)state;
    const svo_voxel voxels[] = {{.rgba = {1, 2, 3, 255}, .material = 7}, {.x = 1, .rgba = {9, 9, 9, 9}, .material = 8}};
    const svo_voxel_property properties[] = {
        {7, "_type", "_metal"}, {256, "_x", "1"}, {7, "unknown", "a b"}, {8, "_rough", ""}, {7, "_type", "_glass"}};
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = voxels;
    source.voxel_count = 2;
    source.properties = properties;
    source.property_count = 5;
    svo_voxels *list = make(&source);
    byte_list file = write_as(list, SVO_VOXEL_FORMAT_VOX, NULL);
    svo_voxels *read = read_back(&file, NULL);
    expect_same(list, read, true, true);
    assert_int_equal(info_of(list).property_count, 4);
    assert_int_equal(info_of(read).property_count, 4);
    for (size_t i = 0; i < 4; ++i) {
        const svo_voxel_property *one = &svo_voxels_get_properties(list)[i];
        const svo_voxel_property *other = &svo_voxels_get_properties(read)[i];
        assert_int_equal(one->material, other->material);
        assert_string_equal(one->key, other->key);
        assert_string_equal(one->value, other->value);
    }
    assert_string_equal(svo_voxels_get_properties(read)[0].value, "_glass"); /* the last one counts */
    svo_voxels_destroy(&read);
    svo_voxels_destroy(&list);
    bytes_free(&file);
}

/* Voxels of so many colors, along x. */
static svo_voxels *rainbow(uint32_t colors)
{
    svo_voxel *voxels = calloc(colors, sizeof *voxels);
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    assert_non_null(voxels);
    for (uint32_t i = 0; i < colors; ++i) {
        voxels[i] = (svo_voxel){.x = (int32_t)i,
                                .rgba = {(uint8_t)(i * 37), (uint8_t)(i >> 3), (uint8_t)(i * 11), 255},
                                .material = (uint16_t)(i % 3)};
    }
    source.voxels = voxels;
    source.voxel_count = colors;
    svo_voxels *made = make(&source);
    free(voxels);
    return made;
}

/* 255 colors are exact. With more, each voxel has the nearest color of those that are left, and the reported error is
   the largest that there is. */
static void test_many_colors_become_the_nearest(void **state)
{
    (void)state;
    svo_voxels_save_info saved = SVO_VOXELS_SAVE_INFO_INIT;
    svo_voxels *exact = rainbow(255);
    byte_list file = write_as(exact, SVO_VOXEL_FORMAT_VOX, &saved);
    svo_voxels *read = read_back(&file, NULL);
    expect_same(exact, read, true, false);
    assert_int_equal(saved.colors, 255);
    assert_int_equal(saved.color_error, 0);
    svo_voxels_destroy(&read);
    svo_voxels_destroy(&exact);
    bytes_free(&file);

    svo_voxels *many = rainbow(2000);
    file = write_as(many, SVO_VOXEL_FORMAT_VOX, &saved);
    read = read_back(&file, NULL);
    assert_int_equal(saved.colors, 2000);
    expect_same(many, read, false, false);
    uint32_t largest = 0;
    for (size_t i = 0; i < 2000; ++i) {
        const svo_voxel *given = &svo_voxels_get(many)[i];
        const svo_voxel *got = &svo_voxels_get(read)[i];
        uint32_t to_got = 0;
        uint32_t least = UINT32_MAX;
        for (int c = 0; c < 4; ++c) {
            const int difference = abs(given->rgba[c] - got->rgba[c]);
            to_got += (uint32_t)(difference * difference);
            largest = (uint32_t)difference > largest ? (uint32_t)difference : largest;
        }
        for (size_t k = 0; k < 2000; ++k) {
            uint32_t to_other = 0;
            for (int c = 0; c < 4; ++c) {
                const int difference = given->rgba[c] - svo_voxels_get(read)[k].rgba[c];
                to_other += (uint32_t)(difference * difference);
            }
            least = to_other < least ? to_other : least;
        }
        assert_int_equal(to_got, least);
    }
    assert_int_equal(saved.color_error, largest);
    assert_true(largest > 0 && largest < 40);
    svo_voxels_destroy(&read);
    svo_voxels_destroy(&many);
    bytes_free(&file);
}

/* ---- .binvox ---- */

static svo_status load_text(const char *header, const uint8_t *data, size_t data_bytes, svo_voxels **voxels,
                            svo_message *message)
{
    byte_list file = {0};
    bytes_put_text(&file, header);
    bytes_put(&file, data, data_bytes);
    const svo_status status =
        svo_voxels_load(svo_from_memory(file.bytes, file.count, NAME), NULL, voxels, NULL, message);
    bytes_free(&file);
    return status;
}

static void test_binvox_headers(void **state)
{
    (void)state;
    static const char *const good[] = {
        "#binvox 1\ndim 2 3 4\ntranslate 1 2 3\nscale 8\ndata\n",
        "#binvox 1\n# a comment\n  scale 8 # more\ntranslate 1\n2 3\r\ndim 2 3 4 \t\ndata \n",
        "#binvox 2 dim 2 3 4#\nscale +8.0e0 translate 1.0 2.0 3 data\n",
    };
    /* y is the last of dim and fastest, z the second, x the first. */
    static const uint8_t runs[] = {0, 5, 1, 2, 0, 16, 1, 1};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; ++i) {
        svo_voxels *voxels = NULL;
        svo_message message = {""};
        if (load_text(good[i], runs, sizeof runs, &voxels, &message) != SVO_OK) {
            fail_msg("header %zu: %s", i, message.text);
        }
        const svo_voxel *v = svo_voxels_get(voxels);
        const svo_voxels_info info = info_of(voxels);
        assert_int_equal(info.voxel_count, 3);
        assert_true(info.voxel_edge == 2.0 && info.origin[0] == 1.0 && info.origin[1] == 2.0 && info.origin[2] == 3.0);
        bool seen[3] = {false, false, false};
        for (int k = 0; k < 3; ++k) {
            seen[0] = seen[0] || (v[k].x == 0 && v[k].y == 1 && v[k].z == 1);
            seen[1] = seen[1] || (v[k].x == 0 && v[k].y == 2 && v[k].z == 1);
            seen[2] = seen[2] || (v[k].x == 1 && v[k].y == 3 && v[k].z == 2);
            assert_int_equal(v[k].material, i == 2 ? 1 : 0);
        }
        assert_true(seen[0] && seen[1] && seen[2]);
        svo_voxels_destroy(&voxels);
    }
}

static void test_binvox_damage(void **state)
{
    (void)state;
    static const struct {
        const char *header;
        const char *data;
        const char *words;
    } cases[] = {
        {"#binvox 3\ndim 1 1 1\ndata\n", "\1\1", "the version is neither 1 nor 2, at byte 8"},
        {"#binvox 1\ndim 1 1\ndata\n", "\1\1", "dim is not three numbers, at byte 18"},
        {"#binvox 1\ndim 1 0 1\ndata\n", "\1\1", "dim is not in 1 .. 2097152, at byte 16"},
        {"#binvox 1\ndim 1 1.5 1\ndata\n", "\1\1", "dim is not in"},
        {"#binvox 1\ndim 1 1 1\ndim 1 1 1\ndata\n", "\1\1", "a word that was there before, at byte 20"},
        {"#binvox 1\ndim 1 1 1\nsize 3\ndata\n", "\1\1", "a word that is not known, at byte 20"},
        {"#binvox 1\nscale 1\ndata\n", "\1\1", "no dim before data"},
        {"#binvox 1\nscale 0\ndim 1 1 1\ndata\n", "\1\1", "scale is not above 0"},
        {"#binvox 1\nscale 1e999\ndim 1 1 1\ndata\n", "\1\1", "scale is not a number"},
        {"#binvox 1\ndim 1 1 1\n", "", "it ends without data"},
        {"#binvox 1\ndim 1 1 1\ndata", "", "no line ends after data"},
        {"#binvox 1\ndim 1 1 1\ndata x\n", "\1\1", "data is not alone in its line"},
        {"#binvox 1\ndim 1 1 2\ndata\n", "\1\1", "data: 1 voxels, the grid has 2, at byte 27"},
        {"#binvox 1\ndim 1 1 1\ndata\n", "\1\2", "a run of 2 voxels where 1 are left, at byte 25"},
        {"#binvox 1\ndim 1 1 1\ndata\n", "\2\1", "value 2 is neither 0 nor 1, at byte 25"},
        {"#binvox 1\ndim 1 1 1\ndata\n", "\1\1\1", "the last run is cut off, at byte 27"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        svo_voxels *voxels = NULL;
        svo_message message = {""};
        const svo_status status =
            load_text(cases[i].header, (const uint8_t *)cases[i].data, strlen(cases[i].data), &voxels, &message);
        if (status != SVO_FILE_DAMAGED || strstr(message.text, cases[i].words) == NULL || voxels != NULL) {
            fail_msg("case %zu: %s '%s', expected '%s'", i, svo_name(SVO_NAME_STATUS, status), message.text,
                     cases[i].words);
        }
    }
}

/* ---- points and cubes ---- */

static void test_points(void **state)
{
    (void)state;
    svo_voxels *voxels = random_voxels(4, corner, small_box, 9);
    byte_list file = write_as(voxels, SVO_VOXEL_FORMAT_PLY, NULL);
    const uint64_t count = info_of(voxels).voxel_count;
    char expected[64];
    (void)snprintf(expected, sizeof expected, "element vertex %" PRIu64 "\n", count);
    bytes_put_u8(&file, 0);
    const char *end = strstr((const char *)file.bytes, "end_header\n");
    assert_non_null(strstr((const char *)file.bytes, expected));
    assert_non_null(end);
    const uint8_t *point = (const uint8_t *)end + strlen("end_header\n");
    assert_int_equal(file.bytes + file.count - 1 - point, count * 18);
    for (uint64_t i = 0; i < count; ++i, point += 18) {
        const svo_voxel *voxel = &svo_voxels_get(voxels)[i];
        const float center[3] = {(float)voxel->x + 0.5f, (float)voxel->y + 0.5f, (float)voxel->z + 0.5f};
        assert_memory_equal(point, center, 12);
        assert_memory_equal(point + 12, voxel->rgba, 4);
        assert_memory_equal(point + 16, &voxel->material, 2);
    }
    svo_voxels_destroy(&voxels);
    bytes_free(&file);
}

/* Points of voxels without materials have no such column. */
static void test_points_without_materials(void **state)
{
    (void)state;
    const svo_voxel voxel = {.x = 1, .rgba = {1, 2, 3, 4}};
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = &voxel;
    source.voxel_count = 1;
    svo_voxels *voxels = make(&source);
    byte_list file = write_as(voxels, SVO_VOXEL_FORMAT_PLY, NULL);
    bytes_put_u8(&file, 0);
    const char *end = strstr((const char *)file.bytes, "end_header\n");
    assert_non_null(end);
    assert_null(strstr((const char *)file.bytes, "material"));
    const uint8_t *point = (const uint8_t *)end + strlen("end_header\n");
    assert_int_equal(file.bytes + file.count - 1 - point, 16);
    assert_memory_equal(point + 12, voxel.rgba, 4);
    svo_voxels_destroy(&voxels);
    bytes_free(&file);
}

static bool is_there(const svo_voxels *voxels, int32_t x, int32_t y, int32_t z)
{
    const svo_voxel *all = svo_voxels_get(voxels);
    for (uint64_t i = 0; i < info_of(voxels).voxel_count; ++i) {
        if (all[i].x == x && all[i].y == y && all[i].z == z) {
            return true;
        }
    }
    return false;
}

/* A face as doubled numbers: the voxel's center, which is inside, and the face's. */
static void check_face(const svo_voxels *voxels, const double corners[4][3])
{
    double center[3] = {0.0, 0.0, 0.0};
    double a[3];
    double b[3];
    double normal[3];
    for (int axis = 0; axis < 3; ++axis) {
        for (int c = 0; c < 4; ++c) {
            center[axis] += corners[c][axis] / 4.0;
        }
        a[axis] = corners[1][axis] - corners[0][axis];
        b[axis] = corners[2][axis] - corners[0][axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        normal[axis] = a[(axis + 1) % 3] * b[(axis + 2) % 3] - a[(axis + 2) % 3] * b[(axis + 1) % 3];
    }
    assert_true(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2] == 1.0);
    int32_t inside[3];
    int32_t outside[3];
    for (int axis = 0; axis < 3; ++axis) {
        inside[axis] = (int32_t)(2 * (center[axis] - 0.5 * normal[axis]) + 2000) / 2 - 1000;
        outside[axis] = (int32_t)(2 * (center[axis] + 0.5 * normal[axis]) + 2000) / 2 - 1000;
    }
    if (!is_there(voxels, inside[0], inside[1], inside[2]) || is_there(voxels, outside[0], outside[1], outside[2])) {
        fail_msg("a face at %g %g %g does not separate a voxel from what is empty", center[0], center[1], center[2]);
    }
}

static void test_cubes_have_outer_faces_alone(void **state)
{
    (void)state;
    svo_voxels_save_info saved = SVO_VOXELS_SAVE_INFO_INIT;
    svo_voxels *voxels = random_voxels(5, corner, small_box, 9);
    byte_list file = write_as(voxels, SVO_VOXEL_FORMAT_OBJ, &saved);
    uint64_t expected = 0;
    for (uint64_t i = 0; i < info_of(voxels).voxel_count; ++i) {
        const svo_voxel *v = &svo_voxels_get(voxels)[i];
        for (int side = -1; side <= 1; side += 2) {
            expected += is_there(voxels, v->x + side, v->y, v->z) ? 0 : 1;
            expected += is_there(voxels, v->x, v->y + side, v->z) ? 0 : 1;
            expected += is_there(voxels, v->x, v->y, v->z + side) ? 0 : 1;
        }
    }
    assert_int_equal(saved.faces, expected);
    double(*vertices)[3] = calloc(8 * DICE, sizeof *vertices);
    assert_non_null(vertices);
    size_t vertex_count = 0;
    uint64_t faces = 0;
    bytes_put_u8(&file, 0);
    for (char *line = (char *)file.bytes; *line != '\0'; line = strchr(line, '\n') + 1) {
        char *rest = line + 1;
        if (*line == 'v') {
            for (int axis = 0; axis < 3; ++axis) {
                vertices[vertex_count][axis] = strtod(rest, &rest);
            }
            ++vertex_count;
        } else if (*line == 'f') {
            double corners[4][3];
            for (int c = 0; c < 4; ++c) {
                const unsigned long index = strtoul(rest, &rest, 10);
                assert_true(index >= 1 && index <= vertex_count);
                memcpy(corners[c], vertices[index - 1], sizeof corners[c]);
            }
            if (faces++ % 7 == 0) {
                check_face(voxels, (const double(*)[3])corners);
            }
        }
    }
    assert_int_equal(faces, expected);
    free(vertices);
    svo_voxels_destroy(&voxels);
    bytes_free(&file);
}

/* ---- real files ---- */

/* Every file of a folder that can be read, there and back in its own format. Returns how many there were. */
static int round_trip_folder(const char *folder)
{
    DIR *opened = opendir(folder);
    int count = 0;
    for (const struct dirent *entry = opened != NULL ? readdir(opened) : NULL; entry != NULL; entry = readdir(opened)) {
        char path[512];
        svo_voxels *voxels = NULL;
        svo_message message = {""};
        const svo_voxel_format format = svo_voxel_format_of_path(entry->d_name);
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (format < SVO_VOXEL_FORMAT_VOX || format > SVO_VOXEL_FORMAT_BINVOX ||
            (format == SVO_VOXEL_FORMAT_SVX && !has_svx())) {
            continue;
        }
        if (svo_voxels_load(svo_from_path(path), NULL, &voxels, NULL, &message) != SVO_OK) {
            fail_msg("%s", message.text);
        }
        check_round_trip(voxels, format, true, true);
        svo_voxels_destroy(&voxels);
        ++count;
    }
    if (opened != NULL) {
        closedir(opened);
    }
    return count;
}

static void test_real_files_there_and_back(void **state)
{
    (void)state;
    const int count = round_trip_folder(SHARED_SCENES "/vox") + round_trip_folder(SHARED_SCENES "/voxel-other");
    if (count == 0) {
        print_message("skipped: no files in %s\n", SHARED_SCENES);
        skip();
    }
    assert_true(count >= 21);
}

/* ---- damage ---- */

/* Reads bytes that may be damaged: one line that begins with the name, or a list. */
static void read_damaged(const byte_list *file, size_t count, const char *what, size_t at)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    const svo_voxels_load_options options = {.struct_size = sizeof options, .voxels_max = 1 << 20};
    uint8_t *exact = malloc(count > 0 ? count : 1); /* a sanitizer sees a read behind it */
    assert_non_null(exact);
    memcpy(exact, file->bytes, count);
    const svo_status status = svo_voxels_load(svo_from_memory(exact, count, NAME), &options, &voxels, NULL, &message);
    free(exact);
    if (status == SVO_OK) {
        assert_non_null(voxels);
        svo_voxels_destroy(&voxels);
        return;
    }
    const bool place = status != SVO_FILE_DAMAGED || strstr(message.text, "byte") != NULL;
    if ((status != SVO_FILE_DAMAGED && status != SVO_INVALID_ARGUMENT) || voxels != NULL || !place ||
        strncmp(message.text, NAME ": ", strlen(NAME) + 2) != 0 || strchr(message.text, '\n') != NULL) {
        fail_msg("%s %zu: %s '%s'", what, at, svo_name(SVO_NAME_STATUS, status), message.text);
    }
}

/* Every beginning of a file, and every change of one bit. */
static void damage(svo_voxel_format format)
{
    static const uint32_t tiny[3] = {2, 3, 2};
    svo_voxels *voxels = random_voxels(6, corner, tiny, 200);
    byte_list file = write_as(voxels, format, NULL);
    for (size_t count = 0; count < file.count; ++count) {
        read_damaged(&file, count, "truncated to", count);
    }
    for (size_t bit = 0; bit < 8 * file.count; ++bit) {
        file.bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
        read_damaged(&file, file.count, "bit", bit);
        file.bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    bytes_free(&file);
    svo_voxels_destroy(&voxels);
}

static void test_damaged_vox(void **state)
{
    (void)state;
    damage(SVO_VOXEL_FORMAT_VOX);
}

static void test_damaged_binvox(void **state)
{
    (void)state;
    damage(SVO_VOXEL_FORMAT_BINVOX);
}

static void test_damaged_svx(void **state)
{
    (void)state;
    if (!has_svx()) {
        print_message("skipped: svocl was built without libzip or expat\n");
        skip();
    }
    damage(SVO_VOXEL_FORMAT_SVX);
}

/* ---- arguments and outputs ---- */

static int fail_late(void *user, const void *bytes, size_t byte_count)
{
    int *left = user;
    (void)bytes;
    (void)byte_count;
    return (*left)-- > 0 ? 0 : 1;
}

static void test_write_failures(void **state)
{
    (void)state;
    svo_voxels *voxels = random_voxels(7, corner, large_box, 255);
    for (int format = SVO_VOXEL_FORMAT_VOX; format <= SVO_VOXEL_FORMAT_VDB; ++format) {
        int left = 0;
        svo_message message = {""};
        if (format == SVO_VOXEL_FORMAT_SLAB6 || format == SVO_VOXEL_FORMAT_LAS || format == SVO_VOXEL_FORMAT_LAZ ||
            (format == SVO_VOXEL_FORMAT_VDB && !has_vdb()) || (format == SVO_VOXEL_FORMAT_SVX && !has_svx()) ||
            (format == SVO_VOXEL_FORMAT_NVDB && !has_nvdb())) {
            continue;
        }
        assert_int_equal(
            svo_voxels_save(voxels, svo_to_callback(fail_late, &left), (svo_voxel_format)format, NULL, &message),
            SVO_FILE_ERROR);
        assert_non_null(strstr(message.text, "could not be written"));
    }
    svo_voxels_destroy(&voxels);
}

static void test_save_and_load_by_path(void **state)
{
    (void)state;
    char folder[] = "/tmp/svocl_voxels_XXXXXX";
    char path[64];
    svo_message message = {""};
    svo_voxels *voxels = random_voxels(8, corner, small_box, 20);
    assert_non_null(mkdtemp(folder));
    (void)snprintf(path, sizeof path, "%s/a.VOX", folder);
    assert_int_equal(svo_voxels_save(voxels, svo_to_path(path), SVO_VOXEL_FORMAT_AUTO, NULL, &message), SVO_OK);
    svo_voxels *read = NULL;
    assert_int_equal(svo_voxels_load(svo_from_path(path), NULL, &read, NULL, &message), SVO_OK);
    expect_same(voxels, read, true, true);
    svo_voxels_destroy(&read);
    assert_int_equal(unlink(path), 0);
    (void)snprintf(path, sizeof path, "%s/no/a.vox", folder);
    assert_int_equal(svo_voxels_save(voxels, svo_to_path(path), SVO_VOXEL_FORMAT_AUTO, NULL, &message), SVO_FILE_ERROR);
    assert_int_equal(svo_voxels_load(svo_from_path(path), NULL, &read, NULL, &message), SVO_FILE_ERROR);
    assert_int_equal(svo_voxels_load(svo_from_path(folder), NULL, &read, NULL, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "directory"));
    (void)snprintf(path, sizeof path, "%s/a.xyz", folder);
    assert_int_equal(svo_voxels_save(voxels, svo_to_path(path), SVO_VOXEL_FORMAT_AUTO, NULL, &message),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(rmdir(folder), 0);
    svo_voxels_destroy(&voxels);
}

static void test_arguments(void **state)
{
    (void)state;
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    svo_voxels_load_options options = SVO_VOXELS_LOAD_OPTIONS_INIT;
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    svo_voxels *some = random_voxels(9, corner, small_box, 20);
    int left = 99;
    assert_int_equal(svo_voxels_load(svo_from_path(NULL), NULL, &voxels, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_load(svo_from_path("x"), NULL, NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_load(svo_from_memory(NULL, 0, NAME), NULL, &voxels, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_load(svo_from_memory("VOX ", 4, NULL), NULL, &voxels, NULL, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_load(svo_from_memory("VOX ", 4, NAME), NULL, NULL, NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_load(svo_from_memory("VOX ", 4, NAME), NULL, &voxels, NULL, NULL), SVO_FILE_DAMAGED);
    assert_int_equal(svo_voxels_load(svo_from_memory("", 0, NAME), NULL, &voxels, NULL, NULL), SVO_FILE_DAMAGED);
    options.struct_size = 3;
    assert_int_equal(svo_voxels_load(svo_from_memory("VOX ", 4, NAME), &options, &voxels, NULL, &message),
                     SVO_INVALID_ARGUMENT);
    info.struct_size = 3;
    assert_int_equal(svo_voxels_load(svo_from_memory("VOX ", 4, NAME), NULL, &voxels, &info, &message),
                     SVO_INVALID_ARGUMENT);
    assert_null(voxels);
    assert_int_equal(svo_voxels_save(some, svo_to_callback(fail_late, &left), SVO_VOXEL_FORMAT_AUTO, NULL, &message),
                     SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_voxels_save: format 0 is neither in 1 .. 6 nor 8 nor 11");
    assert_int_equal(svo_voxels_save(some, svo_to_callback(fail_late, &left), (svo_voxel_format)7, NULL, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_save(NULL, svo_to_path("x.vox"), SVO_VOXEL_FORMAT_AUTO, NULL, NULL),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_save(some, svo_to_path(NULL), SVO_VOXEL_FORMAT_VOX, NULL, &message),
                     SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_voxels_save: sink.path and sink.write are NULL");
    assert_int_equal(svo_voxel_format_of_path("a.b/c.BinVox"), SVO_VOXEL_FORMAT_BINVOX);
    assert_int_equal(svo_voxel_format_of_path("vox"), SVO_VOXEL_FORMAT_AUTO);
    assert_int_equal(svo_voxel_format_of_path(NULL), SVO_VOXEL_FORMAT_AUTO);
    assert_string_equal(svo_name(SVO_NAME_VOXEL_FORMAT, SVO_VOXEL_FORMAT_SVX), "svx");
    assert_string_equal(svo_name(SVO_NAME_VOXEL_FORMAT, (svo_voxel_format)99), "unknown format");
    svo_voxels_destroy(&some);
}

TEST_GROUP(voxel_files)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trips),
        cmocka_unit_test(test_world_positions),
        cmocka_unit_test(test_no_voxels),
        cmocka_unit_test(test_large_boxes_become_models),
        cmocka_unit_test(test_properties_are_kept),
        cmocka_unit_test(test_many_colors_become_the_nearest),
        cmocka_unit_test(test_binvox_headers),
        cmocka_unit_test(test_binvox_damage),
        cmocka_unit_test(test_points),
        cmocka_unit_test(test_points_without_materials),
        cmocka_unit_test(test_cubes_have_outer_faces_alone),
        cmocka_unit_test(test_real_files_there_and_back),
        cmocka_unit_test(test_damaged_vox),
        cmocka_unit_test(test_damaged_binvox),
        cmocka_unit_test(test_damaged_svx),
        cmocka_unit_test(test_write_failures),
        cmocka_unit_test(test_save_and_load_by_path),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests_name("voxel_files", tests, NULL, NULL);
}
