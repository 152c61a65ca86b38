/* SPDX-License-Identifier: MIT */
/*
 * Part files to a .svo file. Its chunks are levels of arrays, and each is made of the parts in Morton order. The head
 * of the file has lengths and checksums, so it is written last.
 */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <string.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/memory.h"
#include "io/file_save.h"
#include "io/file_tree.h"
#include "output/output.h"
#include "parts/pieces.h"
#include "shared/nodes.clh"
#include "svocl/parts.h"

/* Numbers that are made at a time. */
#define NUMBERS 4096

typedef struct stitcher {
    svo_i_pieces all;
    svo_tree_info info; /* of the whole tree */
    const char *mesh_path;
    const char *path;
    svo_message *message;
    svo_i_output output;
    file_head head;
    file_chunk *chunk; /* that is being written */
    XXH3_state_t hash; /* of its bytes */
    svo_tree_buffer array;
    uint64_t next; /* the children of a level, or the lists' entries, so far */
} stitcher;

static svo_status fail_errno(const stitcher *s, int error)
{
    return svo_i_fail(s->message, SVO_FILE_ERROR, "%s: cannot be written: %s", s->path, strerror(error));
}

/* A visitor: appends bytes to the chunk. Of child masks it counts the children. */
static svo_status put(void *user, const void *bytes, size_t byte_count)
{
    stitcher *s = user;
    const uint8_t *masks = bytes;
    for (size_t i = 0; i < byte_count && s->array == SVO_TREE_CHILD_MASK; ++i) {
        s->next += svo_count_bits(masks[i]);
    }
    const int error = svo_i_output_write(&s->output, bytes, byte_count);
    XXH3_64bits_update(&s->hash, bytes, byte_count);
    s->chunk->plain_bytes += byte_count;
    return error == 0 ? SVO_OK : fail_errno(s, error);
}

/* A visitor: where lists begin, counted from the part's first entry. */
static svo_status put_list_begins(void *user, const void *bytes, size_t byte_count)
{
    stitcher *s = user;
    const unsigned char *from = bytes;
    uint32_t numbers[NUMBERS];
    const size_t most = sizeof numbers;
    for (size_t at = 0; at < byte_count; at += most) {
        const size_t piece_bytes = byte_count - at < most ? byte_count - at : most;
        memcpy(numbers, from + at, piece_bytes);
        for (size_t i = 0; i < piece_bytes / sizeof *numbers; ++i) {
            numbers[i] += (uint32_t)s->next;
        }
        SVO_I_TRY(put(s, numbers, piece_bytes));
    }
    return SVO_OK;
}

/* ---- nodes ---- */

static svo_status put_upper(stitcher *s, const svo_i_upper_node *upper)
{
    switch (s->array) {
    case SVO_TREE_CHILD_MASK:
        return put(s, &upper->mask, 1);
    case SVO_TREE_COLORS:
        return put(s, upper->payload.color, sizeof upper->payload.color);
    case SVO_TREE_NORMALS:
        return put(s, upper->payload.normal, sizeof upper->payload.normal);
    case SVO_TREE_MATERIALS:
        return put(s, &upper->payload.material, sizeof upper->payload.material);
    case SVO_TREE_FILLS:
        return put(s, &upper->payload.fill, sizeof upper->payload.fill);
    default:
        return svo_i_fail(s->message, SVO_INTERNAL, "svo_parts_stitch: %s has no elements above the leaves",
                          svo_tree_buffer_name(s->array));
    }
}

/* Bytes that a part's segment must have; lists have any number of entries. */
static uint64_t segment_bytes(const svo_i_piece *piece, uint32_t kind, uint32_t level)
{
    const uint64_t nodes = piece->level_begin[level + 1] - piece->level_begin[level];
    return kind == SVO_TREE_LIST ? piece->list_count * sizeof(uint32_t)
                                 : nodes * svo_i_tree_element_bytes((svo_tree_buffer)kind);
}

