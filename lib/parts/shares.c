/* SPDX-License-Identifier: MIT */
/*
 * Stitching by any number of processes. In the place of the plan lie
 *
 *   stitch-COUNT    who writes what (layout.h), with a token
 *   TOKEN.stitch    the file, which has no head until the end
 *   TOKEN-K.share   that share K is written, and the checksums that it found
 *
 * What is written follows from the plan alone, so a share that is written twice, or by a process that was given up and
 * goes on, gets the same bytes. A token belongs to one file: a share that was written to a file that has its name by
 * then does not count for the next one. Checksums are of the parts' bytes, each compared with the checksums of its part
 * again, so that a byte of the file that was not written as it should be shows when the file is read.
 */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/memory.h"
#include "output/output.h"
#include "parts/job.h"
#include "parts/layout.h"
#include "svocl/parts.h"

#define SHARES_MAX      65536u
#define RECEIPT_MAGIC   "\x89SVW\r\n\x1a\n"
#define RECEIPT_VERSION 1u
#define NAME_BYTES      (OWNER_BYTES + 32)
#define TRIES           1000

/* That a share is written. hash: of all bytes after itself. */
typedef struct receipt_chunk {
    uint64_t hash;
    uint32_t chunk;
    uint32_t reserved; /* 0 */
} receipt_chunk;

typedef struct receipt {
    uint8_t magic[8];
    uint64_t hash;
    uint32_t version, share;
    uint32_t chunk_count;
    uint32_t reserved; /* 0 */
    receipt_chunk chunks[FILE_CHUNKS_MAX];
} receipt;

static_assert(offsetof(receipt, chunks) == 32 && sizeof(receipt_chunk) == 16, "no padding");

/* What the three steps work with. */
typedef struct sharing {
    const svo_parts *parts;
    svo_message *message;
    svo_i_stitcher s;
    svo_i_layout layout;
    svo_i_part_files files;
    char *path; /* of the file that is written */
} sharing;

static svo_status open_sharing(const char *function, const svo_parts *parts, unsigned count, svo_message *message,
                               sharing *h)
{
    if (parts == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: parts is NULL", function);
    }
    if (count < 1 || count > SHARES_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: count %u is not in 1 .. %u", function, count, SHARES_MAX);
    }
    *h = (sharing){.parts = parts, .message = message, .layout = {.share_count = count}};
    h->s.message = message;
    h->s.path = parts->folder;
    h->s.all.message = message;
    h->s.all.header = parts->header;
    h->s.output.descriptor = -1;
    return svo_i_folder_is_current(parts, message);
}

/* Releases all, and tells whether the failure came of a new plan. */
static svo_status close_sharing(sharing *h, svo_status status)
{
    if (h->s.output.descriptor >= 0) {
        (void)close(h->s.output.descriptor);
    }
    svo_i_chunks_free(&h->s);
    svo_i_layout_free(&h->layout);
    svo_i_part_files_free(&h->files);
    svo_i_free(h->path);
    return svo_i_parts_tell_cause(h->parts, status, h->message);
}

static svo_status fail_errno(const sharing *h, const char *path, int error)
{
    return svo_i_fail(h->message, svo_i_file_status(error), "%s: cannot be written: %s", path, strerror(error));
}

static char *path_of_file(const sharing *h)
{
    char name[NAME_BYTES];
    (void)snprintf(name, sizeof name, "%.160s.stitch", h->layout.token);
    return svo_i_folder_path(h->parts, name);
}

static char *path_of_share(const sharing *h, uint32_t share)
{
    char name[NAME_BYTES];
    (void)snprintf(name, sizeof name, "%.160s-%" PRIu32 ".share", h->layout.token, share);
    return svo_i_folder_path(h->parts, name);
}

/* ---- beginning ---- */

/* Whether the file of the layout's token is there, with its length. */
static bool has_file(sharing *h)
{
    struct stat found;
    svo_i_free(h->path);
    h->path = path_of_file(h);
    return h->path != NULL && stat(h->path, &found) == 0 && (uint64_t)found.st_size == h->s.head.header.file_bytes;
}

