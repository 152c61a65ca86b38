/* SPDX-License-Identifier: MIT */
/*
 * Headers and chunks of .svo and .svc files: read and written. tree_file.c and compact_file.c make trees of them.
 *
 * Files are not trusted: lengths are checked against the file before anything is allocated, and a checksum covers every
 * byte. The header has the chunks' lengths and checksums, and a pipe cannot go back to it. So the chunks are measured,
 * and compressed into memory if asked for, before anything is written.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>
#define ZSTD_STATIC_LINKING_ONLY /* ZSTD_customMem */
#include <zstd.h>
#include <zstd_errors.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "io/file_format.h"
#include "svocl/plan.h"

/* A zstd block takes at least 4 bytes and holds at most 128 KiB, so no valid chunk expands further. */
#define ZSTD_BLOCK_STORED_BYTES_MIN 4
#define ZSTD_BLOCK_PLAIN_BYTES_MAX  ((uint64_t)128 * 1024)

/* Grids of builds are 2^20 to 2^24 units wide (lib/plan/plan.c). Rays depend on at least 2^16. */
#define SNAP_BITS_MIN 20
#define SNAP_BITS_MAX 24

#define COMPRESSION_LEVEL 3

/* ---- zstd in the memory of a tree ---- */

static void *zstd_allocate(void *memory, size_t bytes)
{
    return svo_i_alloc(memory, bytes);
}

static void zstd_release(void *memory, void *block)
{
    (void)memory;
    svo_i_free(block);
}

/* For ZSTD_createCCtx_advanced and ZSTD_createDCtx_advanced. memory: to outlive the context. */
static ZSTD_customMem zstd_memory(const svo_i_memory *memory)
{
    return (ZSTD_customMem){zstd_allocate, zstd_release, (void *)(uintptr_t)memory};
}

/* ---- reading ---- */

svo_status svo_i_file_damaged(const svo_i_file_load *state, const char *format, ...)
{
    svo_message detail;
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(&detail, SVO_FILE_DAMAGED, format, arguments);
    va_end(arguments);
    return svo_i_fail(state->source.message, SVO_FILE_DAMAGED, "%s: %s", state->source.name, detail.text);
}

/* Checks that this is a complete file of a known version. */
static svo_status read_identity(svo_i_file_load *state, const svo_i_file_kind *kind)
{
    file_header *header = &state->head.header;
    const size_t there_bytes =
        state->source.byte_count < sizeof *header ? (size_t)state->source.byte_count : sizeof *header;
    SVO_I_TRY(svo_i_source_read(&state->source, 0, header, there_bytes));
    const size_t magic_bytes = there_bytes < FILE_MAGIC_BYTES ? there_bytes : FILE_MAGIC_BYTES;
    if (magic_bytes == 0 || memcmp(header->magic, kind->magic, magic_bytes) != 0) {
        return svo_i_file_damaged(state, "not a %s file", kind->name);
    }
    if (there_bytes < sizeof *header) {
        return svo_i_file_damaged(state, "truncated: %zu bytes expected at least, %" PRIu64 " there", sizeof *header,
                                  state->source.byte_count);
    }
    if (header->version < kind->oldest_version || header->version > kind->version) {
        return svo_i_file_damaged(state, "version %" PRIu32 " is not known, only %" PRIu32 " to %" PRIu32,
                                  header->version, kind->oldest_version, kind->version);
    }
    if (header->file_bytes > state->source.byte_count) {
        return svo_i_file_damaged(state, "truncated: %" PRIu64 " bytes expected, %" PRIu64 " there", header->file_bytes,
                                  state->source.byte_count);
    }
    if (header->file_bytes < state->source.byte_count) {
        return svo_i_file_damaged(state, "%" PRIu64 " bytes expected, %" PRIu64 " there", header->file_bytes,
                                  state->source.byte_count);
    }
    return SVO_OK;
}

