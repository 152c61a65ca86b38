/* SPDX-License-Identifier: MIT */
/* Reads part files: the head is checked as a whole when a file is opened, a segment when it is read. */
#define _POSIX_C_SOURCE 200809L
#include "parts/part_read.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/struct_size.h"
#include "io/file_format.h"
#include "svocl/parts.h"

/* Of a segment that is read at a time: each piece costs two calls of the system where parts are stitched. */
#define PIECE_BYTES 65536

svo_status svo_i_part_damaged(const svo_i_part_reader *reader, const char *why)
{
    return svo_i_fail(reader->message, SVO_FILE_DAMAGED, "%s: %s", reader->path, why);
}

static svo_status read_at(const svo_i_part_reader *reader, uint64_t offset, void *out, size_t byte_count)
{
    size_t got = 0;
    const int error = svo_i_read_at(reader->file, offset, out, byte_count, &got);
    if (error != 0) {
        return svo_i_fail(reader->message, SVO_FILE_ERROR, "%s: cannot be read: %s", reader->path, strerror(error));
    }
    return got == byte_count ? SVO_OK : svo_i_part_damaged(reader, "truncated");
}

static svo_status check_head(const svo_i_part_reader *reader, uint64_t file_bytes)
{
    const part_head *head = &reader->content.head;
    if (memcmp(head->magic, PART_MAGIC, PART_MAGIC_BYTES) != 0) {
        return svo_i_part_damaged(reader, "not a part file");
    }
    if (head->version != PART_VERSION || head->segment_count > PART_SEGMENTS_MAX) {
        return svo_i_part_damaged(reader, "its version or its number of segments is not known");
    }
    if (head->file_bytes != file_bytes) {
        return svo_i_fail(reader->message, SVO_FILE_DAMAGED, "%s: %" PRIu64 " bytes expected, %" PRIu64 " there",
                          reader->path, head->file_bytes, file_bytes);
    }
    return SVO_OK;
}

/* The segments follow one another up to the end of the file. */
static svo_status check_table(const svo_i_part_reader *reader)
{
    const part_head *head = &reader->content.head;
    uint64_t offset = sizeof *head + head->segment_count * sizeof(part_segment);
    for (uint32_t i = 0; i < head->segment_count; ++i) {
        const part_segment *segment = &reader->content.segments[i];
        if (segment->offset != offset || segment->bytes > head->file_bytes - offset) {
            return svo_i_part_damaged(reader, "its segments do not follow one another");
        }
        offset += segment->bytes;
    }
    return offset == head->file_bytes ? SVO_OK : svo_i_part_damaged(reader, "its segments do not fill it");
}

/* Whether the levels are those of a part at its place: each at least as large as the one above, as a node has a child.
   A part without nodes is all zero. */
static bool has_levels(const part_head *head, uint32_t depth)
{
    const uint32_t *begin = head->level_begin;
    bool valid = begin[0] == 0 && (begin[1] == 1 || begin[depth + 1] == 0);
    for (uint32_t level = 0; level < depth && valid; ++level) {
        const uint64_t above = (uint64_t)begin[level + 1] - begin[level];
        const uint64_t nodes = (uint64_t)begin[level + 2] - begin[level + 1];
        valid = begin[level + 2] >= begin[level + 1] && nodes >= above && nodes <= 8 * above;
    }
    return valid;
}

static svo_status check_place(const svo_i_part_reader *reader, const svo_part_header *header, bool is_mesh)
{
    const part_head *head = &reader->content.head;
    if (head->whole != svo_i_part_header_hash(header)) {
        return svo_i_part_damaged(reader, "a part of another tree");
    }
    if (is_mesh || head->is_mesh != 0) {
        return is_mesh && head->is_mesh == 1 ? SVO_OK
                                             : svo_i_part_damaged(reader, is_mesh ? "not a mesh" : "not a part");
    }
    if (head->level >= header->depth || head->code >> (3 * head->level) != 0 ||
        !has_levels(head, header->depth - head->level)) {
        return svo_i_part_damaged(reader, "its place or its levels are none of the tree's");
    }
    return SVO_OK;
}

static svo_status read_head(svo_i_part_reader *reader, const svo_part_header *header, bool is_mesh)
{
    struct stat found;
    part_head *head = &reader->content.head;
    if (fstat(reader->file, &found) != 0) {
        return svo_i_fail(reader->message, SVO_FILE_ERROR, "%s: cannot be read: %s", reader->path, strerror(errno));
    }
    if (!S_ISREG(found.st_mode)) {
        return svo_i_fail(reader->message, SVO_FILE_ERROR, "%s: not a file", reader->path);
    }
    SVO_I_TRY(read_at(reader, 0, head, sizeof *head));
    SVO_I_TRY(check_head(reader, (uint64_t)found.st_size));
    SVO_I_TRY(read_at(reader, sizeof *head, reader->content.segments, head->segment_count * sizeof(part_segment)));
    const size_t head_bytes = sizeof *head + head->segment_count * sizeof(part_segment);
    if (XXH3_64bits((const char *)&reader->content + PART_HASH_BEGIN, head_bytes - PART_HASH_BEGIN) !=
        head->head_hash) {
        return svo_i_part_damaged(reader, "the checksum of its head is wrong");
    }
    SVO_I_TRY(check_table(reader));
    return check_place(reader, header, is_mesh);
}

