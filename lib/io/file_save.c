/* SPDX-License-Identifier: MIT */
/*
 * Trees to .svo files. The header has the chunks' lengths and checksums, and a pipe cannot go back to it. So the chunks
 * are measured, and compressed into memory if asked for, before anything is written. output/output.c makes the file.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>
#include <zstd_errors.h>

#include "core/message.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "io/file_save.h"
#include "io/file_tree.h"
#include "io/file_zstd.h"
#include "output/output.h"

#define COMPRESSION_LEVEL 3

/* ZSTD_compress in the tree's memory. */
static size_t compress_array(const svo_i_file_save *state, void *to, size_t to_bytes, const void *plain,
                             size_t plain_bytes)
{
    ZSTD_CCtx *context = ZSTD_createCCtx_advanced(file_zstd_memory(state->memory));
    if (context == NULL) {
        return (size_t)0 - (size_t)ZSTD_error_memory_allocation;
    }
    const size_t byte_count = ZSTD_compressCCtx(context, to, to_bytes, plain, plain_bytes, COMPRESSION_LEVEL);
    (void)ZSTD_freeCCtx(context);
    return byte_count;
}

/* Compresses an array if that makes it smaller; *packed stays NULL if not. The caller frees it. */
static svo_status pack(const svo_i_file_save *state, const void *plain, size_t plain_bytes, void **packed,
                       uint64_t *packed_bytes)
{
    const size_t bound_bytes = ZSTD_compressBound(plain_bytes);
    void *bytes = svo_i_alloc(state->memory, bound_bytes);
    if (bytes == NULL) {
        return svo_i_fail(state->message, SVO_OUT_OF_HOST_MEMORY, "%s: compressing needs %zu bytes", state->name,
                          bound_bytes);
    }
    const size_t byte_count = compress_array(state, bytes, bound_bytes, plain, plain_bytes);
    if (ZSTD_isError(byte_count)) {
        svo_i_free(bytes);
        return svo_i_fail(state->message, SVO_OUT_OF_HOST_MEMORY, "%s: zstd: %s", state->name,
                          ZSTD_getErrorName(byte_count));
    }
    if (byte_count >= plain_bytes) {
        svo_i_free(bytes);
        return SVO_OK;
    }
    void *shrunk = svo_i_grow(state->memory, bytes, byte_count);
    *packed = shrunk != NULL ? shrunk : bytes;
    *packed_bytes = byte_count;
    return SVO_OK;
}

static svo_status measure_chunk(const svo_i_file_save *state, const svo_i_file_array *array, file_chunk *chunk,
                                void **packed)
{
    const size_t plain_bytes = (size_t)array->bytes;
    if (array->bytes > SIZE_MAX || (plain_bytes > 0 && array->plain == NULL)) {
        return svo_i_fail(state->message, SVO_INVALID_ARGUMENT, "%s: the tree's array %s is missing", state->name,
                          array->name);
    }
    chunk->plain_bytes = plain_bytes;
    chunk->hash = XXH3_64bits(plain_bytes > 0 ? array->plain : "", plain_bytes);
    chunk->codec = FILE_CODEC_STORED;
    chunk->stored_bytes = plain_bytes;
    if (state->compress && plain_bytes > 0) {
        SVO_I_TRY(pack(state, array->plain, plain_bytes, packed, &chunk->stored_bytes));
        chunk->codec = *packed != NULL ? FILE_CODEC_ZSTD : FILE_CODEC_STORED;
    }
    return SVO_OK;
}

void svo_i_file_fill_header(file_header *header, const svo_tree_info *info)
{
    memcpy(header->magic, FILE_MAGIC, FILE_MAGIC_BYTES);
    header->version = FILE_VERSION;
    header->depth = info->depth;
    header->snap_bits = info->snap_bits;
    header->coverage = info->coverage;
    header->need = (uint16_t)info->need;
    header->constant = (uint16_t)info->constant;
    header->weights = (uint16_t)info->weights;
    header->payload_level = (uint16_t)info->payload_level;
    memcpy(header->origin, info->origin, sizeof header->origin);
    header->edge = info->edge;
    header->scale = info->scale;
    header->snap_error = info->snap_error;
    header->triangles = info->triangles;
    header->refused_triangles = info->refused_triangles;
    header->fragments = info->fragments;
    memcpy(header->level_begin, info->level_begin, (info->depth + 2) * sizeof header->level_begin[0]);
}

/* Fills the chunk table and the rest of the header, and compresses the chunks. */
static svo_status measure(svo_i_file_save *state)
{
    file_header *header = &state->head.header;
    header->chunk_count = state->array_count;
    header->header_bytes = (uint32_t)(sizeof *header + header->chunk_count * sizeof(file_chunk));
    uint64_t offset = header->header_bytes;
    for (uint32_t i = 0; i < state->array_count; ++i) {
        file_chunk *chunk = &state->head.chunks[i];
        *chunk = (file_chunk){.kind = state->arrays[i].kind, .offset = offset};
        SVO_I_TRY(measure_chunk(state, &state->arrays[i], chunk, &state->packed[i]));
        offset += chunk->stored_bytes;
    }
    header->file_bytes = offset;
    header->header_hash =
        XXH3_64bits((const uint8_t *)&state->head + FILE_HASH_BEGIN, header->header_bytes - FILE_HASH_BEGIN);
    return SVO_OK;
}

