/* SPDX-License-Identifier: MIT */
/*
 * The nodes on the device: runs of free elements, buffers, what is written to them, and which pages come and go. Rays
 * reach nothing of a page before the table says where it is, and that is written last; so a failure on the way leaves
 * what was there.
 */
#include <stdlib.h>
#include <string.h>

#include "core/staging.h"
#include "paged/paged.h"
#include "shared/nodes.clh"
#include "shared/page.h"

/*
 * ---- runs of free elements ----
 *
 * First fit in a sorted list. Between two free runs something is taken, so there is one more of them at most.
 */

#define FREE_CAPACITY_BEGIN 64u

bool svo_i_runs_begin(svo_i_runs *runs, const svo_i_memory *memory, uint32_t begin, uint32_t count)
{
    svo_i_run *spans = svo_i_alloc(memory, FREE_CAPACITY_BEGIN * sizeof *spans);
    if (spans == NULL) {
        return false;
    }
    spans[0] = (svo_i_run){begin, count};
    *runs = (svo_i_runs){spans, count > 0, FREE_CAPACITY_BEGIN, 0};
    return true;
}

void svo_i_runs_end(svo_i_runs *runs)
{
    svo_i_free(runs->spans);
    *runs = (svo_i_runs){NULL, 0, 0, 0};
}

bool svo_i_runs_reserve(svo_i_runs *runs)
{
    const uint32_t needed = runs->taken_count + 2;
    if (needed <= runs->free_capacity) {
        return true;
    }
    const uint32_t capacity = needed + needed / 2;
    svo_i_run *spans = svo_i_grow(NULL, runs->spans, capacity * sizeof *spans);
    if (spans == NULL) {
        return false;
    }
    runs->spans = spans;
    runs->free_capacity = capacity;
    return true;
}

static void remove_run(svo_i_runs *runs, uint32_t at)
{
    --runs->free_count;
    memmove(runs->spans + at, runs->spans + at + 1, (runs->free_count - at) * sizeof *runs->spans);
}

bool svo_i_runs_take(svo_i_runs *runs, uint32_t count, uint32_t *begin)
{
    uint32_t at = 0;
    while (at < runs->free_count && runs->spans[at].count < count) {
        ++at;
    }
    if (at == runs->free_count) {
        return false;
    }
    svo_i_run *run = &runs->spans[at];
    *begin = run->begin;
    run->begin += count;
    run->count -= count;
    if (run->count == 0) {
        remove_run(runs, at);
    }
    ++runs->taken_count;
    return true;
}

void svo_i_runs_give_back(svo_i_runs *runs, uint32_t begin, uint32_t count)
{
    uint32_t at = 0;
    while (at < runs->free_count && runs->spans[at].begin < begin) {
        ++at;
    }
    memmove(runs->spans + at + 1, runs->spans + at, (runs->free_count - at) * sizeof *runs->spans);
    ++runs->free_count;
    --runs->taken_count;
    runs->spans[at] = (svo_i_run){begin, count};
    if (at + 1 < runs->free_count && begin + count == runs->spans[at + 1].begin) {
        runs->spans[at].count += runs->spans[at + 1].count;
        remove_run(runs, at + 1);
    }
    if (at > 0 && runs->spans[at - 1].begin + runs->spans[at - 1].count == begin) {
        runs->spans[at - 1].count += runs->spans[at].count;
        remove_run(runs, at);
    }
}

/* Nodes of a stage, unless a page has more: enough for writes to be long. */
#define STAGE_NODES 16384u

