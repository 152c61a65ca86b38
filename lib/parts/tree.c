/* SPDX-License-Identifier: MIT */
/*
 * A folder of parts as a tree: numbers of nodes over all parts, elements of arrays by these numbers, hash and check.
 */
#define _POSIX_C_SOURCE 200809L
#include "parts/tree.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/struct_size.h"
#include "shared/nodes.clh"

/* Bytes that are read or made at a time: whole elements of every array. */
#define WINDOW_BYTES ((size_t)3 << 18)

static svo_status no_memory(const svo_parts_tree *tree)
{
    return svo_i_fail(tree->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a tree of %zu parts",
                      tree->parts->folder, tree->all.piece_count);
}

/* ---- numbers ---- */

static uint64_t *row(const svo_parts_tree *tree, uint32_t level)
{
    return tree->before + level * (tree->all.piece_count + 1);
}

uint64_t svo_i_parts_tree_nodes(const svo_parts_tree *tree, uint32_t level)
{
    return row(tree, level)[tree->all.piece_count];
}

uint32_t svo_i_parts_tree_last_level(const svo_parts_tree *tree)
{
    uint64_t nodes = 0;
    uint32_t level = 0;
    const uint32_t depth = tree->all.header.depth;
    const uint32_t most = depth < SVO_DEPTH_MAX ? depth : SVO_DEPTH_MAX;
    while (level <= most && nodes + svo_i_parts_tree_nodes(tree, level) <= tree->nodes_max) {
        nodes += svo_i_parts_tree_nodes(tree, level++);
    }
    return level - 1;
}

static bool is_above(const svo_parts_tree *tree, size_t piece, uint32_t level)
{
    return tree->all.pieces[piece].level > level;
}

/* Nodes of a level in a part, or above it where it is the first below. */
static uint64_t count_at(const svo_parts_tree *tree, size_t i, uint32_t level)
{
    const svo_i_piece *piece = &tree->all.pieces[i];
    if (is_above(tree, i, level)) {
        return svo_i_pieces_begins_upper(&tree->all, i, level) ? 1 : 0;
    }
    return piece->level_begin[level - piece->level + 1] - piece->level_begin[level - piece->level];
}

static svo_status number_nodes(svo_parts_tree *tree)
{
    const size_t count = tree->all.piece_count;
    const uint32_t depth = tree->all.header.depth;
    tree->before = svo_i_alloc_zeroed(NULL, (count + 1) * (depth + 1), sizeof *tree->before);
    tree->list_before = svo_i_alloc_zeroed(NULL, count + 1, sizeof *tree->list_before);
    tree->checked = svo_i_alloc_zeroed(NULL, count + 1, TREE_CHECKED * sizeof *tree->checked);
    if (tree->before == NULL || tree->list_before == NULL || tree->checked == NULL) {
        return no_memory(tree);
    }
    for (uint32_t level = 0; level <= depth; ++level) {
        uint64_t *before = row(tree, level);
        for (size_t i = 0; i < count; ++i) {
            before[i + 1] = before[i] + count_at(tree, i, level);
        }
    }
    for (size_t i = 0; i < count; ++i) {
        tree->list_before[i + 1] = tree->list_before[i] + tree->all.pieces[i].list_count;
        tree->file_bytes += tree->all.pieces[i].file_bytes;
    }
    row(tree, 0)[count] = 1; /* the root is there even without parts */
    return SVO_OK;
}

