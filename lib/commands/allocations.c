/* SPDX-License-Identifier: MIT */
/*
 * Records allocations and places scratch buffers with known lifetimes in one block of memory. In order, each buffer
 * gets the lowest offset that overlaps no buffer with an overlapping lifetime (first fit: Knuth, "The Art of Computer
 * Programming", volume 1, section 2.5).
 */
#include "commands/allocations.h"

bool svo_i_allocations_add(const svo_i_memory *memory, svo_i_allocations *list, const char *name, uint64_t bytes,
                           size_t *index)
{
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity * 2 + 32;
        svo_i_allocation *grown = svo_i_grow(memory, list->entries, capacity * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        list->entries = grown;
        list->capacity = capacity;
    }
    list->entries[list->count] =
        (svo_i_allocation){.name = name, .bytes = bytes > 0 ? bytes : 1, .born = list->clock++, .died = UINT64_MAX};
    *index = list->count++;
    return true;
}

void svo_i_allocations_release(svo_i_allocations *list, size_t index)
{
    list->entries[index].died = list->clock++;
}

static bool overlap_in_time(const svo_i_allocation *a, const svo_i_allocation *b)
{
    return a->born < b->died && b->born < a->died;
}

static uint64_t aligned(uint64_t bytes, uint64_t alignment)
{
    return (bytes + alignment - 1) / alignment * alignment;
}

/* The end of an earlier entry that overlaps this one in time and, at the given offset, in memory; 0 without one. */
static uint64_t blocked_until(const svo_i_allocations *list, size_t index, uint64_t offset)
{
    const svo_i_allocation *entry = &list->entries[index];
    for (size_t i = 0; i < index; ++i) {
        const svo_i_allocation *other = &list->entries[i];
        if (!other->persistent && overlap_in_time(entry, other) && offset < other->offset_bytes + other->bytes &&
            other->offset_bytes < offset + entry->bytes) {
            return other->offset_bytes + other->bytes;
        }
    }
    return 0;
}

void svo_i_allocations_place(svo_i_allocations *list, uint64_t alignment)
{
    list->scratch_bytes = 0;
    for (size_t i = 0; i < list->count; ++i) {
        svo_i_allocation *entry = &list->entries[i];
        if (entry->persistent) {
            continue;
        }
        uint64_t offset = 0;
        for (uint64_t end = blocked_until(list, i, 0); end != 0; end = blocked_until(list, i, offset)) {
            offset = aligned(end, alignment);
        }
        entry->offset_bytes = offset;
        const uint64_t end = offset + entry->bytes;
        list->scratch_bytes = end > list->scratch_bytes ? end : list->scratch_bytes;
    }
}

void svo_i_allocations_free(svo_i_allocations *list)
{
    for (size_t i = 0; i < list->count; ++i) {
        if (list->entries[i].memory != NULL) {
            clReleaseMemObject(list->entries[i].memory);
        }
    }
    svo_i_free(list->entries);
    *list = (svo_i_allocations){0};
}
