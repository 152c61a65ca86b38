/* SPDX-License-Identifier: MIT */
/*
 * Packs the leaf lists: contiguous ranges of triangles, sorted within a leaf. kernels/stages/pack.cl in GLSL.
 *
 *   SVO_K_COUNT       per fragment: lengths
 *   scan.comp         per leaf: where its range begins
 *   SVO_K_SCATTER     per fragment: writes its triangle into the range, in any order (lengths count down to 0)
 *   SVO_K_SORT_SHORT  per leaf: Shell sort of up to SVO_SHORT_LIST_MAX entries. Collects longer leaves in a list and
 *                     sizes the launch of SVO_K_SORT_LONG to it
 *   SVO_K_SORT_LONG   per long leaf, one group, once per digit: a pass of a stable radix sort by four bits, between
 *                     list and spare. One pass per launch and one leaf per group, since loops are limited
 *                     (compute.glsl)
 */
#define SVO_LONG_ROW 16384u /* groups in a row of a launch */

uniform svo_filter_params params;

#ifdef SVO_K_COUNT

layout(std430, binding = 0) readonly buffer Cursors
{
    uint cursors[];
};
layout(std430, binding = 1) buffer Counts
{
    uint counts[];
};

void main()
{
    uint index = svo_item();
    if (index >= params.fragment_count) {
        return;
    }
    uint leaf = cursors[index] - params.leaf_begin;
    if (svo_in_window(leaf)) {
        atomicAdd(counts[leaf - svo_first[1]], 1u);
    }
}

#endif

#ifdef SVO_K_SCATTER

layout(std430, binding = 1) readonly buffer Cursors
{
    uint cursors[];
};
layout(std430, binding = 2) buffer Counts
{
    uint counts[];
};
layout(std430, binding = 3) readonly buffer ListBegin
{
    uint list_begin[];
};
layout(std430, binding = 4) writeonly buffer List
{
    uint list[];
};

void main()
{
    uint index = svo_item();
    if (index >= params.fragment_count) {
        return;
    }
    uint leaf = cursors[index] - params.leaf_begin;
    if (svo_in_window(leaf)) {
        uint slot = list_begin[leaf - svo_first[3]] + atomicAdd(counts[leaf - svo_first[2]], 0xffffffffu) - 1u;
        list[slot - svo_first[4]] = svo_fragment_triangle(index);
    }
}

#endif

#ifdef SVO_K_SORT_SHORT

layout(std430, binding = 0) readonly buffer ListBegin
{
    uint list_begin[];
};
layout(std430, binding = 1) buffer List
{
    uint list[];
};
layout(std430, binding = 2) writeonly buffer LongLeaves
{
    uint long_leaves[];
};
layout(std430, binding = 3) buffer State
{
    svo_build_state state;
};
/* The groups of SVO_K_SORT_LONG: per row, and rows. */
layout(std430, binding = 4) buffer Launches
{
    uint launches[];
};

/* Sorts the entries that are a multiple of gap apart. */
void svo_sort_gap(uint begin, uint end, uint gap)
{
    for (uint i = begin + gap; i < end; ++i) {
        uint triangle = list[i];
        uint slot = i;
        for (uint k = i; k >= begin + gap && list[k - gap] > triangle; k -= gap) {
            list[k] = list[k - gap];
            slot = k - gap;
        }
        list[slot] = triangle;
    }
}

/* The gaps of kernels/stages/pack.cl. */
void svo_sort_short(uint begin, uint end)
{
    const uint gaps[6] = uint[6](132u, 57u, 23u, 10u, 4u, 1u);
    for (uint k = 0u; k < 6u; ++k) {
        svo_sort_gap(begin, end, gaps[k]);
    }
}

void main()
{
    uint leaf = window_begin + svo_item();
    if (!svo_in_window(leaf)) {
        return;
    }
    uint begin = list_begin[leaf - svo_first[0]] - svo_first[1];
    uint end = list_begin[leaf - svo_first[0] + 1u] - svo_first[1];
    if (end - begin > uint(SVO_SHORT_LIST_MAX)) {
        uint slot = atomicAdd(state.long_lists, 1u);
        long_leaves[slot] = leaf;
        atomicMax(launches[0], min(slot + 1u, SVO_LONG_ROW));
        atomicMax(launches[1], slot / SVO_LONG_ROW + 1u);
    } else {
        svo_sort_short(begin, end);
    }
}

