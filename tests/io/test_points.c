/* SPDX-License-Identifier: MIT */
/* Point clouds: voxels, colors and counts against sums over all points, whatever the file's form, order and blocks. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>

#include "support/suite.h"
#include "svocl/points.h"
#include "vox_bytes.h"

#define NAME  "cloud"
#define DEPTH 4
#define SIDE  (1 << DEPTH)
#define SCALE 0.001

/* ---- points ---- */

static uint32_t roll(uint32_t *seed, uint32_t limit)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) % limit;
}

/* Points at whole multiples of SCALE, which .las files hold exactly, and floats do not. */
static svo_point *random_points(uint32_t seed, size_t count)
{
    svo_point *points = calloc(count, sizeof *points);
    assert_non_null(points);
    for (size_t i = 0; i < count; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            points[i].at[axis] = (double)((int32_t)roll(&seed, 4000) - 1000) * SCALE + 0.0;
            points[i].rgb[axis] = (uint16_t)(roll(&seed, 65536));
        }
        points[i].intensity = (uint16_t)roll(&seed, 3000);
    }
    return points;
}

/* ---- what voxels must be ---- */

typedef struct reference {
    uint64_t count[SIDE][SIDE][SIDE];
    uint64_t sums[SIDE][SIDE][SIDE][3];
} reference;

/* Sums all points up on the grid that info names. */
static reference *sum_points(const svo_point *points, size_t count, const svo_points_info *info)
{
    reference *sums = calloc(1, sizeof *sums);
    assert_non_null(sums);
    for (size_t i = 0; i < count; ++i) {
        int cell[3];
        for (int axis = 0; axis < 3; ++axis) {
            cell[axis] = (int)floor((points[i].at[axis] - info->origin[axis]) / info->voxel_edge);
            assert_in_range(cell[axis], 0, SIDE - 1);
        }
        ++sums->count[cell[0]][cell[1]][cell[2]];
        for (int channel = 0; channel < 3; ++channel) {
            sums->sums[cell[0]][cell[1]][cell[2]][channel] += points[i].rgb[channel];
        }
    }
    return sums;
}

static svo_voxels_info info_of(const svo_voxels *voxels)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
    return info;
}

/* The list has the voxels with points, their counts and mean colors, of channels up to most. */
static void expect_sums(const svo_voxels *voxels, const reference *sums, uint64_t most)
{
    const uint64_t *counts = svo_voxels_get_counts(voxels);
    uint64_t filled = 0;
    for (int i = 0; i < SIDE * SIDE * SIDE; ++i) {
        filled += (&sums->count[0][0][0])[i] > 0 ? 1 : 0;
    }
    assert_non_null(counts);
    assert_int_equal(info_of(voxels).voxel_count, filled);
    for (uint64_t i = 0; i < filled; ++i) {
        const svo_voxel *voxel = &svo_voxels_get(voxels)[i];
        const uint64_t count = sums->count[voxel->x][voxel->y][voxel->z];
        assert_int_equal(counts[i], count);
        assert_int_equal(voxel->rgba[3], 255);
        for (int channel = 0; channel < 3; ++channel) {
            const uint64_t sum = sums->sums[voxel->x][voxel->y][voxel->z][channel];
            assert_int_equal(voxel->rgba[channel], (2 * 255 * sum + count * most) / (2 * count * most));
        }
    }
}

static void expect_equal(const svo_voxels *a, const svo_voxels *b)
{
    const svo_voxels_info one = info_of(a);
    const svo_voxels_info other = info_of(b);
    assert_memory_equal(&one, &other, sizeof one);
    assert_memory_equal(svo_voxels_get(a), svo_voxels_get(b), one.voxel_count * sizeof(svo_voxel));
    assert_memory_equal(svo_voxels_get_counts(a), svo_voxels_get_counts(b), one.voxel_count * sizeof(uint64_t));
}

/* ---- files ---- */

static void put_u16(byte_list *list, uint32_t value)
{
    bytes_put_u8(list, (uint8_t)value);
    bytes_put_u8(list, (uint8_t)(value >> 8));
}

static void put_u64(byte_list *list, uint64_t value)
{
    bytes_put_i32(list, (int32_t)(uint32_t)value);
    bytes_put_i32(list, (int32_t)(uint32_t)(value >> 32));
}

static void put_double(byte_list *list, double value)
{
    uint64_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    put_u64(list, bits);
}

static void put_zeros(byte_list *list, size_t until)
{
    while (list->count < until) {
        bytes_put_u8(list, 0);
    }
}

/* A .las file. */
typedef struct las_form {
    uint8_t minor, format;
    uint16_t record_bytes;
    uint32_t gap; /* bytes of records between the header and the points */
    double offset;
} las_form;

