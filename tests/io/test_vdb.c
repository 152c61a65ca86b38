/* SPDX-License-Identifier: MIT */
/*
 * .vdb files, byte by byte as OpenVDB's io/Archive.cc and io/Compression.h have them: every way that values are
 * compressed, types, tiles, instances, maps; files that lie are refused where they do. What is written is read again.
 * openvdb.py has OpenVDB itself on the other side.
 */
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sdf/handle.h"
#include "support/suite.h"
#include "svocl/nodes.h"
#include "svocl/voxel_files.h"
#include "vox_bytes.h"

#define NAME       "file"
#define BACKGROUND 3.0

enum { LEAF = 512, LOWER = 4096, UPPER = 32768, ZIP = 1, MASK = 2, BLOSC = 4, DICE = 300, CHANGES = 1500 };

/* The one leaf of the trees that are made, in the node at (-4096, 0, 0). */
static const int32_t corner[3] = {-8, 24, 8};

/* ---- grids ---- */

/* What the values of a grid are. */
typedef enum value_kind { DISTANCES, ONES, COLORS, MATERIALS } value_kind;

typedef struct grid_spec {
    const char *name, *type, *parent, *class;
    value_kind values;
    uint32_t compression;
    uint8_t code; /* how the inactive values of the leaf are written */
    bool is_double, is_half, is_bool, is_mask;
    bool has_tile; /* the child before the leaf is an active tile */
    const char *map; /* NULL: UniformScaleTranslateMap of width 0.25 from (1, 2, 3) */
    const double *numbers;
    size_t number_count;
} grid_spec;

/* Where parts of the last grid that was made begin. */
typedef struct made_file {
    byte_list bytes;
    size_t descriptor, offsets, grid, map, tree, table, upper, upper_values, lower, leaf, buffers, values, end;
} made_file;

static void put_text(byte_list *list, const char *text)
{
    bytes_put_i32(list, (int32_t)strlen(text));
    bytes_put_text(list, text);
}

static void put_i64(byte_list *list, int64_t value)
{
    bytes_put(list, &value, sizeof value);
}

static uint32_t components_of(const grid_spec *spec)
{
    return spec->values == COLORS ? 3 : 1;
}

/* A number of few bits as IEEE 754's binary16. */
static uint16_t half_of(double value)
{
    int exponent = 0;
    const double fraction = frexp(fabs(value), &exponent);
    return (uint16_t)((value < 0 ? 0x8000 : 0) |
                      (value == 0 ? 0 : (exponent + 14) << 10 | ((int)ldexp(fraction, 11) & 1023)));
}

/* A number in the grid's type, or in that of its packed values. */
static void put_number(byte_list *list, const grid_spec *spec, double value, bool packed)
{
    const float single = (float)value;
    const uint16_t half = half_of(value);
    if (spec->is_bool || spec->is_mask) {
        bytes_put_u8(list, value != 0);
    } else if (spec->values == MATERIALS) {
        bytes_put_i32(list, (int32_t)value);
    } else if (packed && spec->is_half) {
        bytes_put(list, &half, sizeof half);
    } else if (spec->is_double) {
        bytes_put(list, &value, sizeof value);
    } else {
        bytes_put(list, &single, sizeof single);
    }
}

static void put_value(byte_list *list, const grid_spec *spec, const double value[3], bool packed)
{
    for (uint32_t i = 0; i < components_of(spec); ++i) {
        put_number(list, spec, value[i], packed);
    }
}

static bool is_active(uint32_t slot)
{
    return slot % 3 == 0;
}

static bool is_chosen(uint32_t slot)
{
    return slot % 5 == 0;
}

static void value_of(const grid_spec *spec, uint32_t slot, double value[3])
{
    static const double levels[3] = {0.5, 1.0, 0.0}; /* sRGB 188, 255, 0 */
    if (spec->values == MATERIALS) {
        value[0] = slot;
    } else if (spec->values == COLORS) {
        for (uint32_t i = 0; i < 3; ++i) {
            value[i] = levels[(slot + i) % 3];
        }
    } else if (spec->values == ONES) {
        value[0] = 1;
    } else if (is_active(slot)) {
        value[0] = slot % 2 == 0 ? 0.5 : -0.5;
    } else {
        const double of_codes[7] = {BACKGROUND,
                                    -BACKGROUND,
                                    -7,
                                    is_chosen(slot) ? BACKGROUND : -BACKGROUND,
                                    is_chosen(slot) ? BACKGROUND : -7,
                                    is_chosen(slot) ? 4 : -2,
                                    slot % 7 == 0 ? 1 : -1};
        value[0] = of_codes[spec->code];
    }
}

