/* SPDX-License-Identifier: MIT */
/*
 * The library's own readers of OBJ, PLY, STL and OFF: every number of a text is the nearest float, at all scales and in
 * any locale; what a file declares is read or named in a warning; a damaged file ends in an error that names the line
 * or byte, the value and the limit.
 */
#define _XOPEN_SOURCE 700
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <inttypes.h>
#include <locale.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/import_check.h"
#include "support/work_folder.h"

#include "io/import_text.h"
#include "support/suite.h"
#include "svocl/io.h"

#define FLOAT_COUNT 29997 /* a multiple of 9 */
#define SEED        UINT64_C(0x5EED0014)

/* splitmix64 (Steele, Lea, Flood, 2014) */
static uint64_t next_random(uint64_t *state)
{
    uint64_t z = *state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

static uint32_t bits_of(float value)
{
    uint32_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static float float_of(uint32_t bits)
{
    float value = 0;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Any finite float: all signs, exponents and fractions, subnormal numbers among them. */
static float random_float(uint64_t *state)
{
    for (;;) {
        const float value = float_of((uint32_t)next_random(state));
        if (isfinite(value)) {
            return value;
        }
    }
}

/* The positions of a mesh's corners, in order, equal the given ones bit for bit. */
static void expect_corners(const char *what, const svo_mesh *mesh, const float *expected, size_t float_count)
{
    assert_int_equal(mesh->triangle_count, float_count / 9);
    for (size_t i = 0; i < float_count; ++i) {
        const float value = mesh->positions[3 * (size_t)mesh->indices[i / 3] + i % 3];
        if (bits_of(value) != bits_of(expected[i])) {
            fail_msg("%s, seed %#" PRIx64 ": number %zu is %.9g (%08" PRIx32 "), expected %.9g (%08" PRIx32 ")", what,
                     SEED, i, (double)value, bits_of(value), (double)expected[i], bits_of(expected[i]));
        }
    }
}

/* Files of the same triangles */

typedef void (*write_mesh)(FILE *file, const char *number, const float *values, size_t float_count);

static void print_three(FILE *file, const char *number, const float *values)
{
    for (int axis = 0; axis < 3; ++axis) {
        (void)fputc(' ', file);
        (void)fprintf(file, number, (double)values[axis]); /* NOLINT(clang-diagnostic-format-nonliteral) */
    }
    (void)fputc('\n', file);
}

static void write_obj(FILE *file, const char *number, const float *values, size_t float_count)
{
    for (size_t i = 0; i < float_count; i += 3) {
        (void)fputs("v", file);
        print_three(file, number, values + i);
    }
    for (size_t i = 0; i < float_count / 9; ++i) {
        (void)fprintf(file, "f %zu %zu %zu\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
}

static void write_ply(FILE *file, const char *number, const float *values, size_t float_count)
{
    (void)fprintf(file,
                  "ply\nformat ascii 1.0\nelement vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
                  float_count / 3, float_count / 9);
    for (size_t i = 0; i < float_count; i += 3) {
        print_three(file, number, values + i);
    }
    for (size_t i = 0; i < float_count / 9; ++i) {
        (void)fprintf(file, "3 %zu %zu %zu\n", 3 * i, 3 * i + 1, 3 * i + 2);
    }
}

static void write_stl(FILE *file, const char *number, const float *values, size_t float_count)
{
    (void)fputs("solid numbers\n", file);
    for (size_t i = 0; i < float_count; i += 9) {
        (void)fputs("facet normal 0 0 1\nouter loop\n", file);
        for (size_t k = 0; k < 9; k += 3) {
            (void)fputs("vertex", file);
            print_three(file, number, values + i + k);
        }
        (void)fputs("endloop\nendfacet\n", file);
    }
    (void)fputs("endsolid numbers\n", file);
}

static void write_off(FILE *file, const char *number, const float *values, size_t float_count)
{
    (void)fprintf(file, "OFF\n%zu %zu 0\n", float_count / 3, float_count / 9);
    for (size_t i = 0; i < float_count; i += 3) {
        print_three(file, number, values + i);
    }
    for (size_t i = 0; i < float_count / 9; ++i) {
        (void)fprintf(file, "3 %zu %zu %zu\n", 3 * i, 3 * i + 1, 3 * i + 2);
    }
}

static const struct {
    const char *name;
    write_mesh write;
} formats[] = {
    {"random.obj", write_obj}, {"random.ply", write_ply}, {"random.stl", write_stl}, {"random.off", write_off}};

#define FORMAT_COUNT (sizeof formats / sizeof formats[0])

static void write_format(size_t format, const char *number, const float *values, size_t float_count)
{
    FILE *file = fopen(path_of(formats[format].name), "wb");
    assert_non_null(file);
    formats[format].write(file, number, values, float_count);
    assert_int_equal(fclose(file), 0);
    work_folder_remember(formats[format].name);
}

static float *random_floats(void)
{
    static float values[FLOAT_COUNT];
    uint64_t state = SEED;
    for (size_t i = 0; i < FLOAT_COUNT; ++i) {
        values[i] = random_float(&state);
    }
    return values;
}

/* Numbers */

static void test_text_of_any_float_comes_back_bit_for_bit(void **unused)
{
    (void)unused;
    static const char *const numbers[] = {"%.9g", "%.17g", "%+.9e", "%.8E"};
    const float *values = random_floats();
    for (size_t format = 0; format < FORMAT_COUNT; ++format) {
        for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i) {
            char what[64];
            (void)snprintf(what, sizeof what, "%s as %s", formats[format].name, numbers[i]);
            write_format(format, numbers[i], values, FLOAT_COUNT);
            svo_import *import = import_named(formats[format].name);
            expect_corners(what, svo_import_mesh(import), values, FLOAT_COUNT);
            expect_no_warning();
            svo_import_destroy(&import);
        }
    }
}

/* A text file and a binary file of the same triangles give the same mesh, array by array. */
static void test_text_equals_binary(void **unused)
{
    (void)unused;
    const float *values = random_floats();
    FILE *file = fopen(path_of("binary.ply"), "wb");
    assert_non_null(file);
    (void)fprintf(file,
                  "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
                  "property float z\nelement face %d\nproperty list uchar uint vertex_indices\nend_header\n",
                  FLOAT_COUNT / 3, FLOAT_COUNT / 9);
    assert_int_equal(fwrite(values, sizeof *values, FLOAT_COUNT, file), FLOAT_COUNT);
    for (uint32_t i = 0; i < FLOAT_COUNT / 9; ++i) {
        const uint32_t corners[3] = {3 * i, 3 * i + 1, 3 * i + 2};
        (void)fputc(3, file);
        assert_int_equal(fwrite(corners, 4, 3, file), 3);
    }
    assert_int_equal(fclose(file), 0);
    work_folder_remember("binary.ply");
    svo_import *binary = import_named("binary.ply");
    const svo_mesh *expected = svo_import_mesh(binary);
    for (size_t format = 0; format < FORMAT_COUNT; ++format) {
        if (formats[format].write == write_stl) {
            continue; /* has normals as well */
        }
        write_format(format, "%.9g", values, FLOAT_COUNT);
        svo_import *import = import_named(formats[format].name);
        const svo_mesh *mesh = svo_import_mesh(import);
        assert_int_equal(mesh->vertex_count, expected->vertex_count);
        assert_int_equal(mesh->triangle_count, expected->triangle_count);
        assert_memory_equal(mesh->positions, expected->positions, 12 * mesh->vertex_count);
        assert_memory_equal(mesh->indices, expected->indices, 12 * mesh->triangle_count);
        svo_import_destroy(&import);
    }
    svo_import_destroy(&binary);
}

/* Near the middle between two floats, where rounding twice, to double first, goes wrong. The C library rounds
   correctly. */
static void test_numbers_between_floats(void **unused)
{
    (void)unused;
    uint64_t state = SEED;
    for (int i = 0; i < 200000; ++i) {
        const float low = fabsf(random_float(&state)), high = nextafterf(low, INFINITY);
        const double middle = 0.5 * ((double)low + (double)high);
        const double near[3] = {nextafter(middle, 0), middle, nextafter(middle, INFINITY)};
        for (int k = 0; k < 3; ++k) {
            char text[64];
            float value = 0;
            const int length = snprintf(text, sizeof text, "%.*e", 16 + (int)(next_random(&state) % 24), near[k]);
            const char *end = text + length;
            assert_ptr_equal(svo_i_number_float(text, end, &value), end);
            if (bits_of(value) != bits_of(strtof(text, NULL))) {
                fail_msg("seed %#" PRIx64 ": %s is read as %.9g, expected %.9g", SEED, text, (double)value,
                         (double)strtof(text, NULL));
            }
        }
    }
}

static void test_forms_of_numbers(void **unused)
{
    (void)unused;
    static const struct {
        const char *text;
        float value;
        size_t length; /* 0: none */
    } cases[] = {{"+1.5", 1.5f, 4},    {".5", 0.5f, 2},
                 {"5.", 5, 2},         {"-0", -0.0f, 2},
                 {"1e2", 100, 3},      {"1E+2x", 100, 4},
                 {"1e", 1, 1},         {"1e999", INFINITY, 5},
                 {"1e-999", 0, 6},     {"-1e999", -INFINITY, 6},
                 {"inf", INFINITY, 3}, {"-Infinity", -INFINITY, 9},
                 {"1,5", 1, 1},        {"", 0, 0},
                 {"+", 0, 0},          {"-", 0, 0},
                 {".", 0, 0},          {"+-1", 0, 0},
                 {"++1", 0, 0},        {"e5", 0, 0},
                 {"x", 0, 0},          {"0x10", 0, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        float value = 7;
        const char *text = cases[i].text, *behind = svo_i_number_float(text, text + strlen(text), &value);
        if (cases[i].length == 0 ? behind != NULL || value != 7
                                 : behind != text + cases[i].length || bits_of(value) != bits_of(cases[i].value)) {
            fail_msg("'%s' is read as %.9g up to character %td", text, (double)value,
                     behind != NULL ? behind - text : -1);
        }
    }
    double exact = 0;
    const char text[] = "0.1";
    assert_non_null(svo_i_number_double(text, text + 3, &exact));
    assert_true(exact == 0.1);
}

/* A locale whose decimal point is a comma, made here, since few machines have one. */
static bool set_comma_locale(void)
{
    char command[2048];
    const int length = snprintf(command, sizeof command, "localedef -c -i de_DE -f UTF-8 '%s/de_DE.UTF-8' >%s 2>&1",
                                work_folder(), "/dev/null");
    assert_true(length > 0 && (size_t)length < sizeof command);
    (void)system(command); /* NOLINT(cert-env33-c,concurrency-mt-unsafe): a command without input from outside */
    assert_int_equal(setenv("LOCPATH", work_folder(), 1), 0);
    assert_int_equal(setenv("LC_ALL", "de_DE.UTF-8", 1), 0);
    return setlocale(LC_ALL, "de_DE.UTF-8") != NULL && strcmp(localeconv()->decimal_point, ",") == 0;
}

static void remove_comma_locale(void)
{
    char command[2048];
    (void)setlocale(LC_ALL, "C");
    assert_int_equal(unsetenv("LC_ALL"), 0);
    assert_int_equal(unsetenv("LOCPATH"), 0);
    (void)snprintf(command, sizeof command, "rm -rf '%s/de_DE.UTF-8'", work_folder());
    (void)system(command); /* NOLINT(cert-env33-c,concurrency-mt-unsafe) */
}

static void test_a_locale_with_a_decimal_comma(void **unused)
{
    (void)unused;
    const float values[9] = {0.1f, 1.5f, -2.25f, 1e-7f, 3.0e8f, 1.25f, 0, 0.333333343f, 7};
    for (size_t format = 0; format < FORMAT_COUNT; ++format) {
        write_format(format, "%.9g", values, 9); /* in the C locale */
    }
    const bool has_comma = set_comma_locale();
    if (!has_comma) {
        remove_comma_locale();
        print_message("skipped: localedef cannot make the locale de_DE.UTF-8 (Debian package locales)\n");
        skip();
    }
    float value = 0;
    char text[16];
    (void)snprintf(text, sizeof text, "%.1f", 1.5);
    assert_string_equal(text, "1,5"); /* the locale is at work */
    for (size_t format = 0; format < FORMAT_COUNT; ++format) {
        svo_import *import = import_named(formats[format].name);
        expect_corners(formats[format].name, svo_import_mesh(import), values, 9);
        svo_import_destroy(&import);
    }
    const char number[] = "1.5";
    assert_ptr_equal(svo_i_number_float(number, number + 3, &value), number + 3);
    assert_true(value == 1.5f);
    remove_comma_locale();
}

/* PLY */

static void swap_bytes(uint8_t *bytes, size_t byte_count)
{
    for (size_t i = 0; i < byte_count / 2; ++i) {
        const uint8_t kept = bytes[i];
        bytes[i] = bytes[byte_count - 1 - i];
        bytes[byte_count - 1 - i] = kept;
    }
}

static void append(uint8_t *bytes, size_t *used, const void *value, size_t byte_count, bool swapped)
{
    memcpy(bytes + *used, value, byte_count);
    if (swapped) {
        swap_bytes(bytes + *used, byte_count);
    }
    *used += byte_count;
}

/* Every bit pattern of a float, not-a-number with its payload too; doubles are rounded; both byte orders; types of
   other sizes between them. */
static void test_binary_ply(void **unused)
{
    (void)unused;
    const uint32_t patterns[9] = {0x7fa00001, 0xff800000, 0x80000000, 0x00000001, 0x7f7fffff,
                                  0x3f800001, 0xffc12345, 0x12345678, 0x80800000};
    const double doubles[3] = {0.1, 1.00000006, -1e300};
    for (int big = 0; big < 2; ++big) {
        uint8_t bytes[2048];
        size_t used = (size_t)snprintf((char *)bytes, sizeof bytes,
                                       "ply\nformat binary_%s_endian 1.0\ncomment one\nobj_info two\n"
                                       "element vertex 3\nproperty short extra\nproperty float x\nproperty float y\n"
                                       "property float z\nproperty list uchar double more\nproperty double nx\n"
                                       "property uchar red\nproperty ushort green\nproperty float blue\n"
                                       "element face 1\nproperty char kind\nproperty list ushort int vertex_index\n"
                                       "end_header\n",
                                       big != 0 ? "big" : "little");
        for (size_t i = 0; i < 3; ++i) {
            const int16_t extra = -2;
            const uint8_t list_length = (uint8_t)i, red = 200;
            const uint16_t green = 65535;
            const float blue = 0.5f;
            append(bytes, &used, &extra, 2, big != 0);
            for (size_t axis = 0; axis < 3; ++axis) {
                append(bytes, &used, &patterns[3 * i + axis], 4, big != 0);
            }
            append(bytes, &used, &list_length, 1, false);
            for (size_t k = 0; k < i; ++k) {
                append(bytes, &used, &doubles[k], 8, big != 0);
            }
            append(bytes, &used, &doubles[i], 8, big != 0);
            append(bytes, &used, &red, 1, false);
            append(bytes, &used, &green, 2, big != 0);
            append(bytes, &used, &blue, 4, big != 0);
        }
        const int8_t kind = 1;
        const uint16_t corner_count = 3;
        const int32_t corners[3] = {2, 0, 1};
        append(bytes, &used, &kind, 1, false);
        append(bytes, &used, &corner_count, 2, big != 0);
        for (size_t i = 0; i < 3; ++i) {
            append(bytes, &used, &corners[i], 4, big != 0);
        }
        write_bytes("patterns.ply", bytes, used);
        svo_import *import = import_named("patterns.ply");
        const svo_mesh *mesh = svo_import_mesh(import);
        assert_int_equal(mesh->triangle_count, 1);
        for (size_t i = 0; i < 3; ++i) {
            const uint32_t vertex = mesh->indices[i];
            const size_t source = (size_t)corners[i];
            assert_memory_equal(mesh->positions + 3 * (size_t)vertex, patterns + 3 * source, 12);
            assert_true(mesh->normals[3 * (size_t)vertex] == (float)doubles[source]);
            assert_memory_equal(mesh->colors + 4 * (size_t)vertex, ((const uint8_t[]){200, 255, 128, 255}), 4);
        }
        expect_no_warning();
        svo_import_destroy(&import);
    }
}

/* A scan's triangle strips: -1 ends one; every second triangle is turned so that all face the same side. */
static void test_ply_triangle_strips(void **unused)
{
    (void)unused;
    static const uint32_t expected[] = {0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 5, 6, 0, 1, 5};
    svo_import *import =
        import_text("strips.ply", "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\n"
                                  "property float z\nelement tristrips 2\nproperty list int int vertex_indices\n"
                                  "end_header\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n5 0 0\n6 0 0\n"
                                  "11 0 1 2 3 4 -1 4 5 6 -1 3\n3 0 1 5\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 5);
    for (size_t i = 0; i < 15; ++i) {
        const float x = mesh->positions[3 * (size_t)mesh->indices[i]];
        if (x != (float)expected[i]) {
            fail_msg("corner %zu is vertex %.0f, expected %" PRIu32, i, (double)x, expected[i]);
        }
    }
    expect_no_warning();
    svo_import_destroy(&import);
}

static void test_ply_with_other_line_ends(void **unused)
{
    (void)unused;
    static const char *const ends[] = {"\n", "\r\n", "\r"};
    for (size_t i = 0; i < 3; ++i) {
        char text[1024];
        const char *e = ends[i];
        const size_t used = (size_t)snprintf(
            text, sizeof text,
            "ply%sformat binary_little_endian 1.0%selement vertex 3%sproperty uchar x%sproperty uchar y%s"
            "property uchar z%selement face 1%sproperty list uchar uchar vertex_indices%send_header%s",
            e, e, e, e, e, e, e, e, e);
        /* Data that begins with a byte that would end a line. */
        static const uint8_t data[] = {10, 13, 0, 1, 2, 3, 4, 5, 6, 3, 0, 1, 2};
        memcpy(text + used, data, sizeof data);
        write_bytes("ends.ply", text, used + sizeof data);
        svo_import *import = import_named("ends.ply");
        expect_corners("ends.ply", svo_import_mesh(import), (const float[]){10, 13, 0, 1, 2, 3, 4, 5, 6}, 9);
        expect_no_warning();
        svo_import_destroy(&import);
    }
}

/* STL and OFF */

static void test_stl_colors(void **unused)
{
    (void)unused;
    uint8_t bytes[84 + 2 * 50] = {0};
    static const uint8_t plain[4] = {255, 255, 255, 255}, given[4] = {10, 20, 30, 255};
    bytes[80] = 2;
    for (size_t i = 0; i < 2; ++i) {
        const float corners[9] = {0, 0, (float)i, 1, 0, 0, 0, 1, 0};
        memcpy(bytes + 84 + 50 * i + 12, corners, sizeof corners);
    }
    bytes[84 + 48] = 0x1f;
    bytes[84 + 49] = 0x80; /* VisCAM: valid, blue */
    write_bytes("colors.stl", bytes, sizeof bytes);
    svo_import *import = import_named("colors.stl");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_memory_equal(mesh->colors + 4 * (size_t)mesh->indices[0], ((const uint8_t[]){0, 0, 255, 255}), 4);
    assert_memory_equal(mesh->colors + 4 * (size_t)mesh->indices[3], plain, 4);
    svo_import_destroy(&import);
    static const uint8_t word[6] = {'C', 'O', 'L', 'O', 'R', '='};
    memcpy(bytes + 20, word, sizeof word);
    memcpy(bytes + 26, given, 4);
    bytes[84 + 50 + 48] = 0x1f; /* Magics: bit 15 clear, its own color, red */
    write_bytes("colors.stl", bytes, sizeof bytes);
    import = import_named("colors.stl");
    mesh = svo_import_mesh(import);
    assert_memory_equal(mesh->colors + 4 * (size_t)mesh->indices[0], given, 4);
    assert_memory_equal(mesh->colors + 4 * (size_t)mesh->indices[3], ((const uint8_t[]){255, 0, 0, 255}), 4);
    svo_import_destroy(&import);
}

static void test_off_kinds(void **unused)
{
    (void)unused;
    svo_import *import = import_text("kinds.off", "# a comment\nSTCN4OFF # all of it\n3 1 0\n\n"
                                                  "2 4 6 2 0 0 1 255 0 0 255 0.5 0.5 # first\n"
                                                  "1 0 0 1 0 1 0 0.0 1.0 0.5 1.0 0 0\n0 1 0 1 1 0 0 0 0 255 128 1 1\n"
                                                  "3 0 1 2 0.5 0.5 0.5\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    expect_corners("kinds.off", mesh, (const float[]){1, 2, 3, 1, 0, 0, 0, 1, 0}, 9);
    assert_memory_equal(mesh->normals + 3 * (size_t)mesh->indices[0], ((const float[]){0, 0, 1}), 12);
    assert_memory_equal(mesh->colors + 4 * (size_t)mesh->indices[0], ((const uint8_t[]){255, 0, 0, 255}), 4);
    assert_memory_equal(mesh->colors + 4 * (size_t)mesh->indices[1], ((const uint8_t[]){0, 255, 128, 255}), 4);
    assert_memory_equal(mesh->colors + 4 * (size_t)mesh->indices[2], ((const uint8_t[]){0, 0, 255, 128}), 4);
    expect_no_warning();
    svo_import_destroy(&import);
}

/* OBJ */

static void test_obj_forms(void **unused)
{
    (void)unused;
    svo_import *import = import_text("forms.obj", "  # indented, with carriage returns and a line that goes on\r\n"
                                                  "v 0 0 0 # origin\r\n\tv 1 0 0\r\nv 2 2 0 2\r\nv 0 1 0\r\n"
                                                  "vn 0 0 1\r\nvt 0.5\r\n"
                                                  "f 1/1/1 2//1 \\\r\n 3 4/1\r\nf -4 -3 -2\r\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    expect_corners("forms.obj", mesh,
                   (const float[]){0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0},
                   27);
    assert_memory_equal(mesh->normals + 3 * (size_t)mesh->indices[0], ((const float[]){0, 0, 1}), 12);
    expect_no_warning();
    svo_import_destroy(&import);
    import = import_text("forward.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0");
    assert_int_equal(svo_import_mesh(import)->triangle_count, 1);
    svo_import_destroy(&import);
}

/* An arrow: its notch is the corner that a fan must begin at. A star with five inward corners. */
static void test_concave_polygons(void **unused)
{
    (void)unused;
    svo_import *import = import_text("arrow.obj", "v 0 0 0\nv 2 -2 0\nv 0 2 0\nv -2 -2 0\nf 4 1 2 3\n");
    const svo_mesh *mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 2);
    expect_corners("arrow.obj", mesh, (const float[]){0, 0, 0, 2, -2, 0, 0, 2, 0, 0, 0, 0, 0, 2, 0, -2, -2, 0}, 18);
    svo_import_destroy(&import);
    char text[1024] = "";
    for (int i = 0; i < 10; ++i) {
        const double angle = 0.62831853071795862 * i, radius = i % 2 == 0 ? 2 : 0.5;
        const size_t used = strlen(text);
        (void)snprintf(text + used, sizeof text - used, "v %.9g 0 %.9g\n", radius * cos(angle), radius * sin(angle));
    }
    strncat(text, "f 1 2 3 4 5 6 7 8 9 10\n", sizeof text - strlen(text) - 1);
    import = import_text("star.obj", text);
    mesh = svo_import_mesh(import);
    assert_int_equal(mesh->triangle_count, 8);
    double area = 0;
    for (size_t t = 0; t < 8; ++t) {
        const float *a = mesh->positions + 3 * (size_t)mesh->indices[3 * t];
        const float *b = mesh->positions + 3 * (size_t)mesh->indices[3 * t + 1];
        const float *c = mesh->positions + 3 * (size_t)mesh->indices[3 * t + 2];
        area +=
            0.5 * fabs((double)(b[0] - a[0]) * (double)(c[2] - a[2]) - (double)(b[2] - a[2]) * (double)(c[0] - a[0]));
    }
    const double expected = 10 * 0.5 * 2 * 0.5 * sin(0.62831853071795862);
    if (fabs(area - expected) > 1e-5) {
        fail_msg("the triangles of the star cover %.9g, expected %.9g", area, expected);
    }
    svo_import_destroy(&import);
}

/* Declared and read */

static void test_what_is_left_out_is_a_warning(void **unused)
{
    (void)unused;
    const svo_import_options strict = {.struct_size = sizeof strict, .strict = 1};
    static const struct {
        const char *name, *text, *warning;
    } cases[] = {
        {"unused.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\n", "1 of 4 vertices belong to no face"},
        {"lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\np 1\n", "1 lines and 1 points are left out"},
        {"small.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\n", "1 of 2 faces have fewer than 3 corners"},
        {"surface.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ncstype bezier\nend\n",
         "2 statements are not read; the first is 'cstype' in line 5"},
        {"odd.obj", "v 0 0 0\nv 1 0 0\nv 0 1.5abc 0\nf 1 2 3\n",
         "1 words are numbers only in part, which was read; the first is '1.5abc' in line 3"},
        {"library.obj", "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
         "line 1: material library none.mtl cannot be read"},
        {"material.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n", "line 4: material red is in no library"},
        {"uv.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1/1 2/2 3\n",
         "1 corners name texture coordinates that do not exist; the file has 1"},
        {"element.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty list uchar int vertex_indices\nelement range_grid 2\n"
         "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n0\n1 2\n",
         "2 of element range_grid are left out"},
        {"index.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 -7 2\n",
         "1 of 2 faces name a vertex that does not exist; the first is face 1 with vertex -7, which is not in 0 .. 2"},
        {"long.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0 5\n0 1 0\n3 0 1 2\n",
         "1 lines have more values than are declared; the first is line 11"},
        {"words.stl",
         "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
         "0\ncolour\nendloop\nendfacet\n",
         "1 words are none of STL's and are skipped; the first is 'colour' in line 7"},
        {"more.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n",
         "line 7: more follows after the 1 faces that are declared"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        svo_import *import = import_text(cases[i].name, cases[i].text);
        expect_warning(cases[i].warning);
        svo_import_destroy(&import);
        expect_refused(cases[i].name, &strict, cases[i].warning);
    }
    svo_import *import = NULL;
    write_text("whole.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_int_equal(svo_import_file(path_of("whole.obj"), &strict, NULL, NULL, &import, NULL), SVO_OK);
    svo_import_destroy(&import);
}

static void test_counts(void **unused)
{
    (void)unused;
    svo_import_info info = SVO_IMPORT_INFO_INIT;
    svo_import *import = import_text("counts.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 5 5\nf 1 2 3 4\nf 1 2\n");
    assert_int_equal(svo_import_get_info(import, &info), SVO_OK);
    assert_string_equal(info.reader, "obj");
    assert_int_equal(info.declared_vertices, 5);
    assert_int_equal(info.used_vertices, 4);
    assert_int_equal(info.declared_faces, 2);
    assert_int_equal(info.read_faces, 1);
    assert_int_equal(info.triangles, 2);
    assert_int_equal(info.warnings, 2);
    svo_import_info wrong = {.struct_size = 8};
    assert_int_equal(svo_import_get_info(import, &wrong), SVO_INVALID_ARGUMENT);
    svo_import_destroy(&import);
}

/* Damaged files */

#define PLY_BEGIN "ply\nformat ascii 1.0\n"
#define PLY_XYZ   "property float x\nproperty float y\nproperty float z\n"
#define PLY_LIST  "property list uchar int vertex_indices\nend_header\n"
#define FACET     "facet normal 0 0 1\nouter loop\n"

static void test_damaged_texts(void **unused)
{
    (void)unused;
    static const struct {
        const char *name, *text, *error;
    } cases[] = {
        {"a.obj", "v 0 0\nf 1 2 3\n", "line 1: 'v' with 2 numbers; 3, 4, 6 or 7 are needed"},
        {"b.obj", "v 0 0 zero\n", "line 1: 'zero' is not a number"},
        {"c.obj", "v 0 0 0 0\n", "line 1: the weight w is 0"},
        {"d.obj", "v 0 0 0\nf 1 1 2\n", "line 2: position 2 does not exist; the file has 1"},
        {"e.obj", "v 0 0 0\nf 1 1 0\n", "line 2: '0' is no position; 1 .. 1 and -1 .. -1 are"},
        {"f.obj", "v 0 0 0\nf -2 1 1\n", "line 2: '-2' is no position; 1 .. 1 and -1 .. -1 are"},
        {"f0.obj", "f -1 1 1\n", "line 1: '-1' is no position; there is none yet"},
        {"g.obj", "v 0 0 0\nf 1 1 99999999999999999999\n", "line 2: '99999999999999999999' is no position"},
        {"h.obj", "v 0 0 0\nf 1/1/1/1 1 1\n", "line 2: '1/1/1/1' is none of v, v/vt, v//vn and v/vt/vn"},
        {"i.obj", "v 0 0 0\nf 1//0 1 1\n", "line 2: '1//0' is no normal"},
        {"j.obj", "\xff\xfev", "UTF-16"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999\nend_", "line 4: 'end_' where"},
        {"b.ply", "ply\nformat binary_little_endian 1.0\nelement vertex", "line 3"},
        {"c.ply", PLY_BEGIN "element vertex -3\n" PLY_XYZ "end_header\n", "line 3: '-3' where a number of elements"},
        {"d.ply", PLY_BEGIN "element vertex 4000000000\n" PLY_XYZ "end_header\n0 0 0\n",
         "4000000000 of element vertex need at least 6 bytes each, and 6 are left"},
        {"e.ply", PLY_BEGIN "element vertex 2\n" PLY_XYZ "end_header\n0 0 0\n0 0     \n",
         "line 9: the line ends in vertex 1 of 2"},
        {"f.ply", PLY_BEGIN "element vertex 1\n" PLY_XYZ "element face 1\n" PLY_LIST "0 0 0\n300000 1 2\n",
         "line 11: list vertex_indices of face 0 has length 300000"},
        {"g.ply", PLY_BEGIN "element vertex 1\n" PLY_XYZ "element face 1\n" PLY_LIST "0 0 0\n-1 1 2\n",
         "line 11: list vertex_indices of face 0 has length -1"},
        {"h.ply", PLY_BEGIN "element vertex 1\n" PLY_XYZ "element face 1\n" PLY_LIST "0 0 0\n3 0 0.5 0\n",
         "line 11: '0.5' is no whole number"},
        {"i.ply", PLY_BEGIN "element face 1\n" PLY_LIST "3 0 0 0\n", "element face comes before element vertex"},
        {"j.ply", PLY_BEGIN "element vertex 1\n" PLY_XYZ "end_header\n0 0 x\n", "line 8: 'x' is not a number"},
        {"k.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n",
         "line 4: 'quad' where a type"},
        {"l.ply", "ply\nelement vertex 1\nend_header\n", "names no format"},
        {"m.ply", PLY_BEGIN "element vertex 1\n" PLY_XYZ "element face 1\nproperty int x\nend_header\n0 0 0\n1\n",
         "element face has no list vertex_indices"},
        {"a.stl", "solid a\n" FACET "vertex 0 0 0\nvertex 0 1 0\nendloop\nendfacet\n",
         "line 2: the facet has 2 vertices; 3 are needed"},
        {"b.stl", "solid a\n" FACET "vertex 0 0 0\nvertex 0 1", "line 5: the line ends where a number is needed"},
        {"c.stl", "solid a\n" FACET "vertex 0 0 0\n", "the file ends in the facet that begins in line 2"},
        {"d.stl", "solid a\nvertex 0 0 0\n", "line 2: a vertex outside of a facet"},
        {"e.stl", "sol", "no STL file"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "line 6: vertex 3 is not in 0 .. 2"},
        {"b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "line 6: vertex -1 is not in 0 .. 2"},
        {"c.off", "OFF\n353535235358 6 0\n0 0 0\n", "line 2: 353535235358 vertices do not fit"},
        {"d.off", "OFF\n-1 6 0\n0 0 0\n", "is no number of vertices"},
        {"e.off", "OFF\n2 3 0\n0 0 0\n1 2 3\n3 0 1 0\n", "the file ends after 1 of 3 faces"},
        {"f.off", "OFF\n1 1 0\n0 0 0\n300 0 0 0\n", "line 4: 300 corners do not fit into the file"},
        {"g.off", "4GARBAGE\n", "line 1:"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_text(cases[i].name, cases[i].text);
        expect_refused(cases[i].name, NULL, cases[i].error);
    }
}

static void test_damaged_binaries(void **unused)
{
    (void)unused;
    uint8_t stl[84 + 50] = {0};
    stl[80] = 2;
    write_bytes("short.stl", stl, sizeof stl);
    expect_refused("short.stl", NULL, "byte 80: 2 facets need 184 bytes, and the file has 134");
    memset(stl + 80, 0xff, 4);
    write_bytes("short.stl", stl, sizeof stl);
    expect_refused("short.stl", NULL, "byte 80: 4294967295 facets need 214748364834 bytes, and the file has 134");
    static const char header[] = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n" PLY_XYZ
                                 "element face 1\nproperty list uint int vertex_indices\nend_header\n";
    uint8_t ply[sizeof header + 64] = {0};
    memcpy(ply, header, sizeof header - 1);
    const size_t begin = sizeof header - 1;
    write_bytes("short.ply", ply, begin + 30);
    expect_refused("short.ply", NULL, "3 of element vertex need at least 12 bytes each, and 30 are left");
    memset(ply + begin + 36, 0xff, 4);
    write_bytes("short.ply", ply, begin + 52);
    expect_refused("short.ply", NULL, "list vertex_indices of face 0 has length 4294967295, and 12 bytes are left");
    memcpy(ply + begin + 36, (const uint8_t[]){3, 0, 0, 0}, 4);
    write_bytes("short.ply", ply, begin + 50);
    expect_refused("short.ply", NULL, "the file ends in face 0 of 1");
}

/* A header of 60 bytes took assimp's whole time limit. The limit is far above what an error needs. */
static void test_a_damaged_header_of_60_bytes(void **unused)
{
    (void)unused;
    static const char header[] = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nprope";
    write_bytes("header.ply", header, sizeof header - 1);
    const svo_import_options options = {.struct_size = sizeof options, .time_limit_seconds = 60};
    expect_refused("header.ply", &options, "line 5: 'prope' where");
}

TEST_GROUP(import_readers)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_text_of_any_float_comes_back_bit_for_bit),
        cmocka_unit_test(test_text_equals_binary),
        cmocka_unit_test(test_numbers_between_floats),
        cmocka_unit_test(test_forms_of_numbers),
        cmocka_unit_test(test_a_locale_with_a_decimal_comma),
        cmocka_unit_test(test_binary_ply),
        cmocka_unit_test(test_ply_triangle_strips),
        cmocka_unit_test(test_ply_with_other_line_ends),
        cmocka_unit_test(test_stl_colors),
        cmocka_unit_test(test_off_kinds),
        cmocka_unit_test(test_obj_forms),
        cmocka_unit_test(test_concave_polygons),
        cmocka_unit_test(test_what_is_left_out_is_a_warning),
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_damaged_texts),
        cmocka_unit_test(test_damaged_binaries),
        cmocka_unit_test(test_a_damaged_header_of_60_bytes),
    };
    return cmocka_run_group_tests_name("import_readers", tests, work_folder_make, work_folder_remove);
}
