/* SPDX-License-Identifier: MIT */
/*
 * Part files: the arrays of a part's tree level by level, and what rays meet of the whole mesh. When a file is opened,
 * its head is checked as a whole; a segment is checked when it is read.
 */
#define _POSIX_C_SOURCE 200809L
#include "parts/part_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/device.h"
#include "core/struct_size.h"
#include "io/file_format.h"
#include "output/output.h"
#include "plan/arrays.h"
#include "svocl/parts.h"
#include "svocl/version.h"

/* ---- identities ---- */

void svo_i_part_identity(const svo_part_header *header, uint64_t identity[2])
{
    static const char made_by[] = SVO_VERSION_STRING;
    const uint32_t version = PART_VERSION;
    XXH3_state_t state;
    XXH3_INITSTATE(&state);
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, (const char *)header + sizeof header->struct_size,
                        sizeof *header - sizeof header->struct_size);
    XXH3_128bits_update(&state, &version, sizeof version);
    XXH3_128bits_update(&state, made_by, sizeof made_by);
    const XXH128_hash_t digest = XXH3_128bits_digest(&state);
    identity[0] = digest.low64;
    identity[1] = digest.high64;
}

void svo_i_identity_write(const uint64_t identity[2], svo_i_identity_text text)
{
    (void)snprintf(text, IDENTITY_BYTES, "%016" PRIx64 "%016" PRIx64, identity[1], identity[0]);
}

svo_status svo_i_part_is_foreign(const char *path, const uint64_t found[2], const uint64_t own[2], const char *then,
                                 svo_message *message)
{
    svo_i_identity_text found_name, own_name;
    svo_i_identity_write(found, found_name);
    svo_i_identity_write(own, own_name);
    return svo_i_fail(message, SVO_FILE_DAMAGED, "%s belongs to plan %s, the folder's plan is %s%s", path, found_name,
                      own_name, then);
}

svo_status svo_i_file_status(int error)
{
    static const int passing[] = {EAGAIN,    EBUSY,       EDQUOT,       EINTR,   EIO,     EMFILE,
                                  ENETDOWN,  ENETUNREACH, ENFILE,       ENOBUFS, ENOMEM,  ENOSPC,
                                  EHOSTDOWN, ENOTCONN,    EHOSTUNREACH, ESTALE,  ETXTBSY, ETIMEDOUT};
    for (size_t i = 0; i < sizeof passing / sizeof passing[0]; ++i) {
        if (error == passing[i]) {
            return SVO_UNAVAILABLE;
        }
    }
    return SVO_FILE_ERROR;
}

/* ---- writing ---- */

/* A file that is being put together. */
typedef struct writer {
    const char *path;
    svo_message *message;
    part_file file;
    const void *bytes[PART_SEGMENTS_MAX]; /* of each segment; the caller's */
} writer;

static void add_segment(writer *w, uint32_t kind, uint32_t level, const void *bytes, uint64_t byte_count)
{
    const uint32_t index = w->file.head.segment_count++;
    w->file.segments[index] = (part_segment){.kind = kind,
                                             .level = level,
                                             .bytes = byte_count,
                                             .hash = XXH3_64bits(byte_count > 0 ? bytes : "", (size_t)byte_count)};
    w->bytes[index] = bytes;
}

/* Places the segments and completes the head. Returns the bytes of head and table. */
static size_t finish_head(writer *w)
{
    part_head *head = &w->file.head;
    const size_t head_bytes = sizeof *head + head->segment_count * sizeof(part_segment);
    uint64_t offset = head_bytes;
    for (uint32_t i = 0; i < head->segment_count; ++i) {
        w->file.segments[i].offset = offset;
        offset += w->file.segments[i].bytes;
    }
    memcpy(head->magic, PART_MAGIC, PART_MAGIC_BYTES);
    head->version = PART_VERSION;
    head->file_bytes = offset;
    head->head_hash = XXH3_64bits((const char *)&w->file + PART_HASH_BEGIN, head_bytes - PART_HASH_BEGIN);
    return head_bytes;
}

