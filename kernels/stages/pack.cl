/* SPDX-License-Identifier: MIT */
/*
 * Packs the leaf lists: contiguous ranges of triangles, ascending inside a leaf.
 *
 *   svo_k_count       per fragment: the lengths
 *   scan.cl           per leaf: where its range begins
 *   svo_k_scatter     per fragment: its triangle into the range, in any order (lengths count down to 0); where pairs.cl
 *                     sums up the leaves also, or only, the fragment itself, which gives the order of leaves
 *   svo_k_sort_short  per leaf: Shell sort of up to SVO_SHORT_LIST_MAX entries, with the gaps of Ciura, "Best
 *                     Increments for the Average Case of Shellsort", 2001; longer leaves are appended to long_leaves
 *   svo_k_sort_long   per long leaf, one work-group: stable radix sort, four bits a pass, between list and spare
 *
 * The cost is linear in the fragments whatever their distribution; a leaf may hold a million triangles. Invariant:
 * triangles are distinct inside a leaf, so the result does not depend on the order of the fragments.
 * Launch: one work-item per fragment or leaf, rounded up to whole groups; svo_k_sort_long as it says below.
 * Atomics: counters only; each slot of a range is handed out once.
 */
#include "shared/fragment.clh"
#include "shared/state.clh"
#include "stages/digits.clh"

#ifdef SVO_RANGES

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_count(__global const uint *cursors, volatile __global uint *counts, __global const svo_build_state *state,
            svo_filter_params params)
{
    svo_make_current(&params, state);
    const size_t index = get_global_id(0);
    if (index < params.fragment_count) {
        atomic_inc(counts + (cursors[index] - params.leaf_begin));
    }
}

#endif

#if defined(SVO_LISTS) || defined(SVO_ORDER)

/* list: NULL without lists. order: NULL where the list has several chunks. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scatter(__global const uint *fragments, __global const uint *cursors, volatile __global uint *counts,
              __global const uint *list_begin, __global uint *list, __global uint *order,
              __global const svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const size_t index = get_global_id(0);
    if (index < params.fragment_count) {
        const uint leaf = cursors[index] - params.leaf_begin;
        const uint slot = list_begin[leaf] + atomic_dec(counts + leaf) - 1u;
#ifdef SVO_LISTS
        list[slot] = svo_fragment_triangle(fragments, index);
#endif
#ifdef SVO_ORDER
        if (order != 0) {
            order[slot] = (uint)index;
        }
#endif
    }
    (void)fragments;
    (void)list;
    (void)order;
}

#endif

#ifdef SVO_LISTS

#define SVO_SORT_GAPS 6
__constant uint svo_gaps[SVO_SORT_GAPS] = {132, 57, 23, 10, 4, 1};

/* Insertion sort of the entries that lie a multiple of gap apart. */
static void svo_sort_gap(__global uint *list, uint begin, uint end, uint gap)
{
    for (uint i = begin + gap; i < end; ++i) {
        const uint triangle = list[i];
        uint slot = i;
        while (slot >= begin + gap && list[slot - gap] > triangle) {
            list[slot] = list[slot - gap];
            slot -= gap;
        }
        list[slot] = triangle;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sort_short(__global const uint *list_begin, __global uint *list, __global uint *long_leaves,
                 __global svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.leaf_count) {
        return;
    }
    const uint begin = list_begin[leaf];
    const uint end = list_begin[leaf + 1u];
    if (end - begin > SVO_SHORT_LIST_MAX) {
        long_leaves[atomic_inc(&state->long_lists)] = leaf;
        return;
    }
    for (uint k = 0; k < SVO_SORT_GAPS; ++k) {
        svo_sort_gap(list, begin, end, svo_gaps[k]);
    }
}

/* One stable pass over length entries by the digit at shift. Each work-item owns a contiguous strip. */
SVO_INLINED void svo_radix_pass(__global const uint *from, __global uint *to, uint length, uint shift,
                                __local uint *counts, __local uint *scratch)
{
    const uint item = (uint)get_local_id(0);
    const uint2 strip = svo_strip(0u, length);
    for (uint digit = 0; digit < SVO_DIGITS; ++digit) {
        counts[digit * SVO_GROUP_ITEMS + item] = 0u;
    }
    for (uint i = strip.x; i < strip.y; ++i) {
        ++counts[(from[i] >> shift & (SVO_DIGITS - 1u)) * SVO_GROUP_ITEMS + item];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    svo_scan_digits(counts, scratch);
    for (uint i = strip.x; i < strip.y; ++i) {
        const uint triangle = from[i];
        to[counts[(triangle >> shift & (SVO_DIGITS - 1u)) * SVO_GROUP_ITEMS + item]++] = triangle;
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

/* Launch: any number of groups, among which the long leaves are divided. digit_passes is even, so the result ends up in
   list. counts: SVO_DIGITS * SVO_GROUP_ITEMS words, scratch: SVO_GROUP_ITEMS; arguments, see group.clh. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sort_long(__global const uint *list_begin, __global uint *list, __global uint *spare,
                __global const uint *long_leaves, __global const svo_build_state *state, svo_filter_params params,
                __local uint *counts, __local uint *scratch)
{
    const uint long_count = state->long_lists;
    for (uint k = (uint)get_group_id(0); k < long_count; k += (uint)get_num_groups(0)) {
        const uint leaf = long_leaves[k];
        const uint begin = list_begin[leaf];
        const uint length = list_begin[leaf + 1u] - begin;
        for (uint pass = 0; pass < params.digit_passes; pass += 2u) {
            svo_radix_pass(list + begin, spare + begin, length, pass * SVO_DIGIT_BITS, counts, scratch);
            svo_radix_pass(spare + begin, list + begin, length, (pass + 1u) * SVO_DIGIT_BITS, counts, scratch);
        }
    }
}

#endif