static svo_status no_memory(const svo_paged *paged)
{
    return svo_i_device_fail(paged->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for pages", paged->path);
}

/* ---- transfers ---- */

static svo_status write_buffer(const svo_paged *paged, const char *function, cl_mem buffer, size_t offset,
                               const void *from, size_t bytes)
{
    cl_command_queue queue = NULL;
    SVO_I_TRY(svo_i_device_queue(paged->device, function, NULL, &queue));
    return svo_i_device_write(paged->device, function, queue, buffer, offset, from, bytes);
}

static size_t table_bytes(const svo_paged *paged)
{
    return (size_t)paged->layout.page_count * SVO_PAGE_WORDS * sizeof *paged->table;
}

svo_status svo_i_paged_write_table(svo_paged *paged)
{
    return write_buffer(paged, "svo_paged_render", paged->device_table, 0, paged->table, table_bytes(paged));
}

svo_status svo_i_paged_read_table(svo_paged *paged)
{
    static const char function[] = "svo_paged_render";
    const size_t bytes = table_bytes(paged);
    cl_command_queue queue = NULL;
    if (bytes == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_device_queue(paged->device, function, NULL, &queue));
    const cl_int error =
        clEnqueueReadBuffer(queue, paged->device_table, CL_TRUE, 0, bytes, paged->table, 0, NULL, NULL);
    return error == CL_SUCCESS ? SVO_OK : svo_i_device_fail_cl(paged->device, function, "clEnqueueReadBuffer", error);
}

/* ---- links ---- */

/* Links of consecutive nodes whose children follow each other from *next on. */
static void link_nodes(const uint8_t *masks, uint32_t count, uint32_t *next, uint32_t *links)
{
    for (uint32_t i = 0; i < count; ++i) {
        links[i] = *next;
        *next += svo_count_bits(masks[i]);
    }
}

static void link_roots(uint32_t first_page, uint32_t count, uint32_t *links)
{
    for (uint32_t i = 0; i < count; ++i) {
        links[i] = SVO_PAGE_ROOT | (first_page + i);
    }
}

/* All pages' leaves are after all inner nodes, so those of a tree without pages are where a file has them. */
static void link_top(const svo_paged *paged, const uint8_t *masks, uint32_t *links)
{
    const svo_tree_info *info = &paged->file.info;
    const uint32_t top_level = paged->layout.top_level;
    const uint32_t above = info->level_begin[top_level < info->depth ? top_level : info->depth];
    uint32_t next = 1;
    link_nodes(masks, above, &next, links);
    link_roots(0, paged->layout.top_inner_count - above, links + above);
}

/* A page's inner nodes, at the end of the stage. */
static void link_page(const svo_paged *paged, const paged_band *band, uint32_t index)
{
    const paged_stage *stage = &paged->stage;
    const paged_page *page = &paged->pages[band->first_page + index];
    const uint32_t depth = paged->file.info.depth;
    const uint32_t last_level = svo_i_paged_last_level(paged, band);
    const uint8_t *masks = stage->inner[PAGED_MASKS] + stage->inner_count;
    uint32_t *links = stage->links + stage->inner_count;
    uint32_t next = page->inner_at + svo_i_paged_count(band, index, band->root_level + 1);
    for (uint32_t level = band->root_level + 1; level <= last_level && level < depth; ++level) {
        const uint32_t count = svo_i_paged_count(band, index, level);
        if (level == last_level) {
            link_roots(band[1].first_page + band->first[level - band->root_level][index], count, links);
        } else {
            next = level + 1 == depth ? page->leaf_at : next;
            link_nodes(masks, count, &next, links);
        }
        masks += count;
        links += count;
    }
}

/* ---- buffers ---- */

static svo_status make_array(svo_paged *paged, paged_array array, const uint8_t *top)
{
    static const char function[] = "svo_paged_open";
    const paged_layout *layout = &paged->layout;
    const svo_tree_info *info = &paged->file.info;
    const size_t element_bytes = svo_i_paged_element_bytes(array);
    const bool is_masks = array == PAGED_MASKS;
    size_t count = 1, top_count = 1;
    if (layout->by_node[array]) {
        count = (size_t)layout->inner_capacity + (is_masks ? 0 : layout->leaf_capacity);
        top_count = is_masks ? layout->top_inner_count : info->level_begin[layout->top_level + 1];
    }
    SVO_I_TRY(svo_i_device_buffer(paged->device, function, svo_name(SVO_NAME_TREE_BUFFER, svo_i_paged_buffer(array)),
                                  CL_MEM_READ_ONLY, count * element_bytes, &paged->arrays[array]));
    return write_buffer(paged, function, paged->arrays[array], 0, top, top_count * element_bytes);
}

static svo_status make_links(svo_paged *paged, const uint8_t *masks)
{
    static const char function[] = "svo_paged_open";
    const size_t bytes = paged->layout.top_inner_count * sizeof(uint32_t);
    svo_status status = SVO_OK;
    uint32_t *links = svo_i_alloc(&paged->memory, bytes);
    if (links == NULL) {
        return no_memory(paged);
    }
    link_top(paged, masks, links);
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(paged->device, function, "links", CL_MEM_READ_ONLY,
                                          paged->layout.inner_capacity * sizeof(uint32_t), &paged->links));
    SVO_I_TRY_CLEANUP(write_buffer(paged, function, paged->links, 0, links, bytes));

cleanup:
    svo_i_free(links);
    return status;
}