static svo_status read_chunk_table(svo_i_file_load *state, const svo_i_file_kind *kind)
{
    file_header *header = &state->head.header;
    if (header->chunk_count > kind->chunks_max) {
        return svo_i_file_damaged(state, "header: %" PRIu32 " chunks, at most %" PRIu32 " are known",
                                  header->chunk_count, kind->chunks_max);
    }
    const size_t table_bytes = header->chunk_count * sizeof(file_chunk);
    const size_t head_bytes = sizeof *header + table_bytes;
    if (header->header_bytes != head_bytes || head_bytes > state->source.byte_count) {
        return svo_i_file_damaged(state, "header: its length is %" PRIu32 ", %zu expected", header->header_bytes,
                                  head_bytes);
    }
    SVO_I_TRY(svo_i_source_read(&state->source, sizeof *header, state->head.chunks, table_bytes));
    const uint64_t hash = XXH3_64bits((const uint8_t *)&state->head + FILE_HASH_BEGIN, head_bytes - FILE_HASH_BEGIN);
    if (hash != header->header_hash) {
        return svo_i_file_damaged(state, "header: checksum is %016" PRIx64 ", file says %016" PRIx64, hash,
                                  header->header_hash);
    }
    return SVO_OK;
}

static svo_status check_values(const svo_i_file_load *state)
{
    const file_header *header = &state->head.header;
    if (header->depth < SVO_DEPTH_MIN || header->depth > SVO_DEPTH_MAX) {
        return svo_i_file_damaged(state, "header: depth %" PRIu32 " is outside %d .. %d", header->depth, SVO_DEPTH_MIN,
                                  SVO_DEPTH_MAX);
    }
    if (header->snap_bits < SNAP_BITS_MIN || header->snap_bits > SNAP_BITS_MAX) {
        return svo_i_file_damaged(state, "header: snap_bits %" PRIu32 " is outside %d .. %d", header->snap_bits,
                                  SNAP_BITS_MIN, SNAP_BITS_MAX);
    }
    if (header->coverage > SVO_COVERAGE_THIN) {
        return svo_i_file_damaged(state, "header: coverage %" PRIu32 " is not known", header->coverage);
    }
    if ((header->need & ~(uint32_t)SVO_NEED_ALL) != 0) {
        return svo_i_file_damaged(state, "header: need 0x%" PRIx16 " has unknown bits", header->need);
    }
    const uint32_t can_be_constant = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL;
    if ((header->constant & ~(header->need & can_be_constant)) != 0) {
        return svo_i_file_damaged(
            state, "header: constant 0x%" PRIx16 " has bits that need 0x%" PRIx16 " has not, or unknown ones",
            header->constant, header->need);
    }
    if (header->weights > SVO_WEIGHTS_CENTER) {
        return svo_i_file_damaged(state, "header: weights %" PRIu16 " are not known", header->weights);
    }
    if (header->payload_level > header->depth) {
        return svo_i_file_damaged(state, "header: payload_level %" PRIu16 " is above depth %" PRIu32,
                                  header->payload_level, header->depth);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (!isfinite(header->origin[axis])) {
            return svo_i_file_damaged(state, "header: origin is not finite");
        }
    }
    if (!isfinite(header->edge) || !isfinite(header->scale) || header->edge <= 0 || header->scale <= 0) {
        return svo_i_file_damaged(state, "header: edge %g or scale %g is not above 0", header->edge, header->scale);
    }
    if (header->refused_triangles > header->triangles || header->triangles > UINT32_MAX) {
        return svo_i_file_damaged(state, "header: %" PRIu64 " of %" PRIu64 " triangles refused",
                                  header->refused_triangles, header->triangles);
    }
    return SVO_OK;
}

static svo_status check_levels(const svo_i_file_load *state)
{
    const file_header *header = &state->head.header;
    const uint32_t *level_begin = header->level_begin;
    if (level_begin[0] != 0 || level_begin[1] != 1) {
        return svo_i_file_damaged(state, "header: level 0 is %" PRIu32 " .. %" PRIu32 ", not the root alone",
                                  level_begin[0], level_begin[1]);
    }
    for (uint32_t level = 1; level <= header->depth; ++level) {
        const uint64_t parents = level_begin[level] - level_begin[level - 1];
        if (level_begin[level + 1] < level_begin[level] || level_begin[level + 1] - level_begin[level] > 8 * parents) {
            return svo_i_file_damaged(state,
                                      "header: level %" PRIu32 " is %" PRIu32 " .. %" PRIu32 " below %" PRIu64 " nodes",
                                      level, level_begin[level], level_begin[level + 1], parents);
        }
    }
    for (uint32_t i = header->depth + 2; i < SVO_LEVELS_MAX; ++i) {
        if (level_begin[i] != 0) {
            return svo_i_file_damaged(state, "header: level_begin[%" PRIu32 "] is not 0", i);
        }
    }
    return SVO_OK;
}

