/* SPDX-License-Identifier: MIT */
/*
 * .nvdb files: NanoVDB's own reader finds the voxels that were written, and the reader finds those of files that
 * NanoVDB writes; files that lie about their nodes are refused, byte by byte.
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

#include "io/voxels_nvdb_file.h"
#include "nvdb_peer.h"
#include "sdf/handle.h"
#include "support/suite.h"
#include "svocl/nodes.h"
#include "svocl/voxel_files.h"

#define NAME "file"

enum { DICE = 300, CHANGES = 1500 };

/* ---- lists and files ---- */

static uint32_t roll(uint32_t *seed, uint32_t limit)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) % limit;
}

/* Voxels around the origin, some close together, in nodes of all levels; of that many colors and materials. */
static svo_voxels *make_list(uint32_t seed, size_t count, bool plain)
{
    static const uint32_t wide[3] = {4, 200, 9000};
    svo_voxel *voxels = calloc(count, sizeof *voxels);
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
            for (int c = 0; c < 4; ++c) {
                voxels[i].rgba[c] = (uint8_t)roll(&seed, 256);
            }
        }
    }
    svo_voxels_source source = SVO_VOXELS_SOURCE_INIT;
    source.voxels = voxels;
    source.voxel_count = count;
    source.voxel_edge = 0.125;
    source.origin[0] = -3.0;
    source.origin[2] = 0.5;
    assert_int_equal(svo_voxels_create(&source, &made, NULL), SVO_OK);
    free(voxels);
    return made;
}

static svo_voxels_info info_of(const svo_voxels *voxels)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
    return info;
}

static void make_path(char path[64])
{
    (void)snprintf(path, 64, "/tmp/svocl_nvdb_XXXXXX");
    const int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    assert_int_equal(close(descriptor), 0);
}

static uint8_t *read_whole(const char *path, size_t *count)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    *count = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(*count);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *count, file), *count);
    assert_int_equal(fclose(file), 0);
    return bytes;
}