static uint32_t greater(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

/* The stage is one block of memory: links, then each array's inner nodes and leaves. */
static svo_status make_stage(svo_paged *paged)
{
    const paged_layout *layout = &paged->layout;
    paged_stage *stage = &paged->stage;
    const bool has_pages = layout->page_count > 0;
    stage->inner_capacity = has_pages ? greater(paged->largest_inner, STAGE_NODES) : 1;
    stage->leaf_capacity = has_pages ? greater(paged->largest_leaves, STAGE_NODES) : 1;
    const size_t nodes = (size_t)stage->inner_capacity + stage->leaf_capacity;
    stage->links =
        svo_i_alloc(&paged->memory, stage->inner_capacity * sizeof *stage->links + nodes * (1 + layout->payload_bytes));
    if (stage->links == NULL) {
        return no_memory(paged);
    }
    uint8_t *at = (uint8_t *)(stage->links + stage->inner_capacity);
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        if (layout->by_node[i]) {
            const size_t element_bytes = svo_i_paged_element_bytes((paged_array)i);
            stage->inner[i] = at;
            stage->leaves[i] = at + stage->inner_capacity * element_bytes;
            at += nodes * element_bytes;
        }
    }
    return SVO_OK;
}

svo_status svo_i_paged_make_pool(svo_paged *paged, const paged_top *top)
{
    const paged_layout *layout = &paged->layout;
    const uint32_t pages_at = layout->top_inner_count;
    SVO_I_TRY(make_stage(paged));
    paged->table =
        svo_i_alloc_zeroed(&paged->memory, (size_t)layout->page_count + 1, SVO_PAGE_WORDS * sizeof *paged->table);
    if (paged->table == NULL ||
        !svo_i_runs_begin(&paged->inner_runs, &paged->memory, pages_at, layout->inner_capacity - pages_at) ||
        !svo_i_runs_begin(&paged->leaf_runs, &paged->memory, layout->inner_capacity, layout->leaf_capacity)) {
        return no_memory(paged);
    }
    SVO_I_TRY(svo_i_device_buffer(paged->device, "svo_paged_open", "pages", CL_MEM_READ_WRITE, table_bytes(paged),
                                  &paged->device_table));
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        if (top->arrays[i] != NULL) {
            SVO_I_TRY(make_array(paged, (paged_array)i, top->arrays[i]));
        }
    }
    return make_links(paged, top->arrays[PAGED_MASKS]);
}

void svo_i_paged_release_pool(svo_paged *paged)
{
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        svo_i_buffer_release(&paged->arrays[i]);
    }
    svo_i_buffer_release(&paged->links);
    svo_i_buffer_release(&paged->device_table);
    svo_i_runs_end(&paged->inner_runs);
    svo_i_runs_end(&paged->leaf_runs);
    svo_i_free(paged->stage.links);
    svo_i_free(paged->table);
}

/* ---- pages ---- */

