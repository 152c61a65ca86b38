/* SPDX-License-Identifier: MIT */
/*
 * Built trees to .svo files, and from those of every version: whole, or their upper levels alone. file_chunks.c writes
 * and reads the header and the chunks, and file_check.c verifies the structure of the finished arrays.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "core/compact.h"
#include "core/message.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "io/file_format.h"
#include "shared/nodes.clh"
#include "svocl/plan.h"

/*
 * ---- chunks ----
 *
 * An array each up to version 2; since version 3 an array of one level, the levels in order.
 */

/* The levels that an array has elements of. A constant has one element, and it stands with its first level. */
static void find_levels(const svo_tree_info *info, svo_tree_buffer buffer, uint32_t *first, uint32_t *last)
{
    switch (buffer) {
    case SVO_TREE_CHILD_MASK:
        *first = 0;
        *last = info->depth - 1;
        break;
    case SVO_TREE_COLORS:
    case SVO_TREE_NORMALS:
    case SVO_TREE_MATERIALS:
    case SVO_TREE_FILLS:
        *first = info->payload_level;
        *last = svo_i_tree_is_constant(info, buffer) ? info->payload_level : info->depth;
        break;
    default:
        *first = *last = info->depth;
        break;
    }
}

static bool is_in_file(const svo_tree_info *info, uint32_t version, svo_tree_buffer buffer)
{
    return svo_i_tree_holds(info, buffer) && (buffer != SVO_TREE_FIRST_CHILD || version < FILE_BY_LEVELS);
}

uint32_t svo_i_file_list_entries(const svo_tree_info *info, uint32_t version, file_entry entries[FILE_CHUNKS_MAX])
{
    const uint32_t last_level = version < FILE_BY_LEVELS ? 0 : info->depth;
    uint32_t count = 0;
    for (uint32_t level = 0; level <= last_level; ++level) {
        for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
            const svo_tree_buffer buffer = (svo_tree_buffer)i;
            uint32_t first = 0, last = 0;
            if (version >= FILE_BY_LEVELS) {
                find_levels(info, buffer, &first, &last);
            }
            if (is_in_file(info, version, buffer) && level >= first && level <= last) {
                entries[count++] = (file_entry){buffer, level};
            }
        }
    }
    return count;
}

/* Nodes before a level, in an array whose first element is the first node of another level. */
static uint64_t nodes_before(const svo_tree_info *info, uint32_t level, uint32_t first_level)
{
    return info->level_begin[level] - info->level_begin[first_level];
}

/* Whether the array is in pieces, so that an entry is one level of it. */
static bool is_divided(const svo_tree_info *info, uint32_t version, svo_tree_buffer buffer, uint32_t *first)
{
    uint32_t last = 0;
    find_levels(info, buffer, first, &last);
    return version >= FILE_BY_LEVELS && last > *first;
}

/* The first of an entry's elements in the tree's array. */
static uint64_t entry_begin(const svo_tree_info *info, uint32_t version, const file_entry *entry)
{
    uint32_t first = 0;
    return is_divided(info, version, entry->buffer, &first) ? nodes_before(info, entry->level, first) : 0;
}

uint64_t svo_i_file_entry_count(const svo_tree_info *info, uint32_t version, const file_entry *entry)
{
    uint32_t first = 0;
    return is_divided(info, version, entry->buffer, &first) ? nodes_before(info, entry->level + 1, entry->level)
                                                            : svo_i_tree_element_count(info, entry->buffer);
}

/* ---- saving ---- */

void svo_i_file_fill_header(file_header *header, const svo_tree_info *info)
{
    memcpy(header->magic, FILE_MAGIC, FILE_MAGIC_BYTES);
    header->version = info->is_exact != 0 ? FILE_VERSION : FILE_EXACT - 1;
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
    header->triangles = info->triangles;
    header->refused_triangles = info->refused_triangles;
    header->fragments = info->fragments;
    memcpy(header->level_begin, info->level_begin, (info->depth + 2) * sizeof header->level_begin[0]);
}

/* The header and the arrays of a tree. */
static void fill(const svo_tree *tree, svo_i_file_save *state)
{
    state->memory = &tree->memory;
    svo_i_file_fill_header(&state->head.header, &tree->info);
    file_entry entries[FILE_CHUNKS_MAX];
    state->array_count = svo_i_file_list_entries(&tree->info, FILE_VERSION, entries);
    for (uint32_t i = 0; i < state->array_count; ++i) {
        const file_entry *entry = &entries[i];
        const size_t element_bytes = svo_i_tree_element_bytes(entry->buffer);
        const uint8_t *array = tree->host[entry->buffer];
        const uint64_t begin = entry_begin(&tree->info, FILE_VERSION, entry);
        state->arrays[i] =
            (svo_i_file_array){.kind = file_entry_kind(entry),
                               .name = svo_name(SVO_NAME_TREE_BUFFER, entry->buffer),
                               .plain = array != NULL ? array + begin * element_bytes : NULL,
                               .bytes = svo_i_file_entry_count(&tree->info, FILE_VERSION, entry) * element_bytes};
    }
}

