/* SPDX-License-Identifier: MIT */
/*
 * A saved .svo file loads as the same tree. Every flipped byte, truncation and broken structure is refused with a
 * message that names it. A failed save leaves no file behind.
 */
#define _GNU_SOURCE /* O_TMPFILE */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/tree.h"
#include "io/file_format.h"
#include "svocl/io.h"
#include "svocl/plan.h"

#define DEPTH             3
#define NEED_ALL          ((uint32_t)SVO_NEED_ALL)
#define NEED_WITHOUT_RAYS (NEED_ALL & ~(uint32_t)SVO_NEED_RAYS)
#define PATH_BYTES        512

static char directory[PATH_BYTES];

static const char *path_of(const char *name)
{
    static char path[2 * PATH_BYTES];
    const int length = snprintf(path, sizeof path, "%s/%s", directory, name);
    assert_true(length > 0 && (size_t)length < sizeof path);
    return path;
}

static void *allocate(size_t bytes)
{
    void *memory = calloc(1, bytes > 0 ? bytes : 1);
    assert_non_null(memory);
    return memory;
}

/* An array that a tree owns. */
static void *allocate_array(size_t bytes)
{
    void *memory = svo_i_alloc_zeroed(NULL, 1, bytes);
    assert_non_null(memory);
    return memory;
}

/* Fills the arrays parallel to nodes and leaves with values that differ per element. */
static void fill_payload(svo_tree *tree)
{
    svo_tree_info *info = &tree->info;
    uint8_t *colors = allocate_array(info->node_count * 4);
    int16_t *normals = allocate_array(info->node_count * 6);
    uint16_t *materials = allocate_array(info->node_count * 2);
    uint16_t *fills = allocate_array(info->node_count * 2);
    uint16_t *areas = allocate_array(info->leaf_count * 12);
    for (uint64_t i = 0; i < info->node_count; ++i) {
        memset(colors + 4 * i, (int)(i * 7 % 256), 4);
        normals[3 * i] = (int16_t)(i * 100);
        materials[i] = (uint16_t)(i * 11);
        fills[i] = (uint16_t)(i * 13 + 1);
    }
    for (uint64_t i = 0; i < info->leaf_count * 6; ++i) {
        areas[i] = (uint16_t)(i * 17 + 1);
    }
    tree->host[SVO_TREE_COLORS] = colors;
    tree->host[SVO_TREE_NORMALS] = normals;
    tree->host[SVO_TREE_MATERIALS] = materials;
    tree->host[SVO_TREE_FILLS] = fills;
    tree->host[SVO_TREE_AREAS] = areas;

    /* Leaf k meets triangle 0 and, if k is odd, triangle 1. */
    info->vertex_count = 4;
    info->list_triangle_count = 2;
    uint32_t *list_begin = allocate_array((info->leaf_count + 1) * sizeof *list_begin);
    uint32_t *list = allocate_array(2 * info->leaf_count * sizeof *list);
    uint32_t count = 0;
    for (uint32_t leaf = 0; leaf < info->leaf_count; ++leaf) {
        list[count++] = 0;
        if (leaf % 2 == 1) {
            list[count++] = 1;
        }
        list_begin[leaf + 1] = count;
    }
    info->list_count = count;
    info->fragments = count;
    tree->host[SVO_TREE_LIST_BEGIN] = list_begin;
    tree->host[SVO_TREE_LIST] = list;
    int32_t *vertices = allocate_array(12 * sizeof *vertices);
    uint32_t *indices = allocate_array(6 * sizeof *indices);
    uint32_t *triangle_ids = allocate_array(2 * sizeof *triangle_ids);
    memcpy(vertices, (const int32_t[]){0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0, -9}, 12 * sizeof *vertices);
    memcpy(indices, (const uint32_t[]){0, 1, 2, 1, 2, 3}, 6 * sizeof *indices);
    memcpy(triangle_ids, (const uint32_t[]){1, 4}, 2 * sizeof *triangle_ids);
    float *positions = allocate_array(12 * sizeof *positions);
    for (int i = 0; i < 12; ++i) {
        positions[i] = (float)vertices[i] / 3.0f;
    }
    info->positions = SVO_POSITIONS_FLOAT;
    tree->host[SVO_TREE_POSITIONS] = positions;
    tree->host[SVO_TREE_VERTICES] = vertices;
    tree->host[SVO_TREE_INDICES] = indices;
    tree->host[SVO_TREE_TRIANGLE_IDS] = triangle_ids;
}

