/* SPDX-License-Identifier: MIT */
/*
 * What a build allocates, in order, and when it lets go of it: written down by a build that only measures, and given
 * out again, one after the other, to builds that are enqueued. Buffers that are not needed at the same time share
 * memory.
 */
#ifndef SVO_LIB_COMMANDS_ALLOCATIONS_H
#define SVO_LIB_COMMANDS_ALLOCATIONS_H

#include "core/device.h"

typedef struct svo_i_allocation {
    const char *name; /* static string */
    uint64_t bytes;
    uint64_t born, died; /* positions in the sequence of allocations and releases; died UINT64_MAX: never */
    uint64_t offset_bytes; /* in the scratch memory */
    bool persistent; /* the tree's: no scratch */
    cl_mem memory; /* owned; of scratch, once there is memory */
} svo_i_allocation;

typedef struct svo_i_allocations {
    svo_i_allocation *entries;
    size_t count, capacity;
    uint64_t clock; /* of the sequence */
    uint64_t scratch_bytes; /* all scratch, once it is placed */
} svo_i_allocations;

/* One more; it is known by its index. False: no memory. */
bool svo_i_allocations_add(svo_i_allocations *list, const char *name, uint64_t bytes, size_t *index);
void svo_i_allocations_release(svo_i_allocations *list, size_t index);
/* Finds the scratch entries' offsets, multiples of alignment. */
void svo_i_allocations_place(svo_i_allocations *list, uint64_t alignment);
/* Frees the list, and lets go of the memory of its entries. */
void svo_i_allocations_free(svo_i_allocations *list);

#endif
