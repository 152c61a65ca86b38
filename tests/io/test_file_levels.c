/* SPDX-License-Identifier: MIT */
/*
 * Upper levels of .svo files, and files of older versions. The levels of a file are those of the whole tree, array by
 * array; nothing below them is read; files of versions 1 and 2 give the same trees.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/file_format.h"
#include "small_tree.h"
#include "support/older_file.h"
#include "support/suite.h"
#include "svocl/io.h"
#include "svocl/plan.h"

#define NEED_ALL     ((uint32_t)SVO_NEED_ALL)
#define NEED_PAYLOAD ((uint32_t)SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_MATERIAL | SVO_NEED_FILL)

static char path[64];

/* What a tree writes. */
typedef struct received {
    uint8_t bytes[1 << 17];
    size_t byte_count;
} received;

static int receive(void *user, const void *bytes, size_t byte_count)
{
    received *to = user;
    assert_true(byte_count <= sizeof to->bytes - to->byte_count);
    memcpy(to->bytes + to->byte_count, bytes, byte_count);
    to->byte_count += byte_count;
    return 0;
}

static void write_file(const void *bytes, size_t byte_count)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, byte_count, file), byte_count);
    assert_int_equal(fclose(file), 0);
}

static void write_tree(const svo_tree *tree, uint32_t compress)
{
    static received file;
    const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
    file.byte_count = 0;
    assert_int_equal(svo_tree_save(tree, svo_to_callback(receive, &file), &options, NULL), SVO_OK);
    write_file(file.bytes, file.byte_count);
}

