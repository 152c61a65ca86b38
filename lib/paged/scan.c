/* SPDX-License-Identifier: MIT */
/*
 * The pages of a file. A first and only reading of the whole file, level after level, keeps the top levels alone. What
 * is under a root is one piece of each level, since levels are in Morton order; where the pieces are follows from the
 * child masks of the level above. A page gets a checksum over its pieces in the order of the file, beside the checksums
 * of the file, which cover whole levels.
 */
#include <inttypes.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "paged/paged.h"
#include "shared/nodes.clh"
#include "svocl/plan.h"

/* Pages are read together up to this length. No page has more of a level: 8^5 elements of 6 bytes. */
#define WINDOW_BYTES ((size_t)1 << 20)

/* ---- which nodes a page has, and where the file has them ---- */

svo_tree_buffer svo_i_paged_buffer(paged_array array)
{
    static const svo_tree_buffer buffers[PAGED_ARRAYS] = {SVO_TREE_CHILD_MASK, SVO_TREE_COLORS, SVO_TREE_NORMALS};
    return buffers[array];
}

size_t svo_i_paged_element_bytes(paged_array array)
{
    return svo_i_tree_element_bytes(svo_i_paged_buffer(array));
}

uint32_t svo_i_paged_last_level(const svo_paged *paged, const paged_band *band)
{
    return band->root_level + paged->layout.page_levels;
}

uint32_t svo_i_paged_count(const paged_band *band, uint32_t index, uint32_t level)
{
    const uint32_t *first = band->first[level - band->root_level];
    return first[index + 1] - first[index];
}

const paged_band *svo_i_paged_band(const svo_paged *paged, uint32_t page, uint32_t *index)
{
    const paged_band *band = paged->bands;
    while (page - band->first_page >= band->page_count) {
        ++band;
    }
    *index = page - band->first_page;
    return band;
}

void svo_i_paged_size(const svo_paged *paged, uint32_t page, uint32_t *inner_count, uint32_t *leaf_count)
{
    uint32_t index = 0;
    const paged_band *band = svo_i_paged_band(paged, page, &index);
    const uint32_t last_level = svo_i_paged_last_level(paged, band);
    *inner_count = *leaf_count = 0;
    for (uint32_t level = band->root_level + 1; level <= last_level; ++level) {
        *(level < paged->file.info.depth ? inner_count : leaf_count) += svo_i_paged_count(band, index, level);
    }
}

const file_chunk *svo_i_paged_chunk(const svo_paged *paged, paged_array array, uint32_t level, uint32_t *index)
{
    for (uint32_t i = 0; i < paged->load.head.header.chunk_count; ++i) {
        const file_entry *entry = &paged->file.entries[i];
        if (entry->buffer == svo_i_paged_buffer(array) && entry->level == level) {
            *index = i;
            return &paged->load.head.chunks[i];
        }
    }
    return NULL;
}

uint64_t svo_i_paged_hash(uint64_t hash, const void *bytes, size_t byte_count)
{
    return XXH3_64bits_withSeed(bytes, byte_count, hash);
}

/* ---- children ---- */

/* Counts children, node after node, into the first nodes of pages on the next level. */
typedef struct child_count {
    const svo_paged *paged;
    uint32_t level; /* of the parents */
    uint64_t node; /* the next parent, counted from the begin of its level */
    uint64_t children; /* of all before it */
} child_count;

static svo_status count_children(child_count *count, const uint8_t *masks, uint64_t node_count)
{
    const svo_paged *paged = count->paged;
    const uint32_t *level_begin = paged->file.info.level_begin;
    const bool may_be_empty = paged->file.info.leaf_count == 0 && count->level == 0;
    for (uint64_t i = 0; i < node_count; ++i, ++count->node) {
        if (masks[i] == 0 && !may_be_empty) {
            return svo_i_file_damaged(&paged->load, "node %" PRIu64 " of level %" PRIu32 " is empty", count->node,
                                      count->level);
        }
        count->children += svo_count_bits(masks[i]);
    }
    const uint64_t there = level_begin[count->level + 2] - level_begin[count->level + 1];
    const bool is_last = count->node == level_begin[count->level + 1] - level_begin[count->level];
    return count->children > there || (is_last && count->children < there)
               ? svo_i_file_damaged(&paged->load,
                                    "level %" PRIu32 " has %" PRIu64 " nodes, the masks above say %" PRIu64,
                                    count->level + 1, there, count->children)
               : SVO_OK;
}

/* The children of a level's nodes that are roots: where the pages of the next band begin on their first level. */
static svo_status count_under_roots(child_count *count, const uint8_t *masks, uint64_t node_count, uint32_t *first)
{
    for (uint64_t i = 0; i < node_count; ++i) {
        SVO_I_TRY(count_children(count, masks + i, 1));
        first[count->node] = (uint32_t)count->children;
    }
    return SVO_OK;
}

