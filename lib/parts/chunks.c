/* SPDX-License-Identifier: MIT */
/* The bytes of parts, and of the nodes above them, on their way to the chunks of a file. */
#define _POSIX_C_SOURCE 200809L
#include "parts/chunks.h"

#include <string.h>

#include "core/memory.h"
#include "shared/nodes.clh"
#include "svocl/parts.h"

/* Numbers that are made at a time. */
#define NUMBERS 4096

/* Alignment of a checksum's state, which svo_i_alloc does not give. */
#define STATE_ALIGNMENT 64

/* What bytes of a part or of the mesh are appended to. */
typedef struct target {
    svo_i_stitcher *s;
    svo_i_filling *to;
} target;

static svo_status fail_errno(const svo_i_stitcher *s, int error)
{
    return svo_i_fail(s->message, svo_i_file_status(error), "%s: cannot be written: %s", s->path, strerror(error));
}

/* Appends bytes to a chunk. Of child masks it counts the children. */
static svo_status put(svo_i_stitcher *s, svo_i_filling *to, const void *bytes, size_t byte_count)
{
    const uint8_t *masks = bytes;
    for (size_t i = 0; i < byte_count && s->hashes && to->entry.buffer == SVO_TREE_CHILD_MASK; ++i) {
        to->next += svo_count_bits(masks[i]);
    }
    if (s->hashes) {
        XXH3_64bits_update(&to->hash, bytes, byte_count);
    }
    const uint64_t place = to->chunk->offset + to->chunk->plain_bytes;
    const int error = s->writes ? svo_i_output_write_at(&s->output, place, bytes, byte_count) : 0;
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

bool svo_i_chunks_are_of_parts(const svo_i_stitcher *s, svo_tree_buffer array)
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

/* Whether nodes of a level, or of a part of that level, have elements of a chunk. */
static bool has_elements(const svo_i_stitcher *s, const svo_i_filling *to, uint32_t level, bool is_part)
{
    return (is_part ? to->entry.level >= level : to->entry.level == level) &&
           svo_i_chunks_are_of_parts(s, to->entry.buffer);
}

const void *svo_i_chunks_upper(const svo_i_upper_node *upper, svo_tree_buffer array)
{
    switch (array) {
    case SVO_TREE_CHILD_MASK:
        return &upper->mask;
    case SVO_TREE_COLORS:
        return upper->payload.color;
    case SVO_TREE_NORMALS:
        return upper->payload.normal;
    case SVO_TREE_MATERIALS:
        return &upper->payload.material;
    case SVO_TREE_FILLS:
        return &upper->payload.fill;
    default:
        return NULL;
    }
}

static svo_status put_upper(svo_i_stitcher *s, svo_i_filling *to, const svo_i_upper_node *upper)
{
    const void *element = svo_i_chunks_upper(upper, to->entry.buffer);
    return element != NULL
               ? put(s, to, element, svo_i_tree_element_bytes(to->entry.buffer))
               : svo_i_fail(s->message, SVO_INTERNAL, "svo_parts_stitch: %s has no elements above the leaves",
                            svo_name(SVO_NAME_TREE_BUFFER, to->entry.buffer));
}

uint64_t svo_i_chunks_segment_bytes(const svo_i_piece *piece, uint32_t kind, uint32_t level)
{
    const uint64_t nodes = piece->level_begin[level + 1] - piece->level_begin[level];
    return kind == SVO_TREE_LIST ? piece->list_count * sizeof(uint32_t)
                                 : nodes * svo_i_tree_element_bytes((svo_tree_buffer)kind);
}

uint64_t svo_i_chunks_part_bytes(const svo_i_stitcher *s, const svo_i_piece *piece)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        const file_entry *entry = &s->fillings[i].entry;
        if (has_elements(s, &s->fillings[i], piece->level, true)) {
            bytes += svo_i_chunks_segment_bytes(piece, (uint32_t)entry->buffer, entry->level - piece->level);
        }
    }
    return bytes;
}