/* Writes what is in the stage to the device. */
static svo_status flush_stage(svo_paged *paged)
{
    static const char function[] = "svo_paged_update";
    paged_stage *stage = &paged->stage;
    const paged_stage full = *stage;
    stage->inner_count = stage->leaf_count = 0;
    SVO_I_TRY(write_buffer(paged, function, paged->links, full.inner_at * sizeof *full.links, full.links,
                           full.inner_count * sizeof *full.links));
    for (int i = 0; i < PAGED_ARRAYS; ++i) {
        const size_t element_bytes = svo_i_paged_element_bytes((paged_array)i);
        const size_t leaves = i == PAGED_MASKS ? 0 : full.leaf_count;
        if (paged->layout.by_node[i]) {
            SVO_I_TRY(write_buffer(paged, function, paged->arrays[i], full.inner_at * element_bytes, full.inner[i],
                                   full.inner_count * element_bytes));
            SVO_I_TRY(write_buffer(paged, function, paged->arrays[i], full.leaf_at * element_bytes, full.leaves[i],
                                   leaves * element_bytes));
        }
    }
    return SVO_OK;
}

/* Whether the page's nodes follow those of the stage. */
static bool follows(const paged_stage *stage, const paged_page *page, uint32_t inner_count, uint32_t leaf_count)
{
    return page->inner_at == stage->inner_at + stage->inner_count &&
           (leaf_count == 0 || stage->leaf_count == 0 || page->leaf_at == stage->leaf_at + stage->leaf_count) &&
           inner_count <= stage->inner_capacity - stage->inner_count &&
           leaf_count <= stage->leaf_capacity - stage->leaf_count;
}

/* Reads one piece to the end of the stage. inside: nodes of the page before it, of its kind. */
static svo_status read_piece(svo_paged *paged, const paged_band *band, uint32_t index, uint32_t level,
                             paged_array array, uint32_t inside, uint64_t *hash)
{
    paged_stage *stage = &paged->stage;
    const bool is_leaf = level == paged->file.info.depth;
    const size_t element_bytes = svo_i_paged_element_bytes(array);
    const size_t at = (is_leaf ? stage->leaf_count : stage->inner_count) + inside;
    uint8_t *to = (is_leaf ? stage->leaves : stage->inner)[array] + at * element_bytes;
    const size_t bytes = svo_i_paged_count(band, index, level) * element_bytes;
    uint32_t chunk_index = 0;
    const file_chunk *chunk = svo_i_paged_chunk(paged, array, level, &chunk_index);
    const uint64_t begin = band->first[level - band->root_level][index] * (uint64_t)element_bytes;
    SVO_I_TRY(svo_i_source_read(&paged->load.source, chunk->offset + begin, to, bytes));
    *hash = svo_i_paged_hash(*hash, to, bytes);
    paged->counts.read_bytes += bytes;
    return SVO_OK;
}

static svo_status read_page(svo_paged *paged, const paged_band *band, uint32_t index)
{
    const uint32_t depth = paged->file.info.depth;
    const uint32_t last_level = svo_i_paged_last_level(paged, band);
    uint32_t inside = 0;
    uint64_t hash = 0;
    for (uint32_t level = band->root_level + 1; level <= last_level; ++level) {
        inside = level < depth ? inside : 0;
        for (int i = 0; i < PAGED_ARRAYS; ++i) {
            if (paged->layout.by_node[i] && (i != PAGED_MASKS || level < depth)) {
                SVO_I_TRY(read_piece(paged, band, index, level, (paged_array)i, inside, &hash));
            }
        }
        inside += svo_i_paged_count(band, index, level);
    }
    return hash == paged->pages[band->first_page + index].hash
               ? SVO_OK
               : svo_i_file_damaged(&paged->load, "page %u under level %u has changed since the file was opened", index,
                                    band->root_level);
}

/* Reads a page, whose place is set, from the file to the stage, which goes to the device before if the page's nodes do
   not follow those of the stage. SVO_FILE_DAMAGED: they are not those of svo_i_paged_scan. */
