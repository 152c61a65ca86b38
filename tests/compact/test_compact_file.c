/* SPDX-License-Identifier: MIT */
/*
 * Files of compact trees: what is loaded is what was saved, and whatever is wrong with a file is told in one line, also
 * when its checksums agree.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "compact_reference.h"
#include "core/compact.h"
#include "io/file_format.h"
#include "support/fixture_folder.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "svocl/io.h"

#define PAYLOAD \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_FILL)

static uint8_t random_mask(void *user, uint32_t level, uint64_t code)
{
    const uint64_t half = random_below(user, 256);
    const uint8_t mask = (uint8_t)(half & random_below(user, 256)); /* a quarter of the bits */
    (void)level;
    (void)code;
    return mask != 0 ? mask : 16;
}

static svo_compact *make_of(const fixture *opened, const svo_tree *tree, svo_form form)
{
    const svo_compact_options options = {.struct_size = sizeof options, .form = form};
    svo_compact *made = NULL;
    if (svo_compact_create(opened->device, tree, &options, opened->queue, &made) != SVO_OK ||
        svo_compact_download(made, opened->queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened->device));
    }
    return made;
}

static svo_compact *make(const fixture *opened, uint32_t depth, uint32_t need, svo_form form)
{
    uint64_t seed = 3 + depth;
    svo_tree *tree = hand_tree(depth, random_mask, &seed, need, depth / 2);
    svo_compact *made = make_of(opened, tree, form);
    svo_tree_destroy(&tree);
    return made;
}

/* A file in memory. */
typedef struct bytes {
    uint8_t *data;
    size_t count;
} bytes;

static int append(void *user, const void *data, size_t byte_count)
{
    bytes *to = user;
    to->data = realloc(to->data, to->count + byte_count);
    assert_non_null(to->data);
    memcpy(to->data + to->count, data, byte_count);
    to->count += byte_count;
    return 0;
}

static int refuse(void *user, const void *data, size_t byte_count)
{
    (void)user;
    (void)data;
    (void)byte_count;
    return 1;
}