/* Bytes as zlib writes them without compression (RFC 1950, 1951), or as libblosc does. */
static void put_packed(byte_list *list, const byte_list *plain, bool blosc)
{
    const uint16_t length = (uint16_t)plain->count;
    uint32_t a = 1;
    uint32_t b = 0;
    if (blosc) {
        const uint8_t head[4] = {2, 1, 2, 4}; /* versions; copied; bytes of a value */
        put_i64(list, (int64_t)plain->count + 16);
        bytes_put(list, head, sizeof head);
        bytes_put_i32(list, (int32_t)plain->count);
        bytes_put_i32(list, (int32_t)plain->count);
        bytes_put_i32(list, (int32_t)plain->count + 16);
        bytes_put(list, plain->bytes, plain->count);
        return;
    }
    put_i64(list, (int64_t)plain->count + 11);
    bytes_put_u8(list, 0x78);
    bytes_put_u8(list, 0x01);
    bytes_put_u8(list, 1);
    bytes_put(list, &length, 2);
    bytes_put_u8(list, (uint8_t)~length);
    bytes_put_u8(list, (uint8_t)(~length >> 8));
    for (size_t i = 0; i < plain->count; ++i) {
        a = (a + plain->bytes[i]) % 65521;
        b = (b + a) % 65521;
    }
    bytes_put(list, plain->bytes, plain->count);
    for (int i = 0; i < 4; ++i) {
        bytes_put_u8(list, (uint8_t)((b << 16 | a) >> (24 - 8 * i)));
    }
}

/* Of no halves OpenVDB writes no length. */
static void put_data(byte_list *list, const grid_spec *spec, byte_list *plain)
{
    if ((spec->compression & (ZIP | BLOSC)) != 0 && plain->count > 0 && plain->count < 60000) {
        put_packed(list, plain, (spec->compression & BLOSC) != 0);
    } else {
        if ((spec->compression & (ZIP | BLOSC)) != 0 && !(spec->is_half && plain->count == 0)) {
            put_i64(list, -(int64_t)plain->count);
        }
        bytes_put(list, plain->bytes, plain->count);
    }
    bytes_free(plain);
    *plain = (byte_list){0};
}

/* The masks of a node with one child, and its values. tile: an active one. */
static void put_node(made_file *made, const grid_spec *spec, uint32_t slots, uint32_t child, uint32_t tile)
{
    uint8_t masks[2 * UPPER / 8] = {0};
    const double background[3] = {spec->values == DISTANCES ? BACKGROUND : 0, 0, 0};
    byte_list plain = {0};
    masks[child / 8] = (uint8_t)(1 << child % 8);
    if (tile != child) {
        masks[slots / 8 + tile / 8] = (uint8_t)(1 << tile % 8);
    }
    bytes_put(&made->bytes, masks, 2 * slots / 8);
    made->upper_values = slots == UPPER ? made->bytes.count : made->upper_values;
    bytes_put_u8(&made->bytes, (spec->compression & MASK) != 0 ? 0 : 6);
    for (uint32_t i = 0; i < slots; ++i) {
        double value[3];
        value_of(spec, 1, value);
        if (i == tile && tile != child) {
            put_value(&plain, spec, value, true);
        } else if ((spec->compression & MASK) == 0) {
            put_value(&plain, spec, background, true);
        }
    }
    put_data(&made->bytes, spec, &plain);
}

static void put_leaf_mask(byte_list *list)
{
    uint8_t mask[LEAF / 8] = {0};
    for (uint32_t i = 0; i < LEAF; ++i) {
        mask[i / 8] |= (uint8_t)(is_active(i) << i % 8);
    }
    bytes_put(list, mask, sizeof mask);
}

static void put_leaf(made_file *made, const grid_spec *spec)
{
    byte_list *list = &made->bytes;
    byte_list plain = {0};
    const double first[7] = {0, 0, -7, 0, -7, -2, 0};
    uint8_t choice[LEAF / 8] = {0};
    put_leaf_mask(list);
    made->values = list->count;
    if (spec->is_bool || spec->is_mask) {
        bytes_put(list, corner, sizeof corner);
        if (spec->is_bool) {
            put_leaf_mask(list);
        }
        return;
    }
    bytes_put_u8(list, spec->code);
    if (spec->code == 2 || spec->code == 4 || spec->code == 5) {
        put_value(list, spec, &first[spec->code], false);
    }
    if (spec->code == 5) {
        put_number(list, spec, 4, false);
    }
    for (uint32_t i = 0; i < LEAF; ++i) {
        double value[3];
        choice[i / 8] |= (uint8_t)(is_chosen(i) << i % 8);
        value_of(spec, i, value);
        if (is_active(i) || spec->code == 6) {
            put_value(&plain, spec, value, true);
        }
    }
    if (spec->code >= 3 && spec->code <= 5) {
        bytes_put(list, choice, sizeof choice);
    }
    put_data(list, spec, &plain);
}

static void put_map(byte_list *list, const grid_spec *spec)
{
    static const double usual[18] = {1, 2, 3, 0.25, 0.25, 0.25};
    put_text(list, spec->map != NULL ? spec->map : "UniformScaleTranslateMap");
    bytes_put(list, spec->map != NULL ? spec->numbers : usual,
              (spec->map != NULL ? spec->number_count : 18) * sizeof usual[0]);
}

static made_file begin_file(int32_t version, bool has_offsets, int32_t grid_count)
{
    made_file made = {.end = 0};
    bytes_put(&made.bytes, " BDV\0\0\0\0", 8);
    bytes_put_i32(&made.bytes, version);
    bytes_put_i32(&made.bytes, 10);
    bytes_put_i32(&made.bytes, 0);
    bytes_put_u8(&made.bytes, has_offsets);
    bytes_put_text(&made.bytes, "01234567-89ab-cdef-0123-456789abcdef");
    bytes_put_i32(&made.bytes, 1);
    put_text(&made.bytes, "note");
    put_text(&made.bytes, "string");
    put_text(&made.bytes, "of the file");
    bytes_put_i32(&made.bytes, grid_count);
    return made;
}