static svo_status stage_page(svo_paged *paged, uint32_t page)
{
    paged_stage *stage = &paged->stage;
    const paged_page *place = &paged->pages[page];
    uint32_t index = 0, inner_count = 0, leaf_count = 0;
    const paged_band *band = svo_i_paged_band(paged, page, &index);
    svo_i_paged_size(paged, page, &inner_count, &leaf_count);
    if (!follows(stage, place, inner_count, leaf_count)) {
        SVO_I_TRY(flush_stage(paged));
    }
    SVO_I_TRY(read_page(paged, band, index));
    link_page(paged, band, index);
    stage->inner_at = stage->inner_count == 0 ? place->inner_at : stage->inner_at;
    stage->leaf_at = stage->leaf_count == 0 ? place->leaf_at : stage->leaf_at;
    stage->inner_count += inner_count;
    stage->leaf_count += leaf_count;
    return SVO_OK;
}

/*
 * ---- updates ----
 *
 * After a picture, pages that were missed are read, and those that were not used for longest make room for them.
 */

/*
 * Between pictures the table on the host has marks of missed pages alone: how often rays missed them. A page that is
 * there and has a mark was read by the update in progress.
 */

/* What may go, in the order in which it goes. */
typedef struct victims {
    uint64_t *keys; /* owned; NULL: not listed yet */
    uint32_t count, next;
} victims;

static uint32_t *word_of(const svo_paged *paged, uint32_t page, uint32_t word)
{
    return &paged->table[SVO_PAGE_WORDS * (size_t)page + word];
}

/* ---- updates: eviction ---- */

/* By the picture that used it last; of the same picture the last page first, so that no page goes before those under
   it. */
static uint64_t key_of(const svo_paged *paged, uint32_t page)
{
    return (uint64_t)paged->pages[page].used << 32 | ~page;
}

static int compare_keys(const void *left, const void *right)
{
    const uint64_t a = *(const uint64_t *)left;
    const uint64_t b = *(const uint64_t *)right;
    return (a > b) - (a < b);
}

static svo_status list_victims(const svo_paged *paged, victims *list)
{
    const uint32_t now = (uint32_t)paged->counts.pictures;
    list->keys = svo_i_alloc(&paged->memory, ((size_t)paged->counts.held_pages + 1) * sizeof *list->keys);
    if (list->keys == NULL) {
        return svo_i_device_fail(paged->device, SVO_OUT_OF_HOST_MEMORY, "svo_paged_update: no memory to order pages");
    }
    for (uint32_t page = 0; page < paged->layout.page_count; ++page) {
        if (paged->pages[page].inner_at != SVO_PAGE_ABSENT && paged->pages[page].used != now) {
            list->keys[list->count++] = key_of(paged, page);
        }
    }
    qsort(list->keys, list->count, sizeof *list->keys, compare_keys);
    return SVO_OK;
}

static void drop_page(svo_paged *paged, uint32_t page)
{
    paged_page *place = &paged->pages[page];
    uint32_t inner_count = 0, leaf_count = 0;
    svo_i_paged_size(paged, page, &inner_count, &leaf_count);
    svo_i_runs_give_back(&paged->inner_runs, place->inner_at, inner_count);
    if (leaf_count > 0) {
        svo_i_runs_give_back(&paged->leaf_runs, place->leaf_at, leaf_count);
    }
    place->inner_at = SVO_PAGE_ABSENT;
    *word_of(paged, page, SVO_PAGE_BEGIN) = SVO_PAGE_ABSENT;
    --paged->counts.held_pages;
}

/* ---- updates: room ---- */

static bool take_room(svo_paged *paged, uint32_t page)
{
    paged_page *place = &paged->pages[page];
    uint32_t inner_count = 0, leaf_count = 0, inner_at = 0;
    svo_i_paged_size(paged, page, &inner_count, &leaf_count);
    if (!svo_i_runs_take(&paged->inner_runs, inner_count, &inner_at)) {
        return false;
    }
    if (leaf_count > 0 && !svo_i_runs_take(&paged->leaf_runs, leaf_count, &place->leaf_at)) {
        svo_i_runs_give_back(&paged->inner_runs, inner_at, inner_count);
        return false;
    }
    place->inner_at = inner_at;
    place->used = (uint32_t)paged->counts.pictures;
    ++paged->counts.held_pages;
    return true;
}

