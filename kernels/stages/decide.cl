/* SPDX-License-Identifier: MIT */
/*
 * Decides the fragments that front ends have left undecided, by the caller's numbers (shared/decide.clh), and moves
 * those that touch to the chunk's others.
 *
 *   svo_k_decide  marks the undecided fragments that do not touch
 *   svo_k_keep_decided  moves the others to the end of the decided ones, and adds them to the chunk's count
 *
 * A chunk's counters are two of 64 bits: of decided fragments, which lie at its start, and of undecided ones, which lie
 * at its end. Where both do not fit, nothing is decided, and the first becomes their sum: what the chunk must hold.
 *
 * Launch: any number of work-items, in whole groups, for svo_k_decide; one group for svo_k_keep_decided. No atomics.
 * Local memory: a word per work-item. The counters are read on the device, so the host need not wait. On CPUs
 * (SVO_ONE_WORKER) the first work-item does the work of its group.
 */
#include "shared/decide.clh"
#include "shared/fragment.clh"
#include "shared/group.clh"

#define SVO_REFUSED SVO_NO_TRIANGLE

/* The undecided fragments; 0 if they and the decided ones exceed the capacity. */
static uint svo_undecided(__global const uint *counters, uint capacity)
{
    const ulong decided = (ulong)counters[1] << 32 | counters[0];
    const ulong undecided = (ulong)counters[3] << 32 | counters[2];
    return decided + undecided <= (ulong)capacity ? (uint)undecided : 0u;
}

/* Decides every step-th undecided fragment from i on, below end. */
SVO_CALLED void svo_decide_run(__global const uint *positions, __global const uint *indices, __global uint *fragments,
                               const svo_decide_params *params, uint i, uint step, uint end)
{
#ifdef SVO_ONE_WORKER
    svo_decider decider;
    decider.triangle = SVO_NO_TRIANGLE;
#endif
    for (; i < end; i += step) {
        const size_t at = params->capacity - 1u - i;
        const svo_code code = svo_fragment_code(fragments, at);
        const uint cell[3] = {(uint)svo_code_axis(code, 0u), (uint)svo_code_axis(code, 1u),
                              (uint)svo_code_axis(code, 2u)};
        const uint triangle = svo_fragment_triangle(fragments, at);
#ifdef SVO_ONE_WORKER
        const bool touches = svo_decide(positions, indices, triangle, cell, params, &decider);
#else
        const bool touches = svo_decide_once(positions, indices, triangle, cell, params);
#endif
        if (!touches) {
            svo_fragment_store(fragments, at, code, SVO_REFUSED);
        }
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_decide(__global const uint *positions, __global const uint *indices, __global const uint *all_counters,
             __global uint *fragments, svo_decide_params params)
{
    const uint count = svo_undecided(all_counters + SVO_COUNTER_WORDS * params.counter, params.capacity);
#ifdef SVO_ONE_WORKER
    /* Those of a triangle lie side by side. */
    const uint run = count / (uint)get_num_groups(0) + 1u;
    const uint first = (uint)get_group_id(0) * run;
    if (get_local_id(0) == 0u) {
        svo_decide_run(positions, indices, fragments, &params, first, 1u, min(first + run, count));
    }
#else
    svo_decide_run(positions, indices, fragments, &params, (uint)get_global_id(0), (uint)get_global_size(0), count);
#endif
}

/* The chunk's count: of the fragments that it holds now, or what it must hold. end: where the decided ones end. */
static void svo_count_decided(__global uint *counters, uint capacity, uint end)
{
    const ulong both = ((ulong)counters[1] << 32 | counters[0]) + ((ulong)counters[3] << 32 | counters[2]);
    counters[0] = both <= (ulong)capacity ? end : (uint)both;
    counters[1] = both <= (ulong)capacity ? 0u : (uint)(both >> 32);
}

/* Sources are read from the first on, and no place is written that has not been read. */
#ifdef SVO_ONE_WORKER

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_keep_decided(__global uint *all_counters, __global uint *fragments, svo_decide_params params,
                   __local uint *scratch)
{
    __global uint *counters = all_counters + SVO_COUNTER_WORDS * params.counter;
    (void)scratch;
    if (get_local_id(0) == 0u) {
        const uint count = svo_undecided(counters, params.capacity);
        uint end = counters[0];
        for (uint i = 0; i < count; ++i) {
            const size_t at = params.capacity - count + i;
            const uint triangle = svo_fragment_triangle(fragments, at);
            if (triangle != SVO_REFUSED) {
                svo_fragment_store(fragments, end, svo_fragment_code(fragments, at), triangle);
                ++end;
            }
        }
        svo_count_decided(counters, params.capacity, end);
    }
}

#else

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_keep_decided(__global uint *all_counters, __global uint *fragments, svo_decide_params params,
                   __local uint *scratch)
{
    __global uint *counters = all_counters + SVO_COUNTER_WORDS * params.counter;
    const uint item = (uint)get_local_id(0);
    const uint count = svo_undecided(counters, params.capacity);
    uint end = counters[0];
    for (uint first = 0; first < count; first += SVO_GROUP_ITEMS) {
        const size_t at = params.capacity - count + min(first + item, count - 1u);
        const svo_code code = svo_fragment_code(fragments, at);
        const uint triangle = svo_fragment_triangle(fragments, at);
        const uint moves = first + item < count && triangle != SVO_REFUSED ? 1u : 0u;
        uint total;
        const uint place = end + svo_group_exclusive(moves, scratch, &total);
        barrier(CLK_GLOBAL_MEM_FENCE); /* all have read theirs */
        if (moves != 0u) {
            svo_fragment_store(fragments, place, code, triangle);
        }
        end += total;
        barrier(CLK_GLOBAL_MEM_FENCE);
    }
    barrier(CLK_GLOBAL_MEM_FENCE); /* all have read the counters */
    if (item == 0u) {
        svo_count_decided(counters, params.capacity, end);
    }
}

#endif
