/* SPDX-License-Identifier: MIT */
/*
 * Regions of a tree of parts as .svo files: on each level a region is a run of nodes, since nodes under one node follow
 * each other in Morton order. So its file has the same chunks as any, and the bytes of each are a piece of a level.
 */
#include "parts/view.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/struct_size.h"
#include "plan/plan.h"
#include "shared/nodes.clh"

/* Bytes that are read at a time: whole elements of every array. */
#define WINDOW_BYTES ((size_t)3 << 18)

/* ---- which nodes ---- */

static svo_status read_region(const char *function, const svo_parts_tree *tree, const svo_parts_region *given,
                              svo_parts_region *region)
{
    const uint32_t depth = tree->all.header.depth;
    SVO_I_TRY(svo_i_struct_read(tree->message, function, "region", given, region,
                                SVO_I_STRUCT_SIZES(svo_parts_region, voxels_max)));
    region->last_level = region->last_level == 0 ? depth : region->last_level;
    if (region->last_level > depth) {
        return svo_i_fail(tree->message, SVO_INVALID_ARGUMENT,
                          "%s: region.last_level %" PRIu32 " is not in 1 .. %" PRIu32 ", the depth of the tree",
                          function, region->last_level, depth);
    }
    if (region->level >= region->last_level || region->code >> 3 * region->level != 0) {
        return svo_i_fail(tree->message, SVO_INVALID_ARGUMENT,
                          "%s: region %" PRIu32 "-%" PRIx64 " is no node above level %" PRIu32, function, region->level,
                          region->code, region->last_level);
    }
    const uint32_t levels = region->last_level - region->level;
    return levels <= SVO_DEPTH_MAX
               ? SVO_OK
               : svo_i_fail(tree->message, SVO_CAPACITY_EXCEEDED,
                            "%s: from level %" PRIu32 " to level %" PRIu32 " are more than %d levels; down to level "
                            "%" PRIu32 " is possible, or the region of a node below",
                            function, region->level, region->last_level, SVO_DEPTH_MAX, region->level + SVO_DEPTH_MAX);
}

static svo_status no_node(const char *function, const svo_parts_tree *tree, const svo_parts_region *region)
{
    return svo_i_fail(tree->message, SVO_INVALID_ARGUMENT,
                      "%s: region %" PRIu32 "-%" PRIx64 ": the tree has no node there", function, region->level,
                      region->code);
}

/* The node of a region on its level. */
static svo_status find_root(const char *function, svo_parts_tree *tree, const svo_parts_region *region, uint64_t *node)
{
    *node = 0;
    for (uint32_t level = 0; level < region->level; ++level) {
        const uint32_t octant = (uint32_t)(region->code >> 3 * (region->level - level - 1)) & 7u;
        uint8_t mask = 0;
        uint64_t count = 1;
        SVO_I_TRY(svo_i_parts_tree_read(tree, SVO_TREE_CHILD_MASK, level, *node, 1, &mask));
        if ((mask >> octant & 1u) == 0) {
            return no_node(function, tree, region);
        }
        SVO_I_TRY(svo_i_parts_tree_children(tree, level, node, &count));
        if (count != svo_count_bits(mask)) {
            return svo_i_fail(tree->message, SVO_FILE_DAMAGED, "%s: child masks and levels do not agree",
                              tree->parts->folder);
        }
        for (uint32_t i = 0; i < octant; ++i) {
            *node += mask >> i & 1u;
        }
    }
    return SVO_OK;
}

/* Sets what the region's tree has of a level: its nodes. total: of the levels before. */
static svo_status add_level(svo_i_parts_view *view, const char *function, uint32_t own_level, uint64_t count,
                            uint64_t *total)
{
    *total += count;
    if (*total > view->tree->nodes_max) {
        return svo_i_fail(view->tree->message, SVO_CAPACITY_EXCEEDED,
                          "%s: down to level %" PRIu32 " are more than 2^32 - 2 nodes; down to level %" PRIu32
                          " is possible, or a smaller region",
                          function, view->level + own_level, view->level + own_level - 1);
    }
    view->info.level_begin[own_level + 1] = (uint32_t)*total;
    return SVO_OK;
}

