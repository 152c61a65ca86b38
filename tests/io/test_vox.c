/* SPDX-License-Identifier: MIT */
/*
 * The .vox reader on files that the test writes: rotations and flips against sums in doubles, nested groups, frames,
 * layers, materials, limits, and the counts of real files.
 */
#include <inttypes.h>
#include <math.h>
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

#define NAME "file.vox"

/* The options with coordinates as they are in the file, z up; given: NULL or those of a test. */
static svo_voxels_load_options keep_axes(const svo_voxels_load_options *given)
{
    svo_voxels_load_options options = SVO_VOXELS_LOAD_OPTIONS_INIT;
    if (given != NULL) {
        options = *given;
    }
    options.axes = SVO_AXES_KEEP;
    return options;
}

/* Reads a file, which must be good, and frees its bytes. */
static svo_voxels *load(byte_list file, const svo_voxels_load_options *options, svo_voxel_file_info *info)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    const svo_voxels_load_options kept = keep_axes(options);
    const svo_status status =
        svo_voxels_load(svo_from_memory(file.bytes, file.count, NAME), &kept, &voxels, info, &message);
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), message.text);
    }
    bytes_free(&file);
    return voxels;
}

/* The same for a file that is refused with a message that has the words. */
static void refuse(byte_list file, const svo_voxels_load_options *options, svo_status expected, const char *words)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    const svo_voxels_load_options kept = keep_axes(options);
    const svo_status status =
        svo_voxels_load(svo_from_memory(file.bytes, file.count, NAME), &kept, &voxels, NULL, &message);
    if (status != expected || strstr(message.text, words) == NULL || strncmp(message.text, NAME ": ", 10) != 0) {
        fail_msg("%s '%s', expected %s '%s'", svo_name(SVO_NAME_STATUS, status), message.text,
                 svo_name(SVO_NAME_STATUS, expected), words);
    }
    assert_null(voxels);
    bytes_free(&file);
}

static svo_voxels_info info_of(const svo_voxels *voxels)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
    return info;
}

static const svo_voxel *find(const svo_voxels *voxels, const int64_t place[3])
{
    const svo_voxel *all = svo_voxels_get(voxels);
    for (uint64_t i = 0; i < info_of(voxels).voxel_count; ++i) {
        if (all[i].x == place[0] && all[i].y == place[1] && all[i].z == place[2]) {
            return &all[i];
        }
    }
    return NULL;
}

/* ---- rotations ---- */

/* A rotation as a matrix, from the bits of its byte. Returns false for a byte that is none. */
static bool matrix_of(int byte, double matrix[3][3])
{
    const int columns[3] = {byte & 3, byte >> 2 & 3, 3 - (byte & 3) - (byte >> 2 & 3)};
    memset(matrix, 0, 9 * sizeof(double));
    if (columns[0] > 2 || columns[1] > 2 || columns[0] == columns[1]) {
        return false;
    }
    for (int row = 0; row < 3; ++row) {
        matrix[row][columns[row]] = (byte >> (4 + row) & 1) != 0 ? -1.0 : 1.0;
    }
    return true;
}

static void apply(double matrix[3][3], const int32_t moved[3], double point[3])
{
    double made[3];
    for (int row = 0; row < 3; ++row) {
        made[row] = moved[row];
        for (int column = 0; column < 3; ++column) {
            made[row] += matrix[row][column] * point[column];
        }
    }
    memcpy(point, made, sizeof made);
}

static const int32_t sizes[][3] = {{1, 1, 1}, {2, 3, 4}, {3, 2, 5}, {4, 4, 2}, {5, 3, 3}};
enum { SIZES = sizeof sizes / sizeof sizes[0], VOXELS_MAX = 64 };

/* A model that is full, with a color for each voxel. Returns how many there are. */
static size_t fill_model(const int32_t size[3], uint8_t voxels[4 * VOXELS_MAX])
{
    size_t count = 0;
    for (int z = 0; z < size[2]; ++z) {
        for (int y = 0; y < size[1]; ++y) {
            for (int x = 0; x < size[0]; ++x, ++count) {
                const uint8_t entry[4] = {(uint8_t)x, (uint8_t)y, (uint8_t)z, (uint8_t)(count + 1)};
                memcpy(voxels + 4 * count, entry, 4);
            }
        }
    }
    return count;
}

/* A model turned by child, in a group turned by parent: each voxel's center, relative to the corner of the model's
   middle voxel, goes through both matrices in doubles. */