/* Finds a place for a page, and drops others as long as there is none. *found: whether there is one now. */
static svo_status find_room(svo_paged *paged, uint32_t page, victims *list, bool *found)
{
    if (!svo_i_runs_reserve(&paged->inner_runs) || !svo_i_runs_reserve(&paged->leaf_runs)) {
        return svo_i_device_fail(paged->device, SVO_OUT_OF_HOST_MEMORY, "svo_paged_update: no memory for places");
    }
    *found = take_room(paged, page);
    if (!*found && list->keys == NULL) {
        SVO_I_TRY(list_victims(paged, list));
    }
    while (!*found && list->next < list->count) {
        drop_page(paged, ~(uint32_t)list->keys[list->next++]);
        ++paged->counts.evicted_pages;
        *found = take_room(paged, page);
    }
    return SVO_OK;
}

/* ---- updates: all together ---- */

/* The pages of a band that were missed, most often first, of equal ones the first. Returns their number. */
static uint32_t list_missed(const svo_paged *paged, const paged_band *band, uint64_t *keys)
{
    uint32_t count = 0;
    for (uint32_t page = band->first_page; page < band->first_page + band->page_count; ++page) {
        const uint32_t mark = *word_of(paged, page, SVO_PAGE_MARK);
        if (mark != 0) {
            keys[count++] = (uint64_t)~mark << 32 | page;
        }
    }
    qsort(keys, count, sizeof *keys, compare_keys);
    return count;
}

static svo_status bring_page(svo_paged *paged, uint32_t page, victims *list)
{
    const uint64_t limit = paged->update_bytes > 0 ? paged->update_bytes : UINT64_MAX;
    bool found = false;
    if (paged->counts.read_bytes < limit) {
        SVO_I_TRY(find_room(paged, page, list, &found));
    }
    if (!found) {
        ++paged->counts.waiting_pages;
        return SVO_OK;
    }
    SVO_I_TRY(stage_page(paged, page));
    *word_of(paged, page, SVO_PAGE_BEGIN) = paged->pages[page].inner_at;
    ++paged->counts.read_pages;
    return SVO_OK;
}

/* Reads band after band. keys: room for all that were missed. */
static svo_status read_missed(svo_paged *paged, uint64_t *keys, victims *list)
{
    for (uint32_t i = 0; i < paged->layout.band_count; ++i) {
        const uint32_t count = list_missed(paged, &paged->bands[i], keys);
        for (uint32_t k = 0; k < count; ++k) {
            SVO_I_TRY(bring_page(paged, (uint32_t)keys[k], list));
        }
    }
    return flush_stage(paged);
}

/* Ends an update: what it read is there, or after a failure it is missed as before. */
static void settle(svo_paged *paged, bool done)
{
    for (uint32_t page = 0; page < paged->layout.page_count; ++page) {
        uint32_t *mark = word_of(paged, page, SVO_PAGE_MARK);
        if (*mark != 0 && paged->pages[page].inner_at != SVO_PAGE_ABSENT) {
            if (done) {
                *mark = 0;
            } else {
                drop_page(paged, page);
            }
        }
    }
    paged->stage.inner_count = paged->stage.leaf_count = 0;
    paged->counts.read_pages = done ? paged->counts.read_pages : 0;
}

svo_status svo_paged_update(svo_paged *paged)
{
    victims list = {.keys = NULL};
    if (paged == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    svo_paged_counts *counts = &paged->counts;
    counts->read_pages = counts->read_bytes = counts->evicted_pages = counts->waiting_pages = 0;
    uint64_t *missed = svo_i_alloc(&paged->memory, ((size_t)counts->missed_pages + 1) * sizeof *missed);
    if (missed == NULL) {
        return svo_i_device_fail(paged->device, SVO_OUT_OF_HOST_MEMORY, "svo_paged_update: no memory to order pages");
    }
    const svo_status status = read_missed(paged, missed, &list);
    settle(paged, status == SVO_OK);
    svo_i_free(missed);
    svo_i_free(list.keys);
    counts->all_read_pages += counts->read_pages;
    counts->all_read_bytes += counts->read_bytes;
    counts->all_evicted_pages += counts->evicted_pages;
    return status;
}