/* ---- the top levels ---- */

static svo_status no_memory(const svo_paged *paged)
{
    return svo_i_fail(paged->load.source.message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for what is held of the file",
                      paged->path);
}

static svo_status read_level(svo_paged *paged, paged_array array, uint32_t level, uint8_t *to)
{
    uint32_t index = 0;
    const file_chunk *chunk = svo_i_paged_chunk(paged, array, level, &index);
    paged->open_read_bytes += chunk->stored_bytes;
    return svo_i_file_read_chunk(&paged->load, chunk, svo_i_tree_file_name(&paged->file, index).text, to);
}

/* One array: of all top levels, or, of payload that is the same in every node, its only element. */
static svo_status read_top_array(svo_paged *paged, paged_array array, paged_top *top)
{
    const svo_tree_info *info = &paged->file.info;
    const paged_layout *layout = &paged->layout;
    const size_t element_bytes = svo_i_paged_element_bytes(array);
    const bool is_masks = array == PAGED_MASKS;
    const uint32_t end_level = is_masks && layout->top_level == info->depth ? info->depth : layout->top_level + 1;
    const size_t count = layout->by_node[array] ? info->level_begin[end_level] : 1;
    if (!svo_i_tree_holds(info, svo_i_paged_buffer(array))) {
        return SVO_OK;
    }
    uint8_t *to = svo_i_alloc_zeroed(&paged->memory, count, element_bytes);
    if (to == NULL) {
        return no_memory(paged);
    }
    top->arrays[array] = to;
    if (!layout->by_node[array]) {
        return read_level(paged, array, info->payload_level, to);
    }
    for (uint32_t level = 0; level < end_level; ++level) {
        SVO_I_TRY(read_level(paged, array, level, to + info->level_begin[level] * element_bytes));
    }
    return SVO_OK;
}

static svo_status check_top(const svo_paged *paged, const paged_top *top)
{
    const svo_tree_info *info = &paged->file.info;
    const uint8_t *masks = top->arrays[PAGED_MASKS];
    const uint32_t top_level = paged->layout.top_level;
    for (uint32_t level = 0; level < info->depth && level <= top_level; ++level) {
        child_count count = {.paged = paged, .level = level};
        const uint8_t *of_level = masks + info->level_begin[level];
        const uint64_t node_count = info->level_begin[level + 1] - info->level_begin[level];
        SVO_I_TRY(level == top_level ? count_under_roots(&count, of_level, node_count, paged->bands[0].first[1])
                                     : count_children(&count, of_level, node_count));
    }
    return SVO_OK;
}

/* ---- pages ---- */

/* A chunk that is read in windows of whole pages. */
typedef struct chunk_scan {
    svo_paged *paged;
    const file_chunk *chunk;
    const paged_band *band;
    const paged_band *below; /* the band whose roots are on this level; NULL: none */
    paged_array array;
    uint32_t level;
    uint8_t *window; /* of WINDOW_BYTES */
    child_count children; /* of masks */
} chunk_scan;

/* The nodes of a page in the window. */
static svo_status scan_page(chunk_scan *scan, uint32_t index, const uint8_t *bytes, uint64_t byte_count)
{
    const uint32_t inside = scan->level - scan->band->root_level;
    paged_page *page = &scan->paged->pages[scan->band->first_page + index];
    page->hash = svo_i_paged_hash(page->hash, bytes, (size_t)byte_count);
    if (scan->array != PAGED_MASKS) {
        return SVO_OK;
    }
    if (scan->below != NULL) {
        return count_under_roots(&scan->children, bytes, byte_count, scan->below->first[1]);
    }
    SVO_I_TRY(count_children(&scan->children, bytes, byte_count));
    scan->band->first[inside + 1][index + 1] = (uint32_t)scan->children.children;
    return SVO_OK;
}

/* Reads as many pages as the window holds, from one on. Returns the first one after them in *end. */
static svo_status scan_window(chunk_scan *scan, uint32_t begin, XXH3_state_t *state, uint32_t *end)
{
    svo_paged *paged = scan->paged;
    const uint32_t *first = scan->band->first[scan->level - scan->band->root_level];
    const uint64_t element_bytes = svo_i_paged_element_bytes(scan->array);
    uint32_t last = begin + 1;
    while (last < scan->band->page_count && (first[last + 1] - first[begin]) * element_bytes <= WINDOW_BYTES) {
        ++last;
    }
    const size_t bytes = (size_t)((first[last] - first[begin]) * element_bytes);
    SVO_I_TRY(svo_i_source_read(&paged->load.source, scan->chunk->offset + first[begin] * element_bytes, scan->window,
                                bytes));
    paged->open_read_bytes += bytes;
    XXH3_64bits_update(state, scan->window, bytes);
    const uint8_t *at = scan->window;
    for (uint32_t index = begin; index < last; ++index) {
        const uint64_t page_bytes = (first[index + 1] - first[index]) * element_bytes;
        SVO_I_TRY(scan_page(scan, index, at, page_bytes));
        at += page_bytes;
    }
    *end = last;
    return SVO_OK;
}