static void check_rotation(const int32_t size[3], int child, int parent)
{
    static const int32_t group[] = {2};
    const int32_t child_moved[3] = {5, -7, 11};
    const int32_t parent_moved[3] = {-100, 40, 3};
    uint8_t model[4 * VOXELS_MAX];
    double child_matrix[3][3];
    double parent_matrix[3][3];
    byte_list chunks = {0};
    const size_t count = fill_model(size, model);
    assert_true(matrix_of(child, child_matrix) && matrix_of(parent, parent_matrix));
    vox_put_model(&chunks, size, model, count);
    vox_put_transform(&chunks, 0, 1, -1, parent, parent_moved);
    vox_put_group(&chunks, 1, group, 1);
    vox_put_transform(&chunks, 2, 3, -1, child, child_moved);
    vox_put_shape(&chunks, 3, 0);
    svo_voxels *voxels = load(vox_file(150, &chunks), NULL, NULL);
    assert_int_equal(info_of(voxels).voxel_count, count);
    for (size_t i = 0; i < count; ++i) {
        double point[3];
        int64_t place[3];
        for (int axis = 0; axis < 3; ++axis) {
            point[axis] = model[4 * i + (size_t)axis] + 0.5 - floor(size[axis] / 2.0);
        }
        apply(child_matrix, child_moved, point);
        apply(parent_matrix, parent_moved, point);
        for (int axis = 0; axis < 3; ++axis) {
            place[axis] = (int64_t)floor(point[axis]);
        }
        const svo_voxel *found = find(voxels, place);
        if (found == NULL || found->material != model[4 * i + 3]) {
            fail_msg("size %d %d %d, rotations %d in %d: voxel %zu is not at %" PRId64 " %" PRId64 " %" PRId64, size[0],
                     size[1], size[2], child, parent, i, place[0], place[1], place[2]);
        }
    }
    svo_voxels_destroy(&voxels);
}

static void test_all_48_rotations_of_odd_and_even_sizes(void **state)
{
    (void)state;
    double matrix[3][3];
    int valid = 0;
    for (int child = 0; child < 128; ++child) {
        if (!matrix_of(child, matrix)) {
            continue;
        }
        ++valid;
        for (int size = 0; size < SIZES; ++size) {
            check_rotation(sizes[size], child, 4);
        }
    }
    assert_int_equal(valid, 48);
}

static void test_nested_rotated_groups(void **state)
{
    (void)state;
    double matrix[3][3];
    for (int parent = 0; parent < 128; ++parent) {
        for (int child = 0; child < 128 && matrix_of(parent, matrix); child += 7) {
            if (matrix_of(child, matrix)) {
                check_rotation(sizes[1 + (parent + child) % 4], child, parent);
            }
        }
    }
}

static void test_bytes_that_are_no_rotation_are_damage(void **state)
{
    (void)state;
    double matrix[3][3];
    const uint8_t voxel[4] = {0, 0, 0, 1};
    for (int byte = 0; byte < 260; ++byte) {
        if (byte < 128 && matrix_of(byte, matrix)) {
            continue;
        }
        byte_list chunks = {0};
        vox_put_model(&chunks, sizes[0], voxel, 1);
        vox_put_transform(&chunks, 0, 1, -1, byte, NULL);
        vox_put_shape(&chunks, 1, 0);
        refuse(vox_file(150, &chunks), NULL, SVO_FILE_DAMAGED, "chunk nTRN at byte 64: rotation");
    }
}

/* A file whose model is moved by a text. */
static byte_list moved_file(const char *text)
{
    static const char *const none[] = {NULL};
    static const int32_t numbers[] = {1, -1, -1, 1}; /* child, reserved, layer, frames */
    const char *const pairs[] = {"_t", text, NULL};
    const uint8_t voxel[4] = {0, 0, 0, 1};
    byte_list chunks = {0};
    byte_list content = {0};
    vox_put_model(&chunks, sizes[0], voxel, 1);
    bytes_put_i32(&content, 0);
    vox_put_dict(&content, none);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i) {
        bytes_put_i32(&content, numbers[i]);
    }
    vox_put_dict(&content, pairs);
    vox_put_chunk(&chunks, "nTRN", &content);
    vox_put_shape(&chunks, 1, 0);
    return vox_file(150, &chunks);
}

static void test_numbers_without_spaces_are_damage(void **state)
{
    (void)state;
    static const char *const wrong[] = {"1-2-3", "1 -2-3", "1+2 3", "1\t-2 3", "1 -2", "1 -2 3 4", "1 -2 3x", ""};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        refuse(moved_file(wrong[i]), NULL, SVO_FILE_DAMAGED, "_t is not 3 whole numbers");
    }
    svo_voxels *voxels = load(moved_file("1  -2 3 "), NULL, NULL);
    assert_int_equal(info_of(voxels).low[0], 1);
    assert_int_equal(info_of(voxels).low[1], -2);
    assert_int_equal(info_of(voxels).low[2], 3);
    svo_voxels_destroy(&voxels);
}

/* ---- parts of a file ---- */

static void put_one_voxel(byte_list *chunks, uint8_t index)
{
    const uint8_t voxel[4] = {0, 0, 0, index};
    vox_put_model(chunks, sizes[0], voxel, 1);
}