static bytes bytes_of(const svo_compact *compact, bool compress)
{
    const svo_save_options options = {.struct_size = sizeof options, .compress = compress};
    bytes made = {NULL, 0};
    svo_message message = {""};
    if (svo_compact_save(compact, svo_to_callback(append, &made), &options, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return made;
}

static void assert_same(const svo_compact *a, const svo_compact *b)
{
    assert_memory_equal(&a->info, &b->info, sizeof a->info);
    for (int i = 0; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        assert_int_equal(a->host[i] == NULL, b->host[i] == NULL);
        if (a->host[i] != NULL) {
            assert_memory_equal(a->host[i], b->host[i], a->info.bytes[i]);
        }
    }
}

static void assert_damaged(const bytes *file, const char *what, size_t at)
{
    svo_compact *loaded = NULL;
    svo_message message = {""};
    const svo_status status =
        svo_compact_load(svo_from_memory(file->data, file->count, "cut"), NULL, &loaded, &message);
    if (status != SVO_FILE_DAMAGED || strncmp(message.text, "cut: ", 5) != 0 || strchr(message.text, '\n') != NULL ||
        loaded != NULL) {
        fail_msg("%s %zu: %s, \"%s\"", what, at, svo_name(SVO_NAME_STATUS, status), message.text);
    }
}

/* zstd does not read every bit of a frame: what is unpacked may be the same. */
static void assert_damaged_or_same(const bytes *file, const svo_compact *packed, size_t bit)
{
    svo_compact *loaded = NULL;
    if (packed != NULL &&
        svo_compact_load(svo_from_memory(file->data, file->count, "cut"), NULL, &loaded, NULL) == SVO_OK) {
        assert_same(packed, loaded);
        svo_compact_destroy(&loaded);
        return;
    }
    assert_damaged(file, "flipped bit", bit);
}

/* Computes all checksums again. Chunks are not compressed. */
static void repair(bytes *file)
{
    file_head head;
    memset(&head, 0, sizeof head);
    memcpy(&head, file->data, sizeof head < file->count ? sizeof head : file->count);
    for (uint32_t i = 0; i < head.header.chunk_count; ++i) {
        head.chunks[i].hash = XXH3_64bits(file->data + head.chunks[i].offset, (size_t)head.chunks[i].plain_bytes);
    }
    head.header.header_hash =
        XXH3_64bits((const uint8_t *)&head + FILE_HASH_BEGIN, head.header.header_bytes - FILE_HASH_BEGIN);
    memcpy(file->data, &head, head.header.header_bytes);
}

/* ---- whole files ---- */

static void what_is_saved_is_loaded(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    work_folder_remember("a.svc");
    for (int turn = 0; turn < 4 * SVO_FORM_COUNT; ++turn) {
        const int round = turn / SVO_FORM_COUNT;
        const svo_form form = (svo_form)(turn % SVO_FORM_COUNT);
        svo_compact *made = make(&opened, 1 + (uint32_t)turn % 6, round == 0 ? 0 : PAYLOAD, form);
        svo_compact *loaded = NULL;
        svo_message message = {""};
        char hashes[2][SVO_HASH_TEXT_BYTES];
        svo_tree *trees[2] = {NULL, NULL};
        const svo_save_options options = {.struct_size = sizeof options, .compress = round < 2};
        if (svo_compact_save(made, svo_to_path(path_of("a.svc")), &options, &message) != SVO_OK ||
            svo_compact_load(svo_from_path(path_of("a.svc")), NULL, &loaded, &message) != SVO_OK) {
            fail_msg("%s", message.text);
            return;
        }
        assert_same(made, loaded);
        assert_int_equal(svo_compact_upload(loaded, opened.device, opened.queue), SVO_OK);
        assert_int_equal(svo_compact_expand(made, opened.queue, &trees[0]), SVO_OK);
        assert_int_equal(svo_compact_expand(loaded, opened.queue, &trees[1]), SVO_OK);
        for (int i = 0; i < 2; ++i) {
            assert_int_equal(svo_tree_download(trees[i], opened.queue), SVO_OK);
            assert_int_equal(svo_tree_hash(trees[i], SVO_HASH_ALL, hashes[i]), SVO_OK);
            svo_tree_destroy(&trees[i]);
        }
        assert_string_equal(hashes[0], hashes[1]);
        svo_compact_destroy(&loaded);
        svo_compact_destroy(&made);
    }
}

/* What the bytes of a file hold. */
static svo_compact *load_bytes(const bytes *file)
{
    svo_compact *loaded = NULL;
    svo_message message = {""};
    if (svo_compact_load(svo_from_memory(file->data, file->count, "file"), NULL, &loaded, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    return loaded;
}

/* Of eight nodes, as many as the user's number are full. */
static uint8_t block_mask(void *user, uint32_t level, uint64_t code)
{
    return level == 0 || code % 8 < *(const uint64_t *)user ? 255 : 129;
}

/* Levels may have no nodes at all, and leaves lie on any. */
static void merged_trees_are_loaded(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint32_t turn = 0; turn < 9 * SVO_FORM_COUNT; ++turn) {
        const svo_compact_options options = {
            .struct_size = sizeof options, .form = (svo_form)(turn % SVO_FORM_COUNT), .minimize = 1};
        uint64_t full = turn / SVO_FORM_COUNT % 3 * 4;
        svo_tree *tree = hand_tree(2 + turn / SVO_FORM_COUNT / 3, block_mask, &full, 0, 0);
        svo_compact *made = NULL;
        assert_int_equal(svo_compact_create(opened.device, tree, &options, opened.queue, &made), SVO_OK);
        assert_int_equal(svo_compact_download(made, opened.queue), SVO_OK);
        assert_true(full < 8 || made->info.leaf_count == 8);
        bytes file = bytes_of(made, false);
        svo_compact *loaded = load_bytes(&file);
        assert_same(made, loaded);
        free(file.data);
        svo_compact_destroy(&loaded);
        svo_compact_destroy(&made);
        svo_tree_destroy(&tree);
    }
}

/* ---- whether voxels are those of the mesh as it was given ---- */

static uint32_t exactness_of(const svo_compact *compact)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    assert_int_equal(svo_compact_get_info(compact, &info), SVO_OK);
    return info.is_exact;
}

/* Checks the tree that a compact tree expands to, its .svo file, and what it is made compact to again. */
static void check_expanded(const fixture *opened, svo_compact *compact, uint32_t is_exact)
{
    svo_tree *tree = NULL;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    bytes file = {NULL, 0};
    assert_int_equal(svo_compact_expand(compact, opened->queue, &tree), SVO_OK);
    assert_int_equal(svo_tree_get_info(tree, &info), SVO_OK);
    assert_int_equal(info.is_exact, is_exact);
    assert_int_equal(svo_tree_download(tree, opened->queue), SVO_OK);
    assert_int_equal(svo_tree_save(tree, svo_to_callback(append, &file), NULL, NULL), SVO_OK);
    assert_int_equal(file.data[8], is_exact != 0 ? 4 : 3);
    free(file.data);
    svo_compact *again = make_of(opened, tree, SVO_FORM_IMPLIED);
    assert_int_equal(exactness_of(again), is_exact);
    svo_compact_destroy(&again);
    svo_tree_destroy(&tree);
}

static void exactness_is_kept(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint32_t turn = 0; turn < 2 * SVO_FORM_COUNT; ++turn) {
        uint64_t seed = 5;
        svo_tree *tree = hand_tree(4, random_mask, &seed, PAYLOAD, 2);
        const svo_compact_options options = {.struct_size = sizeof options, .form = (svo_form)(turn / 2)};
        svo_compact_info planned = SVO_COMPACT_INFO_INIT;
        tree->info.is_exact = turn % 2;
        assert_int_equal(svo_compact_plan(tree, &options, &planned), SVO_OK);
        assert_int_equal(planned.is_exact, turn % 2);
        svo_compact *made = make_of(&opened, tree, options.form);
        assert_int_equal(exactness_of(made), turn % 2);
        bytes file = bytes_of(made, turn >= SVO_FORM_COUNT);
        assert_int_equal(file.data[8], 1 + turn % 2);
        svo_compact *loaded = load_bytes(&file);
        assert_same(made, loaded);
        assert_int_equal(svo_compact_upload(loaded, opened.device, opened.queue), SVO_OK);
        check_expanded(&opened, loaded, turn % 2);
        free(file.data);
        svo_compact_destroy(&loaded);
        svo_compact_destroy(&made);
        svo_tree_destroy(&tree);
    }
}

/* A file that was written before version 2 has these bytes, and version 1. Its hash covers what it was rounded to. */
static void older_files_are_not_exact(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    char hashes[2][SVO_HASH_TEXT_BYTES];
    uint64_t seed = 6;
    svo_tree *tree = hand_tree(4, random_mask, &seed, PAYLOAD, 2);
    tree->info.is_exact = 1;
    svo_compact *made = make_of(&opened, tree, SVO_FORM_DESCRIPTOR);
    bytes file = bytes_of(made, false);
    file.data[8] = 1;
    svo_compact *loaded = load_bytes(&file);
    assert_int_equal(exactness_of(loaded), 0);
    assert_int_equal(svo_compact_hash(made, hashes[0]), SVO_OK);
    assert_int_equal(svo_compact_hash(loaded, hashes[1]), SVO_OK);
    assert_string_not_equal(hashes[0], hashes[1]);
    for (uint8_t version = 0; version < 5; version = version == 0 ? 3 : (uint8_t)(version + 1)) {
        file.data[8] = version; /* version 3 has packed payload */
        assert_damaged(&file, "version", version);
    }
    free(file.data);
    svo_compact_destroy(&loaded);
    svo_compact_destroy(&made);
    svo_tree_destroy(&tree);
}

/* ---- damage ---- */

static void every_cut_and_every_flipped_bit_is_noticed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (int turn = 0; turn < 2 * SVO_FORM_COUNT; ++turn) {
        svo_compact *made = make(&opened, 3, PAYLOAD, (svo_form)(turn % SVO_FORM_COUNT));
        bytes file = bytes_of(made, turn >= SVO_FORM_COUNT);
        const size_t whole = file.count;
        for (file.count = 0; file.count < whole; ++file.count) {
            assert_damaged(&file, "cut at", file.count);
        }
        for (size_t bit = 0; bit < whole * 8; bit += 3) {
            file.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
            assert_damaged_or_same(&file, turn >= SVO_FORM_COUNT ? made : NULL, bit);
            file.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        }
        free(file.data);
        svo_compact_destroy(&made);
    }
}

