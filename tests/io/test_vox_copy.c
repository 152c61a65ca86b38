/* SPDX-License-Identifier: MIT */
/*
 * .vox files that are written again: every chunk of what the test writes, and of real files, is there, in its place and
 * with its bytes; what a list of voxels lacks is counted. And files of other programs with the same suffix.
 */
#include <dirent.h>
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/suite.h"
#include "svocl/voxel_files.h"
#include "vox_bytes.h"

#define NAME "file.vox"

enum { CHUNKS_MAX = 4096 };

static int append(void *user, const void *bytes, size_t byte_count)
{
    bytes_put(user, bytes, byte_count);
    return 0;
}

static svo_source source_of(const byte_list *file)
{
    return svo_from_memory(file->bytes, file->count, NAME);
}

/* ---- chunks ---- */

typedef struct chunk {
    char id[5];
    const uint8_t *content, *children;
    int32_t content_bytes, children_bytes;
} chunk;

static chunk chunk_at(const byte_list *file, size_t at)
{
    chunk found = {.content = file->bytes + at + 12};
    assert_true(at + 12 <= file->count);
    memcpy(found.id, file->bytes + at, 4);
    memcpy(&found.content_bytes, file->bytes + at + 4, 4);
    memcpy(&found.children_bytes, file->bytes + at + 8, 4);
    found.children = found.content + found.content_bytes;
    assert_true(at + 12 + (size_t)found.content_bytes + (size_t)found.children_bytes <= file->count);
    return found;
}

/* The chunks in MAIN. Returns how many there are. */
static size_t list_chunks(const byte_list *file, chunk out[CHUNKS_MAX])
{
    size_t count = 0;
    const chunk main_chunk = chunk_at(file, 8);
    assert_memory_equal(file->bytes, "VOX ", 4);
    assert_string_equal(main_chunk.id, "MAIN");
    size_t at = (size_t)(main_chunk.children - file->bytes);
    const size_t end = at + (size_t)main_chunk.children_bytes;
    assert_int_equal(end, file->count);
    while (at < end) {
        assert_true(count < CHUNKS_MAX);
        out[count] = chunk_at(file, at);
        at = (size_t)(out[count].children - file->bytes) + (size_t)out[count].children_bytes;
        ++count;
    }
    return count;
}

static void expect_same_chunks(const byte_list *a, const byte_list *b)
{
    static chunk of_a[CHUNKS_MAX];
    static chunk of_b[CHUNKS_MAX];
    const size_t count = list_chunks(a, of_a);
    assert_int_equal(list_chunks(b, of_b), count);
    assert_memory_equal(a->bytes, b->bytes, 8); /* the version */
    for (size_t i = 0; i < count; ++i) {
        assert_string_equal(of_a[i].id, of_b[i].id);
        assert_int_equal(of_a[i].content_bytes, of_b[i].content_bytes);
        assert_int_equal(of_a[i].children_bytes, of_b[i].children_bytes);
        assert_memory_equal(of_a[i].content, of_b[i].content, (size_t)of_a[i].content_bytes);
        assert_memory_equal(of_a[i].children, of_b[i].children, (size_t)of_a[i].children_bytes);
    }
}

/* ---- a file with all that a file can have ---- */