static svo_status put_piece(stitcher *s, uint32_t level, const svo_i_piece *piece)
{
    const uint32_t kind = (uint32_t)s->array;
    const uint32_t own_level = level - piece->level;
    svo_i_part_reader reader = {.file = -1};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_part_open(&s->all.header, piece->path, false, s->message, &reader));
    const part_segment *segment = svo_i_part_find(&reader, kind, own_level);
    if (segment == NULL || segment->bytes != segment_bytes(piece, kind, own_level)) {
        status = svo_i_part_damaged(&reader, "an array is missing or has another length");
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(svo_i_part_stream(&reader, segment, s->array == SVO_TREE_LIST_BEGIN ? put_list_begins : put, s));
    s->next += s->array == SVO_TREE_LIST_BEGIN ? piece->list_count : 0;
cleanup:
    svo_i_part_close(&reader);
    return status;
}

static svo_status put_nodes(void *user, uint32_t level, const svo_i_upper_node *upper, const svo_i_piece *piece)
{
    return upper != NULL ? put_upper(user, upper) : put_piece(user, level, piece);
}

static svo_status put_level(stitcher *s, uint32_t level)
{
    return svo_i_pieces_visit(&s->all, level, put_nodes, s);
}

static svo_status put_list_begin(stitcher *s)
{
    s->next = 0;
    SVO_I_TRY(put_level(s, s->info.depth));
    const uint32_t end = (uint32_t)s->next;
    return put(s, &end, sizeof end);
}

/* Payload that is the same in every node; zero in a tree without leaves. */
static svo_status put_constant(stitcher *s)
{
    static const unsigned char none[8] = {0};
    const svo_part_header *header = &s->all.header;
    const void *value = s->array == SVO_TREE_COLORS    ? (const void *)header->constant_color
                        : s->array == SVO_TREE_NORMALS ? (const void *)header->constant_normal
                                                       : (const void *)&header->constant_material;
    return put(s, s->info.leaf_count > 0 ? value : none, svo_i_tree_element_bytes(s->array));
}

static svo_status put_mesh(stitcher *s)
{
    svo_i_part_reader reader = {.file = -1};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_part_open(&s->all.header, s->mesh_path, true, s->message, &reader));
    const part_segment *segment = svo_i_part_find(&reader, (uint32_t)s->array, 0);
    const uint64_t bytes = svo_i_tree_element_count(&s->info, s->array) * svo_i_tree_element_bytes(s->array);
    if (segment == NULL || segment->bytes != bytes) {
        status = svo_i_part_damaged(&reader, "an array of the mesh is missing or has another length");
        goto cleanup;
    }
    status = svo_i_part_stream(&reader, segment, put, s);
cleanup:
    svo_i_part_close(&reader);
    return status;
}

static svo_status put_masks(stitcher *s, uint32_t level)
{
    const uint32_t *level_begin = s->info.level_begin;
    s->next = 0;
    SVO_I_TRY(put_level(s, level));
    return s->next == level_begin[level + 2] - level_begin[level + 1]
               ? SVO_OK
               : svo_i_fail(s->message, SVO_FILE_DAMAGED, "%s: the parts' masks do not add up to their nodes", s->path);
}

/* The elements of an array that belong to a level. */
static svo_status put_array(stitcher *s, uint32_t level)
{
    switch (s->array) {
    case SVO_TREE_COLORS:
    case SVO_TREE_NORMALS:
    case SVO_TREE_MATERIALS:
    case SVO_TREE_FILLS:
        return svo_i_tree_is_constant(&s->info, s->array) ? put_constant(s) : put_level(s, level);
    case SVO_TREE_CHILD_MASK:
        return put_masks(s, level);
    case SVO_TREE_LIST:
    case SVO_TREE_AREAS:
        return put_level(s, level);
    case SVO_TREE_LIST_BEGIN:
        return put_list_begin(s);
    default:
        return put_mesh(s);
    }
}

/* ---- the file ---- */

static svo_status put_chunk(stitcher *s, const file_entry *entry, uint64_t offset)
{
    s->array = entry->buffer;
    s->chunk = &s->head.chunks[s->head.header.chunk_count++];
    *s->chunk = (file_chunk){.kind = svo_i_file_entry_kind(entry), .codec = FILE_CODEC_STORED, .offset = offset};
    XXH3_INITSTATE(&s->hash);
    XXH3_64bits_reset(&s->hash);
    SVO_I_TRY(put_array(s, entry->level));
    s->chunk->stored_bytes = s->chunk->plain_bytes;
    s->chunk->hash = XXH3_64bits_digest(&s->hash);
    return SVO_OK;
}