static svo_status put_segment(svo_i_stitcher *s, svo_i_filling *to, const svo_i_piece *piece,
                              const svo_i_part_reader *reader)
{
    const uint32_t kind = (uint32_t)to->entry.buffer;
    const uint32_t own_level = to->entry.level - piece->level;
    const part_segment *segment = svo_i_part_find(reader, kind, own_level);
    target at = {s, to};
    if (segment == NULL || segment->bytes != svo_i_chunks_segment_bytes(piece, kind, own_level)) {
        return svo_i_part_damaged(reader, "an array is missing or has another length");
    }
    SVO_I_TRY(svo_i_part_stream(reader, segment, kind == SVO_TREE_LIST_BEGIN ? put_list_begins : put_bytes, &at));
    to->next += kind == SVO_TREE_LIST_BEGIN ? piece->list_count : 0;
    return SVO_OK;
}

static svo_status put_piece(svo_i_stitcher *s, const svo_i_piece *piece)
{
    svo_i_part_reader reader = {.file = -1};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_part_open(&s->all.header, piece->path, false, s->message, &reader));
    if (reader.content.head.head_hash != piece->head_hash) {
        status = svo_i_fail(s->message, SVO_UNAVAILABLE, "%s: another file than when stitching began", piece->path);
        goto cleanup;
    }
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        svo_i_filling *to = &s->fillings[i];
        if (!to->is_left_out && has_elements(s, to, piece->level, true)) {
            SVO_I_TRY_CLEANUP(put_segment(s, to, piece, &reader));
        }
    }
cleanup:
    svo_i_part_close(&reader);
    return status;
}

static svo_status put_uppers(svo_i_stitcher *s, uint32_t level, const svo_i_upper_node *upper)
{
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        svo_i_filling *to = &s->fillings[i];
        if (!to->is_left_out && has_elements(s, to, level, false)) {
            SVO_I_TRY(put_upper(s, to, upper));
        }
    }
    return SVO_OK;
}

/* Counts the bytes of a part, or of a node above, without taking them. */
static void pass_over(const svo_i_stitcher *s, uint32_t level, const svo_i_piece *piece)
{
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        svo_i_filling *to = &s->fillings[i];
        if (has_elements(s, to, level, piece != NULL)) {
            to->chunk->plain_bytes +=
                piece != NULL ? svo_i_chunks_segment_bytes(piece, (uint32_t)to->entry.buffer, to->entry.level - level)
                              : svo_i_tree_element_bytes(to->entry.buffer);
            to->next += piece != NULL && to->entry.buffer == SVO_TREE_LIST_BEGIN ? piece->list_count : 0;
        }
    }
}

static svo_status put_nodes(void *user, uint32_t level, const svo_i_upper_node *upper, const svo_i_piece *piece)
{
    svo_i_stitcher *s = user;
    svo_status status = SVO_OK;
    if (s->passed < s->first || s->passed >= s->end) {
        pass_over(s, level, piece);
    } else {
        status = piece != NULL ? put_piece(s, piece) : put_uppers(s, level, upper);
    }
    s->passed += piece != NULL ? 1u : 0u;
    return status;
}

svo_status svo_i_chunks_put_parts(svo_i_stitcher *s)
{
    s->passed = 0;
    return svo_i_pieces_visit_all(&s->all, put_nodes, s);
}

/* ---- what parts do not have ---- */

const void *svo_i_chunks_constant(const svo_part_header *header, const svo_tree_info *info, svo_tree_buffer array)
{
    static const unsigned char none[8] = {0};
    const void *value = array == SVO_TREE_COLORS    ? (const void *)header->constant_color
                        : array == SVO_TREE_NORMALS ? (const void *)header->constant_normal
                                                    : (const void *)&header->constant_material;
    return info->leaf_count > 0 ? value : none;
}

static svo_status put_constant(svo_i_stitcher *s, svo_i_filling *to)
{
    const svo_tree_buffer array = to->entry.buffer;
    return put(s, to, svo_i_chunks_constant(&s->all.header, &s->info, array), svo_i_tree_element_bytes(array));
}