static void test_default_palette(void **state)
{
    (void)state;
    static const struct {
        uint8_t index;
        uint8_t rgb[3];
    } known[] = {{1, {255, 255, 255}}, {2, {255, 255, 204}}, {7, {255, 204, 255}},   {37, {204, 255, 255}},
                 {215, {0, 0, 51}},    {216, {238, 0, 0}},   {225, {17, 0, 0}},      {226, {0, 238, 0}},
                 {236, {0, 0, 238}},   {245, {0, 0, 17}},    {246, {238, 238, 238}}, {255, {17, 17, 17}}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        byte_list chunks = {0};
        put_one_voxel(&chunks, known[i].index);
        svo_voxels *voxels = load(vox_file(150, &chunks), NULL, NULL);
        const svo_voxel *voxel = svo_voxels_get(voxels);
        if (memcmp(voxel->rgba, known[i].rgb, 3) != 0 || voxel->rgba[3] != 255) {
            fail_msg("entry %d is %d %d %d %d", known[i].index, voxel->rgba[0], voxel->rgba[1], voxel->rgba[2],
                     voxel->rgba[3]);
        }
        svo_voxels_destroy(&voxels);
    }
}

/* Entry i of RGBA is color i + 1; IMAP changes nothing; unknown chunks and their children are skipped; version 200. */
static void test_palette_order_and_unknown_chunks(void **state)
{
    (void)state;
    byte_list chunks = {0};
    byte_list content = {0};
    put_one_voxel(&chunks, 200);
    bytes_put_text(&chunks, "rOBJ");
    bytes_put_i32(&chunks, 3);
    bytes_put_i32(&chunks, 2);
    bytes_put_text(&chunks, "abcde");
    for (int i = 0; i < 256; ++i) {
        const uint8_t color[4] = {(uint8_t)i, (uint8_t)(255 - i), 7, (uint8_t)(i / 2)};
        bytes_put(&content, color, 4);
    }
    vox_put_chunk(&chunks, "RGBA", &content);
    for (int i = 0; i < 256; ++i) {
        bytes_put_u8(&content, (uint8_t)(255 - i));
    }
    vox_put_chunk(&chunks, "IMAP", &content);
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    svo_voxels *voxels = load(vox_file(200, &chunks), NULL, &info);
    const uint8_t expected[4] = {199, 56, 7, 99};
    assert_memory_equal(svo_voxels_get(voxels)->rgba, expected, 4);
    assert_int_equal(svo_voxels_get(voxels)->material, 200);
    assert_int_equal(info.version, 200);
    svo_voxels_destroy(&voxels);
}

/* Without a scene, the frame is the model. Entries with index 0 are empty; of two entries in one place the last one
   counts. */
static void test_packed_models_are_frames(void **state)
{
    (void)state;
    const int32_t size[3] = {4, 4, 4};
    const uint8_t first[] = {3, 0, 1, 5};
    const uint8_t second[] = {0, 1, 2, 6, 1, 1, 1, 0, 2, 2, 2, 7, 2, 2, 2, 8};
    for (uint32_t frame = 0; frame < 3; ++frame) {
        byte_list chunks = {0};
        byte_list content = {0};
        svo_voxels_load_options options = SVO_VOXELS_LOAD_OPTIONS_INIT;
        svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
        options.frame = frame;
        bytes_put_i32(&content, 2);
        vox_put_chunk(&chunks, "PACK", &content);
        vox_put_model(&chunks, size, first, 1);
        vox_put_model(&chunks, size, second, 4);
        if (frame == 2) {
            refuse(vox_file(150, &chunks), &options, SVO_INVALID_ARGUMENT, "frame 2 is not below its 2 models");
            break;
        }
        svo_voxels *voxels = load(vox_file(150, &chunks), &options, &info);
        const int64_t places[2][3] = {{3, 0, 1}, {2, 2, 2}};
        assert_int_equal(info.models, 2);
        assert_int_equal(info.instances, 1);
        assert_int_equal(info.instance_voxels, frame == 0 ? 1 : 3);
        assert_int_equal(info_of(voxels).voxel_count, frame == 0 ? 1 : 2);
        assert_non_null(find(voxels, places[frame]));
        assert_int_equal(find(voxels, places[frame])->material, frame == 0 ? 5 : 8);
        svo_voxels_destroy(&voxels);
    }
}