svo_status svo_tree_save(const svo_tree *tree, svo_sink sink, const svo_save_options *options, svo_message *message)
{
    static const char function[] = "svo_tree_save";
    svo_save_options asked;
    svo_i_file_save state = {.array_count = 0};
    if (tree == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: tree is NULL", function);
    }
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
    fill(tree, &state);
    state.compress = asked.compress != 0;
    return svo_i_file_write(&state, function, sink, message);
}

/* ---- reading ---- */

static void fill_info(svo_tree_info *info, const file_header *header)
{
    info->depth = header->depth;
    info->snap_bits = header->snap_bits;
    info->coverage = header->coverage;
    info->need = header->need;
    info->constant = header->constant;
    info->weights = header->weights;
    info->payload_level = header->payload_level;
    memcpy(info->origin, header->origin, sizeof info->origin);
    info->edge = header->edge;
    info->scale = header->scale;
    info->is_exact = header->version >= FILE_EXACT ? 1 : 0;
    info->triangles = header->triangles;
    info->refused_triangles = header->refused_triangles;
    info->fragments = header->fragments;
    memcpy(info->level_begin, header->level_begin, sizeof info->level_begin);
    info->inner_count = header->level_begin[header->depth];
    info->node_count = header->level_begin[header->depth + 1];
    info->leaf_count = info->node_count - info->inner_count;
}

/* The mesh's positions are there as floats, as doubles, or, in version 1 and in what was made of its files, not at
   all. */
static uint32_t find_positions(const file_head *head)
{
    const bool has_rays = (head->header.need & SVO_NEED_RAYS) != 0 && head->header.coverage != SVO_COVERAGE_THIN;
    for (uint32_t i = 0; i < head->header.chunk_count && head->header.version > 1 && has_rays; ++i) {
        const uint32_t array = head->chunks[i].kind & ((1u << FILE_KIND_BITS) - 1);
        if (array == SVO_TREE_POSITIONS) {
            return SVO_POSITIONS_FLOAT;
        }
        if (array == SVO_TREE_POSITIONS_DOUBLE) {
            return SVO_POSITIONS_DOUBLE;
        }
    }
    return SVO_POSITIONS_ROUNDED;
}

/* Three counts are not in the header but follow from their chunk's length. */
static uint64_t *count_from_length(svo_tree_info *info, svo_tree_buffer kind)
{
    switch (kind) {
    case SVO_TREE_LIST:
        return &info->list_count;
    case SVO_TREE_VERTICES:
        return &info->vertex_count;
    case SVO_TREE_INDICES:
        return &info->list_triangle_count;
    default:
        return NULL;
    }
}

svo_i_entry_name svo_i_tree_file_name(const svo_i_tree_file *file, uint32_t chunk_index)
{
    const file_entry *entry = &file->entries[chunk_index];
    svo_i_entry_name name;
    const char *array = svo_name(SVO_NAME_TREE_BUFFER, entry->buffer);
    if (file->load->head.header.version < FILE_BY_LEVELS) {
        (void)snprintf(name.text, sizeof name.text, "%s", array);
    } else {
        (void)snprintf(name.text, sizeof name.text, "%s of level %" PRIu32, array, entry->level);
    }
    return name;
}

static svo_status check_entry(svo_i_tree_file *file, uint32_t chunk_index, uint64_t offset)
{
    const svo_i_file_load *load = file->load;
    const file_entry *entry = &file->entries[chunk_index];
    const svo_i_entry_name name = svo_i_tree_file_name(file, chunk_index);
    if (chunk_index == load->head.header.chunk_count) {
        return svo_i_file_damaged(load, "chunk %s is missing", name.text);
    }
    const file_chunk *chunk = &load->head.chunks[chunk_index];
    const uint32_t kind = file_entry_kind(entry);
    if (chunk->kind != kind) {
        return svo_i_file_damaged(load, "chunk %" PRIu32 ": kind is 0x%" PRIx32 ", 0x%" PRIx32 " (%s) expected",
                                  chunk_index, chunk->kind, kind, name.text);
    }
    SVO_I_TRY(svo_i_file_check_place(load, chunk, name.text, offset));
    const uint64_t element_bytes = svo_i_tree_element_bytes(entry->buffer);
    uint64_t *count = count_from_length(&file->info, entry->buffer);
    if (count != NULL) {
        *count = chunk->plain_bytes / element_bytes;
    }
    const uint64_t element_count = svo_i_file_entry_count(&file->info, load->head.header.version, entry);
    return chunk->plain_bytes == element_count * element_bytes && element_count <= UINT32_MAX
               ? SVO_OK
               : svo_i_file_damaged(load, "chunk %s: %" PRIu64 " bytes are not %" PRIu64 " elements of %" PRIu64,
                                    name.text, chunk->plain_bytes, element_count, element_bytes);
}