#endif

#ifdef SVO_K_SORT_LONG

layout(std430, binding = 0) readonly buffer ListBegin
{
    uint list_begin[];
};
layout(std430, binding = 1) buffer List
{
    uint list[];
};
layout(std430, binding = 2) buffer Spare
{
    uint spare[];
};
layout(std430, binding = 3) readonly buffer LongLeaves
{
    uint long_leaves[];
};
layout(std430, binding = 4) readonly buffer State
{
    svo_build_state state;
};

shared uint digit_counts[SVO_DIGITS * SVO_GROUP_ITEMS];
shared uint scratch[SVO_GROUP_ITEMS];

/* digit_counts[digit * SVO_GROUP_ITEMS + item] becomes its exclusive sum over all digits and items. */
void svo_scan_digits()
{
    uint item = gl_LocalInvocationID.x;
    uint first = item * uint(SVO_DIGITS);
    uint sum = 0u;
    for (uint k = 0u; k < uint(SVO_DIGITS); ++k) {
        uint count = digit_counts[first + k];
        digit_counts[first + k] = sum;
        sum += count;
    }
    scratch[item] = sum;
    barrier();
    for (uint reach = 1u; reach < uint(SVO_GROUP_ITEMS); reach *= 2u) {
        uint before = item >= reach ? scratch[max(item, reach) - reach] : 0u;
        barrier();
        scratch[item] += before;
        barrier();
    }
    uint before = scratch[item] - sum;
    for (uint k = 0u; k < uint(SVO_DIGITS); ++k) {
        digit_counts[first + k] += before;
    }
    barrier();
}

uint svo_from(bool forth, uint index)
{
    return forth ? list[index] : spare[index];
}

uint svo_digit_slot(uint triangle, uint shift)
{
    return (triangle >> shift & uint(SVO_DIGITS - 1)) * uint(SVO_GROUP_ITEMS) + gl_LocalInvocationID.x;
}

/* One stable pass over length entries, starting at first, by the digit at shift, from list to spare or back. Each item
   owns a contiguous strip. */
void svo_radix_pass(bool forth, uint first, uint length, uint shift)
{
    uint item = gl_LocalInvocationID.x;
    uint strip = (length + uint(SVO_GROUP_ITEMS) - 1u) / uint(SVO_GROUP_ITEMS);
    uint begin = first + min(item * strip, length);
    uint end = min(begin + strip, first + length);
    for (uint digit = 0u; digit < uint(SVO_DIGITS); ++digit) {
        digit_counts[digit * uint(SVO_GROUP_ITEMS) + item] = 0u;
    }
    for (uint i = begin; i < end; ++i) {
        ++digit_counts[svo_digit_slot(svo_from(forth, i), shift)];
    }
    barrier();
    svo_scan_digits();
    for (uint i = begin; i < end; ++i) {
        uint triangle = svo_from(forth, i);
        uint digit_slot = svo_digit_slot(triangle, shift);
        uint slot = first + digit_counts[digit_slot];
        digit_counts[digit_slot] += 1u;
        if (forth) {
            spare[slot] = triangle;
        } else {
            list[slot] = triangle;
        }
    }
}

/* params.level: which pass. The same ranges of list and spare are bound. */
void main()
{
    uint k = gl_WorkGroupID.y * SVO_LONG_ROW + gl_WorkGroupID.x;
    if (k < state.long_lists) { /* uniform within the group */
        uint leaf = long_leaves[k] - svo_first[0];
        uint begin = list_begin[leaf];
        svo_radix_pass((params.level & 1u) == 0u, begin - svo_first[1], list_begin[leaf + 1u] - begin,
                       params.level * uint(SVO_DIGIT_BITS));
        svo_check_loops();
    }
}

#endif