static svo_status find_levels(svo_i_parts_view *view, const char *function, const svo_parts_region *region)
{
    uint64_t first = 0;
    uint64_t count = 1;
    uint64_t total = 0;
    SVO_I_TRY(find_root(function, view->tree, region, &first));
    for (uint32_t level = region->level; level <= region->last_level; ++level) {
        view->first[level - region->level] = first;
        SVO_I_TRY(add_level(view, function, level - region->level, count, &total));
        if (level < region->last_level && region->level == 0) {
            first = 0; /* whole levels, whose counts are known */
            count = svo_i_parts_tree_nodes(view->tree, level + 1);
        } else if (level < region->last_level) {
            SVO_I_TRY(svo_i_parts_tree_children(view->tree, level, &first, &count));
        }
    }
    svo_tree_info *info = &view->info;
    info->inner_count = info->level_begin[info->depth];
    info->node_count = info->level_begin[info->depth + 1];
    info->leaf_count = info->node_count - info->inner_count;
    return SVO_OK;
}

/* ---- its properties ---- */

/* The grid of a node, in as many units as plans choose for its depth. */
static void take_grid(svo_tree_info *info, const svo_parts_region *region)
{
    const double edge = ldexp(info->edge, -(int)region->level);
    const uint32_t snap_bits = svo_i_plan_snap_bits(info->depth);
    uint32_t cell[3];
    svo_deinterleave(region->code, cell);
    for (int axis = 0; axis < 3; ++axis) {
        info->origin[axis] += cell[axis] * edge;
    }
    info->scale = ldexp(info->scale, (int)(snap_bits + region->level) - (int)info->snap_bits);
    info->snap_bits = snap_bits;
    info->edge = edge;
}

static svo_status take_info(svo_i_parts_view *view, const char *function, const svo_parts_region *region)
{
    const svo_parts_tree *tree = view->tree;
    const svo_part_header *header = &tree->all.header;
    svo_tree_info *info = &view->info;
    *info = svo_i_chunks_info(header);
    if (region->level > 0 || region->last_level < header->depth) {
        svo_i_tree_keep_levels(info, region->last_level);
        info->depth = region->last_level - region->level;
        info->payload_level = info->payload_level > region->level ? info->payload_level - region->level : 0;
    } else {
        info->list_count = tree->list_before[tree->all.piece_count];
    }
    if (info->list_count > tree->nodes_max) {
        return svo_i_fail(tree->message, SVO_CAPACITY_EXCEEDED,
                          "%s: the leaf lists have %" PRIu64 " entries, above 2^32 - 2; down to level %" PRIu32
                          " is possible, which has none",
                          function, info->list_count, header->depth - 1);
    }
    for (size_t i = 0; i < tree->all.piece_count && region->level == 0; ++i) {
        info->fragments += tree->all.pieces[i].fragments;
    }
    if (region->level > 0 || header->depth > SVO_DEPTH_MAX) {
        take_grid(info, region);
    }
    return SVO_OK;
}

/* ---- bytes ---- */

static svo_status read_begins(svo_i_parts_view *view, uint64_t first, uint64_t count, uint32_t *out)
{
    uint64_t wide[512];
    const uint64_t most = sizeof wide / sizeof *wide;
    for (uint64_t at = 0; at < count; at += most) {
        const uint64_t taken = count - at < most ? count - at : most;
        SVO_I_TRY(svo_i_parts_tree_read(view->tree, SVO_TREE_LIST_BEGIN, view->info.depth, first + at, taken, wide));
        for (uint64_t i = 0; i < taken; ++i) {
            out[at + i] = (uint32_t)wide[i];
        }
    }
    return SVO_OK;
}