static void put_tree(made_file *made, const grid_spec *spec)
{
    byte_list *list = &made->bytes;
    const double background[3] = {spec->values == DISTANCES ? BACKGROUND : 0, 0, 0};
    const int32_t place[3] = {-4096, 0, 0};
    const uint32_t upper = 31u << 10; /* of the node at (-128, 0, 0) */
    const uint32_t lower = 15u << 8 | 3u << 4 | 1u;
    made->tree = list->count;
    bytes_put_i32(list, 1);
    put_value(list, spec, background, false);
    bytes_put_i32(list, 0);
    bytes_put_i32(list, 1);
    made->table = list->count;
    bytes_put(list, place, sizeof place);
    made->upper = list->count;
    put_node(made, spec, UPPER, upper, upper);
    made->lower = list->count;
    put_node(made, spec, LOWER, lower, spec->has_tile ? lower - 1 : lower);
    made->leaf = list->count;
    put_leaf_mask(list);
    made->buffers = list->count;
    put_leaf(made, spec);
}

/* Adds a grid. */
static void put_grid(made_file *made, const grid_spec *spec, bool has_offsets)
{
    byte_list *list = &made->bytes;
    int64_t offsets[3] = {0, 0, 0};
    made->descriptor = list->count;
    put_text(list, spec->name);
    put_text(list, spec->type);
    put_text(list, spec->parent != NULL ? spec->parent : "");
    made->offsets = list->count;
    bytes_put(list, offsets, sizeof offsets);
    made->grid = list->count;
    bytes_put_i32(list, (int32_t)spec->compression);
    bytes_put_i32(list, 2);
    put_text(list, "class");
    put_text(list, "string");
    put_text(list, spec->class != NULL ? spec->class : "unknown");
    put_text(list, "file_delayed_load");
    put_text(list, "__delayedload");
    put_text(list, "of no use");
    made->map = list->count;
    put_map(list, spec);
    if (spec->parent == NULL) {
        put_tree(made, spec);
    }
    made->end = list->count;
    if (has_offsets) {
        offsets[0] = (int64_t)made->grid;
        offsets[1] = spec->parent == NULL ? (int64_t)made->buffers : 0;
        offsets[2] = (int64_t)made->end;
        memcpy(list->bytes + made->offsets, offsets, sizeof offsets);
    }
}

static made_file make_file(const grid_spec *spec)
{
    made_file made = begin_file(224, true, 1);
    put_grid(&made, spec, true);
    return made;
}

/* ---- reading ---- */

static void keep_line(void *user, svo_log_level level, const char *text)
{
    char *lines = user;
    (void)level;
    (void)snprintf(lines + strlen(lines), 512 - strlen(lines), "%s\n", text);
}

static svo_status load(const byte_list *file, size_t count, char lines[512], svo_voxels **voxels, svo_message *message)
{
    svo_voxels_load_options options = {.struct_size = sizeof options, .voxels_max = 1 << 20};
    uint8_t *exact = malloc(count + 1); /* a sanitizer sees a read behind it */
    assert_non_null(exact);
    memcpy(exact + 1, file->bytes, count); /* nothing is aligned */
    options.log = lines != NULL ? keep_line : NULL;
    options.log_user = lines;
    const svo_status status = svo_voxels_load(svo_from_memory(exact + 1, count, NAME), &options, voxels, NULL, message);
    free(exact);
    return status;
}

static svo_voxels *read_file(made_file *made, char lines[512])
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    if (load(&made->bytes, made->bytes.count, lines, &voxels, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    bytes_free(&made->bytes);
    return voxels;
}

static svo_voxels_info info_of(const svo_voxels *voxels)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
    return info;
}

/* The leaf's voxels are in the list, those of a level set that lie inside, else the active ones, and no others are.
   of: NULL: white and 0; else colors and materials are those of value_of. */
static void expect_leaf(const svo_voxels *list, const grid_spec *spec, bool has_payload)
{
    static const uint8_t levels[3] = {188, 255, 0};
    bool is_there[LEAF] = {false};
    for (uint64_t i = 0; i < info_of(list).voxel_count; ++i) {
        const svo_voxel *voxel = &svo_voxels_get(list)[i];
        const uint32_t at[3] = {(uint32_t)(voxel->x - corner[0]), (uint32_t)(voxel->y - corner[1]),
                                (uint32_t)(voxel->z - corner[2])};
        assert_true(at[0] < 8 && at[1] < 8 && at[2] < 8);
        const uint32_t slot = at[0] << 6 | at[1] << 3 | at[2];
        is_there[slot] = true;
        assert_int_equal(voxel->material, has_payload ? slot : 0);
        for (uint32_t c = 0; c < 3; ++c) {
            assert_int_equal(voxel->rgba[c], has_payload ? levels[(slot + c) % 3] : 255);
        }
    }
    for (uint32_t slot = 0; slot < LEAF; ++slot) {
        double value[3];
        value_of(spec, slot, value);
        if (is_there[slot] != (spec->values == DISTANCES ? value[0] < 0 : is_active(slot))) {
            fail_msg("%s, compression %u, code %d: voxel %u", spec->type, spec->compression, spec->code, slot);
        }
    }
}