static void save(const svo_voxels *voxels, const char *path)
{
    svo_message message = {""};
    if (svo_voxels_save(voxels, svo_to_path(path), SVO_VOXEL_FORMAT_NVDB, NULL, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
}

static int compare_places(const void *a, const void *b)
{
    return memcmp(((const nvdb_voxel *)a)->at, ((const nvdb_voxel *)b)->at, sizeof((const nvdb_voxel *)a)->at);
}

/* Both have the same voxels with the same colors and materials. */
static void expect_same(const svo_voxels *list, nvdb_voxel *other, size_t count)
{
    const svo_voxels_info info = info_of(list);
    assert_int_equal(info.voxel_count, count);
    qsort(other, count, sizeof *other, compare_places);
    for (size_t i = 0; i < count; ++i) {
        const svo_voxel *voxel = &svo_voxels_get(list)[i];
        const nvdb_voxel key = {.at = {voxel->x, voxel->y, voxel->z}};
        const nvdb_voxel *found = bsearch(&key, other, count, sizeof key, compare_places);
        if (found == NULL) {
            fail_msg("no voxel at %d %d %d", voxel->x, voxel->y, voxel->z);
            return;
        }
        assert_memory_equal(found->rgba, voxel->rgba, sizeof voxel->rgba);
        assert_int_equal(found->material, voxel->material);
    }
}

/* ---- NanoVDB reads what was written, and the other way ---- */

static void test_nanovdb_reads(void **state)
{
    (void)state;
    char path[64];
    make_path(path);
    for (int plain = 0; plain < 2; ++plain) {
        nvdb_voxel *found = NULL;
        size_t count = 0;
        svo_voxels *list = make_list(5, DICE, plain != 0);
        const svo_voxels_info info = info_of(list);
        save(list, path);
        const char *problem = nvdb_peer_read(path, &found, &count);
        if (problem != NULL) {
            fail_msg("%s", problem);
        }
        for (size_t i = 0; i < count; ++i) {
            for (int axis = 0; axis < 3; ++axis) {
                assert_true(found[i].center[axis] == info.origin[axis] + (found[i].at[axis] + 0.5) * info.voxel_edge);
            }
        }
        expect_same(list, found, count);
        free(found);
        svo_voxels_destroy(&list);
    }
    assert_int_equal(unlink(path), 0);
}

static void keep_line(void *user, svo_log_level level, const char *text)
{
    char *lines = user;
    (void)level;
    (void)snprintf(lines + strlen(lines), 256 - strlen(lines), "%s\n", text);
}

static void test_nanovdb_writes(void **state)
{
    (void)state;
    char path[64];
    make_path(path);
    for (int kind = 0; kind < NVDB_KINDS; ++kind) {
        char lines[256] = "";
        nvdb_voxel *expected = NULL;
        size_t count = 0;
        svo_voxels *list = NULL;
        svo_message message = {""};
        const svo_voxels_load_options options = {.struct_size = sizeof options, .log = keep_line, .log_user = lines};
        nvdb_peer_write(path, (nvdb_kind)kind, &expected, &count);
        if (svo_voxels_load(svo_from_path(path), &options, &list, NULL, &message) != SVO_OK) {
            fail_msg("kind %d: %s", kind, message.text);
        }
        assert_true(count > 50);
        expect_same(list, expected, count);
        assert_true((strstr(lines, "grid \"heat\" is not read") != NULL) == (kind == NVDB_COLORS));
        if (kind == NVDB_COLORS) {
            assert_true(info_of(list).voxel_edge == 0.25 && info_of(list).origin[1] == 2.0 - 0.125);
        }
        free(expected);
        svo_voxels_destroy(&list);
    }
    assert_int_equal(unlink(path), 0);
}

/* ---- damage ---- */

/* A file of one grid, and where its parts begin in it. Checksums are taken out, so that a change is met where it is. */
typedef struct nvdb_bytes {
    uint8_t *bytes;
    size_t count;
    size_t grid, root, nodes[VDB_NODE_LEVELS];
} nvdb_bytes;

static nvdb_bytes make_file(size_t voxel_count)
{
    char path[64];
    nvdb_bytes file;
    uint64_t offset = 0;
    make_path(path);
    svo_voxels *list = make_list(9, voxel_count, true);
    save(list, path);
    svo_voxels_destroy(&list);
    file.bytes = read_whole(path, &file.count);
    assert_int_equal(unlink(path), 0);
    file.grid = NVDB_HEADER_BYTES + NVDB_RECORD_BYTES + sizeof VDB_DENSITY;
    memset(file.bytes + file.grid + PNANOVDB_GRID_OFF_CHECKSUM, 0xff, 8);
    const size_t tree = file.grid + PNANOVDB_GRID_SIZE;
    memcpy(&offset, file.bytes + tree + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT, sizeof offset);
    file.root = tree + (size_t)offset;
    for (size_t level = 0; level < VDB_NODE_LEVELS; ++level) {
        memcpy(&offset, file.bytes + tree + 8 * level, sizeof offset);
        file.nodes[level] = tree + (size_t)offset;
    }
    return file;
}

static svo_status load(const nvdb_bytes *file, size_t count, svo_voxels **voxels, svo_message *message)
{
    const svo_voxels_load_options options = {.struct_size = sizeof options, .voxels_max = 1 << 20};
    uint8_t *exact = malloc(count + 1); /* a sanitizer sees a read behind it */
    assert_non_null(exact);
    memcpy(exact + 1, file->bytes, count); /* nothing is aligned */
    const svo_status status = svo_voxels_load(svo_from_memory(exact + 1, count, NAME), &options, voxels, NULL, message);
    free(exact);
    return status;
}

/* A value of so many bytes at a place is refused with these words. */
static void refuse(const nvdb_bytes *file, size_t at, uint64_t value, size_t bytes, svo_status expected,
                   const char *words)
{
    uint8_t before[8];
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    memcpy(before, file->bytes + at, bytes);
    memcpy(file->bytes + at, &value, bytes);
    const svo_status status = load(file, file->count, &voxels, &message);
    if (status != expected || strstr(message.text, words) == NULL) {
        fail_msg("%s '%s', expected '%s'", svo_name(SVO_NAME_STATUS, status), message.text, words);
    }
    memcpy(file->bytes + at, before, bytes);
    svo_voxels_destroy(&voxels);
}

static void test_lies(void **state)
{
    (void)state;
    nvdb_bytes file = make_file(1);
    const size_t tree = file.grid + PNANOVDB_GRID_SIZE;
    const pnanovdb_grid_type_constants_t *p = &pnanovdb_grid_type_constants[PNANOVDB_GRID_TYPE_FP4];
    const size_t tile = file.root + p->root_size;
    size_t entry = file.nodes[VDB_LOWER] + p->lower_off_table;
    while (file.bytes[entry] == 0 && file.bytes[entry + 1] == 0) { /* the one child of the one lower node */
        entry += p->table_stride;
    }
    refuse(&file, 0, 'M', 1, SVO_FILE_DAMAGED, "byte 0: neither");
    refuse(&file, NVDB_HEADER_VERSION, 33u << NVDB_MAJOR_SHIFT, 4, SVO_UNSUPPORTED, "version 33 of the format");
    refuse(&file, NVDB_HEADER_COMPRESSION, 1, 2, SVO_UNSUPPORTED, "packed grids are not read");
    refuse(&file, NVDB_HEADER_GRID_COUNT, 0, 2, SVO_FILE_DAMAGED, "no segment of grids begins at byte 16");
    refuse(&file, NVDB_HEADER_BYTES + NVDB_RECORD_NAME_BYTES, UINT32_MAX, 4, SVO_FILE_DAMAGED, "record of grid 0");
    refuse(&file, NVDB_HEADER_BYTES + NVDB_RECORD_FILE_BYTES, UINT64_MAX, 8, SVO_FILE_DAMAGED, "is cut off");
    refuse(&file, file.grid + PNANOVDB_GRID_OFF_GRID_SIZE, 1, 8, SVO_FILE_DAMAGED, "not that of its record");
    refuse(&file, file.grid + PNANOVDB_GRID_OFF_GRID_TYPE, PNANOVDB_GRID_TYPE_FPN, 4, SVO_UNSUPPORTED,
           "values of type 16 are not read");
    refuse(&file, file.grid + PNANOVDB_GRID_OFF_CHECKSUM, 7, 4, SVO_FILE_DAMAGED, "the checksum of its headers");
    refuse(&file, file.grid + PNANOVDB_GRID_OFF_CHECKSUM + 4, 7, 4, SVO_FILE_DAMAGED, "the checksum of its nodes");
    refuse(&file, tree + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT, 1u << 30, 8, SVO_FILE_DAMAGED, "the root lies outside");
    refuse(&file, tree + PNANOVDB_TREE_OFF_NODE_OFFSET_ROOT, UINT64_MAX - 8, 8, SVO_FILE_DAMAGED, "the root lies");
    refuse(&file, file.root + PNANOVDB_ROOT_OFF_TABLE_SIZE, UINT32_MAX, 4, SVO_FILE_DAMAGED, "table ends outside");
    refuse(&file, tree + PNANOVDB_TREE_OFF_NODE_COUNT_LEAF, 2, 4, SVO_FILE_DAMAGED, "nodes lie outside");
    refuse(&file, tree + PNANOVDB_TREE_OFF_NODE_COUNT_UPPER, 0, 4, SVO_FILE_DAMAGED, "leads to no node");
    refuse(&file, tree + PNANOVDB_TREE_OFF_NODE_OFFSET_LEAF, 64, 8, SVO_FILE_DAMAGED, "nodes lie outside");
    refuse(&file, tile + PNANOVDB_ROOT_TILE_OFF_CHILD, 32, 8, SVO_FILE_DAMAGED, "leads to no node");
    refuse(&file, entry, 32, 8, SVO_FILE_DAMAGED, "leads to no node");
    refuse(&file, entry + 8, 32, 8, SVO_OK, ""); /* no child has that entry */
    refuse(&file, file.nodes[VDB_UPPER] + PNANOVDB_UPPER_OFF_VALUE_MASK, 1, 1, SVO_INVALID_ARGUMENT,
           "above the limit of 1048576"); /* a tile of 128^3 voxels */
    free(file.bytes);
}

/* A leaf becomes an active tile, which is 512 voxels. */
static void test_tiles(void **state)
{
    (void)state;
    nvdb_bytes file = make_file(1);
    svo_voxels *voxels = NULL;
    uint8_t *children = file.bytes + file.nodes[VDB_LOWER] + PNANOVDB_LOWER_OFF_CHILD_MASK;
    uint8_t *values = file.bytes + file.nodes[VDB_LOWER] + PNANOVDB_LOWER_OFF_VALUE_MASK;
    for (size_t i = 0; i < 512; ++i) {
        values[i] = children[i];
        children[i] = 0;
    }
    assert_int_equal(load(&file, file.count, &voxels, NULL), SVO_OK);
    const svo_voxels_info info = info_of(voxels);
    assert_int_equal(info.voxel_count, 512);
    for (int axis = 0; axis < 3; ++axis) {
        assert_int_equal(info.high[axis] - info.low[axis], 8);
        assert_int_equal(info.low[axis] % 8, 0);
    }
    svo_voxels_destroy(&voxels);
    free(file.bytes);
}

/* Density 1 becomes -1, inside of a level set; what has code 0 stays outside. */
static void test_level_set_of_four_bits(void **state)
{
    (void)state;
    nvdb_bytes file = make_file(40);
    const pnanovdb_grid_type_constants_t *p = &pnanovdb_grid_type_constants[PNANOVDB_GRID_TYPE_FP4];
    const uint32_t level_set = PNANOVDB_GRID_CLASS_LEVEL_SET;
    const float below = -1.0f;
    svo_voxels *before = NULL;
    svo_voxels *after = NULL;
    assert_int_equal(load(&file, file.count, &before, NULL), SVO_OK);
    memcpy(file.bytes + file.grid + PNANOVDB_GRID_OFF_GRID_CLASS, &level_set, sizeof level_set);
    for (size_t leaf = file.nodes[VDB_LEAF]; leaf < file.count; leaf += p->leaf_size) {
        memcpy(file.bytes + leaf + p->leaf_off_table - PNANOVDB_LEAF_TABLE_NEG_OFF_QUANTUM, &below, sizeof below);
        memset(file.bytes + leaf + PNANOVDB_LEAF_OFF_VALUE_MASK, 0, 64);
    }
    assert_int_equal(load(&file, file.count, &after, NULL), SVO_OK);
    const svo_voxels_info info = info_of(before);
    assert_int_equal(info_of(after).voxel_count, info.voxel_count);
    assert_memory_equal(svo_voxels_get(after), svo_voxels_get(before), info.voxel_count * sizeof(svo_voxel));
    svo_voxels_destroy(&before);
    svo_voxels_destroy(&after);
    free(file.bytes);
}

/* Changed fields and cut files end in one line or in a list. */
static void test_changes(void **state)
{
    (void)state;
    nvdb_bytes file = make_file(4);
    uint32_t seed = 3;
    size_t read = 0;
    for (int i = 0; i < CHANGES; ++i) {
        const size_t parts[5] = {0, file.grid, file.root, file.nodes[i % 2 == 0 ? VDB_UPPER : VDB_LOWER],
                                 file.nodes[VDB_LEAF]};
        size_t at = parts[i % 5] + roll(&seed, i % 5 < 2 ? 700 : 9000);
        if (at >= file.count) {
            continue;
        }
        for (int tries = 0; tries < 3000 && file.bytes[at] == 0 && i % 7 != 0; ++tries) { /* most are empty */
            at = at + 1 < file.count ? at + 1 : 0;
        }
        const uint8_t before = file.bytes[at];
        svo_voxels *voxels = NULL;
        svo_message message = {""};
        file.bytes[at] = (uint8_t)roll(&seed, 256);
        const svo_status status = load(&file, i % 11 == 0 ? at : file.count, &voxels, &message);
        file.bytes[at] = before;
        if (status == SVO_OK) {
            ++read;
            svo_voxels_destroy(&voxels);
            continue;
        }
        if (voxels != NULL || strncmp(message.text, NAME ": ", strlen(NAME ": ")) != 0 ||
            (status == SVO_FILE_DAMAGED && strstr(message.text, "byte") == NULL)) {
            fail_msg("byte %zu: %s '%s'", at, svo_name(SVO_NAME_STATUS, status), message.text);
        }
    }
    assert_true(read > CHANGES / 20 && read < CHANGES / 20 * 19);
    free(file.bytes);
}

/* ---- distances ---- */

enum { SIDE = 64, SITES = SIDE * SIDE * SIDE };

/* Of a hollow ball, in voxels; its inside has whole leaves. */
static float ball_distance(const uint32_t cell[3])
{
    const double x = cell[0] - 31.3;
    const double y = cell[1] - 30.8;
    const double z = cell[2] - 32.1;
    const double away = sqrt(x * x + y * y + z * z);
    return (float)fmax(away - 27.4, 4.2 - away);
}

static uint64_t find_band(float band, float *distances, uint64_t *codes)
{
    uint64_t count = 0;
    for (uint64_t code = 0; code < SITES; ++code) {
        uint32_t cell[3];
        svo_code_to_cell(code, cell);
        const float distance = ball_distance(cell);
        if (fabsf(distance) < band) {
            distances[count] = 0.25F * distance;
            codes[count++] = code;
        }
    }
    return count;
}

/* NanoVDB finds the band's distances in their places, and signs of all else. */
static void check_surface(const char *path, float band, const double origin[3])
{
    nvdb_distance *values = malloc(SITES * sizeof *values);
    double center[3];
    assert_non_null(values);
    const char *problem = nvdb_peer_read_surface(path, SIDE, values, center);
    if (problem != NULL) {
        fail_msg("%s", problem);
    }
    for (uint32_t i = 0; i < SITES; ++i) {
        const uint32_t cell[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        const float distance = ball_distance(cell);
        const bool is_active = band == 0 || fabsf(distance) < band;
        const float expected = 0.25F * (is_active ? distance : distance < 0 ? -band : band);
        if (values[i].value != expected || (values[i].is_active != 0) != is_active) {
            fail_msg("voxel %u %u %u: %.9g, not %.9g", cell[0], cell[1], cell[2], (double)values[i].value,
                     (double)expected);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        assert_true(center[axis] == origin[axis] + 0.125);
    }
    free(values);
}

static void test_distances(void **state)
{
    (void)state;
    static const double origin[3] = {-3.0, 2.5, 0.75};
    static const float bands[] = {2.5F, 6.0F, 0.0F};
    float *distances = malloc(SITES * sizeof *distances);
    uint64_t *codes = malloc(SITES * sizeof *codes);
    svo_message message = {""};
    char path[64];
    assert_non_null(distances);
    assert_non_null(codes);
    make_path(path);
    for (int i = 0; i < 3; ++i) {
        /* A field without a device. */
        svo_sdf sdf = {.info = {.struct_size = sizeof sdf.info, .depth = 6, .band = bands[i], .spacing = 0.25},
                       .host = {distances, bands[i] > 0 ? codes : NULL}};
        memcpy(sdf.info.origin, origin, sizeof sdf.info.origin);
        sdf.info.voxel_count = find_band(bands[i] > 0 ? bands[i] : 1000.0F, distances, codes);
        for (uint32_t at = 0; at < SITES && bands[i] == 0; ++at) {
            const uint32_t cell[3] = {at % SIDE, at / SIDE % SIDE, at / SIDE / SIDE};
            distances[at] = 0.25F * ball_distance(cell);
        }
        if (svo_sdf_save(&sdf, svo_to_path(path), &message) != SVO_OK) {
            fail_msg("%s", message.text);
        }
        check_surface(path, bands[i], origin);
        /* What is inside comes back as voxels. */
        uint64_t inside = 0;
        svo_voxels *list = NULL;
        for (uint64_t code = 0; code < SITES; ++code) {
            uint32_t cell[3];
            svo_code_to_cell(code, cell);
            inside += ball_distance(cell) < 0;
        }
        assert_int_equal(svo_voxels_load(svo_from_path(path), NULL, &list, NULL, &message), SVO_OK);
        assert_int_equal(info_of(list).voxel_count, inside);
        svo_voxels_destroy(&list);
    }
    svo_sdf wrong = {.info = {.struct_size = sizeof wrong.info, .depth = 13, .voxel_count = 1}};
    assert_int_equal(svo_sdf_save(&wrong, svo_to_path(path), &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "call svo_sdf_download first"));
    wrong.host[SVO_SDF_DISTANCES] = distances;
    assert_int_equal(svo_sdf_save(&wrong, svo_to_path(path), &message), SVO_UNSUPPORTED);
    assert_non_null(strstr(message.text, "depth 13 is above 12"));
    assert_int_equal(svo_sdf_save(NULL, svo_to_path(path), &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(unlink(path), 0);
    free(distances);
    free(codes);
}

TEST_GROUP(nvdb)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nanovdb_reads),
        cmocka_unit_test(test_nanovdb_writes),
        cmocka_unit_test(test_lies),
        cmocka_unit_test(test_tiles),
        cmocka_unit_test(test_level_set_of_four_bits),
        cmocka_unit_test(test_changes),
        cmocka_unit_test(test_distances),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