static svo_tree *load_levels(uint32_t last_level)
{
    svo_tree *tree = NULL;
    svo_message message = {""};
    const svo_load_options options = {.struct_size = sizeof options, .last_level = last_level};
    if (svo_tree_load(svo_from_path(path), &options, &tree, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return tree;
}

static void assert_prefix(const svo_tree *whole, const svo_tree *upper, svo_tree_buffer buffer, uint64_t count)
{
    if (count == 0) {
        assert_null(upper->host[buffer]);
    } else {
        assert_memory_equal(upper->host[buffer], whole->host[buffer], count * svo_i_tree_element_bytes(buffer));
    }
}

/* Checks a tree of upper levels against the definition: prefixes of the whole tree's arrays. */
static void check_levels(const svo_tree *whole, const svo_tree *upper, uint32_t last_level)
{
    const svo_tree_info *from = &whole->info;
    const svo_tree_info *info = &upper->info;
    const bool payload = from->payload_level <= last_level;
    const uint64_t payload_count =
        payload ? from->level_begin[last_level + 1] - from->level_begin[from->payload_level] : 0;
    assert_int_equal(info->depth, last_level);
    assert_int_equal(info->snap_bits, from->snap_bits);
    assert_int_equal(info->need, payload ? from->need & NEED_PAYLOAD : 0);
    assert_int_equal(info->constant, payload ? from->constant : 0);
    assert_int_equal(info->triangles, from->triangles);
    assert_int_equal(info->fragments, from->fragments);
    assert_memory_equal(info->level_begin, from->level_begin, (last_level + 2) * sizeof(uint32_t));
    assert_int_equal(info->inner_count, from->level_begin[last_level]);
    assert_int_equal(info->leaf_count, from->level_begin[last_level + 1] - from->level_begin[last_level]);
    assert_prefix(whole, upper, SVO_TREE_CHILD_MASK, info->inner_count);
    assert_prefix(whole, upper, SVO_TREE_FIRST_CHILD, info->inner_count);
    for (svo_tree_buffer i = SVO_TREE_COLORS; i < SVO_TREE_BUFFER_COUNT; ++i) {
        assert_prefix(whole, upper, i, svo_i_tree_holds(info, i) ? payload_count : 0);
    }
}

/* With payload from a level on: the arrays of such a tree are the tail of those with payload everywhere. */
static void begin_payload(svo_tree *tree, uint32_t payload_level)
{
    const uint64_t skipped = tree->info.level_begin[payload_level];
    tree->info.payload_level = payload_level;
    for (svo_tree_buffer i = SVO_TREE_COLORS; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const bool is_payload = i <= SVO_TREE_NORMALS || i == SVO_TREE_MATERIALS || i == SVO_TREE_FILLS;
        const size_t element_bytes = svo_i_tree_element_bytes(i);
        if (is_payload && tree->host[i] != NULL) {
            memmove(tree->host[i], (uint8_t *)tree->host[i] + skipped * element_bytes,
                    (tree->info.node_count - skipped) * element_bytes);
        }
    }
}

static void make_constant(svo_tree *tree)
{
    int16_t *normals = tree->host[SVO_TREE_NORMALS];
    tree->info.constant = SVO_NEED_NORMAL;
    for (uint64_t i = 0; i < svo_i_tree_payload_count(&tree->info); ++i) {
        memcpy(normals + 3 * i, (const int16_t[]){32767, 0, -5}, 3 * sizeof *normals);
    }
}

/* Full, sparse and empty trees; with payload everywhere and in lower levels, different and constant. */
static svo_tree *make_case(uint32_t number)
{
    uint32_t codes[512];
    for (uint32_t i = 0; i < 512; ++i) {
        codes[i] = i;
    }
    static const uint32_t needs[] = {NEED_ALL, SVO_NEED_FILL, NEED_PAYLOAD};
    const uint32_t need = needs[number % 3];
    const uint32_t shape = number / 3 % 3;
    svo_tree *tree = shape == 0 ? small_tree(need) : small_tree_make(codes, shape == 1 ? 512 : 0, need);
    if (shape != 2) {
        begin_payload(tree, number / 9 % 4);
    }
    if ((need & SVO_NEED_NORMAL) != 0 && number / 36 % 2 == 1) {
        make_constant(tree);
    }
    return tree;
}

#define CASES 72

static void test_upper_levels_are_those_of_the_tree(void **unused)
{
    (void)unused;
    for (uint32_t number = 0; number < CASES; ++number) {
        svo_tree *tree = make_case(number);
        for (uint32_t compress = 0; compress < 2; ++compress) {
            write_tree(tree, compress);
            for (uint32_t level = 1; level < SMALL_TREE_DEPTH; ++level) {
                svo_tree *upper = load_levels(level);
                check_levels(tree, upper, level);
                svo_tree_destroy(&upper);
            }
            svo_tree *all = load_levels(SMALL_TREE_DEPTH);
            assert_same_tree(tree, all);
            svo_tree_destroy(&all);
        }
        svo_tree_destroy(&tree);
    }
}

static void test_a_tree_of_upper_levels_can_be_saved(void **unused)
{
    (void)unused;
    for (uint32_t is_exact = 0; is_exact < 2; ++is_exact) {
        svo_tree *tree = small_tree(NEED_ALL);
        tree->info.is_exact = is_exact;
        write_tree(tree, 0);
        svo_tree *upper = load_levels(2);
        assert_int_equal(upper->info.is_exact, is_exact);
        write_tree(upper, 1);
        svo_tree *again = load_levels(2);
        assert_int_equal(again->info.is_exact, is_exact);
        assert_same_tree(upper, again);
        svo_tree_destroy(&again);
        svo_tree_destroy(&upper);
        svo_tree_destroy(&tree);
    }
}

/* Every byte after the chunks of the upper levels is destroyed. */
static void test_lower_levels_are_not_read(void **unused)
{
    (void)unused;
    static received file;
    svo_tree *tree = small_tree(NEED_ALL);
    file.byte_count = 0;
    assert_int_equal(svo_tree_save(tree, svo_to_callback(receive, &file), NULL, NULL), SVO_OK);
    const file_head *head = (const file_head *)(const void *)file.bytes;
    size_t end = 0;
    for (uint32_t i = 0; i < head->header.chunk_count; ++i) {
        const file_chunk *chunk = &head->chunks[i];
        end = chunk->kind >> FILE_KIND_BITS <= 2 ? (size_t)(chunk->offset + chunk->stored_bytes) : end;
    }
    assert_true(end < file.byte_count);
    memset(file.bytes + end, 0xa5, file.byte_count - end);
    write_file(file.bytes, file.byte_count);
    svo_tree *upper = load_levels(2);
    check_levels(tree, upper, 2);
    svo_tree_destroy(&upper);
    assert_int_equal(svo_tree_load(svo_from_path(path), NULL, &upper, NULL), SVO_FILE_DAMAGED);
    svo_tree_destroy(&tree);
}

static void test_levels_that_are_not_there_are_refused(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(NEED_ALL);
    svo_tree *loaded = NULL;
    svo_message message = {""};
    write_tree(tree, 0);
    const svo_load_options below = {.struct_size = sizeof below, .last_level = 4};
    assert_int_equal(svo_tree_load(svo_from_path(path), &below, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(message.text, "svo_tree_load: options.last_level 4 is not in 1 .. 3, the depth of "));
    const svo_load_options upper = {.struct_size = sizeof upper, .last_level = 1};
    assert_int_equal(svo_tree_load(svo_from_path(NULL), &upper, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_tree_load: source.path and source.bytes are NULL");
    assert_null(loaded);
    svo_tree_destroy(&tree);
}

/* Versions 1 and 2, whole and shortened. */
static void test_older_files_give_the_same_trees(void **unused)
{
    (void)unused;
    for (uint32_t number = 0; number < CASES; ++number) {
        svo_tree *tree = make_case(number);
        for (uint32_t version = 1; version <= 2; ++version) {
            size_t byte_count = 0;
            uint8_t *bytes = older_file_make(tree, version, &byte_count);
            write_file(bytes, byte_count);
            free(bytes);
            for (uint32_t level = 1; level < SMALL_TREE_DEPTH; ++level) {
                svo_tree *upper = load_levels(level);
                check_levels(tree, upper, level);
                svo_tree_destroy(&upper);
            }
            svo_tree *all = load_levels(SMALL_TREE_DEPTH);
            if (version == 1 && tree->info.positions != SVO_POSITIONS_ROUNDED) {
                assert_int_equal(all->info.positions, SVO_POSITIONS_ROUNDED);
                assert_null(all->host[SVO_TREE_POSITIONS]);
                svo_i_free(tree->host[SVO_TREE_POSITIONS]);
                tree->host[SVO_TREE_POSITIONS] = NULL;
                tree->info.positions = SVO_POSITIONS_ROUNDED;
            }
            assert_same_tree(tree, all);
            svo_tree_destroy(&all);
        }
        svo_tree_destroy(&tree);
    }
}

/* A file in memory has the same upper levels, whatever its version. */
static void test_levels_of_a_file_in_memory(void **unused)
{
    (void)unused;
    static received file;
    svo_tree *tree = small_tree(NEED_ALL), *upper = NULL;
    svo_message message = {""};
    const svo_load_options options = {.struct_size = sizeof options, .last_level = 2};
    size_t byte_count = 0;
    uint8_t *older = older_file_make(tree, 2, &byte_count);
    file.byte_count = 0;
    assert_int_equal(svo_tree_save(tree, svo_to_callback(receive, &file), NULL, NULL), SVO_OK);
    const svo_source sources[] = {svo_from_memory(file.bytes, file.byte_count, "file"),
                                  svo_from_memory(older, byte_count, "older")};
    for (size_t i = 0; i < 2; ++i) {
        assert_int_equal(svo_tree_load(sources[i], &options, &upper, &message), SVO_OK);
        check_levels(tree, upper, 2);
        svo_tree_destroy(&upper);
    }
    const svo_load_options below = {.struct_size = sizeof below, .last_level = 4};
    assert_int_equal(svo_tree_load(sources[0], &below, &upper, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_tree_load: options.last_level 4 is not in 1 .. 3, the depth of file");
    assert_null(upper);
    free(older);
    svo_tree_destroy(&tree);
}

/* A file of version 2 whose first_child contradicts its child masks. */
static void test_older_links_are_checked(void **unused)
{
    (void)unused;
    svo_tree *tree = small_tree(SVO_NEED_FILL);
    svo_tree *loaded = NULL;
    svo_message message = {""};
    size_t byte_count = 0;
    ((uint32_t *)tree->host[SVO_TREE_FIRST_CHILD])[0] = 2;
    uint8_t *bytes = older_file_make(tree, 2, &byte_count);
    assert_int_equal(svo_tree_load(svo_from_memory(bytes, byte_count, "old"), NULL, &loaded, &message),
                     SVO_FILE_DAMAGED);
    assert_string_equal(message.text, "old: node 0: first_child is 2, 1 expected");
    free(bytes);
    svo_tree_destroy(&tree);
}

static int make_path(void **unused)
{
    (void)unused;
    (void)snprintf(path, sizeof path, "/tmp/svocl-levels-XXXXXX");
    const int file = mkstemp(path);
    return file >= 0 ? close(file) : -1;
}

static int remove_path(void **unused)
{
    (void)unused;
    return unlink(path);
}

TEST_GROUP(file_levels)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_upper_levels_are_those_of_the_tree),
        cmocka_unit_test(test_a_tree_of_upper_levels_can_be_saved),
        cmocka_unit_test(test_lower_levels_are_not_read),
        cmocka_unit_test(test_levels_that_are_not_there_are_refused),
        cmocka_unit_test(test_older_files_give_the_same_trees),
        cmocka_unit_test(test_levels_of_a_file_in_memory),
        cmocka_unit_test(test_older_links_are_checked),
    };
    return cmocka_run_group_tests_name("file_levels", tests, make_path, remove_path);
}