svo_status svo_i_file_read_head(svo_i_file_load *state, const svo_i_file_kind *kind)
{
    SVO_I_TRY(read_identity(state, kind));
    SVO_I_TRY(read_chunk_table(state, kind));
    SVO_I_TRY(check_values(state));
    return check_levels(state);
}

svo_status svo_i_file_check_place(const svo_i_file_load *state, const file_chunk *chunk, const char *array,
                                  uint64_t offset)
{
    if (chunk->codec != FILE_CODEC_STORED && chunk->codec != FILE_CODEC_ZSTD) {
        return svo_i_file_damaged(state, "chunk %s: codec %" PRIu32 " is not known", array, chunk->codec);
    }
    if (chunk->offset != offset || chunk->stored_bytes > state->source.byte_count - offset) {
        return svo_i_file_damaged(
            state, "chunk %s: %" PRIu64 " bytes at %" PRIu64 ", %" PRIu64 " bytes at %" PRIu64 " are free", array,
            chunk->stored_bytes, chunk->offset, state->source.byte_count - offset, offset);
    }
    const uint64_t plain_bytes_max =
        chunk->codec == FILE_CODEC_STORED
            ? chunk->stored_bytes
            : (chunk->stored_bytes / ZSTD_BLOCK_STORED_BYTES_MIN + 1) * ZSTD_BLOCK_PLAIN_BYTES_MAX;
    if (chunk->plain_bytes > plain_bytes_max ||
        (chunk->codec == FILE_CODEC_STORED && chunk->plain_bytes != plain_bytes_max)) {
        return svo_i_file_damaged(state, "chunk %s: %" PRIu64 " bytes in the file cannot hold %" PRIu64, array,
                                  chunk->stored_bytes, chunk->plain_bytes);
    }
    return SVO_OK;
}

svo_status svo_i_file_limit(const svo_i_file_load *state, uint64_t voxel_count, uint64_t byte_count)
{
    const uint64_t there_bytes = svo_i_host_memory_bytes();
    if (state->voxels_max != 0 && voxel_count > state->voxels_max) {
        return svo_i_fail(state->source.message, SVO_INVALID_ARGUMENT,
                          "%s: %" PRIu64 " voxels are above the limit of %" PRIu64 " (voxels_max)", state->source.name,
                          voxel_count, state->voxels_max);
    }
    return state->voxels_max != 0 || byte_count <= there_bytes / 2
               ? SVO_OK
               : svo_i_fail(
                     state->source.message, SVO_OUT_OF_HOST_MEMORY,
                     "%s: %" PRIu64 " voxels need %s of memory, above half of the %s that are there (voxels_max)",
                     state->source.name, voxel_count, svo_i_bytes(byte_count).text, svo_i_bytes(there_bytes).text);
}

svo_status svo_i_file_no_memory(const svo_i_file_load *state, const char *array, uint64_t byte_count)
{
    return svo_i_fail(state->source.message, SVO_OUT_OF_HOST_MEMORY, "%s: chunk %s needs %s of memory",
                      state->source.name, array, svo_i_bytes(byte_count).text);
}