/* The last entry of an ascending row that is at most a number below the row's last: that part has the element. */
static size_t find_piece(const uint64_t *before, size_t count, uint64_t number)
{
    size_t low = 0;
    size_t high = count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (before[middle] <= number) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* ---- opening ---- */

/* The folder of a path to it or to the file "plan" in it; released by svo_i_free. NULL when out of memory. */
static char *folder_of(const char *path)
{
    struct stat found;
    char *folder = svo_i_copy_text(NULL, path);
    const char *slash = strrchr(path, '/');
    if (folder == NULL || stat(path, &found) != 0 || S_ISDIR(found.st_mode)) {
        return folder;
    }
    if (strcmp(slash != NULL ? slash + 1 : path, "plan") == 0) {
        svo_i_free(folder);
        folder = svo_i_copy_text(NULL, slash == path ? "/" : slash != NULL ? path : ".");
        if (folder != NULL && slash != NULL && slash != path) {
            folder[slash - path] = '\0';
        }
    }
    return folder;
}

static svo_status open_folder(svo_parts_tree *tree, const char *path)
{
    char *folder = folder_of(path);
    if (folder == NULL) {
        return svo_i_fail(tree->message, SVO_OUT_OF_HOST_MEMORY, "%s: out of memory", path);
    }
    const svo_status status = svo_parts_open(folder, &tree->parts, tree->message);
    svo_i_free(folder);
    return status;
}

static svo_status open_parts(const char *function, svo_parts_tree *tree)
{
    SVO_I_TRY(svo_i_part_header_read(function, &tree->parts->header, tree->message, &tree->all.header));
    tree->all.message = tree->message;
    SVO_I_TRY(svo_i_parts_gather(tree->parts, &tree->files, tree->message));
    SVO_I_TRY(svo_i_pieces_read(&tree->all, (const char *const *)tree->files.paths, tree->files.count));
    return number_nodes(tree);
}

svo_status svo_i_parts_tree_open(const char *function, const char *folder, svo_parts_tree **out, svo_message *message)
{
    svo_parts_tree *tree = svo_i_alloc_zeroed(NULL, 1, sizeof *tree);
    if (tree == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: out of memory", function);
    }
    tree->message = message;
    tree->nodes_max = PIECES_NODES_MAX;
    for (size_t i = 0; i < TREE_READERS; ++i) {
        tree->readers[i].file = -1;
    }
    svo_status status = open_folder(tree, folder);
    if (status == SVO_OK) {
        status = svo_i_parts_tell_cause(tree->parts, open_parts(function, tree), message);
    }
    if (status == SVO_OK) {
        *out = tree;
    } else {
        svo_parts_tree_close(&tree);
    }
    return status;
}

svo_status svo_parts_tree_open(const char *folder, svo_parts_tree **out, svo_message *message)
{
    static const char function[] = "svo_parts_tree_open";
    return folder != NULL && out != NULL ? svo_i_parts_tree_open(function, folder, out, message)
                                         : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                                      folder == NULL ? "folder" : "out");
}

void svo_parts_tree_close(svo_parts_tree **tree)
{
    if (tree == NULL || *tree == NULL) {
        return;
    }
    svo_parts_tree *closed = *tree;
    for (size_t i = 0; i < TREE_READERS; ++i) {
        svo_i_part_close(&closed->readers[i]);
    }
    svo_i_pieces_free(&closed->all);
    svo_i_part_files_free(&closed->files);
    svo_parts_close(&closed->parts);
    svo_i_free(closed->before);
    svo_i_free(closed->list_before);
    svo_i_free(closed->checked);
    svo_i_free(closed);
    *tree = NULL;
}

/* ---- reading ---- */

/* The open file of a part. */
static svo_status open_piece(svo_parts_tree *tree, size_t i, const svo_i_part_reader **out)
{
    svo_i_part_reader *reader = &tree->readers[i % TREE_READERS];
    const svo_i_piece *piece = &tree->all.pieces[i];
    *out = reader;
    if (reader->file >= 0 && tree->reader_pieces[i % TREE_READERS] == i) {
        reader->message = tree->message;
        return SVO_OK;
    }
    svo_i_part_close(reader);
    tree->reader_pieces[i % TREE_READERS] = i;
    svo_status status = svo_i_part_open(&tree->all.header, piece->path, false, tree->message, reader);
    if (status == SVO_OK && reader->content.head.head_hash != piece->head_hash) {
        status =
            svo_i_fail(tree->message, SVO_UNAVAILABLE, "%s: another file than when the tree was opened", piece->path);
    }
    if (status != SVO_OK) {
        svo_i_part_close(reader);
    }
    return svo_i_parts_tell_cause(tree->parts, status, tree->message);
}