static int write_segments(const writer *w, const svo_i_output *output, size_t head_bytes)
{
    int error = svo_i_output_write(output, &w->file, head_bytes);
    for (uint32_t i = 0; i < w->file.head.segment_count && error == 0; ++i) {
        error = svo_i_output_write(output, w->bytes[i], (size_t)w->file.segments[i].bytes);
    }
    return error;
}

static svo_status write_file(writer *w)
{
    svo_i_output output = {.descriptor = -1};
    const size_t head_bytes = finish_head(w);
    int error = svo_i_output_open(w->path, NULL, &output);
    if (error == 0) {
        error = write_segments(w, &output, head_bytes);
    }
    if (error == 0) {
        error = svo_i_output_commit_unflushed(&output);
    }
    svo_i_output_abandon(&output);
    return error == 0 ? SVO_OK
                      : svo_i_fail(w->message, svo_i_file_status(error), "%s: cannot be written: %s", w->path,
                                   strerror(error));
}

/* ---- parts ---- */

/* Adds the elements of a level of an array that begins with the level first. */
static void add_level(writer *w, const svo_tree *tree, svo_tree_buffer array, uint32_t first, uint32_t level)
{
    const uint32_t *begin = tree->info.level_begin;
    const size_t element_bytes = svo_i_tree_element_bytes(array);
    const size_t before = (size_t)(begin[level] - begin[first]) * element_bytes;
    add_segment(w, (uint32_t)array, level, (const char *)tree->host[array] + before,
                (uint64_t)(begin[level + 1] - begin[level]) * element_bytes);
}

static void add_levels(writer *w, const svo_tree *tree)
{
    static const svo_tree_buffer payload[] = {SVO_TREE_COLORS, SVO_TREE_NORMALS, SVO_TREE_MATERIALS, SVO_TREE_FILLS};
    const svo_tree_info *info = &tree->info;
    for (uint32_t level = 0; level <= info->depth; ++level) {
        if (level < info->depth) {
            add_level(w, tree, SVO_TREE_CHILD_MASK, 0, level);
        }
        for (unsigned i = 0; i < sizeof payload / sizeof payload[0] && level >= info->payload_level; ++i) {
            if (svo_i_tree_holds(info, payload[i]) && !svo_i_tree_is_constant(info, payload[i])) {
                add_level(w, tree, payload[i], info->payload_level, level);
            }
        }
    }
}

/* Names the triangles of lists as the whole does. The caller frees *list. */
static svo_status name_lists(const svo_tree *tree, svo_message *message, uint32_t **list)
{
    const uint32_t *from = tree->host[SVO_TREE_LIST];
    const uint32_t *names = tree->host[SVO_TREE_TRIANGLE_IDS];
    *list = svo_i_alloc(&tree->memory, ((size_t)tree->info.list_count + 1) * sizeof **list);
    if (*list == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_part_save: no memory for %llu list entries",
                          (unsigned long long)tree->info.list_count);
    }
    for (uint64_t i = 0; i < tree->info.list_count; ++i) {
        (*list)[i] = names[from[i]];
    }
    return SVO_OK;
}

/* A part without leaves has no nodes: its root is none of the whole tree. */
static void add_part(writer *w, const svo_tree *tree, const uint32_t *list)
{
    const svo_tree_info *info = &tree->info;
    part_head *head = &w->file.head;
    head->fragments = info->fragments;
    if (info->leaf_count == 0) {
        return;
    }
    head->root = tree->part.root;
    memcpy(head->level_begin, info->level_begin, (info->depth + 2) * sizeof head->level_begin[0]);
    add_levels(w, tree);
    if (svo_i_tree_holds(info, SVO_TREE_AREAS)) {
        add_segment(w, SVO_TREE_AREAS, info->depth, tree->host[SVO_TREE_AREAS], info->leaf_count * 12);
    }
    if (list != NULL) {
        add_segment(w, SVO_TREE_LIST_BEGIN, info->depth, tree->host[SVO_TREE_LIST_BEGIN], info->leaf_count * 4);
        add_segment(w, SVO_TREE_LIST, info->depth, list, info->list_count * 4);
    }
    if (tree->part.runs != NULL) {
        add_segment(w, PART_RUNS, 0, tree->part.runs, tree->part.run_count * sizeof(uint64_t));
    }
}