/* Whether a file holds another tree: with another mirror a reference leads to a record as well. */
static bool is_mirrored_otherwise(const bytes *file, const svo_compact *made, size_t bit)
{
    svo_compact *loaded = NULL;
    if (made->info.form != SVO_FORM_MIRRORED || bit % 16 < 13 ||
        svo_compact_load(svo_from_memory(file->data, file->count, "cut"), NULL, &loaded, NULL) != SVO_OK) {
        return false;
    }
    assert_memory_equal(&loaded->info, &made->info, sizeof made->info);
    svo_compact_destroy(&loaded);
    return true;
}

/* Every bit of the nodes and of what leads to them matters, whatever the checksums say. */
static void damaged_structure_is_noticed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        svo_compact *made = make(&opened, 5, SVO_NEED_COLOR, (svo_form)form);
        bytes file = bytes_of(made, false);
        file_head head;
        memcpy(&head, file.data, sizeof head);
        for (uint32_t i = 0; i < head.header.chunk_count; ++i) {
            const bool counts = head.chunks[i].kind == FILE_COUNTS;
            const size_t end = (size_t)head.chunks[i].plain_bytes * 8;
            for (size_t bit = 0; bit < end && (counts || head.chunks[i].kind < SVO_COMPACT_COLORS); ++bit) {
                uint8_t *at = file.data + head.chunks[i].offset + bit / 8;
                if (counts && bit == 32) {
                    continue; /* minimized: leaves may lie above, but need not */
                }
                *at ^= (uint8_t)(1u << bit % 8);
                const bool nodes = head.chunks[i].kind == SVO_COMPACT_NODES;
                repair(&file);
                if (!nodes || !is_mirrored_otherwise(&file, made, bit)) {
                    assert_damaged(&file, nodes ? "nodes, bit" : "chunk, bit", bit);
                }
                *at ^= (uint8_t)(1u << bit % 8);
            }
        }
        repair(&file);
        svo_compact *loaded = NULL;
        assert_int_equal(svo_compact_load(svo_from_memory(file.data, file.count, "whole"), NULL, &loaded, NULL),
                         SVO_OK);
        svo_compact_destroy(&loaded);
        free(file.data);
        svo_compact_destroy(&made);
    }
}