static bool has_blosc(void)
{
    const grid_spec spec = {
        .name = "a", .type = "Tree_float_5_4_3", .class = "level set", .compression = MASK | BLOSC, .code = 0};
    made_file made = make_file(&spec);
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    const svo_status status = load(&made.bytes, made.bytes.count, NULL, &voxels, &message);
    assert_true(status == SVO_OK || strstr(message.text, "needs libblosc") != NULL);
    bytes_free(&made.bytes);
    svo_voxels_destroy(&voxels);
    return status == SVO_OK;
}

static void test_values(void **state)
{
    (void)state;
    static const char *const types[4] = {"Tree_float_5_4_3", "Tree_float_5_4_3_HalfFloat", "Tree_double_5_4_3",
                                         "Tree_double_5_4_3_HalfFloat"};
    const bool blosc = has_blosc();
    for (uint32_t type = 0; type < 4; ++type) {
        for (uint32_t compression = 0; compression < (blosc ? 8u : 4u); ++compression) {
            for (uint8_t code = (compression & MASK) != 0 ? 0 : 6; code <= 6; ++code) {
                const grid_spec spec = {.name = "surface",
                                        .type = types[type],
                                        .class = "level set",
                                        .compression = compression,
                                        .code = code,
                                        .is_double = type >= 2,
                                        .is_half = type % 2 != 0};
                made_file made = make_file(&spec);
                svo_voxels *list = read_file(&made, NULL);
                const svo_voxels_info info = info_of(list);
                expect_leaf(list, &spec, false);
                assert_true(info.voxel_edge == 0.25 && info.origin[0] == 1 - 0.125 && info.origin[2] == 3 - 0.125);
                svo_voxels_destroy(&list);
            }
        }
    }
}

static void test_occupancy(void **state)
{
    (void)state;
    const grid_spec specs[] = {
        {.name = "density", .type = "Tree_float_5_4_3", .values = ONES, .compression = MASK | ZIP},
        {.name = "density", .type = "Tree_bool_5_4_3", .values = ONES, .compression = MASK, .is_bool = true},
        {.name = "density", .type = "Tree_bool_5_4_3", .values = ONES, .compression = ZIP, .is_bool = true},
        {.name = "density", .type = "Tree_mask_5_4_3", .values = ONES, .compression = MASK | ZIP, .is_mask = true},
        {.name = "count", .type = "Tree_int32_5_4_3", .values = MATERIALS, .compression = MASK},
        {.name = "speed", .type = "Tree_vec3s_5_4_3", .values = COLORS, .compression = MASK}};
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; ++i) {
        made_file made = make_file(&specs[i]);
        svo_voxels *list = read_file(&made, NULL);
        expect_leaf(list, &specs[i], false);
        svo_voxels_destroy(&list);
    }
}

/* Several grids, of which three belong together; others are named. */
static void test_grids(void **state)
{
    (void)state;
    for (int half = 0; half < 2; ++half) {
        char lines[512] = "";
        const char *color_type = half != 0 ? "Tree_vec3s_5_4_3_HalfFloat" : "Tree_vec3s_5_4_3";
        const grid_spec dust = {.name = "dust", .type = "Tree_ptdataidx32_5_4_3", .values = ONES, .compression = MASK};
        const grid_spec specs[] = {
            {.name = "fog", .type = "Tree_float_5_4_3", .values = ONES, .compression = MASK | ZIP},
            {.name = "heat\x1e"
                     "0",
             .type = "Tree_float_5_4_3",
             .values = ONES,
             .compression = MASK},
            {.name = "Cd", .type = color_type, .values = COLORS, .compression = MASK | ZIP, .is_half = half != 0},
            {.name = "material", .type = "Tree_int32_5_4_3", .values = MATERIALS, .compression = 0, .code = 6}};
        made_file made = begin_file(half != 0 ? 222 : 225, true, 5);
        put_grid(&made, &dust, true);
        for (int i = 0; i < 4; ++i) {
            put_grid(&made, &specs[i], true);
        }
        svo_voxels *list = read_file(&made, lines);
        expect_leaf(list, &specs[0], true);
        assert_string_equal(lines, NAME ": grid \"dust\" of type Tree_ptdataidx32_5_4_3 is not read\n" NAME
                                        ": grid \"heat\" is not read\n");
        svo_voxels_destroy(&list);
    }
}

/* An instance has the tree of another grid, before or behind it. */
static void test_instances(void **state)
{
    (void)state;
    static const double wide[15] = {2, 2, 2};
    const grid_spec shape = {.name = "shape", .type = "Tree_float_5_4_3", .values = ONES, .compression = MASK | ZIP};
    grid_spec copy = {.name = "copy",
                      .type = "Tree_float_5_4_3",
                      .parent = "shape",
                      .values = ONES,
                      .map = "UniformScaleMap",
                      .numbers = wide,
                      .number_count = 15};
    made_file made = begin_file(224, true, 2);
    put_grid(&made, &copy, true);
    put_grid(&made, &shape, true);
    svo_voxels *list = read_file(&made, NULL);
    expect_leaf(list, &shape, false);
    assert_true(info_of(list).voxel_edge == 2 && info_of(list).origin[1] == -1);
    svo_voxels_destroy(&list);
    copy.parent = "shade";
    for (int i = 0; i < 2; ++i) {
        svo_message message = {""};
        made = begin_file(224, true, 2);
        put_grid(&made, &copy, true);
        put_grid(&made, &shape, true);
        assert_int_equal(load(&made.bytes, made.bytes.count, NULL, &list, &message), SVO_FILE_DAMAGED);
        assert_non_null(strstr(message.text, i == 0 ? "is not there" : "has no such tree"));
        bytes_free(&made.bytes);
        copy.parent = "copy";
    }
}

