/* SPDX-License-Identifier: MIT */
/*
 * Sorts the fragment list for the bottom-up builder: a stable least-significant-digit radix sort with digits of
 * SVO_SORT_BITS bits (Knuth, "The Art of Computer Programming", volume 3, 5.2.5), parallel as in Satish, Harris and
 * Garland, "Designing Efficient Sorting Algorithms for Manycore GPUs", 2009.
 *
 *   svo_k_sort_count    per block of the list: how often each digit occurs, stored digit by digit, so that the prefix
 *                       sum at an entry counts what precedes that digit of that block
 *   scan.cl             exclusive sums of those counts (svo_k_scan_lists_*)
 *   svo_k_sort_scatter  per block: moves its fragments, in order, to where their digits belong
 *
 * Launch: any number of groups. A group owns a block and each work-item a strip of it, which keeps the sort stable.
 * Reads one list and writes the other. No atomics. Local memory is an argument, see group.clh.
 */
#include "shared/fragment.clh"

/* The digit of a fragment: of its code, or of its triangle. */
static uint svo_sort_digit(__global const uint *fragments, uint index, svo_sort_params params)
{
    const ulong key = params.by_triangle != 0u ? (ulong)svo_fragment_triangle(fragments, index)
                                               : (ulong)svo_fragment_code(fragments, index);
    return (uint)(key >> params.shift) & (SVO_SORT_DIGITS - 1u);
}

/* The strip of this item, as indices of fragments. */
static uint2 svo_sort_strip(uint count)
{
    const uint strips = (uint)get_global_size(0);
    const uint length = count / strips + (count % strips != 0u ? 1u : 0u);
    const ulong begin = (ulong)get_global_id(0) * length;
    return (uint2)((uint)min(begin, (ulong)count), (uint)min(begin + length, (ulong)count));
}

/* digits[digit * SVO_GROUP_ITEMS + item]: how often the digit occurs in the item's strip. */
static void svo_sort_count_strip(__global const uint *fragments, svo_sort_params params, uint2 strip,
                                 __local uint *digits)
{
    const uint item = (uint)get_local_id(0);
    for (uint digit = 0; digit < SVO_SORT_DIGITS; ++digit) {
        digits[digit * SVO_GROUP_ITEMS + item] = 0u;
    }
    for (uint i = strip.x; i < strip.y; ++i) {
        ++digits[svo_sort_digit(fragments, i, params) * SVO_GROUP_ITEMS + item];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sort_count(__global const uint *fragments, __global uint *counts, svo_sort_params params, __local uint *digits)
{
    svo_sort_count_strip(fragments, params, svo_sort_strip(params.fragment_count), digits);
    for (uint digit = (uint)get_local_id(0); digit < SVO_SORT_DIGITS; digit += SVO_GROUP_ITEMS) {
        uint sum = 0;
        for (uint item = 0; item < SVO_GROUP_ITEMS; ++item) {
            sum += digits[digit * SVO_GROUP_ITEMS + item];
        }
        counts[digit * get_num_groups(0) + get_group_id(0)] = sum;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sort_scatter(__global const uint *from, __global uint *to, __global const uint *before, svo_sort_params params,
                   __local uint *digits)
{
    const uint2 strip = svo_sort_strip(params.fragment_count);
    svo_sort_count_strip(from, params, strip, digits);
    for (uint digit = (uint)get_local_id(0); digit < SVO_SORT_DIGITS; digit += SVO_GROUP_ITEMS) {
        uint sum = before[digit * get_num_groups(0) + get_group_id(0)];
        for (uint item = 0; item < SVO_GROUP_ITEMS; ++item) {
            const uint count = digits[digit * SVO_GROUP_ITEMS + item];
            digits[digit * SVO_GROUP_ITEMS + item] = sum;
            sum += count;
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = strip.x; i < strip.y; ++i) {
        const uint slot = digits[svo_sort_digit(from, i, params) * SVO_GROUP_ITEMS + get_local_id(0)]++;
        for (uint word = 0; word < SVO_FRAGMENT_WORDS; ++word) {
            to[(size_t)slot * SVO_FRAGMENT_WORDS + word] = from[(size_t)i * SVO_FRAGMENT_WORDS + word];
        }
    }
}