/* Codes of the parents: unique and in order. Returns their count; masks[i] gets parent i's children. */
static size_t raise_level(const uint32_t *codes, size_t count, uint32_t *parents, uint8_t *masks)
{
    size_t parent_count = 0;
    for (size_t i = 0; i < count; ++i) {
        if (parent_count == 0 || parents[parent_count - 1] != codes[i] >> 3) {
            parents[parent_count] = codes[i] >> 3;
            masks[parent_count++] = 0;
        }
        masks[parent_count - 1] |= (uint8_t)(1u << (codes[i] & 7));
    }
    return parent_count;
}

/* The tree of ascending Morton codes at depth 3; no code gives the empty tree. */
static svo_tree *make_tree(const uint32_t *codes, size_t count, uint32_t need)
{
    uint32_t levels[DEPTH + 1][512];
    uint8_t masks[DEPTH + 1][512] = {{0}};
    size_t counts[DEPTH + 1] = {1, 0, 0, count};
    memcpy(levels[DEPTH], codes, count * sizeof *codes);
    for (int level = DEPTH; level > 0 && count > 0; --level) {
        counts[level - 1] = raise_level(levels[level], counts[level], levels[level - 1], masks[level - 1]);
    }
    svo_tree *tree = svo_i_tree_new(NULL);
    assert_non_null(tree);
    svo_tree_info *info = &tree->info;
    *info = (svo_tree_info){.depth = DEPTH, .snap_bits = 20, .need = NEED_ALL, .edge = 2, .scale = 3, .triangles = 9};
    for (int level = 0; level <= DEPTH; ++level) {
        info->level_begin[level + 1] = info->level_begin[level] + (uint32_t)counts[level];
    }
    info->inner_count = info->level_begin[DEPTH];
    info->node_count = info->level_begin[DEPTH + 1];
    info->leaf_count = info->node_count - info->inner_count;
    uint8_t *child_mask = allocate_array(info->inner_count);
    uint32_t *first_child = allocate_array(info->inner_count * sizeof *first_child);
    uint32_t next_child = 1;
    size_t node = 0;
    for (int level = 0; level < DEPTH; ++level) {
        for (size_t i = 0; i < counts[level]; ++i, ++node) {
            child_mask[node] = masks[level][i];
            first_child[node] = next_child;
            next_child += (uint32_t)__builtin_popcount(masks[level][i]);
        }
    }
    tree->host[SVO_TREE_CHILD_MASK] = child_mask;
    tree->host[SVO_TREE_FIRST_CHILD] = first_child;
    fill_payload(tree);
    info->need = need;
    info->positions = (need & SVO_NEED_RAYS) != 0 ? SVO_POSITIONS_FLOAT : SVO_POSITIONS_SNAPPED;
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (!svo_i_tree_holds(info, (svo_tree_buffer)i)) {
            svo_i_free(tree->host[i]);
            tree->host[i] = NULL;
        }
    }
    if ((need & SVO_NEED_RAYS) == 0) {
        info->list_count = info->vertex_count = info->list_triangle_count = 0;
    }
    tree->downloaded = true;
    return tree;
}

static svo_tree *make_small_tree(uint32_t need)
{
    return make_tree((const uint32_t[]){0, 1, 9, 200, 511}, 5, need);
}

static void assert_same_tree(const svo_tree *a, const svo_tree *b)
{
    assert_memory_equal(&a->info, &b->info, sizeof a->info);
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const size_t bytes = svo_i_tree_holds(&a->info, (svo_tree_buffer)i)
                                 ? (size_t)svo_i_tree_element_count(&a->info, (svo_tree_buffer)i) *
                                       svo_i_tree_element_bytes((svo_tree_buffer)i)
                                 : 0;
        if (bytes == 0) {
            assert_null(b->host[i]);
        } else {
            assert_memory_equal(a->host[i], b->host[i], bytes);
        }
    }
    char hash_a[SVO_HASH_TEXT_BYTES], hash_b[SVO_HASH_TEXT_BYTES];
    assert_int_equal(svo_tree_hash(a, SVO_HASH_ALL, hash_a), SVO_OK);
    assert_int_equal(svo_tree_hash(b, SVO_HASH_ALL, hash_b), SVO_OK);
    assert_string_equal(hash_a, hash_b);
}

/* The whole file; the caller frees it. */
static uint8_t *read_file(const char *path, size_t *byte_count)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    uint8_t *bytes = allocate(1 << 20);
    *byte_count = fread(bytes, 1, 1 << 20, file);
    assert_int_equal(fclose(file), 0);
    return bytes;
}

static void write_file(const char *path, const void *bytes, size_t byte_count)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, byte_count, file), byte_count);
    assert_int_equal(fclose(file), 0);
}