/* Makes the file with a new token. Its bytes are holes until they are written. */
static svo_status make_file(sharing *h)
{
    int file = -1;
    int error = EEXIST;
    for (int i = 0; file < 0 && error == EEXIST && i < TRIES; ++i) {
        svo_i_owner_name(h->layout.token);
        svo_i_free(h->path);
        h->path = path_of_file(h);
        if (h->path == NULL) {
            return svo_i_folder_no_memory(h->parts, h->message);
        }
        file = open(h->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        error = file < 0 ? errno : 0;
    }
    if (file >= 0) {
        error = ftruncate(file, (off_t)h->s.head.header.file_bytes) != 0 ? errno : 0;
        error = close(file) != 0 && error == 0 ? errno : error;
    }
    if (error != 0 && file >= 0) {
        (void)unlink(h->path);
    }
    return error == 0 ? SVO_OK : fail_errno(h, h->path, error);
}

/* Removes what is left of a token. Failures are not told: it is removed with the folder. */
static void remove_shares(const sharing *h)
{
    for (uint32_t i = 0; i < h->layout.share_count; ++i) {
        char *path = path_of_share(h, i);
        if (path != NULL) {
            (void)unlink(path);
        }
        svo_i_free(path);
    }
}

/* Removes what an earlier beginning of as many shares has left that is of other parts, or has got its name. */
static void remove_older(const sharing *h)
{
    svo_message ignored;
    sharing old = {.parts = h->parts, .message = &ignored, .layout = {.share_count = h->layout.share_count}};
    old.s.message = &ignored;
    old.s.path = h->parts->folder;
    old.s.all.message = &ignored;
    old.s.all.header = h->parts->header;
    if (svo_i_layout_load(h->parts, &old.s, &old.layout) == SVO_OK) {
        char *path = path_of_file(&old);
        if (path != NULL) {
            (void)unlink(path);
        }
        svo_i_free(path);
        remove_shares(&old);
    }
    svo_i_chunks_free(&old.s);
    svo_i_layout_free(&old.layout);
}

static svo_status begin(sharing *h)
{
    SVO_I_TRY(svo_i_parts_gather(h->parts, &h->files, h->message));
    h->s.mesh_path = h->files.mesh;
    SVO_I_TRY(svo_i_pieces_read(&h->s.all, (const char *const *)h->files.paths, h->files.count));
    SVO_I_TRY(svo_i_chunks_begin(&h->s));
    SVO_I_TRY(svo_i_layout_make(&h->s, &h->layout));
    if (svo_i_layout_is_there(h->parts, &h->s, &h->layout) && has_file(h)) {
        return SVO_OK;
    }
    remove_older(h);
    SVO_I_TRY(make_file(h));
    return svo_i_layout_save(h->parts, &h->s, &h->layout);
}

svo_status svo_parts_shares_begin(const svo_parts *parts, unsigned count, svo_message *message)
{
    sharing h;
    SVO_I_TRY(open_sharing("svo_parts_shares_begin", parts, count, message, &h));
    return close_sharing(&h, begin(&h));
}

/* ---- writing ---- */

/* Whether bytes are the receipt of a share. */
static bool is_receipt(const sharing *h, uint32_t share, const receipt *found, size_t byte_count)
{
    const size_t begin = offsetof(receipt, version);
    return memcmp(found->magic, RECEIPT_MAGIC, sizeof found->magic) == 0 && found->version == RECEIPT_VERSION &&
           found->share == share && found->chunk_count <= h->s.filling_count &&
           byte_count == offsetof(receipt, chunks) + found->chunk_count * sizeof(receipt_chunk) &&
           found->hash == XXH3_64bits((const char *)found + begin, byte_count - begin);
}

/* Reads that a share is written. *is_there: whether it is. */
static svo_status read_receipt(const sharing *h, uint32_t share, receipt *out, bool *is_there)
{
    unsigned char *bytes = NULL;
    size_t byte_count = 0;
    char *path = path_of_share(h, share);
    if (path == NULL) {
        return svo_i_folder_no_memory(h->parts, h->message);
    }
    const svo_status status = svo_i_file_read_found(path, &bytes, &byte_count, h->message);
    *is_there =
        status == SVO_OK && bytes != NULL && byte_count >= offsetof(receipt, chunks) && byte_count <= sizeof *out;
    if (*is_there) {
        memcpy(out, bytes, byte_count);
        *is_there = is_receipt(h, share, out, byte_count);
    }
    svo_i_free(bytes);
    svo_i_free(path);
    return status;
}

static svo_status write_receipt(const sharing *h, uint32_t share)
{
    receipt made = {.version = RECEIPT_VERSION, .share = share};
    svo_i_output output = {.descriptor = -1};
    memcpy(made.magic, RECEIPT_MAGIC, sizeof made.magic);
    for (uint32_t i = 0; i < h->s.filling_count; ++i) {
        if (h->layout.owners[i] == share) {
            made.chunks[made.chunk_count++] = (receipt_chunk){.hash = h->s.head.chunks[i].hash, .chunk = i};
        }
    }
    const size_t begin = offsetof(receipt, version);
    const size_t byte_count = offsetof(receipt, chunks) + made.chunk_count * sizeof(receipt_chunk);
    made.hash = XXH3_64bits((const char *)&made + begin, byte_count - begin);
    char *path = path_of_share(h, share);
    if (path == NULL) {
        return svo_i_folder_no_memory(h->parts, h->message);
    }
    int error = svo_i_output_open(path, NULL, &output);
    if (error == 0) {
        error = svo_i_output_write(&output, &made, byte_count);
    }
    if (error == 0) {
        error = svo_i_output_commit_unflushed(&output);
    }
    svo_i_output_abandon(&output);
    const svo_status status = error == 0 ? SVO_OK : fail_errno(h, path, error);
    svo_i_free(path);
    return status;
}

static svo_status fail_finished(const sharing *h)
{
    return svo_i_fail(h->message, SVO_UNAVAILABLE,
                      "%s: its %" PRIu32 " shares were finished meanwhile; begin them again", h->parts->folder,
                      h->layout.share_count);
}

/* Opens the file for writing. It is never made here: one that is gone has got its name. */
static svo_status open_file(sharing *h)
{
    struct stat found;
    h->path = path_of_file(h);
    if (h->path == NULL) {
        return svo_i_folder_no_memory(h->parts, h->message);
    }
    h->s.path = h->path;
    h->s.output.descriptor = open(h->path, O_WRONLY | O_CLOEXEC);
    const int error = h->s.output.descriptor < 0 || fstat(h->s.output.descriptor, &found) != 0 ? errno : 0;
    if (error != 0 && error != ENOENT) {
        return fail_errno(h, h->path, error);
    }
    return error == 0 && (uint64_t)found.st_size == h->s.head.header.file_bytes ? SVO_OK : fail_finished(h);
}

static svo_status load(sharing *h)
{
    SVO_I_TRY(svo_i_layout_load(h->parts, &h->s, &h->layout));
    if ((h->parts->header.need & SVO_NEED_RAYS) != 0) {
        h->files.mesh = svo_i_folder_path(h->parts, "mesh");
        h->s.mesh_path = h->files.mesh;
        return h->files.mesh != NULL ? SVO_OK : svo_i_folder_no_memory(h->parts, h->message);
    }
    return SVO_OK;
}

/* Copies the parts of a share. */
static svo_status copy_parts(sharing *h, uint32_t share)
{
    size_t first = 0;
    while (first < h->s.all.piece_count && h->layout.shares[first] < share) {
        ++first;
    }
    size_t end = first;
    while (end < h->s.all.piece_count && h->layout.shares[end] == share) {
        ++end;
    }
    h->s.first = first;
    h->s.end = h->s.all.piece_count == 0 && share == 0 ? 1 : end; /* the root of a tree without parts */
    h->s.writes = true;
    h->s.hashes = false;
    return svo_i_chunks_put_parts(&h->s);
}

/* Finds the checksums of a share's chunks, and writes what no part has. */
static svo_status sum_chunks(sharing *h, uint32_t share)
{
    bool any = false;
    bool any_of_parts = false;
    svo_i_chunks_restart(&h->s);
    for (uint32_t i = 0; i < h->s.filling_count; ++i) {
        svo_i_filling *to = &h->s.fillings[i];
        to->is_left_out = h->layout.owners[i] != share;
        any = any || !to->is_left_out;
        any_of_parts = any_of_parts || (!to->is_left_out && svo_i_chunks_are_of_parts(&h->s, to->entry.buffer));
    }
    h->s.first = 0;
    h->s.end = SIZE_MAX;
    h->s.writes = false;
    h->s.hashes = true;
    if (any_of_parts) {
        SVO_I_TRY(svo_i_chunks_put_parts(&h->s));
    }
    h->s.writes = true;
    return any ? svo_i_chunks_finish(&h->s) : SVO_OK;
}

/* What is written counts when it is on the disk: another machine may read it, and this one may fail. */
static svo_status flush(sharing *h)
{
    const int file = h->s.output.descriptor;
    h->s.output.descriptor = -1;
    int error = fsync(file) != 0 ? errno : 0;
    error = close(file) != 0 && error == 0 ? errno : error;
    return error == 0 ? SVO_OK : fail_errno(h, h->path, error);
}

static svo_status write_share(sharing *h, uint32_t share)
{
    receipt ignored;
    bool is_written = false;
    SVO_I_TRY(load(h));
    SVO_I_TRY(open_file(h));
    SVO_I_TRY(read_receipt(h, share, &ignored, &is_written));
    if (is_written) {
        return SVO_OK;
    }
    SVO_I_TRY(copy_parts(h, share));
    SVO_I_TRY(sum_chunks(h, share));
    SVO_I_TRY(flush(h));
    return write_receipt(h, share);
}

svo_status svo_parts_shares_write(const svo_parts *parts, unsigned index, unsigned count, svo_message *message)
{
    static const char function[] = "svo_parts_shares_write";
    sharing h;
    if (index >= count) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: index %u is not below %u", function, index, count);
    }
    SVO_I_TRY(open_sharing(function, parts, count, message, &h));
    return close_sharing(&h, write_share(&h, index));
}

