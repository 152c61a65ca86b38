/* SPDX-License-Identifier: MIT */
/* After a picture: pages that were missed are read, and those that were not used for longest make room for them. */
#include <stdlib.h>

#include "paged/pool.h"
#include "shared/page.h"

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

/* ---- eviction ---- */

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

/* ---- room ---- */

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

/* ---- the update ---- */

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

static svo_status read_page(svo_paged *paged, uint32_t page, victims *list)
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
    SVO_I_TRY(svo_i_paged_stage_page(paged, page));
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
            SVO_I_TRY(read_page(paged, (uint32_t)keys[k], list));
        }
    }
    return svo_i_paged_flush(paged);
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
