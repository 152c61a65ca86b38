/* SPDX-License-Identifier: MIT */
/*
 * Trees to .svo files. Chunks are written to a temporary file beside the target; the header follows when their lengths
 * and checksums are known. A complete and flushed file is then renamed to the target.
 */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>
#include <zstd.h>

#include "core/message.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "io/file_format.h"

#define COMPRESSION_LEVEL 3
#define NAME_ATTEMPTS     1000

typedef struct save_state {
    const svo_tree *tree;
    const char *path;
    svo_message *message;
    int file;
    bool compress;
    file_head head;
} save_state;

static svo_status fail_errno(const save_state *state, const char *what)
{
    return svo_i_fail(state->message, SVO_FILE_ERROR, "%s: %s: %s", state->path, what, strerror(errno));
}

static svo_status write_at(const save_state *state, uint64_t offset, const void *bytes, size_t byte_count)
{
    const char *from = bytes;
    while (byte_count > 0) {
        const ssize_t written = pwrite(state->file, from, byte_count, (off_t)offset);
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written <= 0) {
            return fail_errno(state, "cannot be written");
        }
        from += written;
        offset += (uint64_t)written;
        byte_count -= (size_t)written;
    }
    return SVO_OK;
}

/* Writes an array compressed if that is smaller. *stored_bytes: its length in the file; 0: nothing was written. */
static svo_status write_compressed(const save_state *state, uint64_t offset, const void *plain, size_t plain_bytes,
                                   uint64_t *stored_bytes)
{
    *stored_bytes = 0;
    const size_t bound_bytes = ZSTD_compressBound(plain_bytes);
    void *packed = malloc(bound_bytes);
    if (packed == NULL) {
        return svo_i_fail(state->message, SVO_OUT_OF_HOST_MEMORY, "%s: compressing needs %zu bytes", state->path,
                          bound_bytes);
    }
    svo_status status = SVO_OK;
    const size_t packed_bytes = ZSTD_compress(packed, bound_bytes, plain, plain_bytes, COMPRESSION_LEVEL);
    if (ZSTD_isError(packed_bytes)) {
        status = svo_i_fail(state->message, SVO_OUT_OF_HOST_MEMORY, "%s: zstd: %s", state->path,
                            ZSTD_getErrorName(packed_bytes));
    } else if (packed_bytes < plain_bytes) {
        status = write_at(state, offset, packed, packed_bytes);
        *stored_bytes = packed_bytes;
    }
    free(packed);
    return status;
}

static svo_status write_chunk(const save_state *state, uint64_t offset, file_chunk *chunk)
{
    const svo_tree_buffer kind = (svo_tree_buffer)chunk->kind;
    const void *plain = state->tree->host[kind];
    size_t plain_bytes = 0;
    if (!svo_i_mul_size((size_t)svo_i_tree_element_count(&state->tree->info, kind), svo_i_tree_element_bytes(kind),
                        &plain_bytes) ||
        (plain_bytes > 0 && plain == NULL)) {
        return svo_i_fail(state->message, SVO_INVALID_ARGUMENT, "svo_tree_save: the tree's array %s is missing",
                          svo_tree_buffer_name(kind));
    }
    chunk->offset = offset;
    chunk->plain_bytes = plain_bytes;
    chunk->hash = XXH3_64bits(plain_bytes > 0 ? plain : "", plain_bytes);
    if (state->compress && plain_bytes > 0) {
        SVO_I_TRY(write_compressed(state, offset, plain, plain_bytes, &chunk->stored_bytes));
        if (chunk->stored_bytes > 0) {
            chunk->codec = FILE_CODEC_ZSTD;
            return SVO_OK;
        }
    }
    chunk->codec = FILE_CODEC_STORED;
    chunk->stored_bytes = plain_bytes;
    return write_at(state, offset, plain, plain_bytes);
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

static svo_status write_tree(save_state *state)
{
    file_header *header = &state->head.header;
    fill_header(header, &state->tree->info);
    uint64_t offset = header->header_bytes;
    uint32_t chunk_index = 0;
    for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        if (!svo_i_tree_holds(&state->tree->info, (svo_tree_buffer)i)) {
            continue;
        }
        file_chunk *chunk = &state->head.chunks[chunk_index++];
        chunk->kind = i;
        SVO_I_TRY(write_chunk(state, offset, chunk));
        offset += chunk->stored_bytes;
    }
    header->file_bytes = offset;
    header->header_hash =
        XXH3_64bits((const uint8_t *)&state->head + FILE_HASH_BEGIN, header->header_bytes - FILE_HASH_BEGIN);
    return write_at(state, 0, &state->head, header->header_bytes);
}