/* A file without offsets is read in order; what has no known end cannot be skipped. */
static void test_streams(void **state)
{
    (void)state;
    const grid_spec shape = {.name = "shape", .type = "Tree_float_5_4_3", .values = ONES, .compression = MASK | ZIP};
    const grid_spec dust = {.name = "dust", .type = "Tree_ptdataidx32_5_4_3", .values = ONES, .compression = MASK};
    char lines[512] = "";
    svo_voxels *list = NULL;
    svo_message message = {""};
    made_file made = begin_file(224, false, 2);
    put_grid(&made, &shape, false);
    put_grid(&made, &shape, false);
    list = read_file(&made, lines);
    expect_leaf(list, &shape, false);
    assert_string_equal(lines, NAME ": grid \"shape\" is not read\n");
    svo_voxels_destroy(&list);
    made = begin_file(224, false, 2);
    put_grid(&made, &dust, false);
    assert_int_equal(load(&made.bytes, made.bytes.count, NULL, &list, &message), SVO_UNSUPPORTED);
    assert_non_null(strstr(message.text, "does not say where it ends"));
    bytes_free(&made.bytes);
    made = begin_file(224, true, 1);
    put_grid(&made, &dust, true);
    assert_int_equal(load(&made.bytes, made.bytes.count, NULL, &list, &message), SVO_UNSUPPORTED);
    assert_non_null(strstr(message.text, "none of its 1 grids"));
    bytes_free(&made.bytes);
}

/* Voxels of an active tile have the color of a tile in their place, and are white where that is not active. */
static void test_tiles(void **state)
{
    (void)state;
    for (int colored = 0; colored < 2; ++colored) {
        const grid_spec specs[] = {
            {.name = "fog", .type = "Tree_float_5_4_3", .values = ONES, .compression = MASK | ZIP, .has_tile = true},
            {.name = "color",
             .type = "Tree_vec3s_5_4_3",
             .values = COLORS,
             .compression = MASK,
             .has_tile = colored != 0}};
        made_file made = begin_file(224, true, 2);
        put_grid(&made, &specs[0], true);
        put_grid(&made, &specs[1], true);
        svo_voxels *list = read_file(&made, NULL);
        const svo_voxels_info info = info_of(list);
        uint64_t of_tile = 0;
        for (uint64_t i = 0; i < info.voxel_count; ++i) {
            const svo_voxel *voxel = &svo_voxels_get(list)[i];
            if (voxel->z < corner[2]) { /* the color of slot 1 */
                assert_true(voxel->z >= corner[2] - 8 && voxel->rgba[0] == 255);
                assert_int_equal(voxel->rgba[1], colored != 0 ? 0 : 255);
                ++of_tile;
            }
        }
        assert_int_equal(of_tile, LEAF);
        assert_int_equal(info.voxel_count, LEAF + (LEAF + 2) / 3);
        svo_voxels_destroy(&list);
    }
}

/* ---- maps ---- */