/* Elements of a chunk. */
static svo_status read_elements(svo_i_parts_view *view, uint32_t index, uint64_t first, uint64_t count, void *out)
{
    const file_entry *entry = &view->entries[index];
    const size_t element_bytes = svo_i_tree_element_bytes(entry->buffer);
    switch (entry->buffer) {
    case SVO_TREE_CHILD_MASK:
    case SVO_TREE_COLORS:
    case SVO_TREE_NORMALS:
    case SVO_TREE_MATERIALS:
    case SVO_TREE_FILLS:
    case SVO_TREE_AREAS:
        if (svo_i_tree_is_constant(&view->info, entry->buffer)) {
            memcpy(out, svo_i_chunks_constant(&view->tree->all.header, &view->info, entry->buffer), element_bytes);
            return SVO_OK;
        }
        return svo_i_parts_tree_read(view->tree, entry->buffer, view->level + entry->level,
                                     view->first[entry->level] + first, count, out);
    case SVO_TREE_LIST:
        return svo_i_parts_tree_read(view->tree, SVO_TREE_LIST, entry->level, first, count, out);
    case SVO_TREE_LIST_BEGIN:
        return read_begins(view, first, count, out);
    default:
        return svo_i_parts_tree_read_mesh(view->tree, entry->buffer, view->head.chunks[index].stored_bytes,
                                          first * element_bytes, (size_t)count * element_bytes, out);
    }
}

svo_status svo_i_parts_view_read(void *of, uint64_t offset, void *out, size_t byte_count)
{
    svo_i_parts_view *view = of;
    const file_header *header = &view->head.header;
    char *to = out;
    if (offset < header->header_bytes && byte_count > 0) {
        const size_t left = (size_t)(header->header_bytes - offset);
        const size_t taken = byte_count < left ? byte_count : left;
        memcpy(to, (const char *)&view->head + offset, taken);
        to += taken;
        offset += taken;
        byte_count -= taken;
    }
    for (uint32_t i = 0; i < header->chunk_count && byte_count > 0; ++i) {
        const file_chunk *chunk = &view->head.chunks[i];
        const size_t element_bytes = svo_i_tree_element_bytes(view->entries[i].buffer);
        if (offset >= chunk->offset + chunk->stored_bytes) {
            continue;
        }
        const uint64_t there = chunk->offset + chunk->stored_bytes - offset;
        const size_t taken = byte_count < there ? byte_count : (size_t)there;
        if ((offset - chunk->offset) % element_bytes != 0 || taken % element_bytes != 0) {
            return svo_i_fail(view->tree->message, SVO_INTERNAL, "%s: bytes %" PRIu64 " .. are no whole elements",
                              view->tree->parts->folder, offset);
        }
        SVO_I_TRY(read_elements(view, i, (offset - chunk->offset) / element_bytes, taken / element_bytes, to));
        to += taken;
        offset += taken;
        byte_count -= taken;
    }
    return SVO_OK;
}

svo_i_source svo_i_parts_view_source(svo_i_parts_view *view)
{
    return (svo_i_source){.name = view->tree->parts->folder,
                          .message = view->tree->message,
                          .file = -1,
                          .byte_count = view->head.header.file_bytes,
                          .read = svo_i_parts_view_read,
                          .of = view};
}

/* ---- the whole file ---- */

/* What is done with the bytes of a chunk. */
typedef bool (*byte_taker)(void *user, const void *bytes, size_t byte_count);

static svo_status read_chunk(svo_i_parts_view *view, uint32_t index, void *window, byte_taker take, void *user)
{
    const file_chunk *chunk = &view->head.chunks[index];
    for (uint64_t at = 0; at < chunk->stored_bytes; at += WINDOW_BYTES) {
        const uint64_t left = chunk->stored_bytes - at;
        const size_t taken = left < WINDOW_BYTES ? (size_t)left : WINDOW_BYTES;
        SVO_I_TRY(svo_i_parts_view_read(view, chunk->offset + at, window, taken));
        if (!take(user, window, taken)) {
            return svo_i_fail(view->tree->message, SVO_FILE_ERROR, "%s: %zu bytes at %" PRIu64 " could not be written",
                              view->tree->parts->folder, taken, chunk->offset + at);
        }
    }
    return SVO_OK;
}

static bool take_hash(void *state, const void *bytes, size_t byte_count)
{
    XXH3_64bits_update(state, bytes, byte_count);
    return true;
}