/* Compares the checksum of a segment when it is first asked for. */
static svo_status check_segment(svo_parts_tree *tree, size_t i, const svo_i_part_reader *reader,
                                const part_segment *segment)
{
    const size_t index = (size_t)(segment - reader->content.segments);
    uint64_t *word = &tree->checked[TREE_CHECKED * i + index / 64];
    const uint64_t bit = UINT64_C(1) << index % 64;
    if ((*word & bit) == 0) {
        SVO_I_TRY(svo_i_part_stream(reader, segment, NULL, NULL));
        *word |= bit;
    }
    return SVO_OK;
}

/* Reads bytes of an array of a part, from one of its own levels. */
static svo_status read_piece(svo_parts_tree *tree, size_t i, svo_tree_buffer array, uint32_t own_level, uint64_t offset,
                             size_t byte_count, void *out)
{
    const svo_i_part_reader *reader = NULL;
    SVO_I_TRY(open_piece(tree, i, &reader));
    const part_segment *segment = svo_i_part_find(reader, (uint32_t)array, own_level);
    if (segment == NULL ||
        segment->bytes != svo_i_chunks_segment_bytes(&tree->all.pieces[i], (uint32_t)array, own_level)) {
        return svo_i_part_damaged(reader, "an array is missing or has another length");
    }
    SVO_I_TRY(check_segment(tree, i, reader, segment));
    return svo_i_part_read(reader, segment->offset + offset, out, byte_count);
}

/* The node above the parts of a level that begins with a part; the root where there are no parts. */
static const svo_i_upper_node *find_upper(const svo_parts_tree *tree, size_t i, uint32_t level)
{
    const svo_i_pieces *all = &tree->all;
    size_t low = all->upper_begin[level];
    size_t high = all->upper_begin[level + 1];
    if (all->piece_count == 0) {
        return all->uppers;
    }
    const uint64_t code = all->pieces[i].code >> 3 * (all->pieces[i].level - level);
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (all->uppers[middle].code <= code) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return &all->uppers[low];
}

static svo_status read_nodes(svo_parts_tree *tree, svo_tree_buffer array, uint32_t level, uint64_t first,
                             uint64_t count, void *out)
{
    const size_t element_bytes = svo_i_tree_element_bytes(array);
    const bool is_list = array == SVO_TREE_LIST;
    const uint64_t *before = is_list ? tree->list_before : row(tree, level);
    char *to = out;
    while (count > 0) {
        const size_t i = find_piece(before, tree->all.piece_count, first);
        if (tree->all.piece_count == 0 || is_above(tree, i, level)) {
            memcpy(to, svo_i_chunks_upper(find_upper(tree, i, level), array), element_bytes);
            to += element_bytes;
            ++first;
            --count;
            continue;
        }
        const uint64_t there = before[i + 1] - first;
        const uint64_t taken = count < there ? count : there;
        SVO_I_TRY(read_piece(tree, i, array, level - tree->all.pieces[i].level, (first - before[i]) * element_bytes,
                             (size_t)taken * element_bytes, to));
        to += taken * element_bytes;
        first += taken;
        count -= taken;
    }
    return SVO_OK;
}

/* Where lists begin: a part has numbers of its own. */
static svo_status read_list_begins(svo_parts_tree *tree, uint64_t first, uint64_t count, uint64_t *out)
{
    uint32_t narrow[1024] = {0};
    const uint32_t depth = tree->all.header.depth;
    const uint64_t leaves = svo_i_parts_tree_nodes(tree, depth);
    const uint64_t *before = row(tree, depth);
    const uint64_t end = first + count > leaves ? leaves : first + count;
    const uint64_t most = sizeof narrow / sizeof *narrow;
    size_t i = first < end ? find_piece(before, tree->all.piece_count, first) : 0;
    for (uint64_t leaf = first; leaf < end;) {
        const uint64_t taken = end - leaf < most ? end - leaf : most;
        SVO_I_TRY(read_nodes(tree, SVO_TREE_LIST_BEGIN, depth, leaf, taken, narrow));
        for (uint64_t k = 0; k < taken; ++k, ++leaf) {
            while (leaf >= before[i + 1]) {
                ++i;
            }
            out[leaf - first] = tree->list_before[i] + narrow[k];
        }
    }
    if (first + count > leaves) {
        out[leaves - first] = tree->list_before[tree->all.piece_count];
    }
    return SVO_OK;
}