static void test_maps(void **state)
{
    (void)state;
    static const double scale[15] = {0.5, 0.5, 0.5};
    static const double place[18] = {4, 5, 6, 0.5, 0.5, 0.5};
    static const double uneven[15] = {0.5, 0.5, 0.25};
    static const double affine[16] = {0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 4, 5, 6, 1};
    static const double turned[16] = {0, 0.5, 0, 0, -0.5, 0, 0, 0, 0, 0, 0.5, 0, 4, 5, 6, 1};
    static const struct {
        const char *map;
        const double *numbers;
        size_t count;
        double edge, origin; /* along x; edge 0: refused */
    } cases[] = {{"UniformScaleMap", scale, 15, 0.5, -0.25},
                 {"ScaleMap", scale, 15, 0.5, -0.25},
                 {"ScaleMap", uneven, 15, 1, 0},
                 {"ScaleTranslateMap", place, 18, 0.5, 3.75},
                 {"UniformScaleTranslateMap", place, 18, 0.5, 3.75},
                 {"TranslationMap", place, 3, 1, 3.5},
                 {"AffineMap", affine, 16, 0.5, 3.75},
                 {"AffineMap", turned, 16, 0, 0},
                 {"NonlinearFrustumMap", place, 18, 0, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const grid_spec spec = {.name = "fog",
                                .type = "Tree_float_5_4_3",
                                .values = ONES,
                                .compression = MASK,
                                .map = cases[i].map,
                                .numbers = cases[i].numbers,
                                .number_count = cases[i].count};
        made_file made = make_file(&spec);
        svo_voxels *list = NULL;
        svo_message message = {""};
        char lines[512] = "";
        if (cases[i].edge == 0) {
            assert_int_equal(load(&made.bytes, made.bytes.count, lines, &list, &message), SVO_UNSUPPORTED);
            assert_non_null(strstr(message.text, cases[i].map));
            bytes_free(&made.bytes);
            continue;
        }
        list = read_file(&made, lines);
        assert_true((strstr(lines, "more than a width") != NULL) == (cases[i].numbers == uneven));
        assert_true(info_of(list).voxel_edge == cases[i].edge && info_of(list).origin[0] == cases[i].origin);
        svo_voxels_destroy(&list);
    }
}

/* ---- damage ---- */

/* A value of so many bytes at a place is refused with these words. */
static void refuse(const made_file *made, size_t at, uint64_t value, size_t bytes, svo_status expected,
                   const char *words)
{
    uint8_t before[8];
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    memcpy(before, made->bytes.bytes + at, bytes);
    memcpy(made->bytes.bytes + at, &value, bytes);
    const svo_status status = load(&made->bytes, made->bytes.count, NULL, &voxels, &message);
    if (status != expected || strstr(message.text, words) == NULL) {
        fail_msg("%s '%s', expected '%s'", svo_name(SVO_NAME_STATUS, status), message.text, words);
    }
    memcpy(made->bytes.bytes + at, before, bytes);
    svo_voxels_destroy(&voxels);
}

static void test_lies(void **state)
{
    (void)state;
    const grid_spec spec = {.name = "fog", .type = "Tree_float_5_4_3", .values = ONES, .compression = MASK | ZIP};
    const size_t name = sizeof "fog" - 1 + 4;
    made_file made = make_file(&spec);
    const svo_status damaged = SVO_FILE_DAMAGED;
    refuse(&made, 0, 'b', 1, damaged, "byte 0: neither");
    refuse(&made, 4, 1, 4, damaged, "byte 0: neither");
    refuse(&made, 8, 221, 4, SVO_UNSUPPORTED, "version 221 of the format is not read, 222 to 225 are");
    refuse(&made, 8, 226, 4, SVO_UNSUPPORTED, "version 226");
    refuse(&made, 57, UINT32_MAX, 4, damaged, "metadata are cut off");
    refuse(&made, 61, UINT32_MAX, 4, damaged, "metadata are cut off");
    refuse(&made, made.descriptor - 4, 0, 4, damaged, "holds no grid");
    refuse(&made, made.descriptor - 4, UINT32_MAX, 4, damaged, "more grids than can follow");
    refuse(&made, made.descriptor - 4, 2, 4, damaged, "descriptor is cut off");
    refuse(&made, made.descriptor, UINT32_MAX, 4, damaged, "descriptor is cut off");
    refuse(&made, made.descriptor + name + 4, 'U', 1, SVO_UNSUPPORTED, "none of its 1 grids");
    refuse(&made, made.offsets, made.grid - 1, 8, damaged, "offsets lie outside");
    refuse(&made, made.offsets, UINT64_MAX, 8, damaged, "offsets lie outside");
    refuse(&made, made.offsets + 8, UINT64_MAX, 8, damaged, "offsets lie outside");
    refuse(&made, made.offsets + 8, made.buffers - 1, 8, damaged, "do not end where values begin");
    refuse(&made, made.offsets + 16, made.end + 1, 8, damaged, "offsets lie outside");
    refuse(&made, made.offsets + 16, made.end - 1, 8, damaged, "cut off");
    refuse(&made, made.grid, 8, 4, SVO_UNSUPPORTED, "compression 8 is not read");
    refuse(&made, made.map, UINT32_MAX, 4, damaged, "the map is cut off");
    refuse(&made, made.map + 4, 'X', 1, SVO_UNSUPPORTED, "XniformScaleTranslateMap is not read");
    refuse(&made, made.tree, 2, 4, damaged, "buffers is not 1");
    refuse(&made, made.tree + 8, UINT32_MAX, 4, damaged, "more tiles than can follow");
    refuse(&made, made.tree + 8, 1, 4, damaged, "left out in an unknown way");
    refuse(&made, made.tree + 12, UINT32_MAX, 4, damaged, "more children than can follow");
    refuse(&made, made.tree + 12, 0, 4, damaged, "do not end where values begin");
    refuse(&made, made.table + 4, 2048, 4, damaged, "no multiple of 4096");
    refuse(&made, made.upper, 1, 1, damaged, "byte");
    refuse(&made, made.upper + UPPER / 8 + (31u << 10) / 8, 1, 1, damaged, "is a value too");
    refuse(&made, made.upper + UPPER / 8, 1, 1, damaged, "length of values is not that");
    refuse(&made, made.upper_values, 7, 1, damaged, "left out in an unknown way");
    refuse(&made, made.upper_values + 1, 1 << 20, 8, damaged, "length of values is not that");
    refuse(&made, made.upper_values + 1, UINT64_MAX, 8, damaged, "length of values is not that");
    refuse(&made, made.lower, UINT64_MAX, 8, damaged, "more children than can follow");
    refuse(&made, made.leaf, 0, 1, damaged, "two masks differ");
    refuse(&made, made.values, 7, 1, damaged, "left out in an unknown way");
    refuse(&made, made.values + 1, INT64_MAX, 8, damaged, "length of values is not that");
    refuse(&made, made.values + 9, 0, 1, damaged, "packed by ZIP are wrong");
    refuse(&made, made.end - 1, 0xee, 1, damaged, "packed by ZIP are wrong");
    bytes_free(&made.bytes);
    const grid_spec level_set = {
        .name = "fog", .type = "Tree_int32_5_4_3", .class = "level set", .values = MATERIALS, .compression = MASK};
    made = make_file(&level_set);
    refuse(&made, made.end - 4, 1, 4, damaged, "a level set without numbers");
    bytes_free(&made.bytes);
    const grid_spec material = {
        .name = "material", .type = "Tree_int32_5_4_3", .values = MATERIALS, .compression = MASK};
    made = make_file(&material);
    refuse(&made, made.end - 4, UINT32_MAX, 4, damaged, "a material is not in 0 .. 65534");
    refuse(&made, made.end - 4, UINT16_MAX, 4, damaged, "a material is not in 0 .. 65534");
    bytes_free(&made.bytes);
    const grid_spec bits = {
        .name = "fog", .type = "Tree_bool_5_4_3", .values = ONES, .compression = MASK, .is_bool = true};
    made = make_file(&bits);
    refuse(&made, made.values, 0, 4, damaged, "another place than its parent");
    /* An active tile of 128^3 voxels. */
    refuse(&made, made.upper + UPPER / 8, 1, 1, damaged, "byte");
    bytes_free(&made.bytes);
}

/* A cube of voxels above the limit is refused before there is memory for it. */
static void test_limits(void **state)
{
    (void)state;
    made_file made = begin_file(224, true, 1);
    const grid_spec spec = {.name = "fog", .type = "Tree_float_5_4_3", .values = ONES, .compression = MASK};
    const int32_t place[3] = {0, 4096, -8192};
    const float one = 1.0F;
    svo_voxels *list = NULL;
    svo_message message = {""};
    put_grid(&made, &spec, true);
    made.bytes.count = made.tree;
    bytes_put_i32(&made.bytes, 1);
    bytes_put_i32(&made.bytes, 0);
    bytes_put_i32(&made.bytes, 1);
    bytes_put_i32(&made.bytes, 0);
    bytes_put(&made.bytes, place, sizeof place);
    bytes_put(&made.bytes, &one, sizeof one);
    bytes_put_u8(&made.bytes, 1);
    const int64_t end[2] = {(int64_t)made.bytes.count, (int64_t)made.bytes.count};
    memcpy(made.bytes.bytes + made.offsets + 8, end, sizeof end);
    assert_int_equal(load(&made.bytes, made.bytes.count, NULL, &list, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "68719476736 voxels are above the limit of 1048576"));
    made.bytes.bytes[made.bytes.count - 1] = 0; /* not active */
    assert_int_equal(load(&made.bytes, made.bytes.count, NULL, &list, &message), SVO_OK);
    assert_int_equal(info_of(list).voxel_count, 0);
    svo_voxels_destroy(&list);
    bytes_free(&made.bytes);
}

/* ---- there and back ---- */

static uint32_t roll(uint32_t *seed, uint32_t limit)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) % limit;
}