/* ---- the end ---- */

/* Takes the checksums of all shares. */
static svo_status take_receipts(sharing *h)
{
    uint32_t taken = 0;
    for (uint32_t share = 0; share < h->layout.share_count; ++share) {
        receipt found = {.chunk_count = 0};
        bool is_written = false;
        SVO_I_TRY(read_receipt(h, share, &found, &is_written));
        if (!is_written) {
            return svo_i_fail(h->message, SVO_UNAVAILABLE, "%s: share %" PRIu32 " of %" PRIu32 " is not written",
                              h->parts->folder, share, h->layout.share_count);
        }
        for (uint32_t i = 0; i < found.chunk_count; ++i) {
            const uint32_t index = found.chunks[i].chunk;
            if (index < h->s.filling_count && h->layout.owners[index] == share) {
                file_chunk *chunk = &h->s.head.chunks[index];
                chunk->plain_bytes = chunk->stored_bytes;
                chunk->hash = found.chunks[i].hash;
                ++taken;
            }
        }
    }
    return taken == h->s.filling_count
               ? SVO_OK
               : svo_i_fail(h->message, SVO_FILE_DAMAGED, "%s: its shares have %" PRIu32 " of %" PRIu32 " checksums",
                            h->parts->folder, taken, h->s.filling_count);
}