svo_status svo_part_save(const svo_tree *tree, const char *path, svo_message *message)
{
    static const char function[] = "svo_part_save";
    uint32_t *list = NULL;
    svo_status status = SVO_OK;
    if (tree == NULL || path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, tree == NULL ? "tree" : "path");
    }
    if (tree->part.header.depth == 0 || !tree->downloaded) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s", function,
                          tree->part.header.depth == 0 ? "the tree is no part; its plan had no part_header"
                                                       : "the tree has no host arrays; call svo_tree_download first");
    }
    writer *w = svo_i_alloc_zeroed(&tree->memory, 1, sizeof *w);
    if (w == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the head", function);
    }
    w->path = path;
    w->message = message;
    svo_i_part_identity(&tree->part.header, w->file.head.whole);
    w->file.head.level = tree->part.level;
    w->file.head.code = tree->part.code;
    if (svo_i_tree_holds(&tree->info, SVO_TREE_LIST)) {
        SVO_I_TRY_CLEANUP(name_lists(tree, message, &list));
    }
    add_part(w, tree, list);
    status = write_file(w);
cleanup:
    svo_i_free(list);
    svo_i_free(w);
    return status;
}

/* ---- the whole mesh ---- */

static void add_mesh(writer *w, const svo_plan *plan)
{
    const uint64_t vertices = plan->vertex_count;
    const uint64_t triangles = plan->triangle_count;
    add_segment(w, SVO_TREE_VERTICES, 0, plan->vertices, vertices * 12);
    add_segment(w, SVO_TREE_INDICES, 0, plan->indices, triangles * 12);
    add_segment(w, SVO_TREE_TRIANGLE_IDS, 0, plan->triangle_ids, triangles * 4);
    if (plan->positions != NULL) {
        add_segment(w, SVO_TREE_POSITIONS, 0, plan->positions, vertices * 12);
    } else if (plan->positions_double != NULL) {
        add_segment(w, SVO_TREE_POSITIONS_DOUBLE, 0, plan->positions_double, vertices * 24);
    }
}

svo_status svo_i_part_save_mesh(svo_plan *plan, const svo_part_header *header, const char *path, svo_message *message)
{
    const svo_status brought = svo_i_plan_copy_to_host(plan);
    if (brought != SVO_OK) {
        return svo_i_fail(message, brought, "%s", svo_device_message(plan->device));
    }
    writer *w = svo_i_alloc_zeroed(&plan->device->memory, 1, sizeof *w);
    if (w == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the head", path);
    }
    w->path = path;
    w->message = message;
    svo_i_part_identity(header, w->file.head.whole);
    w->file.head.is_mesh = 1;
    add_mesh(w, plan);
    const svo_status status = write_file(w);
    svo_i_free(w);
    return status;
}

svo_status svo_part_save_mesh(svo_plan *plan, const char *path, svo_message *message)
{
    static const char function[] = "svo_part_save_mesh";
    svo_part_header header = SVO_PART_HEADER_INIT;
    if (plan == NULL || path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, plan == NULL ? "plan" : "path");
    }
    if ((plan->info.need & SVO_NEED_RAYS) == 0 || svo_plan_get_part_header(plan, &header) != SVO_OK) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the plan is that of a part or has no SVO_NEED_RAYS",
                          function);
    }
    return svo_i_part_save_mesh(plan, &header, path, message);
}