/* A transform and a shape with frames 0, 10 and 20: asked for 0, 9, 10, 25. */
static void test_keyframes(void **state)
{
    (void)state;
    static const char *const none[] = {NULL};
    static const uint32_t asked[] = {0, 9, 10, 25};
    static const int expected[] = {0, 0, 1, 2};
    static const char *const frames[3][5] = {
        {"_f", "0", "_t", "0 0 0", NULL}, {"_t", "100 0 0", "_f", "10", NULL}, {"_f", "20", "_t", "200 0 0", NULL}};
    for (int i = 0; i < 4; ++i) {
        byte_list chunks = {0};
        byte_list content = {0};
        svo_voxels_load_options options = SVO_VOXELS_LOAD_OPTIONS_INIT;
        options.frame = asked[i];
        for (uint8_t model = 0; model < 3; ++model) {
            put_one_voxel(&chunks, (uint8_t)(model + 1));
        }
        bytes_put_i32(&content, 0);
        vox_put_dict(&content, none);
        bytes_put_i32(&content, 1);
        bytes_put_i32(&content, -1);
        bytes_put_i32(&content, -1);
        bytes_put_i32(&content, 3);
        for (int frame = 0; frame < 3; ++frame) {
            vox_put_dict(&content, frames[frame]);
        }
        vox_put_chunk(&chunks, "nTRN", &content);
        bytes_put_i32(&content, 1);
        vox_put_dict(&content, none);
        bytes_put_i32(&content, 3);
        for (int frame = 2; frame >= 0; --frame) { /* in any order */
            const char *const pairs[] = {"_f", frames[frame][frame == 1 ? 3 : 1], NULL};
            bytes_put_i32(&content, frame);
            vox_put_dict(&content, pairs);
        }
        vox_put_chunk(&chunks, "nSHP", &content);
        svo_voxels *voxels = load(vox_file(150, &chunks), &options, NULL);
        const svo_voxel *voxel = svo_voxels_get(voxels);
        if (voxel->x != 100 * expected[i] || voxel->material != expected[i] + 1) {
            fail_msg("frame %u: x %d, model %d", asked[i], voxel->x, voxel->material - 1);
        }
        svo_voxels_destroy(&voxels);
    }
}

/* Two shapes, one of a hidden layer and one of a hidden transform; a third is seen. Later instances win. */
static void test_hidden_and_overlap(void **state)
{
    (void)state;
    static const int32_t children[] = {2, 4, 6};
    static const char *const hidden[] = {"_name", "off", "_hidden", "1", NULL};
    static const char *const none[] = {NULL};
    for (int asked = 0; asked < 2; ++asked) {
        byte_list chunks = {0};
        byte_list content = {0};
        svo_voxels_load_options options = SVO_VOXELS_LOAD_OPTIONS_INIT;
        svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
        options.hidden = (uint32_t)asked;
        for (uint8_t model = 1; model <= 3; ++model) {
            put_one_voxel(&chunks, model);
        }
        vox_put_transform(&chunks, 0, 1, -1, -1, NULL);
        vox_put_group(&chunks, 1, children, 3);
        vox_put_transform(&chunks, 2, 3, 0, -1, NULL);
        vox_put_transform(&chunks, 4, 5, 1, -1, NULL); /* hidden by its layer */
        bytes_put_i32(&content, 6);
        vox_put_dict(&content, hidden);
        bytes_put_i32(&content, 7);
        bytes_put_i32(&content, -1);
        bytes_put_i32(&content, 0);
        bytes_put_i32(&content, 1);
        vox_put_dict(&content, none);
        vox_put_chunk(&chunks, "nTRN", &content);
        for (int32_t shape = 0; shape < 3; ++shape) {
            vox_put_shape(&chunks, 3 + 2 * shape, shape);
        }
        bytes_put_i32(&content, 1);
        vox_put_dict(&content, hidden);
        bytes_put_i32(&content, -1);
        vox_put_chunk(&chunks, "LAYR", &content);
        svo_voxels *voxels = load(vox_file(150, &chunks), &options, &info);
        assert_int_equal(info.instances, asked != 0 ? 3 : 1);
        assert_int_equal(info.hidden_instances, asked != 0 ? 0 : 2);
        assert_int_equal(info_of(voxels).voxel_count, 1);
        assert_int_equal(svo_voxels_get(voxels)->material, asked != 0 ? 3 : 1);
        svo_voxels_destroy(&voxels);
    }
}

static void put_layer(byte_list *chunks, int32_t id, bool hidden)
{
    static const char *const on[] = {"_hidden", "1", NULL};
    static const char *const off[] = {"_hidden", "0", NULL};
    byte_list content = {0};
    bytes_put_i32(&content, id);
    vox_put_dict(&content, hidden ? on : off);
    bytes_put_i32(&content, -1);
    vox_put_chunk(chunks, "LAYR", &content);
}