static svo_status give_name(sharing *h, const char *path)
{
    SVO_I_TRY(svo_i_folder_is_current(h->parts, h->message));
    const int error = svo_i_output_take(h->path, path);
    if (error == EINVAL) {
        return svo_i_fail(h->message, SVO_INVALID_ARGUMENT, "svo_parts_shares_finish: %s is no file", path);
    }
    if (error == EXDEV) {
        return svo_i_fail(h->message, SVO_FILE_ERROR,
                          "%s: not on the file system of the parts; svo_parts_finish writes it", path);
    }
    if (error == ENOENT && access(h->path, F_OK) != 0) {
        return fail_finished(h);
    }
    return error == 0 ? SVO_OK : fail_errno(h, path, error);
}

static svo_status finish(sharing *h, const char *path)
{
    SVO_I_TRY(load(h));
    SVO_I_TRY(open_file(h));
    SVO_I_TRY(take_receipts(h));
    SVO_I_TRY(svo_i_chunks_put_head(&h->s));
    SVO_I_TRY(flush(h));
    SVO_I_TRY(give_name(h, path));
    remove_shares(h);
    char *layout = svo_i_layout_path(h->parts, h->layout.share_count);
    if (layout != NULL) {
        (void)unlink(layout);
    }
    svo_i_free(layout);
    return SVO_OK;
}

svo_status svo_parts_shares_finish(const svo_parts *parts, unsigned count, const char *path, svo_message *message)
{
    static const char function[] = "svo_parts_shares_finish";
    sharing h;
    if (path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: path is NULL", function);
    }
    SVO_I_TRY(open_sharing(function, parts, count, message, &h));
    return close_sharing(&h, finish(&h, path));
}