static int append(void *user, const void *bytes, size_t byte_count)
{
    bytes_put(user, bytes, byte_count);
    return 0;
}

/* Voxels around the origin, some close together, in nodes of all levels. */
static svo_voxels *make_list(uint32_t seed, size_t count, bool plain)
{
    static const uint32_t wide[3] = {4, 200, 20000};
    svo_voxel *voxels = calloc(count + 1, sizeof *voxels);
    svo_voxels *made = NULL;
    assert_non_null(voxels);
    for (size_t i = 0; i < count; ++i) {
        const uint32_t extent = wide[i % 3];
        const int32_t half = (int32_t)(extent / 2);
        voxels[i] = (svo_voxel){.x = (int32_t)roll(&seed, extent) - half,
                                .y = (int32_t)roll(&seed, extent) - half,
                                .z = (int32_t)roll(&seed, extent) - half,
                                .rgba = {255, 255, 255, 255}};
        if (!plain) {
            voxels[i].material = (uint16_t)roll(&seed, 65535);
            for (int c = 0; c < 3; ++c) {
                voxels[i].rgba[c] = (uint8_t)roll(&seed, 256);
            }
        }
    }
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = voxels;
    source.voxel_count = count;
    source.voxel_edge = 0.1;
    source.origin[0] = -1.0 / 3.0;
    source.origin[2] = 1e6;
    assert_int_equal(svo_voxels_create(&source, &made, NULL), SVO_OK);
    free(voxels);
    return made;
}