/* Reads the chunk of an array's level, in the scan's band. */
static svo_status scan_chunk(chunk_scan *scan, paged_array array, uint32_t level)
{
    svo_paged *paged = scan->paged;
    uint32_t index = 0;
    XXH3_state_t state;
    scan->chunk = svo_i_paged_chunk(paged, array, level, &index);
    scan->array = array;
    scan->level = level;
    scan->below = level == svo_i_paged_last_level(paged, scan->band) ? scan->band + 1 : NULL;
    scan->children = (child_count){.paged = paged, .level = level};
    const svo_i_entry_name name = svo_i_tree_file_name(&paged->file, index);
    if (scan->chunk->codec != FILE_CODEC_STORED) {
        return svo_i_fail(paged->load.source.message, SVO_UNSUPPORTED,
                          "%s: chunk %s is compressed, and pages are read from chunks that are not", paged->path,
                          name.text);
    }
    XXH3_INITSTATE(&state);
    XXH3_64bits_reset(&state);
    for (uint32_t page = 0; page < scan->band->page_count;) {
        SVO_I_TRY(scan_window(scan, page, &state, &page));
    }
    const uint64_t hash = XXH3_64bits_digest(&state);
    return hash == scan->chunk->hash
               ? SVO_OK
               : svo_i_file_damaged(&paged->load, "chunk %s: checksum is %016" PRIx64 ", file says %016" PRIx64,
                                    name.text, hash, scan->chunk->hash);
}

/* The levels of a band, each array's chunk in the order of the file. */
static svo_status scan_band(chunk_scan *scan, const paged_band *band)
{
    const svo_paged *paged = scan->paged;
    const uint32_t last_level = svo_i_paged_last_level(paged, band);
    scan->band = band;
    for (uint32_t level = band->root_level + 1; level <= last_level; ++level) {
        for (int i = 0; i < PAGED_ARRAYS; ++i) {
            const bool is_there = paged->layout.by_node[i] && (i != PAGED_MASKS || level < paged->file.info.depth);
            if (is_there) {
                SVO_I_TRY(scan_chunk(scan, (paged_array)i, level));
            }
        }
    }
    return SVO_OK;
}

/* ---- all ---- */

static svo_status make_bands(svo_paged *paged)
{
    const paged_layout *layout = &paged->layout;
    const uint32_t *level_begin = paged->file.info.level_begin;
    uint32_t page = 0;
    paged->pages = svo_i_alloc_zeroed(&paged->memory, (size_t)layout->page_count + 1, sizeof *paged->pages);
    if (paged->pages == NULL) {
        return no_memory(paged);
    }
    for (uint32_t i = 0; i < layout->band_count; ++i) {
        paged_band *band = &paged->bands[i];
        band->root_level = layout->top_level + i * layout->page_levels;
        band->first_page = page;
        band->page_count = level_begin[band->root_level + 1] - level_begin[band->root_level];
        page += band->page_count;
        for (uint32_t k = 1; k <= layout->page_levels; ++k) {
            band->first[k] = svo_i_alloc_zeroed(&paged->memory, (size_t)band->page_count + 1, sizeof(uint32_t));
            if (band->first[k] == NULL) {
                return no_memory(paged);
            }
        }
    }
    return SVO_OK;
}

static void find_largest(svo_paged *paged)
{
    for (uint32_t page = 0; page < paged->layout.page_count; ++page) {
        uint32_t inner_count = 0, leaf_count = 0;
        svo_i_paged_size(paged, page, &inner_count, &leaf_count);
        paged->largest_inner = inner_count > paged->largest_inner ? inner_count : paged->largest_inner;
        paged->largest_leaves = leaf_count > paged->largest_leaves ? leaf_count : paged->largest_leaves;
    }
}

svo_status svo_i_paged_scan(svo_paged *paged, paged_top *top)
{
    chunk_scan scan = {.paged = paged};
    svo_status status = SVO_OK;
    SVO_I_TRY(make_bands(paged));
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        SVO_I_TRY(read_top_array(paged, (paged_array)i, top));
    }
    SVO_I_TRY(check_top(paged, top));
    scan.window = svo_i_alloc(&paged->memory, WINDOW_BYTES);
    if (scan.window == NULL) {
        return no_memory(paged);
    }
    for (uint32_t i = 0; i < paged->layout.band_count; ++i) {
        SVO_I_TRY_CLEANUP(scan_band(&scan, &paged->bands[i]));
    }
    find_largest(paged);

cleanup:
    svo_i_free(scan.window);
    return status;
}
