/* SPDX-License-Identifier: MIT */
/*
 * .svo files of versions 1 and 2, after the description in io.h: a chunk holds a whole array, the kinds ascend, and
 * first_child is one of them. The header's values are those that the library writes today; they have not changed.
 */
#include "older_file.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/tree.h"
#include "svocl/io.h"

/* Offsets of io.h. */
enum {
    AT_VERSION = 8,
    AT_HEADER_BYTES = 12,
    AT_FILE_BYTES = 16,
    AT_HASH = 24,
    AT_CHUNK_COUNT = 32,
    TABLE = 200,
    ENTRY_BYTES = 40,
    ENTRY_OFFSET = 8,
    ENTRY_STORED = 16,
    ENTRY_PLAIN = 24,
    ENTRY_HASH = 32
};

/* Keeps the first bytes of what is written. */
static int keep_header(void *user, const void *bytes, size_t byte_count)
{
    uint8_t **header = user;
    if (*header == NULL && byte_count >= TABLE) {
        *header = malloc(TABLE);
        assert_non_null(*header);
        memcpy(*header, bytes, TABLE);
    }
    return 0;
}

static size_t bytes_of(const svo_tree *tree, svo_tree_buffer buffer)
{
    return (size_t)svo_i_tree_element_count(&tree->info, buffer) * svo_i_tree_element_bytes(buffer);
}

static bool is_written(const svo_tree *tree, uint32_t version, svo_tree_buffer buffer)
{
    const bool positions = buffer == SVO_TREE_POSITIONS || buffer == SVO_TREE_POSITIONS_DOUBLE;
    return svo_i_tree_holds(&tree->info, buffer) && !(positions && version == 1);
}

static void put_entry(uint8_t *entry, svo_tree_buffer kind, uint64_t offset, const void *plain, uint64_t byte_count)
{
    const uint32_t kind_word = kind;
    const uint64_t hash = XXH3_64bits(byte_count > 0 ? plain : "", (size_t)byte_count);
    memset(entry, 0, ENTRY_BYTES);
    memcpy(entry, &kind_word, sizeof kind_word);
    memcpy(entry + ENTRY_OFFSET, &offset, sizeof offset);
    memcpy(entry + ENTRY_STORED, &byte_count, sizeof byte_count);
    memcpy(entry + ENTRY_PLAIN, &byte_count, sizeof byte_count);
    memcpy(entry + ENTRY_HASH, &hash, sizeof hash);
}

uint8_t *older_file_make(const svo_tree *tree, uint32_t version, size_t *byte_count)
{
    uint8_t *header = NULL;
    uint32_t chunk_count = 0;
    uint64_t array_bytes = 0;
    assert_int_equal(svo_tree_save(tree, svo_to_callback(keep_header, &header), NULL, NULL), SVO_OK);
    for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (is_written(tree, version, (svo_tree_buffer)i)) {
            array_bytes += bytes_of(tree, (svo_tree_buffer)i);
            ++chunk_count;
        }
    }
    const uint32_t header_bytes = TABLE + chunk_count * ENTRY_BYTES;
    const uint64_t file_bytes = header_bytes + array_bytes;
    uint8_t *file = malloc((size_t)file_bytes);
    assert_non_null(file);
    memcpy(file, header, TABLE);
    free(header);
    uint64_t offset = header_bytes;
    uint8_t *entry = file + TABLE;
    for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const svo_tree_buffer buffer = (svo_tree_buffer)i;
        if (!is_written(tree, version, buffer)) {
            continue;
        }
        const size_t bytes = bytes_of(tree, buffer);
        put_entry(entry, buffer, offset, tree->host[i], bytes);
        if (bytes > 0) {
            memcpy(file + offset, tree->host[i], bytes);
        }
        entry += ENTRY_BYTES;
        offset += bytes;
    }
    memcpy(file + AT_VERSION, &version, sizeof version);
    memcpy(file + AT_HEADER_BYTES, &header_bytes, sizeof header_bytes);
    memcpy(file + AT_FILE_BYTES, &file_bytes, sizeof file_bytes);
    memcpy(file + AT_CHUNK_COUNT, &chunk_count, sizeof chunk_count);
    const uint64_t hash = XXH3_64bits(file + AT_CHUNK_COUNT, header_bytes - AT_CHUNK_COUNT);
    memcpy(file + AT_HASH, &hash, sizeof hash);
    *byte_count = (size_t)file_bytes;
    return file;
}
