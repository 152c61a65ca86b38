/* SPDX-License-Identifier: MIT */
/*
 * The allocations of a build, in order, with their lifetimes. A measuring build records them. Enqueued builds take them
 * in the same order. Buffers with disjoint lifetimes share memory.
 */
#ifndef SVO_LIB_COMMANDS_ALLOCATIONS_H
#define SVO_LIB_COMMANDS_ALLOCATIONS_H

#include "core/device.h"

typedef struct svo_i_allocation {
    const char *name; /* static string */
    uint64_t bytes;
    uint64_t born, died; /* clock values of the allocation and the release; died UINT64_MAX: never released */
    uint64_t offset_bytes; /* in the scratch memory */
    bool persistent; /* part of the tree, not scratch */
    cl_mem memory; /* owned; a sub-buffer of the scratch memory; NULL until there is one */
} svo_i_allocation;

typedef struct svo_i_allocations {
    svo_i_allocation *entries;
    size_t count, capacity;
    uint64_t clock; /* counts allocations and releases */
    uint64_t scratch_bytes; /* size of the scratch memory; set by svo_i_allocations_place */
} svo_i_allocations;

/* Records an allocation; *index identifies it. Returns false when out of memory. */
bool svo_i_allocations_add(const svo_i_memory *memory, svo_i_allocations *list, const char *name, uint64_t bytes,
                           size_t *index);
/* Records the release of an allocation. */
void svo_i_allocations_release(svo_i_allocations *list, size_t index);
/* Assigns offsets to the scratch entries, in multiples of alignment bytes. */
void svo_i_allocations_place(svo_i_allocations *list, uint64_t alignment);
/* Frees the list and releases the memory of its entries. */
void svo_i_allocations_free(svo_i_allocations *list);

#endif
