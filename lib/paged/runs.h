/* SPDX-License-Identifier: MIT */
/* Runs of free elements. The first one that is long enough is taken, so the same calls give the same places. */
#ifndef SVO_LIB_PAGED_RUNS_H
#define SVO_LIB_PAGED_RUNS_H

#include <stdbool.h>
#include <stdint.h>

#include "core/memory.h"

typedef struct svo_i_run {
    uint32_t begin, count;
} svo_i_run;

typedef struct svo_i_runs {
    svo_i_run *spans; /* ascending, none beside another; owned */
    uint32_t free_count, free_capacity;
    uint32_t taken_count;
} svo_i_runs;

/* All of count elements from begin on are free. Returns false when out of memory. */
bool svo_i_runs_begin(svo_i_runs *runs, const svo_i_memory *memory, uint32_t begin, uint32_t count);
void svo_i_runs_end(svo_i_runs *runs);

/* Makes sure that one more run can be taken and given back. Returns false when out of memory. */
bool svo_i_runs_reserve(svo_i_runs *runs);
/* Takes count elements, above 0, after svo_i_runs_reserve. Returns false where no run is long enough. */
bool svo_i_runs_take(svo_i_runs *runs, uint32_t count, uint32_t *begin);
void svo_i_runs_give_back(svo_i_runs *runs, uint32_t begin, uint32_t count);

#endif