svo_status svo_i_parts_tree_read(svo_parts_tree *tree, svo_tree_buffer array, uint32_t level, uint64_t first,
                                 uint64_t count, void *out)
{
    return array == SVO_TREE_LIST_BEGIN ? read_list_begins(tree, first, count, out)
                                        : read_nodes(tree, array, level, first, count, out);
}

svo_status svo_i_parts_tree_read_mesh(svo_parts_tree *tree, svo_tree_buffer array, uint64_t array_bytes,
                                      uint64_t offset, size_t byte_count, void *out)
{
    svo_i_part_reader reader = {.file = -1};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_part_open(&tree->all.header, tree->files.mesh, true, tree->message, &reader));
    const part_segment *segment = svo_i_part_find(&reader, (uint32_t)array, 0);
    if (segment == NULL || segment->bytes != array_bytes) {
        status = svo_i_part_damaged(&reader, "an array of the mesh is missing or has another length");
        goto cleanup;
    }
    if (offset == 0) { /* an array is read from its begin on */
        SVO_I_TRY_CLEANUP(svo_i_part_stream(&reader, segment, NULL, NULL));
    }
    status = svo_i_part_read(&reader, segment->offset + offset, out, byte_count);
cleanup:
    svo_i_part_close(&reader);
    return status;
}

/* ---- children ---- */

/* The children of the first count nodes of a part's level. */
static svo_status count_children(svo_parts_tree *tree, size_t i, uint32_t own_level, uint64_t count, uint64_t *children)
{
    uint8_t masks[4096] = {0};
    for (uint64_t at = 0; at < count; at += sizeof masks) {
        const size_t taken = count - at < sizeof masks ? (size_t)(count - at) : sizeof masks;
        SVO_I_TRY(read_piece(tree, i, SVO_TREE_CHILD_MASK, own_level, at, taken, masks));
        for (size_t k = 0; k < taken; ++k) {
            *children += svo_count_bits(masks[k]);
        }
    }
    return SVO_OK;
}

/* The first child of a node, or of the first one after it that has children. */
static svo_status find_child(svo_parts_tree *tree, uint32_t level, uint64_t node, uint64_t *child)
{
    const uint64_t *before = row(tree, level);
    if (node == svo_i_parts_tree_nodes(tree, level)) {
        *child = svo_i_parts_tree_nodes(tree, level + 1);
        return SVO_OK;
    }
    const size_t i = find_piece(before, tree->all.piece_count, node);
    *child = row(tree, level + 1)[i];
    if (tree->all.piece_count == 0 || is_above(tree, i, level)) {
        return SVO_OK; /* its first child begins with the same part */
    }
    uint64_t children = 0;
    SVO_I_TRY(count_children(tree, i, level - tree->all.pieces[i].level, node - before[i], &children));
    *child += children;
    return *child <= row(tree, level + 1)[i + 1]
               ? SVO_OK
               : svo_i_fail(tree->message, SVO_FILE_DAMAGED, "%s: its child masks and its levels do not agree",
                            tree->all.pieces[i].path);
}

svo_status svo_i_parts_tree_children(svo_parts_tree *tree, uint32_t level, uint64_t *first, uint64_t *count)
{
    uint64_t end = 0;
    const uint64_t node = *first;
    SVO_I_TRY(find_child(tree, level, node + *count, &end));
    SVO_I_TRY(find_child(tree, level, node, first));
    *count = end - *first;
    return SVO_OK;
}

/* ---- what it holds ---- */