static void put_nodes(byte_list *chunks)
{
    static const int32_t moved[] = {3, -4, 5};
    static const int32_t children[] = {2, 4, 6};
    static const int32_t inner[] = {8};
    static const char *const named[] = {"_name", "left arm", "_hidden", "0", NULL};
    static const char *const first[] = {"_t", "1 2 3", "_f", "0", NULL};
    static const char *const second[] = {"_t", "4 5 6", "_r", "17", "_f", "9", NULL};
    static const char *const none[] = {NULL};
    byte_list content = {0};
    vox_put_transform(chunks, 0, 1, -1, -1, NULL);
    vox_put_group(chunks, 1, children, 3);
    vox_put_transform(chunks, 2, 3, 0, 40, moved); /* an instance of model 0, turned */
    vox_put_shape(chunks, 3, 0);
    vox_put_transform(chunks, 4, 5, 1, -1, moved); /* and of model 1, in a hidden layer */
    vox_put_shape(chunks, 5, 1);
    bytes_put_i32(&content, 6); /* two frames that move a group */
    vox_put_dict(&content, named);
    bytes_put_i32(&content, 7);
    bytes_put_i32(&content, -1);
    bytes_put_i32(&content, 0);
    bytes_put_i32(&content, 2);
    vox_put_dict(&content, first);
    vox_put_dict(&content, second);
    vox_put_chunk(chunks, "nTRN", &content);
    vox_put_group(chunks, 7, inner, 1);
    vox_put_transform(chunks, 8, 9, 0, 4, NULL);
    bytes_put_i32(&content, 9); /* two models, one after the other */
    vox_put_dict(&content, none);
    bytes_put_i32(&content, 2);
    bytes_put_i32(&content, 0);
    vox_put_dict(&content, none);
    bytes_put_i32(&content, 2);
    vox_put_dict(&content, second + 4);
    vox_put_chunk(chunks, "nSHP", &content);
}

static void put_layers(byte_list *chunks)
{
    static const char *const shown[] = {"_name", "walls", NULL};
    static const char *const hidden[] = {"_name", "scaffold", "_hidden", "1", NULL};
    for (int32_t id = 0; id < 2; ++id) {
        byte_list content = {0};
        bytes_put_i32(&content, id);
        vox_put_dict(&content, id == 0 ? shown : hidden);
        bytes_put_i32(&content, -1);
        vox_put_chunk(chunks, "LAYR", &content);
    }
}

static void put_settings(byte_list *chunks)
{
    static const char *const glass[] = {"_type", "_glass", "_ior", "0.3", NULL};
    static const char *const camera[] = {"_mode", "pers", "_focus", "0 0 0", "_angle", "0 0 0", NULL};
    static const char *const sun[] = {"_type", "_inf", "_i", "0.7", NULL};
    byte_list content = {0};
    bytes_put_i32(&content, 7);
    vox_put_dict(&content, glass);
    vox_put_chunk(chunks, "MATL", &content);
    for (int32_t id = 0; id < 2; ++id) {
        bytes_put_i32(&content, id);
        vox_put_dict(&content, camera);
        vox_put_chunk(chunks, "rCAM", &content);
    }
    vox_put_dict(&content, sun);
    vox_put_chunk(chunks, "rOBJ", &content);
    bytes_put_i32(&content, 1);
    bytes_put_i32(&content, 4);
    bytes_put_text(&content, "skin");
    vox_put_chunk(chunks, "NOTE", &content);
}

/* The palette from 0 on, its order turned round, and a chunk of a later version, with a child. */
static void put_palette(byte_list *chunks)
{
    byte_list content = {0};
    for (int i = 0; i < 1024; ++i) {
        bytes_put_u8(&content, (uint8_t)(i * 7));
    }
    vox_put_chunk(chunks, "RGBA", &content);
    for (int i = 0; i < 256; ++i) {
        bytes_put_u8(&content, (uint8_t)(255 - i));
    }
    vox_put_chunk(chunks, "IMAP", &content);
    bytes_put_text(chunks, "zNEW");
    bytes_put_i32(chunks, 3);
    bytes_put_i32(chunks, 14);
    bytes_put_text(chunks, "abc");
    bytes_put_text(&content, "de");
    vox_put_chunk(chunks, "SIZE", &content); /* no model: a child is not read */
}

static byte_list full_file(void)
{
    static const int32_t size[3] = {4, 3, 2};
    byte_list chunks = {0};
    for (uint8_t model = 0; model < 4; ++model) { /* model 3 is nowhere */
        const uint8_t voxels[] = {0, 0, 0, (uint8_t)(1 + model), 3, 2, 1, 7};
        vox_put_model(&chunks, size, voxels, 2);
    }
    put_nodes(&chunks);
    put_layers(&chunks);
    put_palette(&chunks);
    put_settings(&chunks);
    return vox_file(200, &chunks);
}

