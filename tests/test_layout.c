/* SPDX-License-Identifier: MIT */
/*
 * The records of shared/layout.h lie the same in memory for C, OpenCL C and GLSL (std430): a kernel and a shader write
 * back sizes and offsets, which are compared field by field. In C they follow each other without gaps, so that the list
 * of fields that all three go by (agree/layout_fields.h) leaves none out.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "machine.h"
#include "shared/layout.h"

/* Made by cmake/embed.cmake: layout.h, and the list of fields. */
extern const char layout_source[];
extern const char layout_fields[];

/* Two numbers per entry of the list: a record's zero and size, a field's offset and size. */
typedef struct row {
    const char *record, *field;
    uint32_t offset_bytes, size_bytes;
} row;

#define RECORD(record, items, first) {#record, "", 0, sizeof(record)},
#define FIELD(record, field)         {#record, #field, offsetof(record, field), sizeof(((record *)0)->field)},
#define SCALAR(record, items, field) FIELD(record, field)
#define ARRAY(record, items, field)  FIELD(record, field)
static const row rows[] = {
#include "agree/layout_fields.h"
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static const char kernel_head[] = "#define RECORD(record, items, first) found[n++] = 0; found[n++] = sizeof(record);\n"
                                  "#define SCALAR(record, items, field) {\\\n"
                                  "    record r;\\\n"
                                  "    found[n++] = (uint)((uchar *)&r.field - (uchar *)&r);\\\n"
                                  "    found[n++] = sizeof(r.field);\\\n"
                                  "}\n"
                                  "#define ARRAY(record, items, field) SCALAR(record, items, field)\n"
                                  "__kernel void write_layout(__global const uint *words, __global uint *found,\n"
                                  "                           uint item_count)\n"
                                  "{\n"
                                  "    uint n = 0;\n"
                                  "    if (get_global_id(0) >= item_count) {\n"
                                  "        return;\n"
                                  "    }\n";

/* The shader sees the same words as arrays of each record; word i holds FIRST_WORD + i, so that what a field holds
   tells where it lies. */
#define FIRST_WORD 0x3f800000u /* as a float an ordinary number, which nothing flushes to zero */
enum { WORDS = 256 };

#define SHADER_BLOCK(name) \
    "layout(std430, binding = 0) readonly buffer Block_" name " { svo_" name " " name "_items[]; };\n"

static const char shader_head[] = "layout(local_size_x = 64) in;\n" SHADER_BLOCK("draw_item") SHADER_BLOCK("tile_item")
    SHADER_BLOCK("build_state") SHADER_BLOCK("triangle_record") SHADER_BLOCK("voxelize_params") SHADER_BLOCK(
        "subdivide_params") SHADER_BLOCK("sort_params") SHADER_BLOCK("bottom_up_params") SHADER_BLOCK("filter_params")
        SHADER_BLOCK("material_record") SHADER_BLOCK(
            "cast_params") "layout(std430, binding = 1) writeonly buffer Found { uint found[]; };\n"
                           "uniform uint item_count;\n"
                           "uint at(uint word) { return (word - 0x3f800000u) * 4u; }\n"
                           "uint at(float word) { return at(floatBitsToUint(word)); }\n"
                           "#define RECORD(record, items, first) found[n++] = 0u; found[n++] = at(items[1].first) - "
                           "at(items[0].first);\n"
                           "#define SCALAR(record, items, field) found[n++] = at(items[0].field); found[n++] = 4u;\n"
                           "#define ARRAY(record, items, field) found[n++] = at(items[0].field[0]);\\\n"
                           "    found[n++] = at(items[0].field[items[0].field.length() - 1]) + 4u - "
                           "at(items[0].field[0]);\n"
                           "void main()\n"
                           "{\n"
                           "    uint n = 0u;\n"
                           "    if (gl_GlobalInvocationID.x >= item_count) {\n"
                           "        return;\n"
                           "    }\n";

/* Rows of the records that shaders know, too: those before the first that only kernels do. */
static int rows_of_shaders(void)
{
    int count = 0;
    while (strcmp(rows[count].record, "svo_ray") != 0) {
        ++count;
    }
    return count;
}

/* layout.h, head, the list of fields and the closing brace. By malloc. */
static char *make_source(const char *head)
{
    const size_t bytes = strlen(layout_source) + strlen(head) + strlen(layout_fields) + 3;
    char *source = malloc(bytes);
    assert_non_null(source);
    (void)snprintf(source, bytes, "%s%s%s}\n", layout_source, head, layout_fields);
    return source;
}

static void compare(const uint32_t found[ROWS][2], int row_count, const char *language)
{
    for (int i = 0; i < row_count; ++i) {
        if (found[i][0] != rows[i].offset_bytes || found[i][1] != rows[i].size_bytes) {
            fail_msg("%s.%s: offset %u, %u bytes in C; offset %u, %u bytes in %s", rows[i].record, rows[i].field,
                     rows[i].offset_bytes, rows[i].size_bytes, found[i][0], found[i][1], language);
        }
    }
}

static void fields_follow_each_other_without_gaps(void **state)
{
    (void)state;
    uint32_t end_bytes = 0;
    uint32_t record_bytes = 0;
    for (int i = 0; i < ROWS; ++i) {
        const bool begins_record = rows[i].field[0] == '\0';
        if (begins_record) {
            assert_int_equal(end_bytes, record_bytes);
            record_bytes = rows[i].size_bytes;
            end_bytes = 0;
        } else if (rows[i].offset_bytes != end_bytes) {
            fail_msg("%s.%s is at %u, the field before ends at %u", rows[i].record, rows[i].field, rows[i].offset_bytes,
                     end_bytes);
        } else {
            end_bytes += rows[i].size_bytes;
        }
        assert_int_equal(rows[i].offset_bytes % 4, 0);
    }
    assert_int_equal(end_bytes, record_bytes);
}

static void opencl_has_the_layout_of_c(void **state)
{
    (void)state;
    svo_device *device = machine_device_or_skip();
    char *source = make_source(kernel_head);
    const uint32_t nothing = 0;
    uint32_t found[ROWS][2];
    const machine_job job = {&nothing, sizeof nothing, found, sizeof found, 1};
    machine_run_kernel(device, source, "-cl-std=CL1.2", "write_layout", &job);
    compare((const uint32_t(*)[2])found, ROWS, "OpenCL C");
    free(source);
    svo_device_destroy(&device);
}

static void glsl_has_the_layout_of_c(void **state)
{
    (void)state;
    svo_gl_context *context = machine_any_context_or_skip();
    char *source = make_source(shader_head);
    uint32_t words[WORDS];
    for (uint32_t i = 0; i < WORDS; ++i) {
        words[i] = FIRST_WORD + i;
    }
    uint32_t found[ROWS][2];
    const machine_job job = {words, sizeof words, found, sizeof found, 1};
    machine_run_shader(context, "", source, &job);
    compare((const uint32_t(*)[2])found, rows_of_shaders(), "GLSL");
    free(source);
    svo_gl_context_destroy(&context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_follow_each_other_without_gaps),
        cmocka_unit_test(opencl_has_the_layout_of_c),
        cmocka_unit_test(glsl_has_the_layout_of_c),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