static svo_parts_tree_info info_of(const svo_parts_tree *tree)
{
    svo_parts_tree_info info = {.tree = svo_i_chunks_info(&tree->all.header),
                                .part_count = tree->all.piece_count,
                                .file_bytes = tree->file_bytes,
                                .list_count = tree->list_before[tree->all.piece_count],
                                .last_level = svo_i_parts_tree_last_level(tree)};
    const uint32_t depth = info.tree.depth;
    for (uint32_t level = 0; level <= depth; ++level) {
        info.level_nodes[level] = svo_i_parts_tree_nodes(tree, level);
        info.node_count += info.level_nodes[level];
    }
    info.leaf_count = info.level_nodes[depth];
    info.inner_count = info.node_count - info.leaf_count;
    for (size_t i = 0; i < tree->all.piece_count; ++i) {
        info.tree.fragments += tree->all.pieces[i].fragments;
    }
    return info;
}

svo_status svo_parts_tree_get_info(const svo_parts_tree *tree, svo_parts_tree_info *info, svo_message *message)
{
    static const char function[] = "svo_parts_tree_get_info";
    if (tree == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: tree is NULL", function);
    }
    const svo_parts_tree_info made = info_of(tree);
    return svo_i_struct_write(message, function, "info", &made, info,
                              SVO_I_STRUCT_SIZES(svo_parts_tree_info, last_level));
}

/* ---- the hash: svo_tree_hash of the stitched tree ---- */

typedef struct hashing {
    svo_parts_tree *tree;
    svo_parts_tree_info info;
    bool is_wide; /* numbers of nodes and places in lists have 64 bits */
    XXH3_state_t state;
    uint8_t *window; /* of WINDOW_BYTES, as what follows; owned */
    uint8_t *made;
} hashing;

/* Numbers as they are hashed. */
static void hash_numbers(hashing *h, const uint64_t *numbers, size_t count)
{
    uint32_t *narrow = (uint32_t *)(void *)h->made;
    if (h->is_wide) {
        XXH3_128bits_update(&h->state, numbers, count * sizeof *numbers);
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        narrow[i] = (uint32_t)numbers[i];
    }
    XXH3_128bits_update(&h->state, narrow, count * sizeof *narrow);
}

static void hash_length(hashing *h, uint64_t bytes)
{
    XXH3_128bits_update(&h->state, &bytes, sizeof bytes);
}

static uint64_t number_bytes(const hashing *h)
{
    return h->is_wide ? sizeof(uint64_t) : sizeof(uint32_t);
}

/* Child masks, or where their children begin: *next is the number of the first child that is left. */
static void hash_window(hashing *h, svo_tree_buffer array, size_t count, uint64_t *next)
{
    const svo_tree_buffer from = array == SVO_TREE_FIRST_CHILD ? SVO_TREE_CHILD_MASK : array;
    if (array == SVO_TREE_LIST_BEGIN) {
        hash_numbers(h, (const uint64_t *)(const void *)h->window, count);
    } else if (array != SVO_TREE_FIRST_CHILD) {
        XXH3_128bits_update(&h->state, h->window, count * svo_i_tree_element_bytes(from));
    } else {
        uint64_t numbers[512];
        for (size_t i = 0; i < count;) {
            size_t k = 0;
            for (; k < sizeof numbers / sizeof *numbers && i < count; ++k, ++i) {
                numbers[k] = *next;
                *next += svo_count_bits(h->window[i]);
            }
            hash_numbers(h, numbers, k);
        }
    }
}

/* Elements of an array of a level. */
static svo_status hash_level(hashing *h, svo_tree_buffer array, uint32_t level, uint64_t count, uint64_t *next)
{
    const svo_tree_buffer from = array == SVO_TREE_FIRST_CHILD ? SVO_TREE_CHILD_MASK : array;
    const size_t element_bytes = array == SVO_TREE_LIST_BEGIN ? sizeof(uint64_t) : svo_i_tree_element_bytes(from);
    const uint64_t most = WINDOW_BYTES / element_bytes;
    for (uint64_t first = 0; first < count; first += most) {
        const size_t taken = (size_t)(count - first < most ? count - first : most);
        SVO_I_TRY(svo_i_parts_tree_read(h->tree, from, level, first, taken, h->window));
        hash_window(h, array, taken, next);
    }
    return SVO_OK;
}