/* Layers in any order; the last chunk of an id counts. */
static void test_layers_by_id(void **state)
{
    (void)state;
    enum { LAYERS = 40 };
    byte_list chunks = {0};
    int32_t children[LAYERS];
    uint64_t hidden = 0;
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    put_one_voxel(&chunks, 1);
    for (int32_t i = 0; i < 3 * LAYERS; ++i) {
        put_layer(&chunks, i * 7 % LAYERS, i % 3 == 0);
        hidden += i >= 2 * LAYERS && i % 3 == 0 ? 1 : 0; /* the third chunk of each id */
    }
    for (int32_t i = 0; i < LAYERS; ++i) {
        children[i] = 1 + 2 * i;
        vox_put_transform(&chunks, children[i], children[i] + 1, i, -1, NULL);
        vox_put_shape(&chunks, children[i] + 1, 0);
    }
    vox_put_group(&chunks, 0, children, LAYERS);
    svo_voxels *voxels = load(vox_file(150, &chunks), NULL, &info);
    assert_int_equal(info.hidden_instances, hidden);
    assert_int_equal(info.instances, LAYERS - hidden);
    svo_voxels_destroy(&voxels);
}

static int append(void *user, const void *bytes, size_t byte_count)
{
    bytes_put(user, bytes, byte_count);
    return 0;
}

/* Lists at the ends of the range of coordinates are written and read again. */
static void test_farthest_places(void **state)
{
    (void)state;
    const int32_t most = 1 << 30;
    const svo_voxel lists[2][2] = {
        {{.x = most, .y = most - 1, .z = most - 256, .material = 1}, {.x = most, .y = most, .z = most, .material = 1}},
        {{.x = -most, .y = 1 - most, .z = 255 - most, .material = 1},
         {.x = -most, .y = -most, .z = -most, .material = 1}}};
    for (int i = 0; i < 2; ++i) {
        const svo_voxels_source source = {.struct_size = sizeof source, .voxels = lists[i], .voxel_count = 2};
        svo_voxels *voxels = NULL;
        byte_list file = {0};
        assert_int_equal(svo_voxels_create(&source, &voxels, NULL), SVO_OK);
        assert_int_equal(svo_voxels_set_axes(voxels, SVO_AXES_KEEP), SVO_OK);
        assert_int_equal(svo_voxels_save(voxels, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_VOX, NULL, NULL),
                         SVO_OK);
        svo_voxels *back = load(file, NULL, NULL);
        assert_int_equal(info_of(back).voxel_count, 2);
        assert_memory_equal(svo_voxels_get(back), svo_voxels_get(voxels), 2 * sizeof(svo_voxel));
        svo_voxels_destroy(&back);
        svo_voxels_destroy(&voxels);
    }
}

/* z is up in .vox: (x, y, z) is (x, z, -1 - y) in the list, and back in what is written, palette and all. */
static void test_up_is_turned_and_turned_back(void **state)
{
    (void)state;
    static const svo_voxel given[] = {{.x = -3, .y = 4, .z = 9, .rgba = {9, 8, 7, 255}, .material = 1},
                                      {.x = 5, .y = -6, .z = 0, .rgba = {1, 2, 3, 255}, .material = 2},
                                      {.x = 0, .y = 0, .z = -2, .rgba = {1, 2, 3, 255}, .material = 2}};
    const svo_voxels_source source = {.struct_size = sizeof source, .voxels = given, .voxel_count = 3};
    svo_voxels *z_up = NULL;
    byte_list files[3] = {{0}, {0}, {0}};
    assert_int_equal(svo_voxels_create(&source, &z_up, NULL), SVO_OK);
    assert_int_equal(svo_voxels_set_axes(z_up, SVO_AXES_KEEP), SVO_OK);
    assert_int_equal(svo_voxels_save(z_up, svo_to_callback(append, &files[0]), SVO_VOXEL_FORMAT_VOX, NULL, NULL),
                     SVO_OK);
    for (uint32_t axes = SVO_AXES_AUTO; axes <= SVO_AXES_Z_UP; axes += SVO_AXES_Z_UP) { /* the same for .vox */
        const svo_voxels_load_options options = {.struct_size = sizeof options, .axes = axes};
        svo_voxels *y_up = NULL;
        assert_int_equal(
            svo_voxels_load(svo_from_memory(files[0].bytes, files[0].count, NAME), &options, &y_up, NULL, NULL),
            SVO_OK);
        assert_int_equal(info_of(y_up).voxel_count, 3);
        for (int i = 0; i < 3; ++i) {
            const int64_t place[3] = {given[i].x, given[i].z, -1 - given[i].y};
            const svo_voxel *found = find(y_up, place);
            assert_non_null(found);
            assert_memory_equal(found->rgba, given[i].rgba, 4);
            assert_int_equal(found->material, given[i].material);
        }
        byte_list *file = &files[1 + axes / 2];
        assert_int_equal(svo_voxels_save(y_up, svo_to_callback(append, file), SVO_VOXEL_FORMAT_VOX, NULL, NULL),
                         SVO_OK);
        assert_int_equal(file->count, files[0].count);
        assert_memory_equal(file->bytes, files[0].bytes, file->count);
        svo_voxels_destroy(&y_up);
    }
    svo_voxels_destroy(&z_up);
    for (int i = 0; i < 3; ++i) {
        bytes_free(&files[i]);
    }
}

