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
#include "io/file_format.h"
#include "io/file_zstd.h"
#include "output/output.h"

#define COMPRESSION_LEVEL 3

typedef struct save_state {
    const svo_tree *tree;
    const char *name; /* begins messages: the path or the function */
    svo_message *message;
    svo_write_callback write;
    void *user;
    bool compress;
    file_head head;
    void *packed[SVO_TREE_BUFFER_COUNT]; /* compressed chunks, in the order of head.chunks; NULL: written as they are */
} save_state;

/* ZSTD_compress in the tree's memory. */
static size_t compress_array(const save_state *state, void *to, size_t to_bytes, const void *plain, size_t plain_bytes)
{
    ZSTD_CCtx *context = ZSTD_createCCtx_advanced(file_zstd_memory(&state->tree->memory));
    if (context == NULL) {
        return (size_t)0 - (size_t)ZSTD_error_memory_allocation;
    }
    const size_t byte_count = ZSTD_compressCCtx(context, to, to_bytes, plain, plain_bytes, COMPRESSION_LEVEL);
    (void)ZSTD_freeCCtx(context);
    return byte_count;
}

/* Compresses an array if that makes it smaller; *packed stays NULL if not. The caller frees it. */
static svo_status pack(const save_state *state, const void *plain, size_t plain_bytes, void **packed,
                       uint64_t *packed_bytes)
{
    const size_t bound_bytes = ZSTD_compressBound(plain_bytes);
    void *bytes = svo_i_alloc(&state->tree->memory, bound_bytes);
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
    void *shrunk = svo_i_grow(&state->tree->memory, bytes, byte_count);
    *packed = shrunk != NULL ? shrunk : bytes;
    *packed_bytes = byte_count;
    return SVO_OK;
}

static svo_status measure_chunk(const save_state *state, file_chunk *chunk, void **packed)
{
    const svo_tree_buffer kind = (svo_tree_buffer)chunk->kind;
    const void *plain = state->tree->host[kind];
    size_t plain_bytes = 0;
    if (!svo_i_mul_size((size_t)svo_i_tree_element_count(&state->tree->info, kind), svo_i_tree_element_bytes(kind),
                        &plain_bytes) ||
        (plain_bytes > 0 && plain == NULL)) {
        return svo_i_fail(state->message, SVO_INVALID_ARGUMENT, "%s: the tree's array %s is missing", state->name,
                          svo_tree_buffer_name(kind));
    }
    chunk->plain_bytes = plain_bytes;
    chunk->hash = XXH3_64bits(plain_bytes > 0 ? plain : "", plain_bytes);
    chunk->codec = FILE_CODEC_STORED;
    chunk->stored_bytes = plain_bytes;
    if (state->compress && plain_bytes > 0) {
        SVO_I_TRY(pack(state, plain, plain_bytes, packed, &chunk->stored_bytes));
        chunk->codec = *packed != NULL ? FILE_CODEC_ZSTD : FILE_CODEC_STORED;
    }
    return SVO_OK;
}

static void fill_header(file_header *header, const svo_tree_info *info)
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
    for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        header->chunk_count += svo_i_tree_holds(info, (svo_tree_buffer)i) ? 1 : 0;
    }
    header->header_bytes = (uint32_t)(sizeof *header + header->chunk_count * sizeof(file_chunk));
}

/* Fills the header and the chunk table, and compresses the chunks. */
static svo_status measure(save_state *state)
{
    file_header *header = &state->head.header;
    fill_header(header, &state->tree->info);
    uint64_t offset = header->header_bytes;
    uint32_t chunk_index = 0;
    for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (!svo_i_tree_holds(&state->tree->info, (svo_tree_buffer)i)) {
            continue;
        }
        file_chunk *chunk = &state->head.chunks[chunk_index];
        *chunk = (file_chunk){.kind = i, .offset = offset};
        SVO_I_TRY(measure_chunk(state, chunk, &state->packed[chunk_index]));
        offset += chunk->stored_bytes;
        ++chunk_index;
    }
    header->file_bytes = offset;
    header->header_hash =
        XXH3_64bits((const uint8_t *)&state->head + FILE_HASH_BEGIN, header->header_bytes - FILE_HASH_BEGIN);
    return SVO_OK;
}

static svo_status put(const save_state *state, uint64_t offset, const void *bytes, size_t byte_count)
{
    if (byte_count > 0 && state->write(state->user, bytes, byte_count) != 0) {
        return svo_i_fail(state->message, SVO_FILE_ERROR, "%s: %zu bytes at %" PRIu64 " could not be written",
                          state->name, byte_count, offset);
    }
    return SVO_OK;
}

static svo_status write_all(const save_state *state)
{
    const file_header *header = &state->head.header;
    SVO_I_TRY(put(state, 0, &state->head, header->header_bytes));
    for (uint32_t i = 0; i < header->chunk_count; ++i) {
        const file_chunk *chunk = &state->head.chunks[i];
        const void *bytes = state->packed[i] != NULL ? state->packed[i] : state->tree->host[chunk->kind];
        SVO_I_TRY(put(state, chunk->offset, bytes, (size_t)chunk->stored_bytes));
    }
    return SVO_OK;
}

static svo_status write_tree(save_state *state)
{
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(measure(state));
    SVO_I_TRY_CLEANUP(write_all(state));
cleanup:
    for (size_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        svo_i_free(state->packed[i]);
    }
    return status;
}

/* Checks what svo_tree_save and svo_tree_write have in common. */
static svo_status start(const char *function, const svo_tree *tree, const svo_save_options *options,
                        svo_message *message, save_state *state)
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
    *state = (save_state){.tree = tree, .name = function, .message = message, .compress = asked.compress != 0};
    return SVO_OK;
}

svo_status svo_tree_write(const svo_tree *tree, svo_write_callback write, void *user, const svo_save_options *options,
                          svo_message *message)
{
    if (tree == NULL || write == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_tree_write: %s is NULL", tree == NULL ? "tree" : "write");
    }
    save_state state = {.tree = tree};
    SVO_I_TRY(start("svo_tree_write", tree, options, message, &state));
    state.write = write;
    state.user = user;
    return write_tree(&state);
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

svo_status svo_tree_save(const svo_tree *tree, const char *path, const svo_save_options *options, svo_message *message)
{
    if (tree == NULL || path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_tree_save: %s is NULL", tree == NULL ? "tree" : "path");
    }
    sink to = {.output = {.descriptor = -1}};
    save_state state = {.tree = tree};
    SVO_I_TRY(start("svo_tree_save", tree, options, message, &state));
    state.name = path;
    state.write = write_to_sink;
    state.user = &to;
    to.error = svo_i_output_open(path, NULL, &to.output);
    if (to.error != 0) {
        return fail_errno(message, path, to.error);
    }
    svo_status status = write_tree(&state);
    if (status == SVO_OK) {
        to.error = svo_i_output_commit(&to.output);
    }
    svo_i_output_abandon(&to.output);
    return to.error != 0 ? fail_errno(message, path, to.error) : status;
}
