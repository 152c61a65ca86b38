/* SPDX-License-Identifier: MIT */
/*
 * Part files to a .svo file. Its chunks are levels of arrays, and each is made of the parts in Morton order. Parts are
 * read once, in that order: the counts in their heads give the place of every chunk, and a part appends to all of them.
 */
#define _POSIX_C_SOURCE 200809L
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/memory.h"
#include "io/file_format.h"
#include "output/output.h"
#include "parts/pieces.h"
#include "shared/nodes.clh"
#include "svocl/parts.h"

/* Numbers that are made at a time. */
#define NUMBERS 4096

/* Alignment of a checksum's state, which svo_i_alloc does not give. */
#define STATE_ALIGNMENT 64

/* A chunk of the file. Parts append to all chunks in turn, each in its place. */
typedef struct filling {
    XXH3_state_t hash; /* of its bytes so far */
    file_entry entry;
    file_chunk *chunk; /* plain_bytes: so far */
    uint64_t next; /* the children of its nodes, or its lists' entries, so far */
} filling;

typedef struct stitcher {
    svo_i_pieces all;
    svo_tree_info info; /* of the whole tree */
    const char *mesh_path;
    const char *path;
    svo_message *message;
    svo_i_output output;
    file_head head;
    void *memory; /* of the fillings */
    filling *fillings;
    uint32_t filling_count;
} stitcher;

/* What bytes of a part or of the mesh are appended to. */
typedef struct target {
    stitcher *s;
    filling *to;
} target;

static svo_status fail_errno(const stitcher *s, int error)
{
    return svo_i_fail(s->message, svo_i_file_status(error), "%s: cannot be written: %s", s->path, strerror(error));
}

/* Appends bytes to a chunk. Of child masks it counts the children. */
static svo_status put(stitcher *s, filling *to, const void *bytes, size_t byte_count)
{
    const uint8_t *masks = bytes;
    for (size_t i = 0; i < byte_count && to->entry.buffer == SVO_TREE_CHILD_MASK; ++i) {
        to->next += svo_count_bits(masks[i]);
    }
    const int error = svo_i_output_write_at(&s->output, to->chunk->offset + to->chunk->plain_bytes, bytes, byte_count);
    XXH3_64bits_update(&to->hash, bytes, byte_count);
    to->chunk->plain_bytes += byte_count;
    return error == 0 ? SVO_OK : fail_errno(s, error);
}

/* A visitor. */
static svo_status put_bytes(void *user, const void *bytes, size_t byte_count)
{
    const target *at = user;
    return put(at->s, at->to, bytes, byte_count);
}

/* A visitor: where lists begin, counted from the part's first entry. */
static svo_status put_list_begins(void *user, const void *bytes, size_t byte_count)
{
    const target *at = user;
    const unsigned char *from = bytes;
    uint32_t numbers[NUMBERS];
    const size_t most = sizeof numbers;
    for (size_t begin = 0; begin < byte_count; begin += most) {
        const size_t piece_bytes = byte_count - begin < most ? byte_count - begin : most;
        memcpy(numbers, from + begin, piece_bytes);
        for (size_t i = 0; i < piece_bytes / sizeof *numbers; ++i) {
            numbers[i] += (uint32_t)at->to->next;
        }
        SVO_I_TRY(put(at->s, at->to, numbers, piece_bytes));
    }
    return SVO_OK;
}

/* ---- nodes ---- */

/* Whether parts and the nodes above them have elements of an array. */
static bool is_of_parts(const stitcher *s, svo_tree_buffer array)
{
    switch (array) {
    case SVO_TREE_CHILD_MASK:
    case SVO_TREE_LIST:
    case SVO_TREE_LIST_BEGIN:
    case SVO_TREE_AREAS:
        return true;
    case SVO_TREE_COLORS:
    case SVO_TREE_NORMALS:
    case SVO_TREE_MATERIALS:
    case SVO_TREE_FILLS:
        return !svo_i_tree_is_constant(&s->info, array);
    default:
        return false;
    }
}