/* Writes the head in its place. */
static svo_status put_head(stitcher *s, uint64_t file_bytes)
{
    file_header *header = &s->head.header;
    header->file_bytes = file_bytes;
    header->header_hash =
        XXH3_64bits((const uint8_t *)&s->head + FILE_HASH_BEGIN, header->header_bytes - FILE_HASH_BEGIN);
    if (lseek(s->output.descriptor, 0, SEEK_SET) != 0) {
        return fail_errno(s, errno);
    }
    const int error = svo_i_output_write(&s->output, &s->head, header->header_bytes);
    return error == 0 ? SVO_OK : fail_errno(s, error);
}

static svo_status put_file(stitcher *s)
{
    file_header *header = &s->head.header;
    file_entry entries[FILE_CHUNKS_MAX];
    const uint32_t entry_count = svo_i_file_list_entries(&s->info, FILE_VERSION, entries);
    svo_i_file_fill_header(header, &s->info);
    header->header_bytes = (uint32_t)(sizeof *header + entry_count * sizeof(file_chunk));
    uint64_t offset = header->header_bytes;
    const int error = svo_i_output_write(&s->output, &s->head, header->header_bytes); /* holds the place */
    if (error != 0) {
        return fail_errno(s, error);
    }
    for (uint32_t i = 0; i < entry_count; ++i) {
        SVO_I_TRY(put_chunk(s, &entries[i], offset));
        offset += s->chunk->stored_bytes;
    }
    return put_head(s, offset);
}

/* What the header says of the whole tree. */
static svo_tree_info info_of(const svo_part_header *header)
{
    svo_tree_info info = {.depth = header->depth,
                          .snap_bits = header->snap_bits,
                          .coverage = header->coverage,
                          .need = header->need,
                          .constant = header->constant,
                          .weights = header->weights,
                          .payload_level = header->payload_level,
                          .edge = header->edge,
                          .scale = header->scale,
                          .snap_error = header->snap_error,
                          .triangles = header->triangles,
                          .refused_triangles = header->refused_triangles,
                          .positions = header->positions};
    memcpy(info.origin, header->origin, sizeof info.origin);
    if ((header->need & SVO_NEED_RAYS) != 0) {
        info.vertex_count = header->vertex_count;
        info.list_triangle_count = header->kept_triangles;
    }
    return info;
}

static svo_status write_tree(stitcher *s)
{
    svo_status status = SVO_OK;
    int error = svo_i_output_open(s->path, NULL, &s->output);
    if (error != 0) {
        return fail_errno(s, error);
    }
    if (s->output.target[0] == '\0') {
        status = svo_i_fail(s->message, SVO_INVALID_ARGUMENT, "svo_parts_stitch: %s is no file", s->path);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(put_file(s));
    error = svo_i_output_commit(&s->output);
    status = error == 0 ? SVO_OK : fail_errno(s, error);
cleanup:
    svo_i_output_abandon(&s->output);
    return status;
}

svo_status svo_parts_stitch(const svo_part_header *header, const char *const *paths, size_t part_count,
                            const char *mesh_path, const char *path, svo_message *message)
{
    static const char function[] = "svo_parts_stitch";
    stitcher s = {.mesh_path = mesh_path, .path = path, .message = message, .all = {.message = message}};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_part_header_read(function, header, message, &s.all.header));
    if (path == NULL || (paths == NULL && part_count > 0)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function, path == NULL ? "path" : "paths");
    }
    if ((s.all.header.need & SVO_NEED_RAYS) != 0 && mesh_path == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: mesh_path is NULL, and the tree has SVO_NEED_RAYS",
                          function);
    }
    s.info = info_of(&s.all.header);
    SVO_I_TRY_CLEANUP(svo_i_pieces_read(&s.all, paths, part_count));
    SVO_I_TRY_CLEANUP(svo_i_pieces_count(&s.all, &s.info));
    status = write_tree(&s);
cleanup:
    svo_i_pieces_free(&s.all);
    return status;
}