static byte_list save(const svo_voxels *list)
{
    byte_list file = {0};
    svo_message message = {""};
    if (svo_voxels_save(list, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_VDB, NULL, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return file;
}

static void test_round_trips(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        svo_voxels *list = make_list(7, kind == 2 ? 0 : DICE, kind != 0);
        svo_voxels *read = NULL;
        byte_list file = save(list);
        byte_list again = save(list);
        const svo_voxels_info info = info_of(list);
        assert_int_equal(file.count, again.count);
        assert_memory_equal(file.bytes, again.bytes, file.count);
        assert_int_equal(load(&file, file.count, NULL, &read, NULL), SVO_OK);
        const svo_voxels_info found = info_of(read);
        assert_int_equal(found.voxel_count, info.voxel_count);
        assert_true(found.voxel_edge == info.voxel_edge);
        for (int axis = 0; axis < 3; ++axis) { /* the center of a voxel is rounded */
            assert_true(fabs(found.origin[axis] - info.origin[axis]) <= 1e-9);
        }
        assert_memory_equal(svo_voxels_get(read), svo_voxels_get(list), info.voxel_count * sizeof(svo_voxel));
        svo_voxels_destroy(&list);
        svo_voxels_destroy(&read);
        bytes_free(&file);
        bytes_free(&again);
    }
}

/* Changed bytes and cut files end in one line or in a list. */
static void test_changes(void **state)
{
    (void)state;
    svo_voxels *list = make_list(9, 5, false);
    byte_list file = save(list);
    uint32_t seed = 3;
    size_t read = 0;
    svo_voxels_destroy(&list);
    for (int i = 0; i < CHANGES; ++i) {
        size_t at = roll(&seed, (uint32_t)(i % 3 == 0 ? 700 : file.count));
        for (int tries = 0; tries < 9000 && file.bytes[at] == 0 && i % 7 != 0; ++tries) { /* most are empty */
            at = (at + 1) % file.count;
        }
        const uint8_t before = file.bytes[at];
        svo_voxels *voxels = NULL;
        svo_message message = {""};
        file.bytes[at] = (uint8_t)roll(&seed, 256);
        const svo_status status = load(&file, i % 11 == 0 ? at : file.count, NULL, &voxels, &message);
        file.bytes[at] = before;
        if (status == SVO_OK) {
            ++read;
            svo_voxels_destroy(&voxels);
            continue;
        }
        if (voxels != NULL || (strncmp(message.text, NAME ": ", strlen(NAME ": ")) != 0 && at != 0) ||
            (status == SVO_FILE_DAMAGED && strstr(message.text, "byte") == NULL)) {
            fail_msg("%s: '%s'", svo_name(SVO_NAME_STATUS, status), message.text);
        }
    }
    assert_in_range(read, CHANGES / 50, CHANGES);
    bytes_free(&file);
}

/* ---- distance fields ---- */

#define SIDE  32u
#define SITES (SIDE * SIDE * SIDE)

static float ball_distance(const uint32_t cell[3])
{
    float sum = 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
        const float d = (float)cell[axis] - 15.25F;
        sum += d * d;
    }
    return sqrtf(sum) - 9.5F;
}

/* What is inside of a ball comes back as voxels, from a band and from a dense field. */
static void test_distances(void **state)
{
    (void)state;
    float *distances = malloc(SITES * sizeof *distances);
    uint64_t *codes = malloc(SITES * sizeof *codes);
    svo_message message = {""};
    assert_non_null(distances);
    assert_non_null(codes);
    for (int dense = 0; dense < 2; ++dense) {
        svo_sdf sdf = {
            .info = {.struct_size = sizeof sdf.info, .depth = 5, .band = dense != 0 ? 0.0F : 2.0F, .spacing = 0.5},
            .host = {distances, dense != 0 ? NULL : codes}};
        byte_list file = {0};
        svo_voxels *list = NULL;
        uint64_t inside = 0;
        for (uint64_t i = 0; i < SITES; ++i) { /* codes for a band, rows for a dense field */
            uint32_t cell[3] = {(uint32_t)i % SIDE, (uint32_t)i / SIDE % SIDE, (uint32_t)i / SIDE / SIDE};
            if (dense == 0) {
                svo_code_to_cell(i, cell);
            }
            const float distance = ball_distance(cell);
            inside += distance < 0;
            if (dense != 0 || fabsf(distance) < 2.0F) {
                codes[sdf.info.voxel_count] = i;
                distances[sdf.info.voxel_count++] = 0.5F * distance;
            }
        }
        assert_int_equal(svo_sdf_save_as(&sdf, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_VDB, &message), SVO_OK);
        assert_int_equal(load(&file, file.count, NULL, &list, &message), SVO_OK);
        assert_int_equal(info_of(list).voxel_count, inside);
        for (uint64_t i = 0; i < inside; ++i) {
            const svo_voxel *voxel = &svo_voxels_get(list)[i];
            const uint32_t cell[3] = {(uint32_t)voxel->x, (uint32_t)voxel->y, (uint32_t)voxel->z};
            assert_true(ball_distance(cell) < 0);
        }
        assert_true(info_of(list).voxel_edge == 0.5);
        assert_int_equal(svo_sdf_save_as(&sdf, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_VOX, &message),
                         SVO_INVALID_ARGUMENT);
        assert_string_equal(message.text, "svo_sdf_save_as: format 1 is neither 6 nor 11");
        assert_int_equal(svo_sdf_save_as(&sdf, svo_to_path("x.vox"), SVO_VOXEL_FORMAT_AUTO, &message),
                         SVO_INVALID_ARGUMENT);
        svo_voxels_destroy(&list);
        bytes_free(&file);
    }
    free(distances);
    free(codes);
}

TEST_GROUP(vdb)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),      cmocka_unit_test(test_occupancy), cmocka_unit_test(test_grids),
        cmocka_unit_test(test_instances),   cmocka_unit_test(test_streams),   cmocka_unit_test(test_tiles),
        cmocka_unit_test(test_maps),        cmocka_unit_test(test_lies),      cmocka_unit_test(test_limits),
        cmocka_unit_test(test_round_trips), cmocka_unit_test(test_changes),   cmocka_unit_test(test_distances),
    };
    return cmocka_run_group_tests_name("vdb", tests, NULL, NULL);
}