static byte_list copy(const byte_list *file, const svo_voxels_load_options *options, svo_voxel_file_info *info)
{
    byte_list made = {0};
    svo_message message = {""};
    const svo_status status =
        svo_voxels_copy_vox(source_of(file), svo_to_callback(append, &made), options, info, &message);
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), message.text);
    }
    return made;
}

static void test_copy_has_all_chunks(void **state)
{
    (void)state;
    static chunk chunks[CHUNKS_MAX];
    byte_list file = full_file();
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    byte_list made = copy(&file, NULL, &info);
    assert_int_equal(list_chunks(&file, chunks), 4 * 2 + 10 + 2 + 3 + 5);
    expect_same_chunks(&file, &made);
    assert_int_equal(file.count, made.count);
    assert_memory_equal(file.bytes, made.bytes, file.count);
    assert_int_equal(info.format, SVO_VOXEL_FORMAT_VOX);
    assert_int_equal(info.version, 200);
    assert_int_equal(info.models, 4);
    bytes_free(&file);
    bytes_free(&made);
}

static void expect_left_out(const svo_voxel_file_info *info, const char *expected)
{
    svo_message text = {"?"};
    assert_int_equal(svo_voxels_left_out(info, &text), SVO_OK);
    assert_string_equal(text.text, expected);
}

/* What the list of that file lacks, at both frames; hidden instances are no longer missing where they are asked for. */
static void test_what_is_left_out_is_counted(void **state)
{
    (void)state;
    byte_list file = full_file();
    svo_voxels_load_options options = SVO_VOXELS_LOAD_OPTIONS_INIT;
    static const struct {
        uint32_t hidden, frame;
        const char *expected;
    } cases[] = {{0, 0, "the division into 2 instances, 3 models, 1 hidden instance"},
                 {0, 9, "the division into 2 instances, 2 models, 1 hidden instance"},
                 {1, 0, "the division into 3 instances, 2 models"}};
    static const char same[] = ", 2 frames, 3 names, 2 layers, 2 groups, 2 cameras, 1 render setting, 1 list of notes, "
                               "1 order of the palette, 250 colors that no voxel has, 1 chunk of another kind";
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char expected[512];
        svo_voxels *voxels = NULL;
        svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
        svo_voxel_file_info copied = SVO_VOXEL_FILE_INFO_INIT;
        options.hidden = cases[i].hidden;
        options.frame = cases[i].frame;
        assert_int_equal(svo_voxels_load(source_of(&file), &options, &voxels, &info, NULL), SVO_OK);
        (void)snprintf(expected, sizeof expected, "%s%s", cases[i].expected, same);
        expect_left_out(&info, expected);
        byte_list made = copy(&file, &options, &copied);
        assert_memory_equal(&info, &copied, sizeof info);
        assert_int_equal(made.count, file.count);
        svo_voxels_destroy(&voxels);
        bytes_free(&made);
    }
    bytes_free(&file);
}

/* A file of two models without a scene, and one that lacks nothing. */
static void test_left_out_of_small_files(void **state)
{
    (void)state;
    static const int32_t size[3] = {1, 1, 1};
    static const uint8_t voxel[4] = {0, 0, 0, 1};
    for (int models = 1; models <= 2; ++models) {
        byte_list chunks = {0};
        svo_voxels *voxels = NULL;
        svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
        for (int i = 0; i < models; ++i) {
            vox_put_model(&chunks, size, voxel, 1);
        }
        byte_list file = vox_file(150, &chunks);
        assert_int_equal(svo_voxels_load(source_of(&file), NULL, &voxels, &info, NULL), SVO_OK);
        expect_left_out(&info, models == 1 ? "" : "1 model");
        svo_voxels_destroy(&voxels);
        bytes_free(&file);
    }
}