/* ---- packed payload ---- */

/* A tree whose colors and normals go up slowly, so that they become smaller. */
static svo_compact *make_packed(const fixture *opened, uint32_t depth, svo_form form, uint32_t is_exact)
{
    const svo_pack_options options = {.struct_size = sizeof options, .color_error = 2};
    uint64_t seed = 3 + depth;
    svo_tree *tree = hand_tree(depth, random_mask, &seed, PAYLOAD, 0);
    uint8_t *colors = tree->host[SVO_TREE_COLORS];
    int16_t *normals = tree->host[SVO_TREE_NORMALS];
    uint16_t *materials = tree->host[SVO_TREE_MATERIALS];
    uint16_t *fills = tree->host[SVO_TREE_FILLS];
    tree->info.is_exact = is_exact;
    for (uint32_t i = 0; i < (uint32_t)tree->info.node_count; ++i) {
        for (uint32_t c = 0; c < 4; ++c) {
            colors[4 * i + c] = (uint8_t)(c == 3 ? 255 : i / 5 + 7 * (i & 3) * (c + 1));
            normals[3 * i + (c < 3 ? c : 0)] = (int16_t)((i & 7) * 30);
        }
        materials[i] = (uint16_t)(i / 60);
        fills[i] = (uint16_t)(i * 5 % 64);
    }
    svo_compact *plain = make_of(opened, tree, form);
    svo_compact *made = NULL;
    assert_int_equal(svo_compact_pack(plain, &options, opened->queue, &made), SVO_OK);
    assert_int_equal(svo_compact_download(made, opened->queue), SVO_OK);
    assert_int_equal(made->info.packed, PAYLOAD);
    svo_compact_destroy(&plain);
    svo_tree_destroy(&tree);
    return made;
}

static void packed_payload_is_kept(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    for (uint32_t turn = 0; turn < 2 * SVO_FORM_COUNT; ++turn) {
        svo_compact *made = make_packed(&opened, 5, (svo_form)(turn / 2), turn % 2);
        bytes file = bytes_of(made, turn >= SVO_FORM_COUNT);
        assert_int_equal(file.data[8], 3);
        svo_compact *loaded = load_bytes(&file);
        assert_same(made, loaded);
        assert_int_equal(exactness_of(loaded), turn % 2);
        assert_in_range(loaded->info.largest_error[0], 1, 2);
        assert_int_equal(svo_compact_upload(loaded, opened.device, opened.queue), SVO_OK);
        check_expanded(&opened, loaded, turn % 2);
        free(file.data);
        svo_compact_destroy(&loaded);
        svo_compact_destroy(&made);
    }
}