svo_status svo_i_part_open(const svo_part_header *header, const char *path, bool is_mesh, svo_message *message,
                           svo_i_part_reader *reader)
{
    reader->path = path;
    reader->message = message;
    reader->file = open(path, O_RDONLY | O_CLOEXEC);
    return reader->file >= 0 ? read_head(reader, header, is_mesh)
                             : svo_i_fail(message, SVO_FILE_ERROR, "%s: cannot be opened: %s", path, strerror(errno));
}

void svo_i_part_close(svo_i_part_reader *reader)
{
    if (reader->file >= 0) {
        (void)close(reader->file);
        reader->file = -1;
    }
}

const part_segment *svo_i_part_find(const svo_i_part_reader *reader, uint32_t kind, uint32_t level)
{
    for (uint32_t i = 0; i < reader->content.head.segment_count; ++i) {
        const part_segment *segment = &reader->content.segments[i];
        if (segment->kind == kind && segment->level == level) {
            return segment;
        }
    }
    return NULL;
}

svo_status svo_i_part_stream(const svo_i_part_reader *reader, const part_segment *segment, svo_i_part_visitor visit,
                             void *user)
{
    unsigned char piece[PIECE_BYTES];
    XXH3_state_t state;
    XXH3_INITSTATE(&state);
    XXH3_64bits_reset(&state);
    for (uint64_t at = 0; at < segment->bytes; at += sizeof piece) {
        const size_t count = segment->bytes - at < sizeof piece ? (size_t)(segment->bytes - at) : sizeof piece;
        SVO_I_TRY(read_at(reader, segment->offset + at, piece, count));
        XXH3_64bits_update(&state, piece, count);
        if (visit != NULL) {
            SVO_I_TRY(visit(user, piece, count));
        }
    }
    return XXH3_64bits_digest(&state) == segment->hash
               ? SVO_OK
               : svo_i_part_damaged(reader, "the checksum of a segment is wrong");
}

svo_status svo_i_part_header_read(const char *function, const svo_part_header *given, svo_message *message,
                                  svo_part_header *header)
{
    if (given == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: header is NULL", function);
    }
    SVO_I_TRY(svo_i_struct_read(message, function, "header", given, header,
                                SVO_I_STRUCT_SIZES(svo_part_header, expected_nodes)));
    return header->depth >= SVO_DEPTH_MIN && header->depth <= SVO_DEPTH_MAX && header->payload_level <= header->depth
               ? SVO_OK
               : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: header.depth %u is not in %d .. %d", function,
                            header->depth, SVO_DEPTH_MIN, SVO_DEPTH_MAX);
}

static svo_part_info info_of(const svo_part_header *header, const part_head *head)
{
    const uint32_t depth = header->depth - head->level;
    return (svo_part_info){.level = head->level,
                           .code = head->code,
                           .node_count = head->level_begin[depth + 1],
                           .leaf_count = head->level_begin[depth + 1] - head->level_begin[depth],
                           .fragments = head->fragments,
                           .file_bytes = head->file_bytes};
}

svo_status svo_i_part_check(const svo_part_header *header, const char *path, bool reads_all, svo_part_info *info,
                            svo_message *message)
{
    svo_i_part_reader reader = {.file = -1};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_part_open(header, path, false, message, &reader));
    for (uint32_t i = 0; reads_all && i < reader.content.head.segment_count; ++i) {
        SVO_I_TRY_CLEANUP(svo_i_part_stream(&reader, &reader.content.segments[i], NULL, NULL));
    }
    *info = info_of(header, &reader.content.head);
cleanup:
    svo_i_part_close(&reader);
    return status;
}

svo_status svo_part_check(const svo_part_header *header, const char *path, svo_part_info *info, svo_message *message)
{
    static const char function[] = "svo_part_check";
    svo_part_header whole = SVO_PART_HEADER_INIT;
    svo_part_info found;
    if (path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: path is NULL", function);
    }
    SVO_I_TRY(svo_i_part_header_read(function, header, message, &whole));
    SVO_I_TRY(svo_i_part_check(&whole, path, true, &found, message));
    return info == NULL ? SVO_OK
                        : svo_i_struct_write(message, function, "info", &found, info,
                                             SVO_I_STRUCT_SIZES(svo_part_info, file_bytes));
}