static uint8_t *save_to_memory(const svo_tree *tree, uint32_t compress, size_t *byte_count)
{
    const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
    svo_message message = {""};
    if (svo_tree_save(tree, path_of("memory.svo"), &options, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return read_file(path_of("memory.svo"), byte_count);
}

static void assert_no_temporary_left(void)
{
    DIR *entries = opendir(directory);
    assert_non_null(entries);
    for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
        assert_null(strstr(entry->d_name, ".tmp"));
    }
    closedir(entries);
}

static void assert_damaged(const uint8_t *bytes, size_t byte_count, const char *text)
{
    svo_tree *tree = NULL;
    svo_message message = {""};
    const svo_status status = svo_tree_load_memory(bytes, byte_count, "name", &tree, &message);
    if (status != SVO_FILE_DAMAGED || strstr(message.text, text) == NULL || strncmp(message.text, "name: ", 6) != 0) {
        fail_msg("status %s, message \"%s\", expected SVO_FILE_DAMAGED and \"%s\"", svo_status_name(status),
                 message.text, text);
    }
    assert_null(tree);
}

static void round_trip(const svo_tree *tree, uint32_t compress)
{
    const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
    svo_message message = {""};
    assert_int_equal(svo_tree_save(tree, path_of("round.svo"), &options, &message), SVO_OK);
    svo_tree *loaded = NULL;
    if (svo_tree_load(path_of("round.svo"), &loaded, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    assert_same_tree(tree, loaded);
    svo_tree_destroy(&loaded);
    assert_no_temporary_left();
}

static void test_round_trips(void **unused)
{
    (void)unused;
    static const uint32_t needs[] = {
        0,        SVO_NEED_COLOR,         SVO_NEED_NORMAL, SVO_NEED_RAYS, SVO_NEED_MATERIAL, SVO_NEED_FILL,
        NEED_ALL, SVO_NEED_PROJECTED_AREA};
    uint32_t all_codes[512];
    for (uint32_t i = 0; i < 512; ++i) {
        all_codes[i] = i;
    }
    for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
        for (uint32_t compress = 0; compress < 2; ++compress) {
            svo_tree *trees[3] = {make_tree(all_codes, 0, needs[i]), make_small_tree(needs[i]),
                                  make_tree(all_codes, 512, needs[i])};
            for (int t = 0; t < 3; ++t) {
                round_trip(trees[t], compress);
                svo_tree_destroy(&trees[t]);
            }
        }
    }
}

/* The small tree with its positions as doubles. */
static svo_tree *make_double_tree(void)
{
    svo_tree *tree = make_small_tree(NEED_ALL);
    const float *floats = tree->host[SVO_TREE_POSITIONS];
    double *positions = allocate_array(12 * sizeof *positions);
    for (int i = 0; i < 12; ++i) {
        positions[i] = (double)floats[i] + 0.1;
    }
    svo_i_free(tree->host[SVO_TREE_POSITIONS]);
    tree->host[SVO_TREE_POSITIONS] = NULL;
    tree->host[SVO_TREE_POSITIONS_DOUBLE] = positions;
    tree->info.positions = SVO_POSITIONS_DOUBLE;
    return tree;
}

static void test_double_positions_stay_double(void **unused)
{
    (void)unused;
    svo_tree *tree = make_double_tree();
    round_trip(tree, 0);
    round_trip(tree, 1);
    svo_tree_destroy(&tree);
}

/* Recomputes header and chunk checksums, so that the checks after them run. */
static void seal(uint8_t *bytes)
{
    file_head *head = (file_head *)(void *)bytes;
    const size_t there = (head->header.header_bytes - sizeof head->header) / sizeof(file_chunk);
    for (uint32_t i = 0; i < head->header.chunk_count && i < there; ++i) {
        file_chunk *chunk = &head->chunks[i];
        chunk->hash = XXH3_64bits(bytes + chunk->offset, (size_t)chunk->stored_bytes);
    }
    head->header.header_hash = XXH3_64bits(bytes + 32, head->header.header_bytes - 32);
}

/* Takes the last chunk, the positions, out of a file, and gives it a version. Returns the file's new length. */
static size_t drop_positions(uint8_t *bytes, uint32_t version)
{
    file_head *head = (file_head *)(void *)bytes;
    const uint32_t last = head->header.chunk_count - 1;
    const size_t begin = head->header.header_bytes;
    const size_t end = (size_t)head->chunks[last].offset;
    memmove(bytes + begin - sizeof(file_chunk), bytes + begin, end - begin);
    for (uint32_t i = 0; i < last; ++i) {
        head->chunks[i].offset -= sizeof(file_chunk);
    }
    head->header.version = version;
    head->header.chunk_count = last;
    head->header.header_bytes -= (uint32_t)sizeof(file_chunk);
    head->header.file_bytes = end - sizeof(file_chunk);
    seal(bytes);
    return end - sizeof(file_chunk);
}

/* Rays of such a tree meet the snapped mesh, also when it was saved again. */
static void test_a_file_without_positions_loads(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    for (uint32_t version = 1; version <= FILE_VERSION; ++version) {
        size_t byte_count = 0;
        uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
        byte_count = drop_positions(bytes, version);
        svo_tree *loaded = NULL;
        svo_message message = {""};
        if (svo_tree_load_memory(bytes, byte_count, "old", &loaded, &message) != SVO_OK) {
            fail_msg("version %u: %s", version, message.text);
            return;
        }
        assert_int_equal(loaded->info.positions, SVO_POSITIONS_SNAPPED);
        assert_null(loaded->host[SVO_TREE_POSITIONS]);
        round_trip(loaded, 0);
        svo_tree_destroy(&loaded);
        free(bytes);
    }
    svo_tree_destroy(&tree);
}

static void test_compression_makes_the_full_tree_smaller(void **unused)
{
    (void)unused;
    uint32_t codes[512];
    for (uint32_t i = 0; i < 512; ++i) {
        codes[i] = i;
    }
    svo_tree *tree = make_tree(codes, 512, NEED_ALL);
    size_t plain_count = 0, packed_count = 0;
    free(save_to_memory(tree, 0, &plain_count));
    free(save_to_memory(tree, 1, &packed_count));
    assert_true(packed_count < plain_count);
    svo_tree_destroy(&tree);
}

/* The documented header, read back at io.h's offsets. */
static void test_layout_is_as_documented(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    uint32_t words[3], level_begin[2], kind;
    uint64_t file_bytes, hash, triangles;
    double edge;
    memcpy(words, bytes + 8, 4);
    memcpy(words + 1, bytes + 12, 4);
    memcpy(words + 2, bytes + 36, 4);
    memcpy(&file_bytes, bytes + 16, 8);
    memcpy(&hash, bytes + 24, 8);
    memcpy(&edge, bytes + 80, 8);
    memcpy(&triangles, bytes + 104, 8);
    memcpy(level_begin, bytes + 128, 8);
    memcpy(&kind, bytes + 200 + 40 * 12, 4);
    assert_memory_equal(bytes, "\x89SVO\r\n\x1a\n", 8);
    assert_int_equal(words[0], 2);
    assert_int_equal(words[1], 200 + 40 * 13);
    assert_int_equal(words[2], DEPTH);
    assert_int_equal(file_bytes, byte_count);
    assert_true(hash == XXH3_64bits(bytes + 32, 200 + 40 * 13 - 32));
    assert_true(edge == 2);
    assert_int_equal(triangles, 9);
    assert_int_equal(level_begin[0], 0);
    assert_int_equal(level_begin[1], 1);
    assert_int_equal(kind, SVO_TREE_POSITIONS);
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_every_flipped_byte_is_found(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    for (size_t i = 0; i < byte_count; ++i) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            bytes[i] ^= (uint8_t)(1u << bit);
            assert_damaged(bytes, byte_count, "");
            bytes[i] ^= (uint8_t)(1u << bit);
        }
    }
    free(bytes);
    svo_tree_destroy(&tree);
}

/* A zstd frame has a few bits that its decoder ignores: if they flip, the tree must load unchanged. */
static void test_flipped_bytes_of_compressed_chunks_do_no_harm(void **unused)
{
    (void)unused;
    uint32_t codes[512];
    for (uint32_t i = 0; i < 512; ++i) {
        codes[i] = i;
    }
    svo_tree *tree = make_tree(codes, 512, NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 1, &byte_count);
    for (size_t i = 0; i < byte_count; ++i) {
        bytes[i] ^= 0x10;
        svo_tree *loaded = NULL;
        const svo_status status = svo_tree_load_memory(bytes, byte_count, "name", &loaded, NULL);
        if (status == SVO_OK) {
            assert_same_tree(tree, loaded);
        } else {
            assert_int_equal(status, SVO_FILE_DAMAGED);
        }
        svo_tree_destroy(&loaded);
        bytes[i] ^= 0x10;
    }
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_every_truncation_is_found(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    char expected[64];
    for (size_t i = 0; i < byte_count; ++i) {
        (void)snprintf(expected, sizeof expected, "%zu there", i);
        assert_damaged(bytes, i, i == 0 ? "not a .svo file" : expected);
    }
    (void)snprintf(expected, sizeof expected, "truncated: %zu bytes expected, %zu there", byte_count, byte_count - 1);
    assert_damaged(bytes, byte_count - 1, expected);
    assert_damaged(bytes, byte_count + 1, "bytes expected");
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_foreign_files_are_named(void **unused)
{
    (void)unused;
    assert_damaged((const uint8_t *)"PNG", 3, "not a .svo file");
    uint8_t zeros[4096] = {0};
    assert_damaged(zeros, sizeof zeros, "not a .svo file");
    write_file(path_of("empty.svo"), "", 0);
    svo_tree *tree = NULL;
    svo_message message = {""};
    assert_int_equal(svo_tree_load(path_of("empty.svo"), &tree, &message), SVO_FILE_DAMAGED);
    assert_non_null(strstr(message.text, "empty.svo: not a .svo file"));
}

static void test_files_that_cannot_be_read(void **unused)
{
    (void)unused;
    svo_tree *tree = NULL;
    svo_message message = {""};
    assert_int_equal(svo_tree_load(path_of("missing.svo"), &tree, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "missing.svo: cannot be read: No such file or directory"));
    assert_int_equal(svo_tree_load(directory, &tree, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "Is a directory"));
    assert_int_equal(mkfifo(path_of("pipe.svo"), 0600), 0);
    assert_int_equal(svo_tree_load(path_of("pipe.svo"), &tree, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "not a regular file"));
    assert_int_equal(svo_tree_load(NULL, &tree, &message), SVO_INVALID_ARGUMENT);
    assert_null(tree);
}

/* Sets a 32-bit word at an offset, recomputes checksums, expects the text in the message, and restores the word. */
static void expect_word_refused(uint8_t *bytes, size_t byte_count, size_t offset, uint32_t value, const char *text)
{
    uint8_t *copy = allocate(byte_count);
    memcpy(copy, bytes, byte_count);
    memcpy(copy + offset, &value, sizeof value);
    seal(copy);
    assert_damaged(copy, byte_count, text);
    free(copy);
}

static void test_broken_headers_are_named(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    expect_word_refused(bytes, byte_count, 8, 0, "version 0 is not known");
    expect_word_refused(bytes, byte_count, 8, 3, "version 3 is not known");
    expect_word_refused(bytes, byte_count, 8, 1, "chunk 12: kind 12 is not expected");
    expect_word_refused(bytes, byte_count, 32, 15, "15 chunks, at most 14");
    expect_word_refused(bytes, byte_count, 36, 0, "depth 0 is outside 1 .. 16");
    expect_word_refused(bytes, byte_count, 36, 17, "depth 17 is outside 1 .. 16");
    expect_word_refused(bytes, byte_count, 40, 40, "snap_bits 40");
    expect_word_refused(bytes, byte_count, 40, 15, "snap_bits 15");
    expect_word_refused(bytes, byte_count, 44, 3, "coverage 3 is not known");
    expect_word_refused(bytes, byte_count, 48, 64, "unknown bits");
    expect_word_refused(bytes, byte_count, 48, NEED_ALL & ~(uint32_t)SVO_NEED_COLOR,
                        "chunk 2: kind is 2, 3 (normals) expected");
    expect_word_refused(bytes, byte_count, 52, 3, "weights 3 are not known");
    expect_word_refused(bytes, byte_count, 48, NEED_ALL | (uint32_t)SVO_NEED_FILL << 16, "constant 0x");
    expect_word_refused(bytes, byte_count, 52, 9u << 16, "payload_level 9 is above depth");
    expect_word_refused(bytes, byte_count, 100, 0xbff00000, "snap_error -1");
    expect_word_refused(bytes, byte_count, 60, 0x7ff00000, "origin is not finite");
    expect_word_refused(bytes, byte_count, 84, 0xbff00000, "edge");
    expect_word_refused(bytes, byte_count, 112, 100, "100 of 9 triangles refused");
    expect_word_refused(bytes, byte_count, 128 + 4, 2, "not the root alone");
    expect_word_refused(bytes, byte_count, 128 + 8, UINT32_MAX, "header: level 1");
    expect_word_refused(bytes, byte_count, 128 + 17 * 4, 1, "level_begin[17] is not 0");
    expect_word_refused(bytes, byte_count, 200 + 40 * 2, 99, "chunk 2: kind is 99");
    expect_word_refused(bytes, byte_count, 200 + 4, 7, "chunk child_mask: codec 7 is not known");
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_a_chunk_cannot_promise_more_than_it_holds(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    file_head *head = (file_head *)(void *)bytes;
    file_chunk *list = &head->chunks[SVO_TREE_LIST];
    list->codec = FILE_CODEC_ZSTD;
    list->plain_bytes = (uint64_t)1 << 40;
    seal(bytes);
    assert_damaged(bytes, byte_count, "chunk list: 28 bytes in the file cannot hold 1099511627776");
    list->plain_bytes = 2;
    seal(bytes);
    assert_damaged(bytes, byte_count, "chunk list: 2 bytes are not 0 elements of 4");
    list->plain_bytes = 400;
    seal(bytes);
    assert_damaged(bytes, byte_count, "chunk list: zstd: ");
    free(bytes);
    svo_tree_destroy(&tree);
}

/* A zstd frame of one stored block, 19 bytes, where the table of chunks says 20. */
static void test_a_chunk_that_unpacks_to_less(void **unused)
{
    (void)unused;
    static const uint8_t frame[28] = {0x28, 0xb5, 0x2f, 0xfd, 0x20, 19, 1 | 19 << 3};
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    file_chunk *list = &((file_head *)(void *)bytes)->chunks[SVO_TREE_LIST];
    assert_int_equal(list->stored_bytes, sizeof frame);
    memcpy(bytes + list->offset, frame, sizeof frame);
    list->codec = FILE_CODEC_ZSTD;
    list->plain_bytes = 20;
    seal(bytes);
    assert_damaged(bytes, byte_count, "chunk list: 19 bytes unpacked, 20 expected");
    free(bytes);
    svo_tree_destroy(&tree);
}

/* A chunk too few, one too many, one that does not begin where the one before ends, and bytes behind the last. */
static void test_chunks_that_do_not_fit_the_file_are_named(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_WITHOUT_RAYS);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    const file_head *head = (const file_head *)(const void *)bytes;
    uint8_t *copy = allocate(byte_count + 4);
    file_head *changed = (file_head *)(void *)copy;
    expect_word_refused(bytes, byte_count, 200 + 8, (uint32_t)head->chunks[0].offset + 1, " are free");
    expect_word_refused(bytes, byte_count, 48, NEED_WITHOUT_RAYS & ~(uint32_t)SVO_NEED_PROJECTED_AREA,
                        "chunk 6: kind 11 is not expected");
    memcpy(copy, bytes, byte_count);
    memset(copy + byte_count, 0, 4);
    changed->header.file_bytes = byte_count + 4;
    seal(copy);
    assert_damaged(copy, byte_count + 4, "the chunks end at byte ");
    const uint32_t last = head->header.chunk_count - 1;
    const size_t begin = head->header.header_bytes, end = (size_t)head->chunks[last].offset;
    memcpy(copy, bytes, byte_count);
    memmove(copy + begin - sizeof(file_chunk), copy + begin, end - begin);
    for (uint32_t i = 0; i < last; ++i) {
        changed->chunks[i].offset -= sizeof(file_chunk);
    }
    changed->header.chunk_count = last;
    changed->header.header_bytes -= (uint32_t)sizeof(file_chunk);
    changed->header.file_bytes = end - sizeof(file_chunk);
    seal(copy);
    assert_damaged(copy, end - sizeof(file_chunk), "chunk areas is missing");
    free(copy);
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_damaged_chunks_are_named(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    const file_head *head = (const file_head *)(const void *)bytes;
    for (uint32_t i = 0; i < head->header.chunk_count; ++i) {
        char expected[64];
        (void)snprintf(expected, sizeof expected, "chunk %s: checksum is ", svo_tree_buffer_name((svo_tree_buffer)i));
        bytes[head->chunks[i].offset] ^= 1;
        assert_damaged(bytes, byte_count, expected);
        bytes[head->chunks[i].offset] ^= 1;
    }
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_broken_structure_is_named(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    const file_chunk *chunks = ((const file_head *)(const void *)bytes)->chunks;
    const size_t masks = (size_t)chunks[SVO_TREE_CHILD_MASK].offset;
    const size_t lists = (size_t)chunks[SVO_TREE_LIST].offset;
    expect_word_refused(bytes, byte_count, masks, 0, "is empty");
    expect_word_refused(bytes, byte_count, masks, 0xffffffff, "the masks above say 9");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_FIRST_CHILD].offset, 2,
                        "node 0: first_child is 2, 1 expected");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_LIST_BEGIN].offset, 1, "the lists are 1 .. 7");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_LIST_BEGIN].offset + 4, 9, "its list is 0 .. 9");
    expect_word_refused(bytes, byte_count, lists, 2, "not ascending below 2");
    expect_word_refused(bytes, byte_count, lists + 8, 0, "not ascending below 2");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_INDICES].offset, 4, "index 4 is not below 4");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_VERTICES].offset, 1u << 29, "is not within 2^29");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_TRIANGLE_IDS].offset, 4, "not ascending below 9");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_TRIANGLE_IDS].offset + 4, 9,
                        "not ascending below 9");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_POSITIONS].offset + 12, 0x40600000,
                        "vertex 1: position 3.5 is not that of the snapped coordinate 9");
    expect_word_refused(bytes, byte_count, (size_t)chunks[SVO_TREE_POSITIONS].offset, 0x7fc00000,
                        "vertex 0: position nan");
    free(bytes);
    svo_tree_destroy(&tree);
}