/* With good checksums: a file that is taken can be read from the first element to the last, and nothing that leads to
   them is free. */
static void damaged_packed_payload_is_noticed(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_compact *made = make_packed(&opened, 5, SVO_FORM_IMPLIED, 1);
    bytes file = bytes_of(made, false);
    file_head head;
    memcpy(&head, file.data, sizeof head);
    size_t noticed = 0;
    for (uint32_t i = 0; i < head.header.chunk_count; ++i) {
        const size_t end = (size_t)head.chunks[i].plain_bytes * 8;
        const bool packed = head.chunks[i].kind >= SVO_COMPACT_COLORS && head.chunks[i].kind < SVO_COMPACT_BUFFER_COUNT;
        for (size_t bit = 0; packed && bit < end; bit += 5) {
            uint8_t *at = file.data + head.chunks[i].offset + bit / 8;
            svo_compact *loaded = NULL;
            *at ^= (uint8_t)(1u << bit % 8);
            repair(&file);
            if (svo_compact_load(svo_from_memory(file.data, file.count, "cut"), NULL, &loaded, NULL) == SVO_OK) {
                const svo_compact_buffer buffer = (svo_compact_buffer)head.chunks[i].kind;
                uint8_t *elements = malloc((size_t)made->info.payload_count * 6);
                assert_non_null(elements);
                assert_int_equal(svo_compact_read_payload(loaded, buffer, 0, made->info.payload_count, elements),
                                 SVO_OK);
                free(elements);
                svo_compact_destroy(&loaded);
            } else {
                assert_damaged(&file, "packed, bit", bit);
                ++noticed;
            }
            *at ^= (uint8_t)(1u << bit % 8);
        }
        /* Where the first block's data begins. */
        for (size_t bit = 0; packed && bit < 14; ++bit) {
            uint32_t header = 0;
            memcpy(&header, file.data + head.chunks[i].offset + 4 * 9, sizeof header);
            uint8_t *at = file.data + head.chunks[i].offset + 4 * (size_t)header + bit / 8;
            *at ^= (uint8_t)(1u << bit % 8);
            repair(&file);
            assert_damaged(&file, "header, bit", bit);
            *at ^= (uint8_t)(1u << bit % 8);
        }
        /* The kind, both counts, the first entry of the directory: each bit. */
        for (size_t bit = 0; packed && bit < 32; ++bit) {
            static const size_t words[] = {0, 1, 7, 8, 9};
            for (size_t k = 0; k < sizeof words / sizeof words[0]; ++k) {
                uint8_t *at = file.data + head.chunks[i].offset + 4 * words[k] + bit / 8;
                *at ^= (uint8_t)(1u << bit % 8);
                repair(&file);
                assert_damaged(&file, "head, bit", 32 * words[k] + bit);
                *at ^= (uint8_t)(1u << bit % 8);
            }
        }
    }
    assert_in_range(noticed, 100, file.count * 8);
    free(file.data);
    svo_compact_destroy(&made);
}

/* ---- wrong calls ---- */