static svo_status put_mesh(svo_i_stitcher *s, svo_i_filling *to)
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

static svo_status put_rest(svo_i_stitcher *s, svo_i_filling *to)
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

/* ---- all chunks ---- */

svo_tree_info svo_i_chunks_info(const svo_part_header *header)
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

uint32_t svo_i_chunks_place(const svo_tree_info *info, file_head *head, file_entry entries[FILE_CHUNKS_MAX])
{
    file_header *header = &head->header;
    const uint32_t count = svo_i_file_list_entries(info, FILE_VERSION, entries);
    svo_i_file_fill_header(header, info);
    header->chunk_count = count;
    header->header_bytes = (uint32_t)(sizeof *header + count * sizeof(file_chunk));
    header->file_bytes = header->header_bytes;
    for (uint32_t i = 0; i < count; ++i) {
        head->chunks[i] = (file_chunk){.kind = file_entry_kind(&entries[i]),
                                       .codec = FILE_CODEC_STORED,
                                       .offset = header->file_bytes,
                                       .stored_bytes = svo_i_file_entry_count(info, FILE_VERSION, &entries[i]) *
                                                       svo_i_tree_element_bytes(entries[i].buffer)};
        header->file_bytes += head->chunks[i].stored_bytes;
    }
    return count;
}

static svo_status alloc_fillings(svo_i_stitcher *s)
{
    s->memory = svo_i_alloc(NULL, s->filling_count * sizeof *s->fillings + STATE_ALIGNMENT);
    if (s->memory == NULL) {
        return svo_i_fail(s->message, SVO_OUT_OF_HOST_MEMORY, "svo_parts_stitch: no memory for %u chunks",
                          s->filling_count);
    }
    const uintptr_t aligned = ((uintptr_t)s->memory + STATE_ALIGNMENT - 1) / STATE_ALIGNMENT * STATE_ALIGNMENT;
    s->fillings = (svo_i_filling *)aligned;
    return SVO_OK;
}

svo_status svo_i_chunks_begin(svo_i_stitcher *s)
{
    file_entry entries[FILE_CHUNKS_MAX];
    s->info = svo_i_chunks_info(&s->all.header);
    SVO_I_TRY(svo_i_pieces_count(&s->all, &s->info));
    s->filling_count = svo_i_chunks_place(&s->info, &s->head, entries);
    SVO_I_TRY(alloc_fillings(s));
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        s->fillings[i].entry = entries[i];
        s->fillings[i].chunk = &s->head.chunks[i];
        s->fillings[i].is_left_out = false;
    }
    svo_i_chunks_restart(s);
    return SVO_OK;
}

void svo_i_chunks_restart(svo_i_stitcher *s)
{
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        svo_i_filling *to = &s->fillings[i];
        to->next = 0;
        to->chunk->plain_bytes = 0;
        XXH3_INITSTATE(&to->hash);
        XXH3_64bits_reset(&to->hash);
    }
}

svo_status svo_i_chunks_finish(svo_i_stitcher *s)
{
    const uint32_t *level_begin = s->info.level_begin;
    for (uint32_t i = 0; i < s->filling_count; ++i) {
        svo_i_filling *to = &s->fillings[i];
        const uint32_t level = to->entry.level;
        if (to->is_left_out) {
            continue;
        }
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

/* The head has the checksums, so it is written last. */
svo_status svo_i_chunks_put_head(svo_i_stitcher *s)
{
    file_header *header = &s->head.header;
    header->header_hash =
        XXH3_64bits((const uint8_t *)&s->head + FILE_HASH_BEGIN, header->header_bytes - FILE_HASH_BEGIN);
    const int error = svo_i_output_write_at(&s->output, 0, &s->head, header->header_bytes);
    return error == 0 ? SVO_OK : fail_errno(s, error);
}

void svo_i_chunks_free(svo_i_stitcher *s)
{
    svo_i_free(s->memory);
    svo_i_pieces_free(&s->all);
}