static svo_status put_upper(stitcher *s, filling *to, const svo_i_upper_node *upper)
{
    switch (to->entry.buffer) {
    case SVO_TREE_CHILD_MASK:
        return put(s, to, &upper->mask, 1);
    case SVO_TREE_COLORS:
        return put(s, to, upper->payload.color, sizeof upper->payload.color);
    case SVO_TREE_NORMALS:
        return put(s, to, upper->payload.normal, sizeof upper->payload.normal);
    case SVO_TREE_MATERIALS:
        return put(s, to, &upper->payload.material, sizeof upper->payload.material);
    case SVO_TREE_FILLS:
        return put(s, to, &upper->payload.fill, sizeof upper->payload.fill);
    default:
        return svo_i_fail(s->message, SVO_INTERNAL, "svo_parts_stitch: %s has no elements above the leaves",
                          svo_name(SVO_NAME_TREE_BUFFER, to->entry.buffer));
    }
}

/* Bytes that a part's segment must have; lists have any number of entries. */
static uint64_t segment_bytes(const svo_i_piece *piece, uint32_t kind, uint32_t level)
{
    const uint64_t nodes = piece->level_begin[level + 1] - piece->level_begin[level];
    return kind == SVO_TREE_LIST ? piece->list_count * sizeof(uint32_t)
                                 : nodes * svo_i_tree_element_bytes((svo_tree_buffer)kind);
}

static svo_status put_segment(stitcher *s, filling *to, const svo_i_piece *piece, const svo_i_part_reader *reader)
{
    const uint32_t kind = (uint32_t)to->entry.buffer;
    const uint32_t own_level = to->entry.level - piece->level;
    const part_segment *segment = svo_i_part_find(reader, kind, own_level);
    target at = {s, to};
    if (segment == NULL || segment->bytes != segment_bytes(piece, kind, own_level)) {
        return svo_i_part_damaged(reader, "an array is missing or has another length");
    }
    SVO_I_TRY(svo_i_part_stream(reader, segment, kind == SVO_TREE_LIST_BEGIN ? put_list_begins : put_bytes, &at));
    to->next += kind == SVO_TREE_LIST_BEGIN ? piece->list_count : 0;
    return SVO_OK;
}

static svo_status put_piece(stitcher *s, const svo_i_piece *piece)
{
    svo_i_part_reader reader = {.file = -1};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_part_open(&s->all.header, piece->path, false, s->message, &reader));
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        filling *to = &s->fillings[i];
        if (to->entry.level >= piece->level && is_of_parts(s, to->entry.buffer)) {
            SVO_I_TRY_CLEANUP(put_segment(s, to, piece, &reader));
        }
    }
cleanup:
    svo_i_part_close(&reader);
    return status;
}

static svo_status put_nodes(void *user, uint32_t level, const svo_i_upper_node *upper, const svo_i_piece *piece)
{
    stitcher *s = user;
    if (piece != NULL) {
        return put_piece(s, piece);
    }
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        filling *to = &s->fillings[i];
        if (to->entry.level == level && is_of_parts(s, to->entry.buffer)) {
            SVO_I_TRY(put_upper(s, to, upper));
        }
    }
    return SVO_OK;
}

/* ---- what parts do not have ---- */

/* Payload that is the same in every node; zero in a tree without leaves. */
static svo_status put_constant(stitcher *s, filling *to)
{
    static const unsigned char none[8] = {0};
    const svo_part_header *header = &s->all.header;
    const svo_tree_buffer array = to->entry.buffer;
    const void *value = array == SVO_TREE_COLORS    ? (const void *)header->constant_color
                        : array == SVO_TREE_NORMALS ? (const void *)header->constant_normal
                                                    : (const void *)&header->constant_material;
    return put(s, to, s->info.leaf_count > 0 ? value : none, svo_i_tree_element_bytes(array));
}

static svo_status put_mesh(stitcher *s, filling *to)
{
    svo_i_part_reader reader = {.file = -1};
    target at = {s, to};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_part_open(&s->all.header, s->mesh_path, true, s->message, &reader));
    const part_segment *segment = svo_i_part_find(&reader, (uint32_t)to->entry.buffer, 0);
    if (segment == NULL || segment->bytes != to->chunk->stored_bytes) {
        status = svo_i_part_damaged(&reader, "an array of the mesh is missing or has another length");
        goto cleanup;
    }
    status = svo_i_part_stream(&reader, segment, put_bytes, &at);
cleanup:
    svo_i_part_close(&reader);
    return status;
}