/* Payload that is the same in every node. */
static void hash_constant(hashing *h, svo_tree_buffer array, uint64_t count)
{
    const size_t element_bytes = svo_i_tree_element_bytes(array);
    const svo_tree_info leaves = {.leaf_count = h->info.leaf_count};
    const void *element = svo_i_chunks_constant(&h->tree->all.header, &leaves, array);
    const uint64_t most = WINDOW_BYTES / element_bytes;
    for (size_t i = 0; i < most && i < count; ++i) {
        memcpy(h->window + i * element_bytes, element, element_bytes);
    }
    for (; count > most; count -= most) {
        XXH3_128bits_update(&h->state, h->window, most * element_bytes);
    }
    XXH3_128bits_update(&h->state, h->window, (size_t)count * element_bytes);
}

/* An array's length and then its bytes, level after level. */
static svo_status hash_levels(hashing *h, svo_tree_buffer array, uint32_t first_level, uint32_t end_level,
                              uint64_t element_bytes)
{
    uint64_t count = 0;
    uint64_t next = 1;
    for (uint32_t level = first_level; level < end_level; ++level) {
        count += h->info.level_nodes[level];
    }
    hash_length(h, count * element_bytes);
    if (svo_i_tree_is_constant(&h->info.tree, array)) {
        hash_constant(h, array, count);
        return SVO_OK;
    }
    for (uint32_t level = first_level; level < end_level; ++level) {
        SVO_I_TRY(hash_level(h, array, level, h->info.level_nodes[level], &next));
    }
    return SVO_OK;
}

static svo_status hash_lists(hashing *h)
{
    const uint32_t depth = h->info.tree.depth;
    const bool has_lists = svo_i_tree_holds(&h->info.tree, SVO_TREE_LIST);
    const uint64_t begins = has_lists ? h->info.leaf_count + 1 : 0;
    const uint64_t entries = has_lists ? h->info.list_count : 0;
    hash_length(h, begins * number_bytes(h));
    SVO_I_TRY(hash_level(h, SVO_TREE_LIST_BEGIN, depth, begins, NULL));
    hash_length(h, entries * sizeof(uint32_t));
    return hash_level(h, SVO_TREE_LIST, depth, entries, NULL);
}

static svo_status hash_payload(hashing *h)
{
    static const svo_tree_buffer payload[] = {SVO_TREE_COLORS, SVO_TREE_NORMALS, SVO_TREE_MATERIALS, SVO_TREE_FILLS};
    const svo_tree_info *info = &h->info.tree;
    for (size_t i = 0; i < sizeof payload / sizeof payload[0]; ++i) {
        const uint32_t first = svo_i_tree_holds(info, payload[i]) ? info->payload_level : info->depth + 1;
        SVO_I_TRY(hash_levels(h, payload[i], first, info->depth + 1, svo_i_tree_element_bytes(payload[i])));
    }
    return svo_i_tree_holds(info, SVO_TREE_AREAS)
               ? hash_levels(h, SVO_TREE_AREAS, info->depth, info->depth + 1, svo_i_tree_element_bytes(SVO_TREE_AREAS))
               : SVO_OK;
}

static void hash_head(hashing *h)
{
    const svo_tree_info *info = &h->info.tree;
    const uint32_t words[3] = {info->depth, info->coverage, info->is_exact != 0 ? 0 : info->snap_bits};
    uint64_t begin[SVO_PARTS_LEVELS_MAX] = {0};
    for (uint32_t level = 0; level <= info->depth; ++level) {
        begin[level + 1] = begin[level] + h->info.level_nodes[level];
    }
    XXH3_128bits_update(&h->state, words, sizeof words);
    XXH3_128bits_update(&h->state, info->origin, sizeof info->origin);
    XXH3_128bits_update(&h->state, &info->edge, sizeof info->edge);
    hash_numbers(h, begin, info->depth + 2);
}