static svo_status unpack_chunk(const svo_i_file_load *state, const file_chunk *chunk, const char *array, void *plain)
{
    const size_t stored_bytes = (size_t)chunk->stored_bytes;
    svo_status status = SVO_OK;
    size_t got = 0;
    ZSTD_DCtx *context = NULL;
    void *packed = svo_i_alloc(&state->host_memory, stored_bytes > 0 ? stored_bytes : 1);
    if (packed == NULL) {
        return svo_i_file_no_memory(state, array, chunk->stored_bytes);
    }
    context = ZSTD_createDCtx_advanced(zstd_memory(&state->host_memory));
    if (context == NULL) {
        status = svo_i_file_no_memory(state, array, chunk->plain_bytes);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(svo_i_source_read(&state->source, chunk->offset, packed, stored_bytes));
    got = ZSTD_decompressDCtx(context, plain, (size_t)chunk->plain_bytes, packed, stored_bytes);
    if (ZSTD_isError(got)) {
        status = svo_i_file_damaged(state, "chunk %s: zstd: %s", array, ZSTD_getErrorName(got));
    } else if (got != chunk->plain_bytes) {
        status = svo_i_file_damaged(state, "chunk %s: %zu bytes unpacked, %" PRIu64 " expected", array, got,
                                    chunk->plain_bytes);
    }
cleanup:
    (void)ZSTD_freeDCtx(context);
    svo_i_free(packed);
    return status;
}

svo_status svo_i_file_read_chunk(const svo_i_file_load *state, const file_chunk *chunk, const char *array, void *plain)
{
    if (chunk->plain_bytes > SIZE_MAX || chunk->stored_bytes > SIZE_MAX) {
        return svo_i_file_no_memory(state, array, chunk->plain_bytes);
    }
    const size_t plain_bytes = (size_t)chunk->plain_bytes;
    if (plain_bytes > 0) {
        SVO_I_TRY(chunk->codec == FILE_CODEC_ZSTD
                      ? unpack_chunk(state, chunk, array, plain)
                      : svo_i_source_read(&state->source, chunk->offset, plain, plain_bytes));
    }
    const uint64_t hash = XXH3_64bits(plain_bytes > 0 ? plain : "", plain_bytes);
    return hash == chunk->hash
               ? SVO_OK
               : svo_i_file_damaged(state, "chunk %s: checksum is %016" PRIx64 ", file says %016" PRIx64, array, hash,
                                    chunk->hash);
}

svo_status svo_i_file_check_end(const svo_i_file_load *state, uint32_t chunk_index, uint64_t offset)
{
    if (chunk_index != state->head.header.chunk_count) {
        return svo_i_file_damaged(state, "chunk %" PRIu32 ": kind 0x%" PRIx32 " is not expected", chunk_index,
                                  state->head.chunks[chunk_index].kind);
    }
    if (offset != state->source.byte_count) {
        return svo_i_file_damaged(state, "the chunks end at byte %" PRIu64 ", the file at %" PRIu64, offset,
                                  state->source.byte_count);
    }
    return SVO_OK;
}

svo_status svo_i_file_load_open(const char *function, svo_source source, const svo_load_options *options,
                                svo_message *message, svo_i_file_load *state)
{
    svo_load_options asked;
    SVO_I_TRY(
        svo_i_struct_read(message, function, "options", options, &asked, SVO_I_STRUCT_SIZES(svo_load_options, memory)));
    SVO_I_TRY(svo_i_memory_read(message, function, "options.memory", asked.memory, &state->host_memory));
    state->voxels_max = asked.voxels_max;
    state->last_level = asked.last_level;
    return svo_i_source_open(function, source, message, &state->source);
}

/* ---- writing ---- */

/* ZSTD_compress in the tree's memory. */
static size_t compress_array(const svo_i_file_save *state, void *to, size_t to_bytes, const void *plain,
                             size_t plain_bytes)
{
    ZSTD_CCtx *context = ZSTD_createCCtx_advanced(zstd_memory(state->memory));
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
        return svo_i_fail(state->sink.message, SVO_OUT_OF_HOST_MEMORY, "%s: compressing needs %zu bytes",
                          state->sink.name, bound_bytes);
    }
    const size_t byte_count = compress_array(state, bytes, bound_bytes, plain, plain_bytes);
    if (ZSTD_isError(byte_count)) {
        svo_i_free(bytes);
        return svo_i_fail(state->sink.message, SVO_OUT_OF_HOST_MEMORY, "%s: zstd: %s", state->sink.name,
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
        return svo_i_fail(state->sink.message, SVO_INVALID_ARGUMENT, "%s: the tree's array %s is missing",
                          state->sink.name, array->name);
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

static svo_status put(svo_i_file_save *state, uint64_t offset, const void *bytes, size_t byte_count)
{
    if (byte_count > 0 && !svo_i_sink_write(&state->sink, bytes, byte_count)) {
        return svo_i_fail(state->sink.message, SVO_FILE_ERROR, "%s: %zu bytes at %" PRIu64 " could not be written",
                          state->sink.name, byte_count, offset);
    }
    return SVO_OK;
}

static svo_status write_all(svo_i_file_save *state)
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

svo_status svo_i_file_write(svo_i_file_save *state, const char *function, svo_sink sink, svo_message *message)
{
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_sink_open(function, sink, message, &state->sink));
    SVO_I_TRY_CLEANUP(measure(state));
    SVO_I_TRY_CLEANUP(write_all(state));
cleanup:
    for (size_t i = 0; i < FILE_CHUNKS_MAX; ++i) {
        svo_i_free(state->packed[i]);
    }
    return svo_i_sink_close(&state->sink, status);
}