static svo_status no_memory(const svo_parts_tree *tree)
{
    return svo_i_fail(tree->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a window", tree->parts->folder);
}

/* The checksums of chunks, and that of the head. */
static svo_status find_checksums(svo_i_parts_view *view)
{
    XXH3_state_t state;
    file_head *head = &view->head;
    svo_status status = SVO_OK;
    void *window = svo_i_alloc(NULL, WINDOW_BYTES);
    if (window == NULL) {
        return no_memory(view->tree);
    }
    for (uint32_t i = 0; i < head->header.chunk_count; ++i) {
        XXH3_INITSTATE(&state);
        XXH3_64bits_reset(&state);
        SVO_I_TRY_CLEANUP(read_chunk(view, i, window, take_hash, &state));
        head->chunks[i].plain_bytes = head->chunks[i].stored_bytes;
        head->chunks[i].hash = XXH3_64bits_digest(&state);
    }
    head->header.header_hash =
        XXH3_64bits((const char *)head + FILE_HASH_BEGIN, head->header.header_bytes - FILE_HASH_BEGIN);
cleanup:
    svo_i_free(window);
    return status;
}

svo_status svo_i_parts_view_open(const char *function, svo_parts_tree *tree, const svo_parts_region *region,
                                 svo_i_parts_view *view)
{
    svo_parts_region asked;
    SVO_I_TRY(read_region(function, tree, region, &asked));
    *view = (svo_i_parts_view){.tree = tree, .level = asked.level};
    SVO_I_TRY(take_info(view, function, &asked));
    SVO_I_TRY(find_levels(view, function, &asked));
    (void)svo_i_chunks_place(&view->info, &view->head, view->entries);
    return find_checksums(view);
}

/* ---- loading and saving ---- */

static svo_status open_view(const char *function, svo_parts_tree *tree, const svo_parts_region *region,
                            svo_message *message, svo_i_parts_view *view)
{
    if (tree == NULL) {
        (void)svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: tree is NULL", function);
        return SVO_INVALID_ARGUMENT;
    }
    tree->message = message;
    return svo_i_parts_view_open(function, tree, region, view);
}

svo_status svo_parts_tree_load(svo_parts_tree *tree, const svo_parts_region *region, svo_tree **out,
                               svo_message *message)
{
    static const char function[] = "svo_parts_tree_load";
    svo_i_parts_view view = {.tree = tree};
    if (out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: out is NULL", function);
    }
    SVO_I_TRY(open_view(function, tree, region, message, &view));
    svo_i_file_load load = {.source = svo_i_parts_view_source(&view),
                            .voxels_max = region != NULL ? region->voxels_max : 0};
    return svo_i_tree_file_load(&load, out);
}

static bool take_bytes(void *sink, const void *bytes, size_t byte_count)
{
    return svo_i_sink_write(sink, bytes, byte_count);
}

static svo_status write_view(svo_i_parts_view *view, svo_i_sink *sink)
{
    const file_header *header = &view->head.header;
    svo_status status = SVO_OK;
    void *window = svo_i_alloc(NULL, WINDOW_BYTES);
    if (window == NULL) {
        return no_memory(view->tree);
    }
    if (!svo_i_sink_write(sink, &view->head, header->header_bytes)) {
        status = svo_i_fail(sink->message, SVO_FILE_ERROR, "%s: cannot be written", sink->name);
        goto cleanup;
    }
    for (uint32_t i = 0; i < header->chunk_count; ++i) {
        SVO_I_TRY_CLEANUP(read_chunk(view, i, window, take_bytes, sink));
    }
cleanup:
    svo_i_free(window);
    return status;
}

svo_status svo_parts_tree_save(svo_parts_tree *tree, const svo_parts_region *region, svo_sink sink, svo_tree_info *info,
                               svo_message *message)
{
    static const char function[] = "svo_parts_tree_save";
    svo_i_parts_view view = {.tree = tree};
    svo_i_sink opened;
    SVO_I_TRY(open_view(function, tree, region, message, &view));
    SVO_I_TRY(svo_i_sink_open(function, sink, message, &opened));
    SVO_I_TRY(svo_i_sink_close(&opened, write_view(&view, &opened)));
    return info == NULL ? SVO_OK
                        : svo_i_struct_write(message, function, "info", &view.info, info,
                                             SVO_I_STRUCT_SIZES(svo_tree_info, ray_bytes));
}