static svo_status hash_tree(hashing *h, svo_hash_scope scope)
{
    h->info = info_of(h->tree);
    h->is_wide = h->info.node_count > h->tree->nodes_max || h->info.list_count > h->tree->nodes_max;
    XXH3_INITSTATE(&h->state);
    XXH3_128bits_reset(&h->state);
    hash_head(h);
    SVO_I_TRY(hash_levels(h, SVO_TREE_CHILD_MASK, 0, h->info.tree.depth, 1));
    SVO_I_TRY(hash_levels(h, SVO_TREE_FIRST_CHILD, 0, h->info.tree.depth, number_bytes(h)));
    if (scope == SVO_HASH_ALL) {
        SVO_I_TRY(hash_lists(h));
        SVO_I_TRY(hash_payload(h));
    }
    return SVO_OK;
}

svo_status svo_parts_tree_hash(svo_parts_tree *tree, svo_hash_scope scope, char text[SVO_HASH_TEXT_BYTES],
                               svo_message *message)
{
    hashing h = {.tree = tree};
    if (tree == NULL || text == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_tree_hash: %s is NULL",
                          tree == NULL ? "tree" : "text");
    }
    tree->message = message;
    h.window = svo_i_alloc(NULL, WINDOW_BYTES);
    h.made = svo_i_alloc(NULL, WINDOW_BYTES);
    svo_status status = h.window != NULL && h.made != NULL ? hash_tree(&h, scope) : no_memory(tree);
    if (status == SVO_OK) {
        const XXH128_hash_t hash = XXH3_128bits_digest(&h.state);
        (void)snprintf(text, SVO_HASH_TEXT_BYTES, "%016llx%016llx", (unsigned long long)hash.high64,
                       (unsigned long long)hash.low64);
    }
    svo_i_free(h.window);
    svo_i_free(h.made);
    return status;
}

/* ---- the check ---- */

/* Child masks of a level, and what they say of the next one. */
typedef struct mask_check {
    uint64_t children;
    bool has_empty;
} mask_check;

static svo_status check_masks(void *user, const void *bytes, size_t byte_count)
{
    mask_check *check = user;
    const uint8_t *masks = bytes;
    for (size_t i = 0; i < byte_count; ++i) {
        check->children += svo_count_bits(masks[i]);
        check->has_empty = check->has_empty || masks[i] == 0;
    }
    return SVO_OK;
}

static svo_status check_piece(svo_parts_tree *tree, size_t i)
{
    const svo_i_piece *piece = &tree->all.pieces[i];
    const svo_i_part_reader *reader = NULL;
    SVO_I_TRY(open_piece(tree, i, &reader));
    for (uint32_t k = 0; k < reader->content.head.segment_count; ++k) {
        const part_segment *segment = &reader->content.segments[k];
        const bool is_masks = segment->kind == SVO_TREE_CHILD_MASK;
        if (segment->level > tree->all.header.depth - piece->level - (is_masks ? 1 : 0)) {
            return svo_i_part_damaged(reader, "an array is of a level that it has not");
        }
        mask_check check = {0, false};
        SVO_I_TRY(svo_i_part_stream(reader, segment, is_masks ? check_masks : NULL, &check));
        const uint32_t *begin = piece->level_begin + segment->level;
        if (is_masks &&
            (check.has_empty || segment->bytes != begin[1] - begin[0] || check.children != begin[2] - begin[1])) {
            return svo_i_part_damaged(reader, "its child masks and its levels do not agree");
        }
    }
    return SVO_OK;
}

svo_status svo_parts_tree_check(svo_parts_tree *tree, uint64_t count, uint64_t seed, uint64_t *checked,
                                svo_message *message)
{
    if (tree == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "svo_parts_tree_check: tree is NULL");
    }
    const uint64_t there = tree->all.piece_count;
    const uint64_t taken = count == 0 || count > there ? there : count;
    const uint64_t step = taken > 0 ? there / taken : 1;
    tree->message = message;
    for (uint64_t i = 0; i < taken; ++i) {
        SVO_I_TRY(check_piece(tree, (size_t)(i * there / taken + seed % step)));
    }
    if (checked != NULL) {
        *checked = taken;
    }
    return SVO_OK;
}