static void test_real_files_are_copied(void **state)
{
    (void)state;
    DIR *folder = opendir(SHARED_SCENES "/vox");
    int copied = 0;
    if (folder == NULL) {
        skip();
    }
    for (const struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        char path[1024];
        (void)snprintf(path, sizeof path, "%s/vox/%s", SHARED_SCENES, entry->d_name);
        if (svo_voxel_format_of_path(path) != SVO_VOXEL_FORMAT_VOX) {
            continue;
        }
        byte_list made = {0};
        byte_list file = {0};
        uint8_t block[4096];
        FILE *stream = fopen(path, "rb");
        assert_non_null(stream);
        for (size_t got = fread(block, 1, sizeof block, stream); got > 0; got = fread(block, 1, sizeof block, stream)) {
            bytes_put(&file, block, got);
        }
        (void)fclose(stream);
        assert_int_equal(svo_voxels_copy_vox(svo_from_path(path), svo_to_callback(append, &made), NULL, NULL, NULL),
                         SVO_OK);
        expect_same_chunks(&file, &made);
        bytes_free(&file);
        bytes_free(&made);
        ++copied;
    }
    (void)closedir(folder);
    assert_true(copied > 0);
}

/* ---- what is refused ---- */

static void refuse_copy(const byte_list *file, const svo_voxels_load_options *options, svo_status expected,
                        const char *words)
{
    byte_list made = {0};
    svo_message message = {""};
    const svo_status status =
        svo_voxels_copy_vox(source_of(file), svo_to_callback(append, &made), options, NULL, &message);
    if (status != expected || strstr(message.text, words) == NULL) {
        fail_msg("%s '%s', expected %s '%s'", svo_name(SVO_NAME_STATUS, status), message.text,
                 svo_name(SVO_NAME_STATUS, expected), words);
    }
    assert_int_equal(made.count, 0);
}

static int write_nothing(void *user, const void *bytes, size_t byte_count)
{
    (void)user;
    (void)bytes;
    (void)byte_count;
    return 1;
}

static void test_refused_copies(void **state)
{
    (void)state;
    svo_message message = {""};
    svo_voxels_load_options few = SVO_VOXELS_LOAD_OPTIONS_INIT;
    svo_voxel_file_info small = {.struct_size = 8};
    byte_list file = full_file();
    few.voxels_max = 3;
    refuse_copy(&file, &few, SVO_INVALID_ARGUMENT, NAME ": 4 voxels are above the limit of 3 (voxels_max)");
    few.voxels_max = 4;
    byte_list made = copy(&file, &few, NULL);
    bytes_free(&made);
    few.axes = 9;
    refuse_copy(&file, &few, SVO_INVALID_ARGUMENT, "svo_voxels_copy_vox: options.axes 9 is not in 0 .. 2");
    assert_int_equal(svo_voxels_copy_vox(source_of(&file), svo_to_callback(append, &made), NULL, &small, &message),
                     SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_voxels_copy_vox(source_of(&file), svo_to_callback(write_nothing, NULL), NULL, NULL, &message),
                     SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "bytes could not be written"));
    assert_int_equal(
        svo_voxels_copy_vox(svo_from_path("no/such.vox"), svo_to_callback(append, &made), NULL, NULL, &message),
        SVO_FILE_ERROR);
    assert_int_equal(made.count, 0);
    file.count -= 1;
    refuse_copy(&file, NULL, SVO_FILE_DAMAGED, "truncated");
    bytes_free(&file);
    bytes_put_text(&file, "#binvox 1\ndim 1 1 1\ndata\n");
    refuse_copy(&file, NULL, SVO_UNSUPPORTED, NAME ": no .vox file of MagicaVoxel");
    bytes_free(&file);
    assert_int_equal(svo_voxels_left_out(NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_voxels_left_out: info is NULL");
    assert_int_equal(svo_voxels_left_out(&small, &message), SVO_INVALID_ARGUMENT);
    small.struct_size = sizeof small;
    assert_int_equal(svo_voxels_left_out(&small, NULL), SVO_INVALID_ARGUMENT);
}

/* ---- other programs' files with the suffix ---- */

static void expect_refused(const byte_list *file, svo_status expected, const char *words)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    const svo_status status = svo_voxels_load(source_of(file), NULL, &voxels, NULL, &message);
    if (status != expected || strstr(message.text, words) == NULL) {
        fail_msg("%s '%s', expected %s '%s'", svo_name(SVO_NAME_STATUS, status), message.text,
                 svo_name(SVO_NAME_STATUS, expected), words);
    }
    assert_null(voxels);
}

