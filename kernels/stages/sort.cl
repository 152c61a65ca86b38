/* SPDX-License-Identifier: MIT */
/*
 * Sorts the fragment list for the bottom-up builder: a stable least-significant-digit radix sort with digits of
 * params.bits bits (Knuth, "The Art of Computer Programming", volume 3, 5.2.5), parallel as in Satish, Harris and
 * Garland, "Designing Efficient Sorting Algorithms for Manycore GPUs", 2009.
 *
 *   svo_k_sort_count    per block of the list: how often each digit occurs, stored digit by digit, so that the prefix
 *                       sum at an entry counts what precedes that digit of that block
 *   scan.cl             exclusive sums of those counts (svo_k_scan_lists_*)
 *   svo_k_sort_scatter  per block: moves its fragments, in order, to where their digits belong
 *
 * Launch: any number of groups, each of which owns a block of the list. On GPUs the work-items of a group take
 * adjacent fragments, tile after tile; a fragment's place among those of its digit follows from a bit for each
 * work-item. On CPUs (SVO_SORT_SERIAL) one work-item takes the whole block, since a group runs on one thread, and
 * digits may be wider. Either keeps the sort stable, and gives the same list. Reads one list and writes the other.
 * Atomics: on bits and counts in local memory, where order does not matter. Local memory is an argument, see group.clh.
 */
#include "shared/fragment.clh"

/* The digit of a fragment: of its code, or of its triangle. */
static uint svo_sort_digit(__global const uint *fragments, uint index, svo_sort_params params)
{
    const ulong key = params.by_triangle != 0u ? (ulong)svo_fragment_triangle(fragments, index)
                                               : (ulong)svo_fragment_code(fragments, index);
    return (uint)(key >> params.shift) & ((1u << params.bits) - 1u);
}

/* A part of the list, by index of so many parts: first, and one past the last. */
static uint2 svo_sort_part(uint index, uint parts, uint count)
{
    const uint length = count / parts + (count % parts != 0u ? 1u : 0u);
    const ulong begin = (ulong)index * length;
    return (uint2)((uint)min(begin, (ulong)count), (uint)min(begin + length, (ulong)count));
}

static void svo_sort_move(__global const uint *from, uint index, __global uint *to, uint slot)
{
    for (uint word = 0; word < SVO_FRAGMENT_WORDS; ++word) {
        to[(size_t)slot * SVO_FRAGMENT_WORDS + word] = from[(size_t)index * SVO_FRAGMENT_WORDS + word];
    }
}

/* The block of this group, as indices of fragments. */
static uint2 svo_sort_block(uint count)
{
    return svo_sort_part((uint)get_group_id(0), (uint)get_num_groups(0), count);
}

#ifdef SVO_SORT_SERIAL

/* digits: receives how often each digit occurs in a block. */
static void svo_sort_count_block(__global const uint *fragments, svo_sort_params params, uint2 block,
                                 __local uint *digits)
{
    for (uint digit = 0; digit < 1u << params.bits; ++digit) {
        digits[digit] = 0u;
    }
    for (uint i = block.x; i < block.y; ++i) {
        ++digits[svo_sort_digit(fragments, i, params)];
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sort_count(__global const uint *fragments, __global uint *counts, svo_sort_params params, __local uint *digits)
{
    if (get_local_id(0) == 0) {
        svo_sort_count_block(fragments, params, svo_sort_block(params.fragment_count), digits);
        for (uint digit = 0; digit < 1u << params.bits; ++digit) {
            counts[digit * get_num_groups(0) + get_group_id(0)] = digits[digit];
        }
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sort_scatter(__global const uint *from, __global uint *to, __global const uint *before, svo_sort_params params,
                   __local uint *digits)
{
    if (get_local_id(0) == 0) {
        const uint2 block = svo_sort_block(params.fragment_count);
        for (uint digit = 0; digit < 1u << params.bits; ++digit) {
            digits[digit] = before[digit * get_num_groups(0) + get_group_id(0)];
        }
        for (uint i = block.x; i < block.y; ++i) {
            svo_sort_move(from, i, to, digits[svo_sort_digit(from, i, params)]++);
        }
    }
}

#else

/* digits: a count for each. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sort_count(__global const uint *fragments, __global uint *counts, svo_sort_params params,
                 volatile __local uint *digits)
{
    const uint2 block = svo_sort_block(params.fragment_count);
    const uint item = (uint)get_local_id(0);
    for (uint digit = item; digit < 1u << params.bits; digit += SVO_GROUP_ITEMS) {
        digits[digit] = 0u;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = block.x + item; i < block.y; i += SVO_GROUP_ITEMS) {
        atomic_inc(digits + svo_sort_digit(fragments, i, params));
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint digit = item; digit < 1u << params.bits; digit += SVO_GROUP_ITEMS) {
        counts[digit * get_num_groups(0) + get_group_id(0)] = digits[digit];
    }
}

/* Of the work-items before this one, how many have a bit among those of a digit. */
static uint svo_sort_rank(volatile __local const uint *bits)
{
    const uint item = (uint)get_local_id(0);
    uint rank = popcount(bits[item / 32u] & ((1u << item % 32u) - 1u));
    for (uint word = 0; word < item / 32u; ++word) {
        rank += popcount(bits[word]);
    }
    return rank;
}

/* digits: for each one the place of its next fragment, then for each one SVO_SORT_ITEM_WORDS words with a bit
   for each work-item. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_sort_scatter(__global const uint *from, __global uint *to, __global const uint *before, svo_sort_params params,
                   volatile __local uint *digits)
{
    const uint2 block = svo_sort_block(params.fragment_count);
    const uint item = (uint)get_local_id(0);
    volatile __local uint *bits = digits + (1u << params.bits);
    for (uint digit = item; digit < 1u << params.bits; digit += SVO_GROUP_ITEMS) {
        digits[digit] = before[digit * get_num_groups(0) + get_group_id(0)];
        for (uint word = 0; word < SVO_SORT_ITEM_WORDS; ++word) {
            bits[digit * SVO_SORT_ITEM_WORDS + word] = 0u;
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint tile = block.x; tile < block.y; tile += SVO_GROUP_ITEMS) {
        const bool has_fragment = item < block.y - tile;
        const uint own = has_fragment ? svo_sort_digit(from, tile + item, params) : 0u;
        volatile __local uint *of_own = bits + own * SVO_SORT_ITEM_WORDS;
        if (has_fragment) {
            atomic_or(of_own + item / 32u, 1u << item % 32u);
        }
        barrier(CLK_LOCAL_MEM_FENCE);
        if (has_fragment) {
            svo_sort_move(from, tile + item, to, digits[own] + svo_sort_rank(of_own));
        }
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint digit = item; digit < 1u << params.bits; digit += SVO_GROUP_ITEMS) {
            for (uint word = 0; word < SVO_SORT_ITEM_WORDS; ++word) {
                digits[digit] += popcount(bits[digit * SVO_SORT_ITEM_WORDS + word]);
                bits[digit * SVO_SORT_ITEM_WORDS + word] = 0u;
            }
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

#endif