/* Checks all chunks of the table, also those that are not going to be read. */
static svo_status check_entries(svo_i_tree_file *file)
{
    const svo_i_file_load *load = file->load;
    const uint32_t entry_count = svo_i_file_list_entries(&file->info, load->head.header.version, file->entries);
    uint64_t offset = load->head.header.header_bytes;
    for (uint32_t i = 0; i < entry_count; ++i) {
        SVO_I_TRY(check_entry(file, i, offset));
        offset += load->head.chunks[i].stored_bytes;
    }
    return svo_i_file_check_end(load, entry_count, offset);
}

static svo_status read_entry(const svo_i_tree_file *file, uint32_t chunk_index, svo_tree *tree)
{
    const svo_i_file_load *load = file->load;
    const file_entry *entry = &file->entries[chunk_index];
    const svo_i_entry_name name = svo_i_tree_file_name(file, chunk_index);
    const size_t element_bytes = svo_i_tree_element_bytes(entry->buffer);
    const uint64_t array_bytes = svo_i_tree_element_count(&tree->info, entry->buffer) * element_bytes;
    void **array = &tree->host[entry->buffer];
    if (*array == NULL && array_bytes > 0) {
        *array = array_bytes <= SIZE_MAX ? svo_i_alloc(&load->host_memory, (size_t)array_bytes) : NULL;
        if (*array == NULL) {
            return svo_i_file_no_memory(load, name.text, array_bytes);
        }
    }
    const uint64_t begin = entry_begin(&tree->info, load->head.header.version, entry);
    uint8_t *plain = *array != NULL ? (uint8_t *)*array + begin * element_bytes : NULL;
    return svo_i_file_read_chunk(load, &load->head.chunks[chunk_index], name.text, plain);
}

/* Child masks say where children begin; files say it too up to version 2. */
static svo_status number_children(const svo_i_file_load *load, svo_tree *tree)
{
    const uint8_t *child_mask = tree->host[SVO_TREE_CHILD_MASK];
    const uint64_t bytes = tree->info.inner_count * sizeof(uint32_t);
    uint32_t *first_child = bytes <= SIZE_MAX ? svo_i_alloc(&load->host_memory, (size_t)bytes) : NULL;
    if (first_child == NULL) {
        return svo_i_file_no_memory(load, svo_name(SVO_NAME_TREE_BUFFER, SVO_TREE_FIRST_CHILD), bytes);
    }
    uint32_t next_child = 1;
    for (uint64_t node = 0; node < tree->info.inner_count; ++node) {
        first_child[node] = next_child;
        next_child += svo_count_bits(child_mask[node]);
    }
    tree->host[SVO_TREE_FIRST_CHILD] = first_child;
    return SVO_OK;
}

/* Reads those of the file's arrays that the tree, all of the file's or its upper levels, holds. */
static svo_status read_entries(const svo_i_tree_file *file, svo_tree *tree)
{
    const svo_i_file_load *load = file->load;
    for (uint32_t i = 0; i < load->head.header.chunk_count; ++i) {
        const file_entry *entry = &file->entries[i];
        const bool above = entry->level < tree->info.depth ||
                           (entry->level == tree->info.depth && entry->buffer != SVO_TREE_CHILD_MASK);
        if (svo_i_tree_holds(&tree->info, entry->buffer) && above) {
            SVO_I_TRY(read_entry(file, i, tree));
        }
    }
    return tree->host[SVO_TREE_FIRST_CHILD] == NULL ? number_children(load, tree) : SVO_OK;
}

static svo_status repeat_constants(const svo_i_file_load *load, svo_tree *tree)
{
    for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const svo_tree_buffer buffer = (svo_tree_buffer)i;
        if (tree->host[i] != NULL && !svo_i_tree_repeat(tree, buffer, &tree->host[i])) {
            return svo_i_file_no_memory(load, svo_name(SVO_NAME_TREE_BUFFER, buffer),
                                        tree->info.node_count * svo_i_tree_element_bytes(buffer));
        }
    }
    return SVO_OK;
}

/* ---- upper levels ---- */