static void expect_save_fails(const svo_tree *tree, const char *path, const char *text)
{
    svo_message message = {""};
    assert_int_equal(svo_tree_save(tree, path, NULL, &message), SVO_FILE_ERROR);
    if (strncmp(message.text, path, strlen(path)) != 0 || strstr(message.text, text) == NULL) {
        fail_msg("message \"%s\", expected \"%s\" and \"%s\"", message.text, path, text);
    }
}

static void test_save_fails_cleanly(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    expect_save_fails(tree, path_of("no/such/place.svo"), "cannot be written: No such file or directory");
    expect_save_fails(tree, directory, "Is a directory");
    if (access("/dev/full", W_OK) == 0) {
        expect_save_fails(tree, "/dev/full", strerror(ENOSPC));
    }
    const bool downloaded = tree->downloaded;
    tree->downloaded = false;
    assert_int_equal(svo_tree_save(tree, path_of("none.svo"), NULL, NULL), SVO_INVALID_ARGUMENT);
    tree->downloaded = downloaded;
    assert_int_not_equal(access(path_of("none.svo"), F_OK), 0);
    svo_tree_destroy(&tree);
}

/* Bytes that a function received. */
typedef struct received {
    uint8_t *bytes;
    size_t byte_count, limit;
} received;

static int receive(void *user, const void *bytes, size_t byte_count)
{
    received *to = user;
    if (byte_count > to->limit - to->byte_count) {
        return 1;
    }
    memcpy(to->bytes + to->byte_count, bytes, byte_count);
    to->byte_count += byte_count;
    return 0;
}