static void wrong_arguments_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_compact *made = make(&opened, 2, 0, SVO_FORM_DESCRIPTOR);
    svo_compact *nowhere = svo_i_compact_new(NULL);
    svo_compact *loaded = NULL;
    svo_message message = {""};
    const svo_save_options small = {.struct_size = 4};
    const svo_load_options levels = {.struct_size = sizeof levels, .last_level = 2};
    assert_int_equal(svo_compact_save(NULL, svo_to_path("a"), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_compact_save: compact is NULL");
    assert_int_equal(svo_compact_save(made, svo_to_path(NULL), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_compact_save: sink.path and sink.write are NULL");
    assert_int_equal(svo_compact_save(made, svo_to_path("a"), &small, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_save(nowhere, svo_to_path("a"), NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_compact_save: there are no host arrays; call svo_compact_download first");
    assert_int_equal(svo_compact_save(made, svo_to_path(path_of("no/such")), NULL, &message), SVO_FILE_ERROR);
    assert_int_equal(svo_compact_save(made, svo_to_callback(refuse, NULL), NULL, &message), SVO_FILE_ERROR);
    assert_int_equal(svo_compact_load(svo_from_path(NULL), NULL, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_load(svo_from_path(path_of("none.svc")), NULL, &loaded, &message), SVO_FILE_ERROR);
    assert_int_equal(svo_compact_load(svo_from_path(path_of("none.svc")), NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_load(svo_from_memory(NULL, 0, "a"), NULL, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_load(svo_from_memory("a", 1, NULL), NULL, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_load(svo_from_memory("a", 1, "a"), NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_compact_load(svo_from_memory("a", 1, "a"), NULL, &loaded, &message), SVO_FILE_DAMAGED);
    assert_string_equal(message.text, "a: not a compact tree's file");
    assert_int_equal(svo_compact_load(svo_from_memory("a", 1, "a"), &levels, &loaded, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, "svo_compact_load: options.last_level is 2; compact trees are read whole");
    assert_null(loaded);
    svo_compact_destroy(&nowhere);
    svo_compact_destroy(&made);
}

/* ---- seeds of the fuzz target ---- */

static void write_seeds(void **state)
{
    static const struct {
        const char *name;
        uint32_t depth, need;
        svo_form form;
        bool compress;
    } seeds[] = {{"words.svc", 4, PAYLOAD, SVO_FORM_DESCRIPTOR, false},
                 {"masks.svc", 4, PAYLOAD, SVO_FORM_IMPLIED, false},
                 {"records.svc", 5, PAYLOAD, SVO_FORM_SHARED, false},
                 {"bare_records.svc", 6, 0, SVO_FORM_SHARED, false},
                 {"halves.svc", 5, PAYLOAD, SVO_FORM_MIRRORED, false},
                 {"bare_halves.svc", 6, 0, SVO_FORM_MIRRORED, false},
                 {"bare_words.svc", 5, 0, SVO_FORM_DESCRIPTOR, false},
                 {"packed.svc", 4, SVO_NEED_COLOR, SVO_FORM_IMPLIED, true}};
    const char *seed_folder = getenv("SVOCL_SEED_FOLDER");
    assert_non_null(seed_folder);
    const fixture opened = fixture_cl_of_group(state);
    for (size_t i = 0; i < sizeof seeds / sizeof seeds[0]; ++i) {
        const svo_save_options options = {.struct_size = sizeof options, .compress = seeds[i].compress};
        char path[512];
        svo_compact *made = make(&opened, seeds[i].depth, seeds[i].need, seeds[i].form);
        (void)snprintf(path, sizeof path, "%s/%s", seed_folder, seeds[i].name);
        assert_int_equal(svo_compact_save(made, svo_to_path(path), &options, NULL), SVO_OK);
        svo_compact_destroy(&made);
    }
    svo_compact *packed = make_packed(&opened, 5, SVO_FORM_IMPLIED, 1);
    char path[512];
    (void)snprintf(path, sizeof path, "%s/blocks.svc", seed_folder);
    assert_int_equal(svo_compact_save(packed, svo_to_path(path), NULL, NULL), SVO_OK);
    svo_compact_destroy(&packed);
}

TEST_GROUP(compact_seeds)
{
    const struct CMUnitTest writing[] = {cmocka_unit_test(write_seeds)};
    return cmocka_run_group_tests_name("compact_seeds", writing, fixture_folder_setup, fixture_folder_teardown);
}

TEST_GROUP(compact_file)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_saved_is_loaded),
                                       cmocka_unit_test(merged_trees_are_loaded),
                                       cmocka_unit_test(exactness_is_kept),
                                       cmocka_unit_test(older_files_are_not_exact),
                                       cmocka_unit_test(every_cut_and_every_flipped_bit_is_noticed),
                                       cmocka_unit_test(damaged_structure_is_noticed),
                                       cmocka_unit_test(packed_payload_is_kept),
                                       cmocka_unit_test(damaged_packed_payload_is_noticed),
                                       cmocka_unit_test(wrong_arguments_are_refused)};
    return cmocka_run_group_tests_name("compact_file", tests, fixture_folder_setup, fixture_folder_teardown);
}