void svo_i_tree_keep_levels(svo_tree_info *info, uint32_t last_level)
{
    const uint32_t kept = info->payload_level <= last_level ? info->need & SVO_I_PAYLOAD_NEEDS : 0;
    info->depth = last_level;
    info->need = kept;
    info->constant &= kept;
    info->payload_level = kept != 0 ? info->payload_level : 0;
    info->positions = SVO_POSITIONS_ROUNDED;
    info->list_count = info->vertex_count = info->list_triangle_count = 0;
    info->inner_count = info->level_begin[last_level];
    info->node_count = info->level_begin[last_level + 1];
    info->leaf_count = info->node_count - info->inner_count;
    for (uint32_t i = last_level + 2; i < SVO_LEVELS_MAX; ++i) {
        info->level_begin[i] = 0;
    }
}

/* Shortens the arrays of a whole tree to those of its upper levels: nodes lie level after level. */
static void shorten(svo_tree *tree, uint32_t last_level)
{
    svo_i_tree_keep_levels(&tree->info, last_level);
    for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const svo_tree_buffer buffer = (svo_tree_buffer)i;
        const bool holds = svo_i_tree_holds(&tree->info, buffer);
        const size_t bytes =
            holds ? (size_t)svo_i_tree_element_count(&tree->info, buffer) * svo_i_tree_element_bytes(buffer) : 0;
        void *shorter = bytes > 0 ? svo_i_grow(&tree->memory, tree->host[i], bytes) : NULL;
        if (bytes == 0) {
            svo_i_free(tree->host[i]);
        }
        if (bytes == 0 || shorter != NULL) {
            tree->host[i] = shorter;
        }
    }
}

/* ---- loading ---- */

/* Bytes of all arrays on the host. */
static uint64_t count_bytes(const svo_tree_info *info)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const svo_tree_buffer buffer = (svo_tree_buffer)i;
        const uint64_t count =
            svo_i_tree_is_constant(info, buffer) ? info->node_count : svo_i_tree_element_count(info, buffer);
        bytes += svo_i_tree_holds(info, buffer) ? count * svo_i_tree_element_bytes(buffer) : 0;
    }
    return bytes;
}

/* last_level: 0 for all of them. */
static svo_status load_tree(svo_i_tree_file *file, uint32_t last_level, svo_tree *tree)
{
    const svo_i_file_load *load = file->load;
    const bool by_levels = load->head.header.version >= FILE_BY_LEVELS;
    tree->info = file->info;
    if (last_level != 0 && by_levels) {
        svo_i_tree_keep_levels(&tree->info, last_level);
    }
    SVO_I_TRY(svo_i_file_limit(load, tree->info.node_count, count_bytes(&tree->info)));
    SVO_I_TRY(read_entries(file, tree));
    if (last_level != 0 && !by_levels) {
        shorten(tree, last_level);
    }
    SVO_I_TRY(repeat_constants(load, tree));
    tree->downloaded = true;
    return svo_i_file_check_structure(tree, load->source.name, load->source.message);
}

svo_status svo_i_tree_file_read_head(svo_i_tree_file *file)
{
    static const svo_i_file_kind kind = {".svo", FILE_MAGIC, FILE_OLDEST, FILE_VERSION, FILE_CHUNKS_MAX};
    SVO_I_TRY(svo_i_file_read_head(file->load, &kind));
    fill_info(&file->info, &file->load->head.header);
    file->info.positions = find_positions(&file->load->head);
    return check_entries(file);
}

svo_status svo_i_tree_file_load(svo_i_file_load *state, svo_tree **out)
{
    svo_i_tree_file file = {.load = state};
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_tree_file_read_head(&file));
    const uint32_t depth = file.info.depth;
    if (state->last_level > depth) {
        return svo_i_fail(state->source.message, SVO_INVALID_ARGUMENT,
                          "svo_tree_load: options.last_level %" PRIu32 " is not in 1 .. %" PRIu32 ", the depth of %s",
                          state->last_level, depth, state->source.name);
    }
    svo_tree *tree = svo_i_tree_new(&state->host_memory);
    if (tree == NULL) {
        return svo_i_fail(state->source.message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the tree",
                          state->source.name);
    }
    SVO_I_TRY_CLEANUP(load_tree(&file, state->last_level == depth ? 0 : state->last_level, tree));
    *out = tree;
    tree = NULL;
cleanup:
    svo_tree_destroy(&tree);
    return status;
}

svo_status svo_tree_load(svo_source source, const svo_load_options *options, svo_tree **out, svo_message *message)
{
    svo_i_file_load state = {.voxels_max = 0};
    if (out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_tree_load: out is NULL");
    }
    SVO_I_TRY(svo_i_file_load_open("svo_tree_load", source, options, message, &state));
    const svo_status status = svo_i_tree_file_load(&state, out);
    svo_i_source_close(&state.source);
    return status;
}