/* Even if its old arrays were still there. */
static void test_trees_in_flight_are_not_saved(void **unused)
{
    (void)unused;
    svo_message message = {""};
    svo_tree *tree = make_small_tree(NEED_ALL);
    tree->content = SVO_I_TREE_IN_FLIGHT;
    assert_int_equal(svo_tree_save(tree, path_of("none.svo"), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "in flight"));
    assert_int_not_equal(access(path_of("none.svo"), F_OK), 0);
    received got = {0};
    assert_int_equal(svo_tree_write(tree, receive, &got, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "svo_tree_write: "));
    assert_non_null(strstr(message.text, "in flight"));
    svo_tree_destroy(&tree);
}

/* A limit on file sizes emulates a full disk: the write fails half-way in both cases. */
static void test_disk_full_keeps_the_old_file(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    write_file(path_of("old.svo"), "old", 3);
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    void (*const handler)(int) = signal(SIGXFSZ, SIG_IGN);
    const struct rlimit tight = {.rlim_cur = 600, .rlim_max = before.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &tight), 0);
    svo_message message = {""};
    const svo_status status = svo_tree_save(tree, path_of("old.svo"), NULL, &message);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    (void)signal(SIGXFSZ, handler);
    assert_int_equal(status, SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, strerror(EFBIG)));
    size_t byte_count = 0;
    uint8_t *bytes = read_file(path_of("old.svo"), &byte_count);
    assert_int_equal(byte_count, 3);
    assert_memory_equal(bytes, "old", 3);
    free(bytes);
    assert_no_temporary_left();
    svo_tree_destroy(&tree);
}