/* Opens PATH.N.tmp for the first free N; the caller frees *temporary. */
static svo_status open_temporary(save_state *state, char **temporary)
{
    const size_t name_bytes = strlen(state->path) + 64;
    char *name = malloc(name_bytes);
    if (name == NULL) {
        return svo_i_fail(state->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a file name", state->path);
    }
    errno = EEXIST;
    for (int i = 0; i < NAME_ATTEMPTS && state->file < 0 && errno == EEXIST; ++i) {
        (void)snprintf(name, name_bytes, "%s.%ld.%d.tmp", state->path, (long)getpid(), i);
        state->file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    }
    if (state->file < 0) {
        free(name);
        return fail_errno(state, "cannot be written");
    }
    *temporary = name;
    return SVO_OK;
}

/* Makes the rename durable. Failure is ignored: the file is complete and has its name, and some file systems cannot
   synchronize directories. */
static void sync_directory(const char *path)
{
    char *directory = strdup(path);
    if (directory == NULL) {
        return;
    }
    char *slash = strrchr(directory, '/');
    if (slash != NULL) {
        slash[slash == directory ? 1 : 0] = '\0';
    }
    const int descriptor = open(slash != NULL ? directory : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor >= 0) {
        (void)fsync(descriptor);
        close(descriptor);
    }
    free(directory);
}

static svo_status flush_and_close(save_state *state)
{
    svo_status status = SVO_OK;
    if (fsync(state->file) != 0) {
        status = fail_errno(state, "cannot be written");
    }
    if (close(state->file) != 0 && status == SVO_OK) {
        status = fail_errno(state, "cannot be written");
    }
    state->file = -1;
    return status;
}

static svo_status save_by_rename(save_state *state)
{
    svo_status status = SVO_OK;
    char *temporary = NULL;
    SVO_I_TRY(open_temporary(state, &temporary));
    SVO_I_TRY_CLEANUP(write_tree(state));
    SVO_I_TRY_CLEANUP(flush_and_close(state));
    if (rename(temporary, state->path) != 0) {
        status = fail_errno(state, "cannot be written");
        goto cleanup;
    }
    sync_directory(state->path);
cleanup:
    if (state->file >= 0) {
        close(state->file);
    }
    if (status != SVO_OK) {
        (void)unlink(temporary);
    }
    free(temporary);
    return status;
}

svo_status svo_tree_save(const svo_tree *tree, const char *path, const svo_save_options *options, svo_message *message)
{
    if (tree == NULL || path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_tree_save: %s is NULL", tree == NULL ? "tree" : "path");
    }
    svo_save_options asked;
    SVO_I_TRY(svo_i_struct_read(message, "svo_tree_save", "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_save_options, struct_size)));
    if (!tree->downloaded) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          "svo_tree_save: the tree has no host arrays; call svo_tree_download first");
    }
    struct stat entry;
    if (stat(path, &entry) == 0 && !S_ISREG(entry.st_mode)) {
        /* The rename would replace a device or a pipe. */
        return svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be written: not a regular file", path);
    }
    save_state state = {.tree = tree, .path = path, .message = message, .file = -1, .compress = asked.compress != 0};
    return save_by_rename(&state);
}