/* ---- reading ---- */

/* Of a segment that is read at a time: each piece costs two calls of the system where parts are stitched. */
#define PIECE_BYTES 65536

svo_status svo_i_part_damaged(const svo_i_part_reader *reader, const char *why)
{
    return svo_i_fail(reader->message, SVO_FILE_DAMAGED, "%s: %s", reader->path, why);
}

svo_status svo_i_part_read(const svo_i_part_reader *reader, uint64_t offset, void *out, size_t byte_count)
{
    size_t got = 0;
    const int error = svo_i_read_at(reader->file, offset, out, byte_count, &got);
    if (error != 0) {
        return svo_i_fail(reader->message, svo_i_file_status(error), "%s: cannot be read: %s", reader->path,
                          strerror(error));
    }
    return got == byte_count ? SVO_OK : svo_i_part_damaged(reader, "truncated");
}

static svo_status check_head(const svo_i_part_reader *reader, uint64_t file_bytes)
{
    const part_head *head = &reader->content.head;
    if (memcmp(head->magic, PART_MAGIC, PART_MAGIC_BYTES) != 0) {
        return svo_i_part_damaged(reader, "not a part file");
    }
    if (head->version != PART_VERSION) {
        return svo_i_fail(reader->message, SVO_FILE_DAMAGED, "%s: version %" PRIu32 " is not known, only %d",
                          reader->path, head->version, PART_VERSION);
    }
    if (head->segment_count > PART_SEGMENTS_MAX) {
        return svo_i_part_damaged(reader, "its number of segments is not known");
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
    uint64_t own[2];
    svo_i_part_identity(header, own);
    if (memcmp(head->whole, own, sizeof own) != 0) {
        return svo_i_part_is_foreign(reader->path, head->whole, own, "", reader->message);
    }
    if (is_mesh || head->is_mesh != 0) {
        return is_mesh && head->is_mesh == 1 ? SVO_OK
                                             : svo_i_part_damaged(reader, is_mesh ? "not a mesh" : "not a part");
    }
    if (head->level >= header->depth || header->depth - head->level > SVO_DEPTH_MAX ||
        head->code >> (3 * head->level) != 0 || !has_levels(head, header->depth - head->level)) {
        return svo_i_part_damaged(reader, "its place or its levels are none of the tree's");
    }
    return SVO_OK;
}

static svo_status read_head(svo_i_part_reader *reader, const svo_part_header *header, bool is_mesh)
{
    struct stat found;
    part_head *head = &reader->content.head;
    if (fstat(reader->file, &found) != 0) {
        return svo_i_fail(reader->message, svo_i_file_status(errno), "%s: cannot be read: %s", reader->path,
                          strerror(errno));
    }
    if (!S_ISREG(found.st_mode)) {
        return svo_i_fail(reader->message, SVO_FILE_ERROR, "%s: not a file", reader->path);
    }
    SVO_I_TRY(svo_i_part_read(reader, 0, head, sizeof *head));
    SVO_I_TRY(check_head(reader, (uint64_t)found.st_size));
    SVO_I_TRY(
        svo_i_part_read(reader, sizeof *head, reader->content.segments, head->segment_count * sizeof(part_segment)));
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
    return reader->file >= 0
               ? read_head(reader, header, is_mesh)
               : svo_i_fail(message, svo_i_file_status(errno), "%s: cannot be opened: %s", path, strerror(errno));
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
        SVO_I_TRY(svo_i_part_read(reader, segment->offset + at, piece, count));
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
    return header->depth >= SVO_DEPTH_MIN && header->depth <= SVO_PARTS_DEPTH_MAX &&
                   header->payload_level <= header->depth
               ? SVO_OK
               : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: header.depth %u is not in %d .. %d", function,
                            header->depth, SVO_DEPTH_MIN, SVO_PARTS_DEPTH_MAX);
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