/* The link stays, whether it leads to a file or to nothing yet. */
static void test_what_a_link_leads_to_is_written(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    char link[2 * PATH_BYTES];
    struct stat entry;
    (void)snprintf(link, sizeof link, "%s", path_of("link.svo"));
    assert_int_equal(symlink("round.svo", link), 0);
    for (int i = 0; i < 2; ++i) {
        svo_tree *loaded = NULL;
        (void)unlink(path_of("round.svo"));
        if (i == 1) {
            write_file(path_of("round.svo"), "old", 3);
        }
        assert_int_equal(svo_tree_save(tree, link, NULL, NULL), SVO_OK);
        assert_int_equal(lstat(link, &entry), 0);
        assert_true(S_ISLNK(entry.st_mode));
        assert_int_equal(svo_tree_load(path_of("round.svo"), &loaded, NULL), SVO_OK);
        assert_same_tree(tree, loaded);
        svo_tree_destroy(&loaded);
    }
    svo_tree_destroy(&tree);
}

static void test_a_pipe_gets_the_bytes_of_the_file(void **unused)
{
    (void)unused;
    svo_tree *tree = make_small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    uint8_t *through = allocate(1 << 16);
    char path[2 * PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s", path_of("stream.svo"));
    assert_int_equal(mkfifo(path, 0600), 0);
    const int reading = open(path, O_RDONLY | O_NONBLOCK); /* the bytes fit into the pipe */
    assert_true(reading >= 0);
    assert_int_equal(svo_tree_save(tree, path, NULL, NULL), SVO_OK);
    assert_int_equal(read(reading, through, 1 << 16), byte_count);
    assert_memory_equal(through, bytes, byte_count);
    assert_int_equal(close(reading), 0);
    /* Nobody reads: an error, and no SIGPIPE, which would end this test. */
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(close(ends[0]), 0);
    (void)snprintf(path, sizeof path, "/dev/fd/%d", ends[1]);
    expect_save_fails(tree, path, strerror(EPIPE));
    assert_int_equal(close(ends[1]), 0);
    free(through);
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_a_function_receives_the_bytes_of_the_file(void **unused)
{
    (void)unused;
    uint32_t codes[512];
    for (uint32_t i = 0; i < 512; ++i) {
        codes[i] = i;
    }
    svo_tree *tree = make_tree(codes, 512, NEED_ALL);
    for (uint32_t compress = 0; compress < 2; ++compress) {
        const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
        svo_message message = {""};
        size_t byte_count = 0;
        uint8_t *bytes = save_to_memory(tree, compress, &byte_count);
        received got = {.bytes = allocate(byte_count), .limit = byte_count};
        assert_int_equal(svo_tree_write(tree, receive, &got, &options, &message), SVO_OK);
        assert_int_equal(got.byte_count, byte_count);
        assert_memory_equal(got.bytes, bytes, byte_count);
        got.byte_count = 0;
        got.limit = byte_count - 1;
        assert_int_equal(svo_tree_write(tree, receive, &got, &options, &message), SVO_FILE_ERROR);
        assert_non_null(strstr(message.text, "svo_tree_write: "));
        free(got.bytes);
        free(bytes);
    }
    svo_message message = {""};
    assert_int_equal(svo_tree_write(tree, NULL, NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "write is NULL"));
    assert_int_equal(svo_tree_write(NULL, receive, NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&tree);
}

/* The limit on file sizes ends the process by SIGXFSZ after 600 bytes. */
static void test_a_process_that_ends_while_saving_leaves_nothing(void **unused)
{
    (void)unused;
    const int probe = open(directory, O_TMPFILE | O_WRONLY, 0600);
    if (probe < 0) {
        print_message("skipped: this file system has no O_TMPFILE\n");
        skip();
    }
    assert_int_equal(close(probe), 0);
    svo_tree *tree = make_small_tree(NEED_ALL);
    const char *path = path_of("none.svo");
    const pid_t child = fork();
    if (child == 0) {
        const struct rlimit core = {0};
        const struct rlimit tight = {.rlim_cur = 600, .rlim_max = 600};
        (void)setrlimit(RLIMIT_CORE, &core);
        (void)setrlimit(RLIMIT_FSIZE, &tight);
        (void)signal(SIGXFSZ, SIG_DFL);
        (void)svo_tree_save(tree, path, NULL, NULL);
        _exit(0);
    }
    int ended = 0;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == SIGXFSZ);
    assert_no_temporary_left();
    svo_tree_destroy(&tree);
}

static int make_directory(void **unused)
{
    (void)unused;
    const char *parent = getenv("TMPDIR");
    (void)snprintf(directory, sizeof directory, "%s/svocl-file-XXXXXX", parent != NULL ? parent : "/tmp");
    return mkdtemp(directory) != NULL ? 0 : -1;
}

static int remove_directory(void **unused)
{
    (void)unused;
    static const char *const names[] = {"memory.svo", "round.svo", "empty.svo", "pipe.svo",
                                        "old.svo",    "link.svo",  "stream.svo"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        (void)unlink(path_of(names[i]));
    }
    return rmdir(directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trips),
        cmocka_unit_test(test_double_positions_stay_double),
        cmocka_unit_test(test_a_file_without_positions_loads),
        cmocka_unit_test(test_compression_makes_the_full_tree_smaller),
        cmocka_unit_test(test_layout_is_as_documented),
        cmocka_unit_test(test_every_flipped_byte_is_found),
        cmocka_unit_test(test_flipped_bytes_of_compressed_chunks_do_no_harm),
        cmocka_unit_test(test_every_truncation_is_found),
        cmocka_unit_test(test_foreign_files_are_named),
        cmocka_unit_test(test_files_that_cannot_be_read),
        cmocka_unit_test(test_broken_headers_are_named),
        cmocka_unit_test(test_a_chunk_cannot_promise_more_than_it_holds),
        cmocka_unit_test(test_a_chunk_that_unpacks_to_less),
        cmocka_unit_test(test_chunks_that_do_not_fit_the_file_are_named),
        cmocka_unit_test(test_damaged_chunks_are_named),
        cmocka_unit_test(test_broken_structure_is_named),
        cmocka_unit_test(test_save_fails_cleanly),
        cmocka_unit_test(test_trees_in_flight_are_not_saved),
        cmocka_unit_test(test_disk_full_keeps_the_old_file),
        cmocka_unit_test(test_what_a_link_leads_to_is_written),
        cmocka_unit_test(test_a_pipe_gets_the_bytes_of_the_file),
        cmocka_unit_test(test_a_function_receives_the_bytes_of_the_file),
        cmocka_unit_test(test_a_process_that_ends_while_saving_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
