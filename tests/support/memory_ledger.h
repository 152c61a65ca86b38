/* SPDX-License-Identifier: MIT */
/*
 * Memory functions for svo_memory_callbacks that check what they are given: sizes and alignments at release, bytes
 * beyond a block's end, blocks that are not theirs. Blocks begin at odd multiples of 16 bytes and hold garbage, before
 * and after. One allocation may be made to fail. One ledger per program; several threads may use it.
 *
 * With svocl_watch_malloc(test_name) in CMake it also counts the calls of malloc and its relatives that the test and
 * its static libraries make (ld --wrap).
 */
#ifndef SVOCL_TESTS_MEMORY_LEDGER_H
#define SVOCL_TESTS_MEMORY_LEDGER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "svocl/memory.h"

#define LEDGER_NEVER UINT64_MAX

typedef struct ledger_counts {
    uint64_t live_blocks, live_bytes;
    uint64_t allocations; /* since ledger_begin */
    size_t largest_bytes; /* of a block, since ledger_begin */
    uint64_t others; /* calls of malloc and its relatives, since ledger_begin */
    bool failed; /* an allocation, since ledger_begin */
    const char *wrong; /* the first thing that was wrong since the program began; NULL: nothing */
} ledger_counts;

extern const svo_memory_callbacks ledger_callbacks;

/* Counts anew. The fail_at-th allocation from now on, counted from 0, fails. */
void ledger_begin(uint64_t fail_at);
/* No allocation fails from now on, and calls of malloc are not counted. */
ledger_counts ledger_end(void);

/* Waits until no more than so many blocks are live, at most 10 s: a driver may release buffers late. Returns the blocks
   that are live. */
uint64_t ledger_settle(uint64_t blocks);

#endif
