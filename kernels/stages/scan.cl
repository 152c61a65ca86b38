/* SPDX-License-Identifier: MIT */
/*
 * Exclusive prefix sums over millions of small numbers: reduce, then add (Blelloch, "Prefix Sums and Their
 * Applications", 1990). There is no look-back and no spinning, since work-groups may run one after the other.
 *
 *   reduce  each group sums a contiguous range of whole tiles into its partial
 *   add     the same groups: exclusive sums inside the range, on top of the partials of the groups before; the last
 *           group writes the total. Groups are few, so each adds up those partials for itself
 *
 * A tile is SVO_GROUP_ITEMS work-items times 16 consecutive elements. The host launches as many groups as there may be
 * tiles, and no more than the device needs; the sums are the same for any number of groups. The elements are the
 * lengths of leaf lists, or of whatever other programs count.
 * Launch: as above, in groups of SVO_GROUP_ITEMS. No atomics. Local memory, SVO_GROUP_ITEMS words, is an argument, see
 * group.clh.
 */
#include "shared/group.clh"
#include "shared/state.clh"

#define SVO_ITEM_ELEMENTS 16u
#define SVO_TILE_ELEMENTS ((uint)SVO_SCAN_TILE)

/* The tiles of this group: first and one past last element, of count elements in all. */
static uint2 svo_group_range(uint count)
{
    const uint tiles = count / SVO_TILE_ELEMENTS + (count % SVO_TILE_ELEMENTS != 0u ? 1u : 0u);
    const uint groups = (uint)get_num_groups(0);
    const uint tiles_per_group = (tiles + groups - 1u) / groups;
    const uint group = (uint)get_group_id(0);
    /* The host keeps counts some tiles below 2^32 (SVO_I_FRAGMENTS_MAX), so nothing here wraps. */
    const uint first = min(group * tiles_per_group, tiles);
    const uint last = min(first + tiles_per_group, tiles);
    return (uint2)(first * SVO_TILE_ELEMENTS, last == tiles ? count : last * SVO_TILE_ELEMENTS);
}

/* Sixteen elements from index on; those from end on count as 0. */
static uint16 svo_list_counts(__global const uint *counts, uint index, uint end)
{
    if (index + SVO_ITEM_ELEMENTS <= end) {
        return vload16(0, counts + index);
    }
    uint elements[SVO_ITEM_ELEMENTS];
    for (uint k = 0; k < SVO_ITEM_ELEMENTS; ++k) {
        elements[k] = index + k < end ? counts[index + k] : 0u;
    }
    return vload16(0, elements);
}

static uint svo_sum16(uint16 v)
{
    const uint8 a = v.lo + v.hi;
    const uint4 b = a.lo + a.hi;
    const uint2 c = b.lo + b.hi;
    return c.x + c.y;
}

/* Writes sum + (exclusive sums of v) to out[index ..], up to end. */
static void svo_store_prefixes(uint16 v, uint sum, __global uint *out, uint index, uint end)
{
    uint elements[SVO_ITEM_ELEMENTS];
    vstore16(v, 0, elements);
    for (uint k = 0; k < SVO_ITEM_ELEMENTS; ++k) {
        const uint element = elements[k];
        elements[k] = sum;
        sum += element;
    }
    if (index + SVO_ITEM_ELEMENTS <= end) {
        vstore16(vload16(0, elements), 0, out + index);
        return;
    }
    for (uint k = 0; k < SVO_ITEM_ELEMENTS && index + k < end; ++k) {
        out[index + k] = elements[k];
    }
}

/* The sum of the partials of the groups before this one. */
SVO_INLINED uint svo_sum_before(__global const uint *partials, __local uint *scratch)
{
    const uint group = (uint)get_group_id(0);
    uint sum = 0;
    for (uint k = (uint)get_local_id(0); k < group; k += SVO_GROUP_ITEMS) {
        sum += partials[k];
    }
    uint total;
    (void)svo_group_exclusive(sum, scratch, &total);
    return total;
}

#if defined(SVO_RANGES) || defined(SVO_SORT)

/* The lengths of the leaves' lists; for the sort, numbers of any kind. */
static uint svo_count_numbers(svo_filter_params params, __global const svo_build_state *state)
{
#ifdef SVO_SORT
    (void)state;
    return params.leaf_count;
#else
    return svo_count_leaves(params.depth, state);
#endif
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scan_lists_reduce(__global const uint *counts, __global uint *partials, __global const svo_build_state *state,
                        svo_filter_params params, __local uint *scratch)
{
    const uint2 range = svo_group_range(svo_count_numbers(params, state));
    uint sum = 0;
    for (uint i = range.x + (uint)get_local_id(0) * SVO_ITEM_ELEMENTS; i < range.y; i += SVO_TILE_ELEMENTS) {
        sum += svo_sum16(svo_list_counts(counts, i, range.y));
    }
    const uint total = svo_group_sum(sum, scratch);
    if (get_local_id(0) == 0) {
        partials[get_group_id(0)] = total;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_scan_lists_add(__global const uint *counts, __global const uint *partials, __global uint *list_begin,
                     __global const svo_build_state *state, svo_filter_params params, __local uint *scratch)
{
    const uint count = svo_count_numbers(params, state);
    const uint2 range = svo_group_range(count);
    uint sum = svo_sum_before(partials, scratch);
    for (uint tile = range.x; tile < range.y; tile += SVO_TILE_ELEMENTS) {
        const uint i = tile + (uint)get_local_id(0) * SVO_ITEM_ELEMENTS;
        const uint16 lengths = svo_list_counts(counts, i, range.y);
        uint total;
        const uint before = svo_group_exclusive(svo_sum16(lengths), scratch, &total);
        svo_store_prefixes(lengths, sum + before, list_begin, i, range.y);
        sum += total;
    }
    if (get_local_id(0) == 0u && get_group_id(0) + 1u == get_num_groups(0)) {
        list_begin[count] = sum;
    }
}

#endif