static svo_status put(const svo_i_file_save *state, uint64_t offset, const void *bytes, size_t byte_count)
{
    if (byte_count > 0 && state->write(state->user, bytes, byte_count) != 0) {
        return svo_i_fail(state->message, SVO_FILE_ERROR, "%s: %zu bytes at %" PRIu64 " could not be written",
                          state->name, byte_count, offset);
    }
    return SVO_OK;
}

static svo_status write_all(const svo_i_file_save *state)
{
    const file_header *header = &state->head.header;
    SVO_I_TRY(put(state, 0, &state->head, header->header_bytes));
    for (uint32_t i = 0; i < header->chunk_count; ++i) {
        const file_chunk *chunk = &state->head.chunks[i];
        const void *bytes = state->packed[i] != NULL ? state->packed[i] : state->arrays[i].plain;
        SVO_I_TRY(put(state, chunk->offset, bytes, (size_t)chunk->stored_bytes));
    }
    return SVO_OK;
}

svo_status svo_i_file_write(svo_i_file_save *state)
{
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(measure(state));
    SVO_I_TRY_CLEANUP(write_all(state));
cleanup:
    for (size_t i = 0; i < FILE_CHUNKS_MAX; ++i) {
        svo_i_free(state->packed[i]);
    }
    return status;
}

/* An output and the first error of writing to it. */
typedef struct sink {
    svo_i_output output;
    int error;
} sink;

static int write_to_sink(void *user, const void *bytes, size_t byte_count)
{
    sink *to = user;
    to->error = svo_i_output_write(&to->output, bytes, byte_count);
    return to->error;
}

static svo_status fail_errno(svo_message *message, const char *path, int error)
{
    return svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be written: %s", path, strerror(error));
}

svo_status svo_i_file_save_to(svo_i_file_save *state, const char *path)
{
    sink to = {.output = {.descriptor = -1}};
    state->name = path;
    state->write = write_to_sink;
    state->user = &to;
    to.error = svo_i_output_open(path, NULL, &to.output);
    if (to.error != 0) {
        state->user = NULL;
        return fail_errno(state->message, path, to.error);
    }
    svo_status status = svo_i_file_write(state);
    state->user = NULL;
    if (status == SVO_OK) {
        to.error = svo_i_output_commit(&to.output);
    }
    svo_i_output_abandon(&to.output);
    return to.error != 0 ? fail_errno(state->message, path, to.error) : status;
}

/* ---- built trees ---- */

/* Checks what svo_tree_save and svo_tree_write have in common. */
static svo_status start(const char *function, const svo_tree *tree, const svo_save_options *options,
                        svo_message *message, svo_i_file_save *state)
{
    svo_save_options asked;
    SVO_I_TRY(svo_i_struct_read(message, function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_save_options, struct_size)));
    const char *undefined = svo_i_tree_undefined(tree);
    if (undefined != NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s", function, undefined);
    }
    if (!tree->downloaded) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "%s: the tree has no host arrays; call svo_tree_download first", function);
    }
    if (tree->part.header.depth != 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the tree is a part of another; call svo_part_save",
                          function);
    }
    *state = (svo_i_file_save){
        .name = function, .message = message, .memory = &tree->memory, .compress = asked.compress != 0};
    svo_i_file_fill_header(&state->head.header, &tree->info);
    file_entry entries[FILE_CHUNKS_MAX];
    state->array_count = svo_i_file_list_entries(&tree->info, FILE_VERSION, entries);
    for (uint32_t i = 0; i < state->array_count; ++i) {
        const file_entry *entry = &entries[i];
        const size_t element_bytes = svo_i_tree_element_bytes(entry->buffer);
        const uint8_t *array = tree->host[entry->buffer];
        const uint64_t begin = svo_i_file_entry_begin(&tree->info, FILE_VERSION, entry);
        state->arrays[i] =
            (svo_i_file_array){.kind = svo_i_file_entry_kind(entry),
                               .name = svo_tree_buffer_name(entry->buffer),
                               .plain = array != NULL ? array + begin * element_bytes : NULL,
                               .bytes = svo_i_file_entry_count(&tree->info, FILE_VERSION, entry) * element_bytes};
    }
    return SVO_OK;
}

svo_status svo_tree_write(const svo_tree *tree, svo_write_callback write, void *user, const svo_save_options *options,
                          svo_message *message)
{
    if (tree == NULL || write == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_tree_write: %s is NULL", tree == NULL ? "tree" : "write");
    }
    svo_i_file_save state = {.name = "svo_tree_write"};
    SVO_I_TRY(start("svo_tree_write", tree, options, message, &state));
    state.write = write;
    state.user = user;
    return svo_i_file_write(&state);
}

svo_status svo_tree_save(const svo_tree *tree, const char *path, const svo_save_options *options, svo_message *message)
{
    if (tree == NULL || path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_tree_save: %s is NULL", tree == NULL ? "tree" : "path");
    }
    svo_i_file_save state = {.name = path};
    SVO_I_TRY(start("svo_tree_save", tree, options, message, &state));
    return svo_i_file_save_to(&state, path);
}
