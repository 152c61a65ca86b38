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
#include "small_tree.h"
#include "support/suite.h"
#include "svocl/io.h"
#include "svocl/plan.h"

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
    if (svo_tree_save(tree, svo_to_path(path_of("memory.svo")), &options, &message) != SVO_OK) {
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
    const svo_status status = svo_tree_load(svo_from_memory(bytes, byte_count, "name"), NULL, &tree, &message);
    if (status != SVO_FILE_DAMAGED || strstr(message.text, text) == NULL || strncmp(message.text, "name: ", 6) != 0) {
        fail_msg("status %s, message \"%s\", expected SVO_FILE_DAMAGED and \"%s\"", svo_name(SVO_NAME_STATUS, status),
                 message.text, text);
    }
    assert_null(tree);
}

static void round_trip(const svo_tree *tree, uint32_t compress)
{
    const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
    svo_message message = {""};
    assert_int_equal(svo_tree_save(tree, svo_to_path(path_of("round.svo")), &options, &message), SVO_OK);
    svo_tree *loaded = NULL;
    if (svo_tree_load(svo_from_path(path_of("round.svo")), NULL, &loaded, &message) != SVO_OK) {
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
            svo_tree *trees[3] = {small_tree_make(all_codes, 0, needs[i]), small_tree(needs[i]),
                                  small_tree_make(all_codes, 512, needs[i])};
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
    svo_tree *tree = small_tree(NEED_ALL);
    const float *floats = tree->host[SVO_TREE_POSITIONS];
    double *positions = svo_i_alloc_zeroed(NULL, 12, sizeof *positions);
    assert_non_null(positions);
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

/* The chunk of an array, of the first level that it has elements of. */
static file_chunk *find_chunk(uint8_t *bytes, svo_tree_buffer buffer)
{
    file_head *head = (file_head *)(void *)bytes;
    for (uint32_t i = 0; i < head->header.chunk_count; ++i) {
        if ((head->chunks[i].kind & 0xffff) == buffer) {
            return &head->chunks[i];
        }
    }
    fail_msg("the file has no %s", svo_name(SVO_NAME_TREE_BUFFER, buffer));
    return NULL;
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

static void test_compression_makes_the_full_tree_smaller(void **unused)
{
    (void)unused;
    uint32_t codes[512];
    for (uint32_t i = 0; i < 512; ++i) {
        codes[i] = i;
    }
    svo_tree *tree = small_tree_make(codes, 512, NEED_ALL);
    size_t plain_count = 0, packed_count = 0;
    free(save_to_memory(tree, 0, &plain_count));
    free(save_to_memory(tree, 1, &packed_count));
    assert_true(packed_count < plain_count);
    svo_tree_destroy(&tree);
}

/* The documented header, read back at io.h's offsets. Three levels of masks, four of four kinds of payload, and seven
   arrays of leaves and geometry. */
static void test_layout_is_as_documented(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    enum { CHUNKS = 3 + 4 * 4 + 7 };
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
    memcpy(&kind, bytes + 200 + 40 * (CHUNKS - 1), 4);
    assert_memory_equal(bytes, "\x89SVO\r\n\x1a\n", 8);
    assert_int_equal(words[0], 3);
    assert_int_equal(words[1], 200 + 40 * CHUNKS);
    assert_int_equal(words[2], SMALL_TREE_DEPTH);
    assert_int_equal(file_bytes, byte_count);
    assert_true(hash == XXH3_64bits(bytes + 32, 200 + 40 * CHUNKS - 32));
    assert_true(edge == 2);
    assert_int_equal(triangles, 9);
    assert_int_equal(level_begin[0], 0);
    assert_int_equal(level_begin[1], 1);
    assert_int_equal(kind, SVO_TREE_POSITIONS | SMALL_TREE_DEPTH << 16);
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_every_flipped_byte_is_found(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
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
    svo_tree *tree = small_tree_make(codes, 512, NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 1, &byte_count);
    for (size_t i = 0; i < byte_count; ++i) {
        bytes[i] ^= 0x10;
        svo_tree *loaded = NULL;
        const svo_status status = svo_tree_load(svo_from_memory(bytes, byte_count, "name"), NULL, &loaded, NULL);
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
    svo_tree *tree = small_tree(NEED_ALL);
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

/* Nodes on all levels, as many as the header says, before there is memory for them. */
static void test_trees_have_a_limit_of_voxels(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL), *loaded = NULL;
    svo_message message = {""};
    svo_load_options options = {.struct_size = sizeof options, .voxels_max = tree->info.node_count};
    assert_int_equal(svo_tree_save(tree, svo_to_path(path_of("limit.svo")), NULL, NULL), SVO_OK);
    assert_int_equal(svo_tree_load(svo_from_path(path_of("limit.svo")), &options, &loaded, &message), SVO_OK);
    svo_tree_destroy(&loaded);
    --options.voxels_max;
    assert_int_equal(svo_tree_load(svo_from_path(path_of("limit.svo")), &options, &loaded, &message),
                     SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "(voxels_max)"));
    options.voxels_max = tree->info.level_begin[2];
    options.last_level = 1;
    assert_int_equal(svo_tree_load(svo_from_path(path_of("limit.svo")), &options, &loaded, &message), SVO_OK);
    svo_tree_destroy(&loaded);
    svo_tree_destroy(&tree);
    assert_int_equal(unlink(path_of("limit.svo")), 0);
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
    assert_int_equal(svo_tree_load(svo_from_path(path_of("empty.svo")), NULL, &tree, &message), SVO_FILE_DAMAGED);
    assert_non_null(strstr(message.text, "empty.svo: not a .svo file"));
}

static void test_files_that_cannot_be_read(void **unused)
{
    (void)unused;
    svo_tree *tree = NULL;
    svo_message message = {""};
    assert_int_equal(svo_tree_load(svo_from_path(path_of("missing.svo")), NULL, &tree, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "missing.svo: cannot be read: No such file or directory"));
    assert_int_equal(svo_tree_load(svo_from_path(directory), NULL, &tree, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "Is a directory"));
    assert_int_equal(mkfifo(path_of("pipe.svo"), 0600), 0);
    assert_int_equal(svo_tree_load(svo_from_path(path_of("pipe.svo")), NULL, &tree, &message), SVO_FILE_ERROR);
    assert_non_null(strstr(message.text, "not a regular file"));
    assert_int_equal(svo_tree_load(svo_from_path(NULL), NULL, &tree, &message), SVO_INVALID_ARGUMENT);
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

/* The version says whether voxels are those of the mesh as it was given. */
static void test_exactness_is_kept(void **unused)
{
    (void)unused;
    for (uint32_t is_exact = 0; is_exact < 2; ++is_exact) {
        svo_tree *tree = small_tree(NEED_WITHOUT_RAYS);
        svo_tree *loaded = NULL;
        size_t byte_count = 0;
        tree->info.is_exact = is_exact;
        uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
        assert_int_equal(bytes[8], 3 + is_exact);
        assert_int_equal(svo_tree_load(svo_from_memory(bytes, byte_count, "file"), NULL, &loaded, NULL), SVO_OK);
        assert_int_equal(loaded->info.is_exact, is_exact);
        free(bytes);
        svo_tree_destroy(&loaded);
        svo_tree_destroy(&tree);
    }
}

static void test_broken_headers_are_named(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    expect_word_refused(bytes, byte_count, 8, 0, "version 0 is not known");
    expect_word_refused(bytes, byte_count, 8, 5, "version 5 is not known");
    expect_word_refused(bytes, byte_count, 8, 2, "chunk child_mask: 1 bytes are not 8 elements of 1");
    expect_word_refused(bytes, byte_count, 32, 105, "105 chunks, at most 104");
    expect_word_refused(bytes, byte_count, 36, 0, "depth 0 is outside 1 .. 16");
    expect_word_refused(bytes, byte_count, 36, 17, "depth 17 is outside 1 .. 16");
    expect_word_refused(bytes, byte_count, 40, 40, "snap_bits 40");
    expect_word_refused(bytes, byte_count, 40, 15, "snap_bits 15");
    expect_word_refused(bytes, byte_count, 44, 3, "coverage 3 is not known");
    expect_word_refused(bytes, byte_count, 48, 64, "unknown bits");
    expect_word_refused(bytes, byte_count, 48, NEED_ALL & ~(uint32_t)SVO_NEED_COLOR,
                        "chunk 1: kind is 0x2, 0x3 (normals of level 0) expected");
    expect_word_refused(bytes, byte_count, 52, 3, "weights 3 are not known");
    expect_word_refused(bytes, byte_count, 48, NEED_ALL | (uint32_t)SVO_NEED_FILL << 16, "constant 0x");
    expect_word_refused(bytes, byte_count, 52, 9u << 16, "payload_level 9 is above depth");
    expect_word_refused(bytes, byte_count, 60, 0x7ff00000, "origin is not finite");
    expect_word_refused(bytes, byte_count, 84, 0xbff00000, "edge");
    expect_word_refused(bytes, byte_count, 112, 100, "100 of 9 triangles refused");
    expect_word_refused(bytes, byte_count, 128 + 4, 2, "not the root alone");
    expect_word_refused(bytes, byte_count, 128 + 8, UINT32_MAX, "header: level 1");
    expect_word_refused(bytes, byte_count, 128 + 17 * 4, 1, "level_begin[17] is not 0");
    expect_word_refused(bytes, byte_count, 200 + 40 * 2, 99, "chunk 2: kind is 0x63, 0x3 (normals of level 0)");
    expect_word_refused(bytes, byte_count, 200 + 4, 7, "chunk child_mask of level 0: codec 7 is not known");
    free(bytes);
    svo_tree_destroy(&tree);
}

/* Files that svocl wrote before have a distance where zeros are now. */
static void test_reserved_bytes_are_not_read(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    static const uint8_t zeros[8] = {0};
    svo_tree *again = NULL;
    svo_message message;
    assert_memory_equal(bytes + 96, zeros, sizeof zeros);
    memset(bytes + 96, 0xff, sizeof zeros);
    seal(bytes);
    if (svo_tree_load(svo_from_memory(bytes, byte_count, "name"), NULL, &again, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    svo_tree_destroy(&again);
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_a_chunk_cannot_promise_more_than_it_holds(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    file_chunk *list = find_chunk(bytes, SVO_TREE_LIST);
    list->codec = FILE_CODEC_ZSTD;
    list->plain_bytes = (uint64_t)1 << 40;
    seal(bytes);
    assert_damaged(bytes, byte_count, "chunk list of level 3: 28 bytes in the file cannot hold 1099511627776");
    list->plain_bytes = 2;
    seal(bytes);
    assert_damaged(bytes, byte_count, "chunk list of level 3: 2 bytes are not 0 elements of 4");
    list->plain_bytes = 400;
    seal(bytes);
    assert_damaged(bytes, byte_count, "chunk list of level 3: zstd: ");
    free(bytes);
    svo_tree_destroy(&tree);
}

/* A zstd frame of one stored block, 19 bytes, where the table of chunks says 20. */
static void test_a_chunk_that_unpacks_to_less(void **unused)
{
    (void)unused;
    static const uint8_t frame[28] = {0x28, 0xb5, 0x2f, 0xfd, 0x20, 19, 1 | 19 << 3};
    svo_tree *tree = small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    file_chunk *list = find_chunk(bytes, SVO_TREE_LIST);
    assert_int_equal(list->stored_bytes, sizeof frame);
    memcpy(bytes + list->offset, frame, sizeof frame);
    list->codec = FILE_CODEC_ZSTD;
    list->plain_bytes = 20;
    seal(bytes);
    assert_damaged(bytes, byte_count, "chunk list of level 3: 19 bytes unpacked, 20 expected");
    free(bytes);
    svo_tree_destroy(&tree);
}

/* A chunk too few, one too many, one that does not begin where the one before ends, and bytes behind the last. */
static void test_chunks_that_do_not_fit_the_file_are_named(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_WITHOUT_RAYS);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    const file_head *head = (const file_head *)(const void *)bytes;
    uint8_t *copy = allocate(byte_count + 4);
    file_head *changed = (file_head *)(void *)copy;
    expect_word_refused(bytes, byte_count, 200 + 8, (uint32_t)head->chunks[0].offset + 1, " are free");
    expect_word_refused(bytes, byte_count, 48, NEED_WITHOUT_RAYS & ~(uint32_t)SVO_NEED_PROJECTED_AREA,
                        "chunk 19: kind 0x3000b is not expected");
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
    assert_damaged(copy, end - sizeof(file_chunk), "chunk areas of level 3 is missing");
    free(copy);
    free(bytes);
    svo_tree_destroy(&tree);
}

static void test_damaged_chunks_are_named(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    const file_head *head = (const file_head *)(const void *)bytes;
    for (uint32_t i = 0; i < head->header.chunk_count; ++i) {
        char expected[64];
        const uint32_t kind = head->chunks[i].kind;
        (void)snprintf(expected, sizeof expected, "chunk %s of level %u: checksum is ",
                       svo_name(SVO_NAME_TREE_BUFFER, (svo_tree_buffer)(kind & 0xffff)), kind >> 16);
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
    svo_tree *tree = small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    const size_t masks = (size_t)find_chunk(bytes, SVO_TREE_CHILD_MASK)->offset;
    const size_t lists = (size_t)find_chunk(bytes, SVO_TREE_LIST)->offset;
    expect_word_refused(bytes, byte_count, masks, 0, "is empty");
    expect_word_refused(bytes, byte_count, masks, 0xffffffff, "the masks above say 9");
    expect_word_refused(bytes, byte_count, (size_t)find_chunk(bytes, SVO_TREE_LIST_BEGIN)->offset, 1,
                        "the lists are 1 .. 7");
    expect_word_refused(bytes, byte_count, (size_t)find_chunk(bytes, SVO_TREE_LIST_BEGIN)->offset + 4, 9,
                        "its list is 0 .. 9");
    expect_word_refused(bytes, byte_count, lists, 2, "not ascending below 2");
    expect_word_refused(bytes, byte_count, lists + 8, 0, "not ascending below 2");
    expect_word_refused(bytes, byte_count, (size_t)find_chunk(bytes, SVO_TREE_INDICES)->offset, 4,
                        "index 4 is not below 4");
    expect_word_refused(bytes, byte_count, (size_t)find_chunk(bytes, SVO_TREE_VERTICES)->offset, 1u << 29,
                        "is not within 2^29");
    expect_word_refused(bytes, byte_count, (size_t)find_chunk(bytes, SVO_TREE_TRIANGLE_IDS)->offset, 4,
                        "not ascending below 9");
    expect_word_refused(bytes, byte_count, (size_t)find_chunk(bytes, SVO_TREE_TRIANGLE_IDS)->offset + 4, 9,
                        "not ascending below 9");
    expect_word_refused(bytes, byte_count, (size_t)find_chunk(bytes, SVO_TREE_POSITIONS)->offset + 12, 0x40600000,
                        "vertex 1: position 3.5 does not round to the coordinate 9");
    expect_word_refused(bytes, byte_count, (size_t)find_chunk(bytes, SVO_TREE_POSITIONS)->offset, 0x7fc00000,
                        "vertex 0: position nan");
    free(bytes);
    svo_tree_destroy(&tree);
}

static void expect_save_fails(const svo_tree *tree, const char *path, const char *text)
{
    svo_message message = {""};
    assert_int_equal(svo_tree_save(tree, svo_to_path(path), NULL, &message), SVO_FILE_ERROR);
    if (strncmp(message.text, path, strlen(path)) != 0 || strstr(message.text, text) == NULL) {
        fail_msg("message \"%s\", expected \"%s\" and \"%s\"", message.text, path, text);
    }
}

static void test_save_fails_cleanly(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    expect_save_fails(tree, path_of("no/such/place.svo"), "cannot be written: No such file or directory");
    expect_save_fails(tree, directory, "Is a directory");
    if (access("/dev/full", W_OK) == 0) {
        expect_save_fails(tree, "/dev/full", strerror(ENOSPC));
    }
    const bool downloaded = tree->downloaded;
    tree->downloaded = false;
    assert_int_equal(svo_tree_save(tree, svo_to_path(path_of("none.svo")), NULL, NULL), SVO_INVALID_ARGUMENT);
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
    svo_tree *tree = small_tree(NEED_ALL);
    tree->content = SVO_I_TREE_IN_FLIGHT;
    assert_int_equal(svo_tree_save(tree, svo_to_path(path_of("none.svo")), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "in flight"));
    assert_int_not_equal(access(path_of("none.svo"), F_OK), 0);
    received got = {0};
    assert_int_equal(svo_tree_save(tree, svo_to_callback(receive, &got), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "svo_tree_save: "));
    assert_non_null(strstr(message.text, "in flight"));
    svo_tree_destroy(&tree);
}

/* A limit on file sizes emulates a full disk: the write fails half-way in both cases. */
static void test_disk_full_keeps_the_old_file(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    write_file(path_of("old.svo"), "old", 3);
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    void (*const handler)(int) = signal(SIGXFSZ, SIG_IGN);
    const struct rlimit tight = {.rlim_cur = 600, .rlim_max = before.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &tight), 0);
    svo_message message = {""};
    const svo_status status = svo_tree_save(tree, svo_to_path(path_of("old.svo")), NULL, &message);
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
    svo_tree *tree = small_tree(NEED_ALL);
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
        assert_int_equal(svo_tree_save(tree, svo_to_path(link), NULL, NULL), SVO_OK);
        assert_int_equal(lstat(link, &entry), 0);
        assert_true(S_ISLNK(entry.st_mode));
        assert_int_equal(svo_tree_load(svo_from_path(path_of("round.svo")), NULL, &loaded, NULL), SVO_OK);
        assert_same_tree(tree, loaded);
        svo_tree_destroy(&loaded);
    }
    svo_tree_destroy(&tree);
}

static void test_a_pipe_gets_the_bytes_of_the_file(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    size_t byte_count = 0;
    uint8_t *bytes = save_to_memory(tree, 0, &byte_count);
    uint8_t *through = allocate(1 << 16);
    char path[2 * PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s", path_of("stream.svo"));
    assert_int_equal(mkfifo(path, 0600), 0);
    const int reading = open(path, O_RDONLY | O_NONBLOCK); /* the bytes fit into the pipe */
    assert_true(reading >= 0);
    assert_int_equal(svo_tree_save(tree, svo_to_path(path), NULL, NULL), SVO_OK);
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
    svo_tree *tree = small_tree_make(codes, 512, NEED_ALL);
    for (uint32_t compress = 0; compress < 2; ++compress) {
        const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
        svo_message message = {""};
        size_t byte_count = 0;
        uint8_t *bytes = save_to_memory(tree, compress, &byte_count);
        received got = {.bytes = allocate(byte_count), .limit = byte_count};
        assert_int_equal(svo_tree_save(tree, svo_to_callback(receive, &got), &options, &message), SVO_OK);
        assert_int_equal(got.byte_count, byte_count);
        assert_memory_equal(got.bytes, bytes, byte_count);
        got.byte_count = 0;
        got.limit = byte_count - 1;
        assert_int_equal(svo_tree_save(tree, svo_to_callback(receive, &got), &options, &message), SVO_FILE_ERROR);
        assert_non_null(strstr(message.text, "svo_tree_save: "));
        free(got.bytes);
        free(bytes);
    }
    svo_message message = {""};
    assert_int_equal(svo_tree_save(tree, svo_to_callback(NULL, NULL), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "sink.path and sink.write are NULL"));
    assert_int_equal(svo_tree_save(NULL, svo_to_callback(receive, NULL), NULL, &message), SVO_INVALID_ARGUMENT);
    svo_tree_destroy(&tree);
}

static int end_the_test(void *user, const void *bytes, size_t byte_count)
{
    (void)user;
    (void)bytes;
    fail_msg("a function received %zu bytes of the file at a path", byte_count);
    return 1;
}

static void test_a_path_comes_before_bytes_and_functions(void **unused)
{
    (void)unused;
    svo_message message = {""};
    svo_tree *tree = small_tree(NEED_ALL), *loaded = NULL;
    const char *path = path_of("round.svo");
    const svo_sink sink = {.path = path, .write = end_the_test};
    const svo_source source = {.path = path, .bytes = "no tree", .byte_count = 7, .name = "bytes"};
    (void)unlink(path);
    assert_int_equal(svo_tree_save(tree, sink, NULL, &message), SVO_OK);
    assert_int_equal(svo_tree_load(source, NULL, &loaded, &message), SVO_OK);
    assert_same_tree(tree, loaded);
    assert_int_equal(unlink(path), 0);
    svo_tree_destroy(&loaded);
    assert_int_equal(svo_tree_load(source, NULL, &loaded, &message), SVO_FILE_ERROR);
    assert_null(loaded);
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
    svo_tree *tree = small_tree(NEED_ALL);
    const char *path = path_of("none.svo");
    const pid_t child = fork();
    if (child == 0) {
        const struct rlimit core = {0};
        const struct rlimit tight = {.rlim_cur = 600, .rlim_max = 600};
        (void)setrlimit(RLIMIT_CORE, &core);
        (void)setrlimit(RLIMIT_FSIZE, &tight);
        (void)signal(SIGXFSZ, SIG_DFL);
        (void)svo_tree_save(tree, svo_to_path(path), NULL, NULL);
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

TEST_GROUP(file)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trips),
        cmocka_unit_test(test_double_positions_stay_double),
        cmocka_unit_test(test_compression_makes_the_full_tree_smaller),
        cmocka_unit_test(test_layout_is_as_documented),
        cmocka_unit_test(test_every_flipped_byte_is_found),
        cmocka_unit_test(test_flipped_bytes_of_compressed_chunks_do_no_harm),
        cmocka_unit_test(test_every_truncation_is_found),
        cmocka_unit_test(test_trees_have_a_limit_of_voxels),
        cmocka_unit_test(test_foreign_files_are_named),
        cmocka_unit_test(test_files_that_cannot_be_read),
        cmocka_unit_test(test_exactness_is_kept),
        cmocka_unit_test(test_broken_headers_are_named),
        cmocka_unit_test(test_reserved_bytes_are_not_read),
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
        cmocka_unit_test(test_a_path_comes_before_bytes_and_functions),
        cmocka_unit_test(test_a_process_that_ends_while_saving_leaves_nothing),
    };
    return cmocka_run_group_tests_name("file", tests, make_directory, remove_directory);
}