static void test_teardown_is_named(void **state)
{
    (void)state;
    byte_list file = {0};
    bytes_put_text(&file, "TDCZ");
    bytes_put_i32(&file, 12345);
    expect_refused(&file, SVO_UNSUPPORTED, NAME ": a .vox file that Teardown compressed (TDCZ)");
    refuse_copy(&file, NULL, SVO_UNSUPPORTED, NAME ": a .vox file that Teardown compressed (TDCZ)");
    bytes_free(&file);
}

/* A file of SLAB6 of 2 x 3 x 4 voxels, all empty but (1, 0, 3), of color 5, and (0, 2, 1), of color 0. */
static byte_list slab6_file(void)
{
    byte_list file = {0};
    for (int32_t side = 2; side <= 4; ++side) {
        bytes_put_i32(&file, side);
    }
    for (int x = 0; x < 2; ++x) {
        for (int y = 0; y < 3; ++y) {
            for (int z = 0; z < 4; ++z) {
                const bool first = x == 1 && y == 0 && z == 3;
                const bool second = x == 0 && y == 2 && z == 1;
                bytes_put_u8(&file, first ? 5 : second ? 0 : 255);
            }
        }
    }
    for (int i = 0; i < 768; ++i) {
        bytes_put_u8(&file, (uint8_t)(i % 64));
    }
    return file;
}

/* z points down and x to the right: as .vox files have it, y and z turn, and what is up stays up in the list. */
static void test_slab6(void **state)
{
    (void)state;
    byte_list file = slab6_file();
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    svo_voxels_info list = SVO_VOXELS_INFO_INIT;
    svo_voxels_load_options options = SVO_VOXELS_LOAD_OPTIONS_INIT;
    static const svo_voxel in_file_axes[2] = {{.x = 1, .y = 2, .z = 0, .rgba = {60, 65, 69, 255}, .material = 6},
                                              {.x = 0, .y = 0, .z = 2, .rgba = {0, 4, 8, 255}, .material = 1}};
    for (int turned = 0; turned < 2; ++turned) {
        options.axes = turned != 0 ? SVO_AXES_AUTO : SVO_AXES_KEEP;
        if (svo_voxels_load(source_of(&file), &options, &voxels, &info, &message) != SVO_OK) {
            fail_msg("%s", message.text);
        }
        assert_int_equal(svo_voxels_get_info(voxels, &list), SVO_OK);
        assert_int_equal(list.voxel_count, 2);
        for (uint64_t i = 0; i < 2; ++i) {
            const svo_voxel *found = &svo_voxels_get(voxels)[i];
            svo_voxel expected = in_file_axes[found->material == 6 ? 0 : 1];
            if (turned != 0) {
                const int32_t y = expected.y;
                expected.y = expected.z;
                expected.z = -1 - y;
            }
            assert_memory_equal(found, &expected, sizeof expected);
        }
        svo_voxels_destroy(&voxels);
    }
    assert_int_equal(info.format, SVO_VOXEL_FORMAT_SLAB6);
    assert_string_equal(svo_name(SVO_NAME_VOXEL_FORMAT, info.format), "slab6");
    refuse_copy(&file, NULL, SVO_UNSUPPORTED, "no .vox file of MagicaVoxel");
    file.bytes[file.count - 1] = 64;
    expect_refused(&file, SVO_FILE_DAMAGED, "palette: 64 is above 63, at byte 803");
    --file.count;
    expect_refused(&file, SVO_FILE_DAMAGED, "byte 0: neither");
    bytes_free(&file);
}

TEST_GROUP(vox_copy)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_copy_has_all_chunks),
        cmocka_unit_test(test_what_is_left_out_is_counted),
        cmocka_unit_test(test_left_out_of_small_files),
        cmocka_unit_test(test_real_files_are_copied),
        cmocka_unit_test(test_refused_copies),
        cmocka_unit_test(test_teardown_is_named),
        cmocka_unit_test(test_slab6),
    };
    return cmocka_run_group_tests_name("vox_copy", tests, NULL, NULL);
}