/* Appends what follows the parts' elements, or stands in their place. */
static svo_status put_rest(stitcher *s, filling *to)
{
    const uint32_t end = (uint32_t)to->next;
    switch (to->entry.buffer) {
    case SVO_TREE_COLORS:
    case SVO_TREE_NORMALS:
    case SVO_TREE_MATERIALS:
    case SVO_TREE_FILLS:
        return svo_i_tree_is_constant(&s->info, to->entry.buffer) ? put_constant(s, to) : SVO_OK;
    case SVO_TREE_CHILD_MASK:
    case SVO_TREE_LIST:
    case SVO_TREE_AREAS:
        return SVO_OK;
    case SVO_TREE_LIST_BEGIN:
        return put(s, to, &end, sizeof end);
    default:
        return put_mesh(s, to);
    }
}

/* ---- the file ---- */

/* Places the chunks, whose lengths follow from the counts. Returns the length of the file. */
static uint64_t place_chunks(stitcher *s, const file_entry *entries)
{
    file_header *header = &s->head.header;
    svo_i_file_fill_header(header, &s->info);
    header->chunk_count = s->filling_count;
    header->header_bytes = (uint32_t)(sizeof *header + s->filling_count * sizeof(file_chunk));
    uint64_t offset = header->header_bytes;
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        filling *to = &s->fillings[i];
        to->entry = entries[i];
        to->chunk = &s->head.chunks[i];
        to->next = 0;
        XXH3_INITSTATE(&to->hash);
        XXH3_64bits_reset(&to->hash);
        *to->chunk = (file_chunk){.kind = file_entry_kind(&entries[i]),
                                  .codec = FILE_CODEC_STORED,
                                  .offset = offset,
                                  .stored_bytes = svo_i_file_entry_count(&s->info, FILE_VERSION, &entries[i]) *
                                                  svo_i_tree_element_bytes(entries[i].buffer)};
        offset += to->chunk->stored_bytes;
    }
    return offset;
}

static svo_status alloc_fillings(stitcher *s)
{
    s->memory = svo_i_alloc(NULL, s->filling_count * sizeof *s->fillings + STATE_ALIGNMENT);
    if (s->memory == NULL) {
        return svo_i_fail(s->message, SVO_OUT_OF_HOST_MEMORY, "svo_parts_stitch: no memory for %u chunks",
                          s->filling_count);
    }
    const uintptr_t aligned = ((uintptr_t)s->memory + STATE_ALIGNMENT - 1) / STATE_ALIGNMENT * STATE_ALIGNMENT;
    s->fillings = (filling *)aligned;
    return SVO_OK;
}

/* Appends what is left, and completes the chunks. */
static svo_status finish_chunks(stitcher *s)
{
    const uint32_t *level_begin = s->info.level_begin;
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        filling *to = &s->fillings[i];
        const uint32_t level = to->entry.level;
        SVO_I_TRY(put_rest(s, to));
        if (to->chunk->plain_bytes != to->chunk->stored_bytes ||
            (to->entry.buffer == SVO_TREE_CHILD_MASK && to->next != level_begin[level + 2] - level_begin[level + 1])) {
            return svo_i_fail(s->message, SVO_FILE_DAMAGED, "%s: the parts' %s do not add up to their nodes", s->path,
                              svo_name(SVO_NAME_TREE_BUFFER, to->entry.buffer));
        }
        to->chunk->hash = XXH3_64bits_digest(&to->hash);
    }
    return SVO_OK;
}

/* One pass over the parts; the head has checksums, so it is written last. */
static svo_status put_file(stitcher *s)
{
    file_header *header = &s->head.header;
    file_entry entries[FILE_CHUNKS_MAX];
    s->filling_count = svo_i_file_list_entries(&s->info, FILE_VERSION, entries);
    SVO_I_TRY(alloc_fillings(s));
    header->file_bytes = place_chunks(s, entries);
    SVO_I_TRY(svo_i_pieces_visit_all(&s->all, put_nodes, s));
    SVO_I_TRY(finish_chunks(s));
    header->header_hash =
        XXH3_64bits((const uint8_t *)&s->head + FILE_HASH_BEGIN, header->header_bytes - FILE_HASH_BEGIN);
    const int error = svo_i_output_write_at(&s->output, 0, &s->head, header->header_bytes);
    return error == 0 ? SVO_OK : fail_errno(s, error);
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
                          .triangles = header->triangles,
                          .refused_triangles = header->refused_triangles,
                          .positions = header->positions,
                          .is_exact = 1};
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
    svo_i_free(s.memory);
    svo_i_pieces_free(&s.all);
    return status;
}