static byte_list las_header(const las_form *form, size_t count)
{
    byte_list file = {0};
    const uint32_t header_bytes = form->minor == 4 ? 375 : form->minor == 3 ? 235 : 227;
    bytes_put_text(&file, "LASF");
    put_zeros(&file, 24);
    bytes_put_u8(&file, 1);
    bytes_put_u8(&file, form->minor);
    put_zeros(&file, 94);
    put_u16(&file, header_bytes);
    bytes_put_i32(&file, (int32_t)(header_bytes + form->gap));
    bytes_put_i32(&file, 0); /* records before the points */
    bytes_put_u8(&file, form->format);
    put_u16(&file, form->record_bytes);
    bytes_put_i32(&file, form->format < 6 ? (int32_t)count : 0);
    put_zeros(&file, 131);
    for (int axis = 0; axis < 3; ++axis) {
        put_double(&file, SCALE);
    }
    for (int axis = 0; axis < 3; ++axis) {
        put_double(&file, form->offset);
    }
    put_zeros(&file, 247); /* bounds are not looked at */
    if (form->minor == 4) {
        put_u64(&file, count);
    }
    file.count = header_bytes < file.count ? header_bytes : file.count;
    put_zeros(&file, header_bytes + form->gap);
    return file;
}

/* Bytes from the beginning of a record to its color; 0: none. */
static size_t color_place(unsigned format)
{
    static const uint8_t places[] = {0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
    return places[format];
}

static byte_list make_las(const las_form *form, const svo_point *points, size_t count)
{
    byte_list file = las_header(form, count);
    for (size_t i = 0; i < count; ++i) {
        const size_t begin = file.count;
        for (int axis = 0; axis < 3; ++axis) {
            bytes_put_i32(&file, (int32_t)lrint((points[i].at[axis] - form->offset) / SCALE));
        }
        put_u16(&file, points[i].intensity);
        if (color_place(form->format) > 0) {
            put_zeros(&file, begin + color_place(form->format));
            for (int channel = 0; channel < 3; ++channel) {
                put_u16(&file, points[i].rgb[channel]);
            }
        }
        put_zeros(&file, begin + form->record_bytes);
    }
    return file;
}

static void put_big(byte_list *list, const void *bytes, size_t count, bool is_big)
{
    for (size_t i = 0; i < count; ++i) {
        bytes_put_u8(list, ((const uint8_t *)bytes)[is_big ? count - 1 - i : i]);
    }
}

static const char ply_properties[] = "property double x\nproperty int8 between\nproperty double y\nproperty double z\n"
                                     "property ushort red\nproperty ushort green\nproperty ushort blue\n"
                                     "property ushort intensity\nend_header\n";

/* form: "ascii", "binary_little_endian" or "binary_big_endian"; an element lies before the vertices, and one behind. */
static byte_list make_ply(const char *form, const svo_point *points, size_t count)
{
    byte_list file = {0};
    char line[256];
    const bool is_text = form[0] == 'a';
    const bool is_big = strstr(form, "big") != NULL;
    const uint8_t before[] = {1, 0, 2, 0};
    (void)snprintf(line, sizeof line, "ply\nformat %s 1.0\nelement before 2\nproperty short a\nelement vertex %zu\n",
                   form, count);
    bytes_put_text(&file, line);
    bytes_put(&file, ply_properties, sizeof ply_properties - 1);
    bytes_put(&file, is_text ? (const void *)"1\n\n2\n" : before, is_text ? 5 : sizeof before);
    for (size_t i = 0; i < count; ++i) {
        const svo_point *p = &points[i];
        if (is_text) {
            (void)snprintf(line, sizeof line, "%.17g 7 %.17g\t%.17g %u %u %u %u %s", p->at[0], p->at[1], p->at[2],
                           p->rgb[0], p->rgb[1], p->rgb[2], p->intensity, i % 2 == 0 ? "\r\n" : "\n");
            bytes_put_text(&file, line);
            continue;
        }
        put_big(&file, &p->at[0], 8, is_big);
        bytes_put_u8(&file, 99);
        put_big(&file, &p->at[1], 8, is_big);
        put_big(&file, &p->at[2], 8, is_big);
        for (int channel = 0; channel < 3; ++channel) {
            put_big(&file, &p->rgb[channel], 2, is_big);
        }
        put_big(&file, &p->intensity, 2, is_big);
    }
    bytes_put_text(&file, is_text ? "" : "more");
    return file;
}

/* ---- calls ---- */

static svo_points_options options_of(uint32_t depth)
{
    return (svo_points_options){.struct_size = sizeof(svo_points_options), .depth = depth, .axes = SVO_AXES_KEEP};
}

static svo_status load(const byte_list *file, const svo_points_options *options, svo_voxels **out,
                       svo_points_info *info, svo_message *message)
{
    *info = (svo_points_info)SVO_POINTS_INFO_INIT;
    return svo_points_load(svo_from_memory(file->bytes, file->count, NAME), options, out, info, message);
}

static svo_voxels *load_well(const byte_list *file, const svo_points_options *options, svo_points_info *info)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    if (load(file, options, &voxels, info, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return voxels;
}

static svo_voxels *collect_well(const svo_point *points, size_t count, const svo_points_options *options,
                                svo_points_info *info)
{
    svo_points_source source = SVO_POINTS_SOURCE_INIT;
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    source.points = points;
    source.point_count = count;
    *info = (svo_points_info)SVO_POINTS_INFO_INIT;
    if (svo_points_collect(&source, options, &voxels, info, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return voxels;
}

/* ---- tests ---- */

#define COUNT 3000

static void test_forms_of_las(void **state)
{
    (void)state;
    static const uint16_t bytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    svo_point *points = random_points(1, COUNT);
    for (uint8_t format = 0; format <= 10; ++format) {
        const las_form form = {.minor = format < 6 ? format % 4 : 4,
                               .format = format,
                               .record_bytes = (uint16_t)(bytes[format] + format % 3 * 5),
                               .gap = 7u * format,
                               .offset = format == 3 ? 0.25 : 0.0};
        svo_points_info info;
        const svo_points_options options = options_of(DEPTH);
        byte_list file = make_las(&form, points, COUNT);
        svo_voxels *voxels = load_well(&file, &options, &info);
        assert_int_equal(info.format, SVO_VOXEL_FORMAT_LAS);
        assert_int_equal(info.version, 10 + form.minor);
        assert_int_equal(info.point_format, format);
        assert_int_equal(info.point_count, COUNT);
        assert_int_equal(info.taken_count, COUNT);
        assert_int_equal(info.color, color_place(format) > 0 ? SVO_POINTS_RGB : SVO_POINTS_INTENSITY);
        svo_point *expected = malloc(COUNT * sizeof *expected);
        assert_non_null(expected);
        memcpy(expected, points, COUNT * sizeof *expected);
        for (size_t i = 0; i < COUNT; ++i) {
            for (int channel = 0; channel < 3; ++channel) {
                /* What the file's whole numbers stand for, and intensities in place of colors. */
                expected[i].at[channel] = rint((points[i].at[channel] - form.offset) / SCALE) * SCALE + form.offset;
                expected[i].rgb[channel] = color_place(format) > 0 ? points[i].rgb[channel] : points[i].intensity;
            }
        }
        reference *sums = sum_points(expected, COUNT, &info);
        expect_sums(voxels, sums, color_place(format) > 0 ? 65535 : info.intensity_max);
        free(sums);
        free(expected);
        svo_voxels_destroy(&voxels);
        bytes_free(&file);
    }
    free(points);
}

static void test_forms_of_ply(void **state)
{
    (void)state;
    static const char *const forms[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const svo_points_options options = options_of(DEPTH);
    svo_point *points = random_points(2, COUNT);
    svo_points_info info;
    svo_voxels *given = collect_well(points, COUNT, &options, &info);
    reference *sums = sum_points(points, COUNT, &info);
    expect_sums(given, sums, 65535);
    assert_int_equal(info.format, SVO_VOXEL_FORMAT_AUTO);
    for (size_t i = 0; i < 3; ++i) {
        byte_list file = make_ply(forms[i], points, COUNT);
        svo_voxels *read = load_well(&file, &options, &info);
        assert_int_equal(info.format, SVO_VOXEL_FORMAT_PLY);
        assert_int_equal(svo_points_format(svo_from_memory(file.bytes, file.count, NAME)), SVO_VOXEL_FORMAT_PLY);
        expect_equal(given, read);
        svo_voxels_destroy(&read);
        bytes_free(&file);
    }
    svo_voxels_destroy(&given);
    free(sums);
    free(points);
}

/* A caller's points, from the last to the first. */
static int give_reversed(void *user, uint64_t first, svo_point *points, size_t count)
{
    const svo_points_source *all = user;
    for (size_t i = 0; i < count; ++i) {
        points[i] = all->points[all->point_count - 1 - first - i];
    }
    return 0;
}

/* Many blocks of points, by a low limit of memory, make the voxels that one makes; so do points in another order. */
static void test_blocks_and_orders(void **state)
{
    (void)state;
    enum { MANY = 90000 };
    svo_point *points = random_points(3, MANY);
    svo_points_options options = options_of(DEPTH);
    svo_points_info info;
    svo_voxels *whole = collect_well(points, MANY, &options, &info);
    reference *sums = sum_points(points, MANY, &info);
    expect_sums(whole, sums, 65535);
    options.memory_bytes = SVO_POINTS_MEMORY_MIN;
    svo_voxels *blocks = collect_well(points, MANY, &options, &info);
    expect_equal(whole, blocks);
    svo_points_source all = SVO_POINTS_SOURCE_INIT;
    all.points = points;
    all.point_count = MANY;
    svo_points_source source = SVO_POINTS_SOURCE_INIT;
    source.read = give_reversed;
    source.user = &all;
    source.point_count = MANY;
    svo_voxels *reversed = NULL;
    assert_int_equal(svo_points_collect(&source, &options, &reversed, NULL, NULL), SVO_OK);
    expect_equal(whole, reversed);
    svo_voxels_destroy(&whole);
    svo_voxels_destroy(&blocks);
    svo_voxels_destroy(&reversed);
    free(sums);
    free(points);
}

/* Where a point at (x, 0, 0) goes. */
static void expect_place(const svo_voxels *voxels, uint64_t index, int32_t x)
{
    assert_true(index < info_of(voxels).voxel_count);
    assert_int_equal(svo_voxels_get(voxels)[index].x, x);
}

static void test_grids(void **state)
{
    (void)state;
    const svo_point points[] = {{.at = {-1.0, 0.0, 0.0}}, {.at = {0.5, 0.0, 0.0}}, {.at = {1.0, 0.0, 0.0}}};
    svo_points_options options = options_of(2);
    svo_points_info info;
    svo_voxels *voxels = collect_well(points, 3, &options, &info);
    assert_true(info.origin[0] == -1.0 && info.voxel_edge == nextafter(0.5, 1.0)); /* the greatest is in the last */
    assert_int_equal(info_of(voxels).voxel_count, 3);
    expect_place(voxels, 0, 0);
    expect_place(voxels, 1, 2); /* with 0.5 it were 3, for a plane belongs to the voxel above it */
    expect_place(voxels, 2, 3);
    assert_int_equal(info_of(voxels).depth, 2);
    svo_voxels_destroy(&voxels);

    options = (svo_points_options){.struct_size = sizeof options, .voxel_edge = 0.75};
    voxels = collect_well(points, 3, &options, &info);
    assert_true(info.origin[0] == -1.5 && info.voxel_edge == 0.75);
    expect_place(voxels, 0, 0);
    expect_place(voxels, 1, 2);
    expect_place(voxels, 2, 3);
    assert_true(info_of(voxels).origin[0] == -1.5);
    svo_voxels_destroy(&voxels);

    options = (svo_points_options){.struct_size = sizeof options, .depth = 3, .edge = 2.0, .origin = {-1.0, 0.0, -0.5}};
    voxels = collect_well(points, 3, &options, &info); /* the far face does not belong to the cube */
    assert_int_equal(info.outside_count, 1);
    assert_int_equal(info.taken_count, 2);
    assert_true(info.voxel_edge == 0.25 && info.high[0] == 0.5);
    expect_place(voxels, 0, 0);
    expect_place(voxels, 1, 6);
    assert_int_equal(svo_voxels_get(voxels)[0].z, 2);
    assert_true(info_of(voxels).origin[0] == -1.0);
    svo_voxels_destroy(&voxels);

    options = options_of(16);
    voxels = collect_well(points, 1, &options, &info);
    assert_true(info.voxel_edge == 1.0 && info.voxel_count == 1);
    svo_voxels_destroy(&voxels);
    voxels = collect_well(points, 0, &options, &info);
    assert_int_equal(info.voxel_count, 0);
    svo_voxels_destroy(&voxels);
}

static void test_axes(void **state)
{
    (void)state;
    const svo_point points[] = {{.at = {1.0, 2.0, 3.0}}, {.at = {2.0, 4.0, 3.5}}};
    const las_form form = {.minor = 2, .record_bytes = 20};
    byte_list file = make_las(&form, points, 2);
    const svo_points_options options = {.struct_size = sizeof options, .voxel_edge = 0.5};
    svo_points_info info;
    svo_voxels *voxels = load_well(&file, &options, &info);
    assert_true(info.low[0] == 1.0 && info.low[1] == 3.0 && info.low[2] == -4.0);
    assert_true(info.high[2] == -2.0);
    assert_true(info.origin[1] == 3.0 && info.origin[2] == -4.0);
    assert_int_equal(svo_voxels_get(voxels)[1].z, 4); /* of the first point, at -2 */
    svo_voxels_destroy(&voxels);
    bytes_free(&file);
}

static void expect_color(const svo_point *points, size_t count, svo_points_color color, uint32_t most,
                         const uint8_t expected[3])
{
    svo_points_info info;
    const svo_points_options options = {.struct_size = sizeof options, .depth = 1};
    svo_voxels *voxels = collect_well(points, count, &options, &info);
    assert_int_equal(info.color, color);
    assert_int_equal(info.rgb_max, most);
    assert_int_equal(info_of(voxels).voxel_count, 1);
    assert_memory_equal(svo_voxels_get(voxels)[0].rgba, expected, 3);
    svo_voxels_destroy(&voxels);
}

static void test_colors(void **state)
{
    (void)state;
    svo_point points[4] = {{.rgb = {0, 255, 3}}, {.rgb = {1, 255, 4}}, {.rgb = {0, 255, 4}}, {.rgb = {1, 255, 4}}};
    expect_color(points, 4, SVO_POINTS_RGB, 255, (const uint8_t[]){1, 255, 4}); /* halves are rounded up */
    expect_color(points, 3, SVO_POINTS_RGB, 255, (const uint8_t[]){0, 255, 4});
    points[0].rgb[0] = 65535;
    expect_color(points, 1, SVO_POINTS_RGB, 65535, (const uint8_t[]){255, 1, 0});
    const svo_point gray[2] = {{.intensity = 100}, {.intensity = 400}};
    expect_color(gray, 2, SVO_POINTS_INTENSITY, 0, (const uint8_t[]){159, 159, 159});
    const svo_point plain[1] = {{.intensity = 0}};
    expect_color(plain, 1, SVO_POINTS_WHITE, 0, (const uint8_t[]){255, 255, 255});
}

/* Types of channels: bytes, fractions, signed bytes; a float of another name is left out. */
static void test_ply_colors(void **state)
{
    (void)state;
    static const struct {
        const char *types, *values;
        uint8_t expected[3];
    } cases[] = {{"uchar uchar uchar", "7 0 300", {7, 0, 255}},
                 {"float float float", "0.5 1 -2", {128, 255, 0}},
                 {"char char char", "-127 0 127", {0, 127, 254}},
                 {"ushort ushort ushort", "65535 128 129", {255, 0, 1}}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[512];
        char types[3][8];
        assert_int_equal(sscanf(cases[i].types, "%7s %7s %7s", types[0], types[1], types[2]), 3);
        const int length = snprintf(text, sizeof text,
                                    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                                    "property float z\nproperty %s red\nproperty %s green\nproperty %s blue\n"
                                    "property float scalar_Intensity\nend_header\n1 2 3 %s 0.25",
                                    types[0], types[1], types[2], cases[i].values);
        byte_list file = {0};
        svo_points_info info;
        const svo_points_options options = options_of(1);
        bytes_put(&file, text, (size_t)length);
        svo_voxels *voxels = load_well(&file, &options, &info);
        assert_memory_equal(svo_voxels_get(voxels)[0].rgba, cases[i].expected, 3);
        assert_int_equal(info.intensity_max, 0);
        svo_voxels_destroy(&voxels);
        bytes_free(&file);
    }
}

static unsigned warnings;

static void count_warning(void *user, svo_log_level level, const char *text)
{
    (void)user;
    assert_int_equal(level, SVO_LOG_WARNING);
    assert_ptr_equal(strstr(text, NAME ": 1 of 3 points are left out: "), text);
    ++warnings;
}

/* Withheld points and those at no place are left out, are counted, and do not move the bounds. */
static void test_left_out(void **state)
{
    (void)state;
    svo_point points[] = {{.at = {1, 2, 3}}, {.at = {9, 9, 9}}, {.at = {2, 2, 2}}};
    svo_points_options options = options_of(1);
    svo_points_info info;
    options.log = count_warning;
    warnings = 0;
    for (unsigned i = 0; i < 3; ++i) {
        const las_form form = {.minor = i < 2 ? (uint8_t)i : 4, .format = i < 2 ? 0 : 6, .record_bytes = 30};
        byte_list file = make_las(&form, points, 3);
        const size_t second = file.count - 2 * (size_t)form.record_bytes;
        file.bytes[second + 15] = i < 2 ? 0x80 : 4;
        svo_voxels *voxels = load_well(&file, &options, &info);
        assert_int_equal(info.withheld_count, i > 0 ? 1 : 0); /* version 1.0 has no such flag */
        assert_int_equal(info.taken_count, i > 0 ? 2 : 3);
        assert_true(info.high[0] == (i > 0 ? 2.0 : 9.0));
        svo_voxels_destroy(&voxels);
        bytes_free(&file);
    }
    points[1].at[2] = NAN;
    byte_list file = make_ply("binary_big_endian", points, 3);
    svo_voxels *voxels = load_well(&file, &options, &info);
    assert_int_equal(info.not_finite_count, 1);
    assert_true(info.high[0] == 2.0);
    assert_int_equal(warnings, 3);
    svo_voxels_destroy(&voxels);
    bytes_free(&file);
}

static void test_counts_as_materials(void **state)
{
    (void)state;
    svo_point *points = calloc(70003, sizeof *points);
    svo_points_options options = options_of(1);
    svo_points_info info;
    assert_non_null(points);
    for (int i = 0; i < 3; ++i) {
        points[i].at[0] = 1.0;
    }
    svo_voxels *voxels = collect_well(points, 70003, &options, &info);
    assert_int_equal(info.count_max, 70000);
    assert_int_equal(svo_voxels_get(voxels)[0].material, 0);
    svo_voxels_destroy(&voxels);
    options.counts = 1;
    voxels = collect_well(points, 70003, &options, &info);
    assert_int_equal(svo_voxels_get(voxels)[0].material, 65534);
    assert_int_equal(svo_voxels_get(voxels)[1].material, 3);
    assert_int_equal(svo_voxels_get_counts(voxels)[0], 70000);
    svo_voxels_destroy(&voxels);
    free(points);
}

/* ---- refusals ---- */

static void expect_refusal(const byte_list *file, const svo_points_options *options, svo_status status,
                           const char *words)
{
    svo_voxels *voxels = NULL;
    svo_points_info info;
    svo_message message = {""};
    const svo_status got = load(file, options, &voxels, &info, &message);
    if (got != status || strstr(message.text, words) == NULL || voxels != NULL) {
        fail_msg("%s '%s', expected '%s'", svo_name(SVO_NAME_STATUS, got), message.text, words);
    }
}

static void test_limits(void **state)
{
    (void)state;
    svo_point *points = random_points(5, 40000);
    const las_form form = {.minor = 2, .format = 2, .record_bytes = 26};
    byte_list file = make_las(&form, points, 40000);
    svo_points_options options = options_of(10);
    options.voxels_max = 1000;
    expect_refusal(&file, &options, SVO_INVALID_ARGUMENT, "more than 1000 voxels, the limit (voxels_max)");
    options.voxels_max = 0;
    options.memory_bytes = SVO_POINTS_MEMORY_MIN;
    expect_refusal(&file, &options, SVO_OUT_OF_HOST_MEMORY, "4.0 MiB of memory has room (memory_bytes)");
    options.memory_bytes = SVO_POINTS_MEMORY_MIN - 1;
    expect_refusal(&file, &options, SVO_INVALID_ARGUMENT, "options.memory_bytes");
    options = options_of(17);
    expect_refusal(&file, &options, SVO_INVALID_ARGUMENT, "options.depth 17 is not in 0 .. 16");
    options = options_of(3);
    options.origin[1] = 1.0;
    expect_refusal(&file, &options, SVO_INVALID_ARGUMENT, "options.origin 1 is not 0, as it must be without edge");
    options.edge = 1.0;
    options.voxel_edge = 1.0;
    expect_refusal(&file, &options, SVO_INVALID_ARGUMENT, "options.edge 1 is not 0, as it must be with voxel_edge");
    options = options_of(0);
    options.voxel_edge = 1e-7;
    expect_refusal(&file, &options, SVO_INVALID_ARGUMENT, "are more than 2097152 voxels of width 1e-07");
    options.voxel_edge = -1.0;
    expect_refusal(&file, &options, SVO_INVALID_ARGUMENT, "options.voxel_edge -1");
    options.voxel_edge = 0.0;
    options.axes = 3;
    expect_refusal(&file, &options, SVO_INVALID_ARGUMENT, "options.axes 3");
    bytes_free(&file);
    free(points);
}

/* Other bytes in the header of a file of two points. */
static void test_damaged_las(void **state)
{
    (void)state;
    static const struct {
        size_t at;
        uint8_t byte;
        const char *words;
    } cases[] = {{24, 2, "version 2.4 is not in 1.0 .. 1.4, at byte 24"},
                 {25, 5, "version 1.5"},
                 {94, 100, "a header of 356 bytes, where 375 to"},
                 {95, 9, "bytes, where 375 to"},
                 {96, 0, "points begin at 256, which is in the header"},
                 {99, 9, "which is in the header or behind the file's"},
                 {104, 11, "point format 11 is above 10, at byte 104"},
                 {105, 29, "points of 29 bytes, where format 6 has 30, at byte 105"},
                 {107, 3, "2 points, and 3 in the field of older versions"},
                 {138, 0x7f, "scale inf or offset 0 of x"},
                 {170, 0x7f, "of y is not a finite number"},
                 {247, 3, "3 points of 30 bytes, where the file has room for 2, at byte 247"},
                 {254, 9, "where the file has room for 2, at byte 247"}};
    const svo_point points[2] = {{.at = {1, 2, 3}}, {.at = {2, 3, 4}}};
    const las_form form = {.minor = 4, .format = 6, .record_bytes = 30};
    const svo_points_options options = options_of(1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        byte_list file = make_las(&form, points, 2);
        file.bytes[cases[i].at] = cases[i].byte;
        if (cases[i].at == 138 || cases[i].at == 170) { /* the second highest byte: an infinity */
            memset(file.bytes + cases[i].at - 7, 0, 6);
            file.bytes[cases[i].at - 1] = 0xf0;
        }
        expect_refusal(&file, &options, SVO_FILE_DAMAGED, cases[i].words);
        bytes_free(&file);
    }
    byte_list file = make_las(&form, points, 2);
    file.bytes[104] |= 0x80;
    expect_refusal(&file, &options, SVO_UNSUPPORTED, "a compressed file (LAZ)");
    assert_int_equal(svo_points_format(svo_from_memory(file.bytes, file.count, NAME)), SVO_VOXEL_FORMAT_LAZ);
    memset(file.bytes + 131, 0, 8);
    file.bytes[104] = 6;
    expect_refusal(&file, &options, SVO_FILE_DAMAGED, "scale 0");
    file.count = 100;
    expect_refusal(&file, &options, SVO_FILE_DAMAGED, "the file ends in the header, at byte 100");
    assert_int_equal(svo_points_format(svo_from_memory(file.bytes, file.count, NAME)), SVO_VOXEL_FORMAT_LAS);
    file.bytes[0] = 'M';
    expect_refusal(&file, &options, SVO_FILE_DAMAGED, "byte 0: neither a .ply nor a .las file");
    bytes_free(&file);
}

#define PLY_BEGIN "ply\nformat ascii 1.0\n"
#define PLY_XYZ   "property float x\nproperty float y\nproperty float z\n"

static void test_damaged_ply(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        svo_status status;
        const char *words;
    } cases[] = {{"ply\n", SVO_FILE_DAMAGED, "the header, before byte 4: line 2"},
                 {PLY_BEGIN "element face 1\nproperty int a\nend_header\n1\n", SVO_FILE_DAMAGED, "no element vertex"},
                 {PLY_BEGIN "element vertex 1\nproperty int x\nproperty int z\nend_header\n1 1\n", SVO_FILE_DAMAGED,
                  "element vertex has no property y"},
                 {PLY_BEGIN "element vertex 9\n" PLY_XYZ "end_header\n1 1 1\n", SVO_FILE_DAMAGED,
                  "9 of element vertex, where there is room for 1"},
                 {PLY_BEGIN "element vertex 1\n" PLY_XYZ "end_header\n1 1a 1\n", SVO_FILE_DAMAGED,
                  "line 8: '1a' is not a number, at byte"},
                 {PLY_BEGIN "element vertex 1\n" PLY_XYZ "end_header\n1 11111\n", SVO_FILE_DAMAGED,
                  "where another value is declared"},
                 {PLY_BEGIN "element vertex 1\n" PLY_XYZ "end_header\n1 1 1 5\n", SVO_FILE_DAMAGED,
                  "'5' behind the last value that is declared"},
                 {PLY_BEGIN "element vertex 2\n" PLY_XYZ "end_header\n1 2222222 3\n\n", SVO_FILE_DAMAGED,
                  "line 10: the file ends in vertex 1 of 2"},
                 {PLY_BEGIN "element vertex 1\n" PLY_XYZ "property list uchar int more\nend_header\n1 1 1 0\n",
                  SVO_UNSUPPORTED, "element vertex has a list"},
                 {PLY_BEGIN "element vertex 1\n" PLY_XYZ
                            "property uchar red\nproperty float blue\nend_header\n1 1 1 0 0 0\n",
                  SVO_UNSUPPORTED, "channels have different types"},
                 {"ply\nformat binary_little_endian 1.0\nelement other 1\nproperty list uchar int more\nelement vertex "
                  "1\n" PLY_XYZ "end_header\n1234567890123",
                  SVO_UNSUPPORTED, "element other, which has lists, comes before"},
                 {"ply\nformat binary_little_endian 1.0\nelement other 9\nproperty int a\nelement vertex 1\n" PLY_XYZ
                  "end_header\n1234567890123",
                  SVO_FILE_DAMAGED, "9 of element other do not fit in the 13 bytes"}};
    const svo_points_options options = options_of(1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        byte_list file = {0};
        bytes_put_text(&file, cases[i].text);
        expect_refusal(&file, &options, cases[i].status, cases[i].words);
        bytes_free(&file);
    }
}

/* Each file cut off at each byte, and with each byte of its beginning changed, is read or refused with its name. */
static void try_variants(const byte_list *file)
{
    const svo_points_options options = options_of(3);
    for (size_t i = 0; i < 2 * file->count; ++i) {
        byte_list other = {0};
        svo_points_info info;
        svo_voxels *voxels = NULL;
        svo_message message = {""};
        bytes_put(&other, file->bytes, i < file->count ? i : file->count);
        bytes_put(&other, "", 0);
        if (i >= file->count) {
            other.bytes[i - file->count] ^= (uint8_t)(1u << i % 8);
        } else if (i == 0) {
            bytes_put_u8(&other, 0);
            other.count = 0;
        }
        const svo_status status = load(&other, &options, &voxels, &info, &message);
        assert_true((status == SVO_OK) == (voxels != NULL));
        assert_true(status == SVO_OK || strncmp(message.text, NAME ": ", strlen(NAME ": ")) == 0);
        assert_true(status != SVO_FILE_DAMAGED || strstr(message.text, "byte") != NULL);
        (void)svo_points_format(svo_from_memory(other.bytes, other.count, NAME));
        svo_voxels_destroy(&voxels);
        bytes_free(&other);
    }
}

static void test_variants(void **state)
{
    (void)state;
    svo_point *points = random_points(6, 5);
    const las_form form = {.minor = 4, .format = 7, .record_bytes = 36};
    byte_list files[] = {make_las(&form, points, 5), make_ply("ascii", points, 5),
                         make_ply("binary_big_endian", points, 5)};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        try_variants(&files[i]);
        bytes_free(&files[i]);
    }
    free(points);
}

static int fail_at_once(void *user, uint64_t first, svo_point *points, size_t count)
{
    (void)user;
    (void)first;
    (void)points;
    (void)count;
    return 1;
}

/* Gives other points at the second reading. */
static int change_mind(void *user, uint64_t first, svo_point *points, size_t count)
{
    int *calls = user;
    memset(points, 0, count * sizeof *points);
    points[0].at[0] = first == 0 && (*calls)++ > 0 ? 5.0 : 0.0;
    return 0;
}

static void test_callers(void **state)
{
    (void)state;
    svo_points_source source = SVO_POINTS_SOURCE_INIT;
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    int calls = 0;
    source.point_count = 5;
    assert_int_equal(svo_points_collect(&source, NULL, &voxels, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "source.points and source.read are NULL"));
    source.read = fail_at_once;
    assert_int_equal(svo_points_collect(&source, NULL, &voxels, NULL, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "source.read failed at point 0"));
    source.read = change_mind;
    source.user = &calls;
    assert_int_equal(svo_points_collect(&source, NULL, &voxels, NULL, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "changed while they were read"));
    const svo_point bright = {.rgb = {256, 0, 0}};
    source.points = &bright;
    source.point_count = 1;
    source.rgb_max = 255;
    assert_int_equal(svo_points_collect(&source, NULL, &voxels, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "a color channel of 256 is above rgb_max 255"));
    source.rgb_max = 254;
    assert_int_equal(svo_points_collect(&source, NULL, &voxels, NULL, &message), SVO_INVALID_ARGUMENT);
    source.point_count = SVO_POINTS_MAX + 1;
    assert_int_equal(svo_points_collect(&source, NULL, &voxels, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_points_collect(NULL, NULL, &voxels, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_null(voxels);
}

/* Memory that runs out at one allocation, and what is not released. */
typedef struct short_memory {
    int left; /* allocations until one fails */
    int blocks;
} short_memory;

static void *allocate_some(void *user, size_t bytes, size_t alignment)
{
    short_memory *memory = user;
    if (memory->left-- == 0) {
        return NULL;
    }
    ++memory->blocks;
    assert_true(alignment <= _Alignof(max_align_t));
    return malloc(bytes);
}

static void release_some(void *user, void *block, size_t bytes, size_t alignment)
{
    short_memory *memory = user;
    (void)bytes;
    (void)alignment;
    --memory->blocks;
    free(block);
}

/* Whichever allocation fails, the call says so and keeps nothing. */
static void test_short_memory(void **state)
{
    (void)state;
    enum { MANY = 40000 };
    svo_point *points = random_points(8, MANY);
    const las_form form = {.minor = 2, .format = 2, .record_bytes = 26};
    byte_list file = make_las(&form, points, MANY);
    int failures = 0;
    bool ran_out = true;
    for (int place = 0; ran_out; ++place) {
        short_memory memory = {.left = place};
        const svo_memory_callbacks callbacks = {
            .struct_size = sizeof callbacks, .allocate = allocate_some, .release = release_some, .user = &memory};
        svo_points_options options = options_of(4);
        svo_voxels *voxels = NULL;
        svo_points_info info;
        svo_message message = {""};
        options.memory = &callbacks;
        options.memory_bytes = SVO_POINTS_MEMORY_MIN;
        const svo_status status = load(&file, &options, &voxels, &info, &message);
        ran_out = memory.left < 0;
        failures += status == SVO_OUT_OF_HOST_MEMORY ? 1 : 0;
        /* A run that cannot be made smaller stays as large as it is. */
        assert_true(status == SVO_OK || (ran_out && status == SVO_OUT_OF_HOST_MEMORY));
        assert_true((status == SVO_OK) == (voxels != NULL));
        svo_voxels_destroy(&voxels);
        assert_int_equal(memory.blocks, 0);
    }
    assert_true(failures > 10);
    bytes_free(&file);
    free(points);
}

/* Meshes are no clouds; what cannot be read is none either. */
static void test_formats(void **state)
{
    (void)state;
    static const char mesh[] = PLY_BEGIN "element vertex 1\n" PLY_XYZ "element face 1\nproperty list uchar int i\n"
                                         "end_header\n1 1 1\n0\n";
    static const char none[] = PLY_BEGIN "element vertex 1\n" PLY_XYZ "element face 0\nproperty list uchar int i\n"
                                         "end_header\n1 1 1\n";
    assert_int_equal(svo_points_format(svo_from_memory(mesh, sizeof mesh - 1, NAME)), SVO_VOXEL_FORMAT_AUTO);
    assert_int_equal(svo_points_format(svo_from_memory(none, sizeof none - 1, NAME)), SVO_VOXEL_FORMAT_PLY);
    assert_int_equal(svo_points_format(svo_from_path("/no/such.las")), SVO_VOXEL_FORMAT_AUTO);
    assert_int_equal(svo_voxel_format_of_path("a.LAS"), SVO_VOXEL_FORMAT_LAS);
    assert_int_equal(svo_voxel_format_of_path("a.slab6"), SVO_VOXEL_FORMAT_AUTO);
}

TEST_GROUP(points)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_forms_of_las),
        cmocka_unit_test(test_forms_of_ply),
        cmocka_unit_test(test_blocks_and_orders),
        cmocka_unit_test(test_grids),
        cmocka_unit_test(test_axes),
        cmocka_unit_test(test_colors),
        cmocka_unit_test(test_ply_colors),
        cmocka_unit_test(test_left_out),
        cmocka_unit_test(test_counts_as_materials),
        cmocka_unit_test(test_limits),
        cmocka_unit_test(test_damaged_las),
        cmocka_unit_test(test_damaged_ply),
        cmocka_unit_test(test_variants),
        cmocka_unit_test(test_callers),
        cmocka_unit_test(test_short_memory),
        cmocka_unit_test(test_formats),
    };
    return cmocka_run_group_tests_name("points", tests, NULL, NULL);
}