static void test_axes_that_do_not_exist_are_refused(void **state)
{
    (void)state;
    const svo_voxels_load_options options = {.struct_size = sizeof options, .axes = 3};
    const svo_voxels_source source = {.struct_size = sizeof source};
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    assert_int_equal(svo_voxels_load(svo_from_memory("VOX ", 4, NAME), &options, &voxels, NULL, &message),
                     SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_voxels_load: options.axes 3 is not in 0 .. 2");
    assert_int_equal(svo_voxels_create(&source, &voxels, NULL), SVO_OK);
    assert_int_equal(svo_voxels_set_axes(voxels, (svo_axes)3), SVO_INVALID_ARGUMENT);
    svo_voxels_destroy(&voxels);
}

/* MATL keeps all keys; MATT gets the keys of MATL. */
static void test_materials(void **state)
{
    (void)state;
    static const char *const pairs[] = {"_type", "_glass", "_own key", "kept", "_empty", "", NULL};
    const float values[] = {0.25f, 0.5f, 1.5f};
    byte_list chunks = {0};
    byte_list content = {0};
    put_one_voxel(&chunks, 9);
    bytes_put_i32(&content, 9);
    vox_put_dict(&content, pairs);
    vox_put_chunk(&chunks, "MATL", &content);
    bytes_put_i32(&content, 3);
    bytes_put_i32(&content, 1);
    bytes_put(&content, &values[0], 4);
    bytes_put_i32(&content, 2 | 8);
    bytes_put(&content, &values[1], 8);
    vox_put_chunk(&chunks, "MATT", &content);
    svo_voxels *voxels = load(vox_file(150, &chunks), NULL, NULL);
    static const svo_voxel_property expected[] = {{3, "_ior", "1.5"},     {3, "_rough", "0.5"}, {3, "_type", "_metal"},
                                                  {3, "_weight", "0.25"}, {9, "_empty", ""},    {9, "_own key", "kept"},
                                                  {9, "_type", "_glass"}};
    const size_t count = sizeof expected / sizeof expected[0];
    assert_int_equal(info_of(voxels).property_count, count);
    for (size_t i = 0; i < count; ++i) {
        const svo_voxel_property *one = &svo_voxels_get_properties(voxels)[i];
        assert_int_equal(one->material, expected[i].material);
        assert_string_equal(one->key, expected[i].key);
        assert_string_equal(one->value, expected[i].value);
    }
    svo_voxels_destroy(&voxels);
}

/* ---- limits and damage ---- */

/* A scene of so many groups, one in the other, with a shape at the end. */
static byte_list deep_file(int32_t groups)
{
    byte_list chunks = {0};
    put_one_voxel(&chunks, 1);
    for (int32_t id = 0; id < groups; ++id) {
        const int32_t child = id + 1;
        vox_put_group(&chunks, id, &child, 1);
    }
    vox_put_shape(&chunks, groups, 0);
    return vox_file(150, &chunks);
}

static void test_depth_limit(void **state)
{
    (void)state;
    svo_voxels *voxels = load(deep_file(1023), NULL, NULL);
    assert_int_equal(info_of(voxels).voxel_count, 1);
    svo_voxels_destroy(&voxels);
    refuse(deep_file(1024), NULL, SVO_FILE_DAMAGED, "node 1024 lies deeper than 1024");
}

/* Groups whose children are all the same group, 16 each, and a shape: 16^levels instances. */
static byte_list wide_file(int32_t levels, int32_t more)
{
    byte_list chunks = {0};
    int32_t children[17];
    put_one_voxel(&chunks, 1);
    for (int32_t id = 0; id < levels; ++id) {
        for (int i = 0; i < 17; ++i) {
            children[i] = id + 1;
        }
        vox_put_group(&chunks, id, children, id == 0 ? (size_t)(16 + more) : 16);
    }
    vox_put_shape(&chunks, levels, 0);
    return vox_file(150, &chunks);
}

static void test_instance_limit(void **state)
{
    (void)state;
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    svo_voxels *voxels = load(wide_file(5, 0), NULL, &info);
    assert_int_equal(info.instances, SVO_VOXEL_INSTANCES_MAX);
    assert_int_equal(info_of(voxels).voxel_count, 1);
    svo_voxels_destroy(&voxels);
    refuse(wide_file(5, 1), NULL, SVO_FILE_DAMAGED, "is beyond the limit of instances, 1048576");
}

/* Many visits without an instance end too. */
static void test_empty_groups_end(void **state)
{
    (void)state;
    byte_list chunks = {0};
    put_one_voxel(&chunks, 1);
    for (int32_t id = 0; id < 60; ++id) {
        const int32_t children[2] = {id + 1, id + 1};
        vox_put_group(&chunks, id, children, 2);
    }
    vox_put_group(&chunks, 60, NULL, 0);
    refuse(vox_file(150, &chunks), NULL, SVO_FILE_DAMAGED, "is visited too often");
}

static void test_voxel_limit(void **state)
{
    (void)state;
    svo_voxels_load_options options = SVO_VOXELS_LOAD_OPTIONS_INIT;
    uint8_t model[4 * VOXELS_MAX];
    for (int extra = 0; extra < 2; ++extra) {
        byte_list chunks = {0};
        vox_put_model(&chunks, sizes[1], model, fill_model(sizes[1], model));
        options.voxels_max = 24 - (uint64_t)extra;
        if (extra == 0) {
            svo_voxels *voxels = load(vox_file(150, &chunks), &options, NULL);
            svo_voxels_destroy(&voxels);
        } else {
            refuse(vox_file(150, &chunks), &options, SVO_INVALID_ARGUMENT, "24 voxels are above the limit of 23");
        }
    }
}

/* One chunk with a scene around it, which is damaged in some way. */
static byte_list scene_with(int kind)
{
    byte_list chunks = {0};
    const int32_t self = 1;
    const int32_t far[3] = {INT32_MAX, 0, 0};
    put_one_voxel(&chunks, 1);
    vox_put_transform(&chunks, kind == 0 ? 7 : 0, 1, -1, -1, kind == 5 ? far : NULL);
    if (kind == 1) {
        vox_put_group(&chunks, 1, &self, 1);
    } else if (kind == 2) {
        vox_put_transform(&chunks, 1, 0, -1, -1, NULL);
    } else if (kind == 3) {
        vox_put_shape(&chunks, 1, 1);
    } else if (kind == 4) {
        vox_put_shape(&chunks, 1, 0);
        vox_put_shape(&chunks, 1, 0);
    } else if (kind == 5) {
        vox_put_shape(&chunks, 1, 0);
    }
    return vox_file(150, &chunks);
}

static void test_scenes_that_are_damaged(void **state)
{
    (void)state;
    static const char *const words[] = {"there is no root, 0",
                                        "chunk nGRP at byte 104: node 1 contains itself, by its child 1",
                                        "chunk nTRN at byte 64: node 0 contains itself, by its child 1",
                                        "chunk nSHP at byte 104: node 1 names a model that the file does not have: 1",
                                        "has the id of another node: 1",
                                        "is moved beyond 2^30 along axis 0",
                                        "chunk nTRN at byte 64: node 0 has a child that is not there: 1"};
    for (int kind = 0; kind < 7; ++kind) {
        refuse(scene_with(kind), NULL, SVO_FILE_DAMAGED, words[kind]);
    }
}

/* A chunk of numbers alone. */
static byte_list chunk_file(const char *id, const int32_t *numbers, size_t count)
{
    byte_list chunks = {0};
    byte_list content = {0};
    for (size_t i = 0; i < count; ++i) {
        bytes_put_i32(&content, numbers[i]);
    }
    vox_put_chunk(&chunks, id, &content);
    return vox_file(150, &chunks);
}

static void test_chunks_that_are_damaged(void **state)
{
    (void)state;
    static const struct {
        const char *id;
        int32_t numbers[8];
        size_t count;
        const char *words;
    } cases[] = {
        {"SIZE", {1, 2, 0}, 3, "chunk SIZE at byte 20: size z 0 is not in 1 .. 256, at byte 44"},
        {"SIZE", {1, -2, 5}, 3, "size y -2 is not in 1 .. 256"},
        {"SIZE", {257, 2, 5}, 3, "size x 257"},
        {"SIZE", {1, 2}, 2, "a size ends beyond its chunk, at byte 40"},
        {"SIZE", {1, 2, 3}, 3, "the last SIZE has no XYZI"},
        {"XYZI", {0}, 1, "no SIZE before it"},
        {"PACK", {3}, 1, "0 models, PACK says 3"},
        {"PACK", {-1}, 1, "-1 models"},
        {"RGBA", {1, 2}, 2, "8 bytes of colors, not 1024"},
        {"IMAP", {1, 2}, 2, "8 bytes of indices, not 256"},
        {"MATL", {257, 0}, 2, "material 257 is not in 0 .. 256"},
        {"MATL", {1, 1, 0, 0}, 4, "an attribute without a key"},
        {"MATL", {1, 1, 9, 0}, 4, "a text of 9 bytes, 4 are left"},
        {"MATL", {1, 1, -1, 0}, 4, "a text of -1 bytes"},
        {"MATL", {1, 1, 4, 0}, 4, "a text has a byte 0"},
        {"MATL", {1, 1000000000}, 2, "1000000000 attributes in 0 bytes"},
        {"MATT", {1, 4, 0, 0}, 4, "material type 4 is not in 0 .. 3"},
        {"MATT", {1, 1, 0x7fc00000, 0}, 4, "is not finite"},
        {"nTRN", {0, 0, 1, -1, -1, 0}, 6, "the number of frames is 0"},
        {"nGRP", {0, 0, 3, 1}, 4, "3 children in 4 bytes"},
        {"nSHP", {0, 0, 1, -1, 0}, 5, "model -1 is below 0"},
        {"NOTE", {0}, 1, "no model in it"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        refuse(chunk_file(cases[i].id, cases[i].numbers, cases[i].count), NULL, SVO_FILE_DAMAGED, cases[i].words);
    }
    byte_list chunks = {0};
    const uint8_t outside[4] = {0, 2, 0, 1};
    vox_put_model(&chunks, sizes[0], outside, 1);
    refuse(vox_file(150, &chunks), NULL, SVO_FILE_DAMAGED, "voxel 0: y 2 is not below 1, at byte 60");
    put_one_voxel(&chunks, 1);
    refuse(vox_file(151, &chunks), NULL, SVO_FILE_DAMAGED, "byte 4: version 151 is not known, only 150 and 200");
    put_one_voxel(&chunks, 1);
    byte_list longer = vox_file(150, &chunks);
    bytes_put_u8(&longer, 0);
    refuse(longer, NULL, SVO_FILE_DAMAGED, "it ends at byte 64, the file at 65");
}

/* ---- real files ---- */

typedef struct real_file {
    const char *name;
    uint64_t instances, rotated, instance_voxels, distinct;
    int32_t low[3], high[3]; /* all 0: not compared */
} real_file;

static void test_counts_of_real_files(void **state)
{
    (void)state;
    static const real_file files[] = {
        {"8ontop.vox", 72, 72, 12096, 8946, {-213, -247, 7}, {239, 244, 87}},
        {"test_multiple_model_scene.vox", 104, 87, 12926, 12926, {0}, {0}},
        {"vox_character.vox", 16, 6, 4598, 4260, {0}, {0}},
        {"test_groups.vox", 19, 0, 1754, 1754, {0}, {0}},
        {"robo.vox", 3, 0, 1291, 1291, {-26, 5, 0}, {-4, 26, 30}},
        {"test_meta_chunk.vox", 1, 0, 64000, 64000, {-43, -20, 0}, {-3, 20, 40}},
        {"menger.vox", 1, 0, 160000, 160000, {0, 0, 0}, {81, 81, 81}},
    };
    if (access(SHARED_SCENES "/vox", R_OK) != 0) {
        print_message("skipped: %s is not there\n", SHARED_SCENES "/vox");
        skip();
    }
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        char path[512];
        svo_voxels *voxels = NULL;
        svo_message message = {""};
        svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
        (void)snprintf(path, sizeof path, "%s/vox/%s", SHARED_SCENES, files[i].name);
        const svo_voxels_load_options kept = keep_axes(NULL);
        if (svo_voxels_load(svo_from_path(path), &kept, &voxels, &info, &message) != SVO_OK) {
            fail_msg("%s", message.text);
        }
        const svo_voxels_info list = info_of(voxels);
        if (info.instances != files[i].instances || info.rotated_instances != files[i].rotated ||
            info.instance_voxels != files[i].instance_voxels || list.voxel_count != files[i].distinct) {
            fail_msg("%s: %" PRIu64 " instances, %" PRIu64 " rotated, %" PRIu64 " voxels, %" PRIu64 " distinct",
                     files[i].name, info.instances, info.rotated_instances, info.instance_voxels, list.voxel_count);
        }
        if (files[i].high[2] != 0) {
            assert_memory_equal(list.low, files[i].low, sizeof list.low);
            assert_memory_equal(list.high, files[i].high, sizeof list.high);
        }
        svo_voxels_destroy(&voxels);
    }
}

TEST_GROUP(vox)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_48_rotations_of_odd_and_even_sizes),
        cmocka_unit_test(test_nested_rotated_groups),
        cmocka_unit_test(test_bytes_that_are_no_rotation_are_damage),
        cmocka_unit_test(test_numbers_without_spaces_are_damage),
        cmocka_unit_test(test_default_palette),
        cmocka_unit_test(test_palette_order_and_unknown_chunks),
        cmocka_unit_test(test_packed_models_are_frames),
        cmocka_unit_test(test_keyframes),
        cmocka_unit_test(test_hidden_and_overlap),
        cmocka_unit_test(test_layers_by_id),
        cmocka_unit_test(test_farthest_places),
        cmocka_unit_test(test_up_is_turned_and_turned_back),
        cmocka_unit_test(test_axes_that_do_not_exist_are_refused),
        cmocka_unit_test(test_materials),
        cmocka_unit_test(test_depth_limit),
        cmocka_unit_test(test_instance_limit),
        cmocka_unit_test(test_empty_groups_end),
        cmocka_unit_test(test_voxel_limit),
        cmocka_unit_test(test_scenes_that_are_damaged),
        cmocka_unit_test(test_chunks_that_are_damaged),
        cmocka_unit_test(test_counts_of_real_files),
    };
    return cmocka_run_group_tests_name("vox", tests, NULL, NULL);
}
