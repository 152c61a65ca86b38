/* SPDX-License-Identifier: MIT */
/* First fit in a sorted list. Between two free runs something is taken, so there is one more of them at most. */
#include "paged/runs.h"

#include <string.h>

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
