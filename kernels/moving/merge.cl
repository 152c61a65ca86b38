/* SPDX-License-Identifier: MIT */
/*
 * Merges two lists of kept pairs, each in the order of (code, object), and leaves out pairs of the first whose object
 * has changed. The lists are cut by diagonals, so that all work-items have as many pairs (Odeh, Green, Mwassi, Shmueli
 * and Birk, "Merge Path - Parallel Merging Made Simple", 2012).
 *
 *   svo_k_merge_count  per strip: how many of its pairs stay
 *   scan.cl            exclusive sums of the counts
 *   svo_k_merge_write  per strip: writes them
 *
 * Launch: one work-item per SVO_MERGE_STRIP pairs of both lists, rounded up to whole groups.
 * Atomics: marks are joined by atomic_or; the order does not matter.
 * Invariant: an object has pairs in one list, or those in the first are left out; so the order is that of (code,
 * object), and within these two that of the list.
 */
#include "moving/kept.clh"

/* A list: fragments and values. */
typedef struct svo_kept_list {
    __global const uint *fragments;
    __global const uint4 *values;
    uint count;
} svo_kept_list;

/* The part of a strip: from first to end in both lists. */
typedef struct svo_merge_part {
    uint2 first, end;
} svo_merge_part;

static ulong svo_merge_key(svo_kept_list list, uint index)
{
    return (ulong)svo_fragment_code(list.fragments, index) << 16 | svo_kept_object(list.values, index);
}

/* How many of the first diagonal pairs are of the first list, and of the second. */
static uint2 svo_merge_split(svo_kept_list a, svo_kept_list b, ulong diagonal)
{
    uint low = (uint)(diagonal > b.count ? diagonal - b.count : 0UL);
    uint high = (uint)min(diagonal, (ulong)a.count);
    while (low < high) {
        const uint middle = low + (high - low) / 2u;
        if (svo_merge_key(a, middle) <= svo_merge_key(b, (uint)(diagonal - 1UL - middle))) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return (uint2)(low, (uint)(diagonal - low));
}

static svo_merge_part svo_merge_part_of(svo_kept_list a, svo_kept_list b, uint strip)
{
    const ulong all = (ulong)a.count + b.count;
    const ulong begin = (ulong)strip * SVO_MERGE_STRIP;
    svo_merge_part part;
    part.first = svo_merge_split(a, b, min(begin, all));
    part.end = svo_merge_split(a, b, min(begin + SVO_MERGE_STRIP, all));
    return part;
}

static bool svo_is_dropped(__global const uint *dropped, svo_kept_list list, uint index)
{
    const uint object = svo_kept_object(list.values, index);
    return (dropped[object >> 5] >> (object & 31u) & 1u) != 0u;
}

/* A list's marks: for each SVO_MERGE_STRIP of its pairs, a bit for each object, modulo 32, that has any of them. */
static uint svo_mark_of(uint4 value)
{
    return 1u << (value.w >> SVO_KEPT_OBJECT_SHIFT & 31u);
}

/* Whether pairs from begin to end may be of objects with such marks. marks: NULL where they are not known. */
static bool svo_may_drop(__global const uint *marks, uint begin, uint end, uint sought)
{
    uint found = marks != 0 ? 0u : ~0u;
    for (uint i = begin / SVO_MERGE_STRIP; marks != 0 && (ulong)i * SVO_MERGE_STRIP < end; ++i) {
        found |= marks[i];
    }
    return (found & sought) != 0u;
}

/* a_marks: NULL where they are not known. a_count, b_count: see svo_kept_count. dropped: a bit for each object.
   counts: one of each strip. params.object: the marks of the objects that are left out. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_merge_count(__global const uint *a_fragments, __global const uint4 *a_values, __global const uint *a_marks,
                  __global const uint *b_fragments, __global const uint4 *b_values, __global const uint *a_count,
                  __global const uint *b_count, __global const uint *dropped, __global uint *counts,
                  svo_moving_params params)
{
    const svo_kept_list a = {a_fragments, a_values, svo_kept_count(params.count, a_count)};
    const svo_kept_list b = {b_fragments, b_values, svo_kept_count(params.other_count, b_count)};
    const uint strip = (uint)get_global_id(0);
    if ((ulong)strip * SVO_MERGE_STRIP >= (ulong)params.count + params.other_count) {
        return;
    }
    const svo_merge_part part = svo_merge_part_of(a, b, strip);
    uint count = part.end.x - part.first.x + part.end.y - part.first.y;
    if (svo_may_drop(a_marks, part.first.x, part.end.x, params.object)) {
        for (uint i = part.first.x; i < part.end.x; ++i) {
            count -= svo_is_dropped(dropped, a, i) ? 1u : 0u;
        }
    }
    counts[strip] = count;
}

/* Copies adjacent pairs. */
static void svo_copy_kept(__global const uint *from_fragments, __global const uint4 *from_values,
                          __global const uint *from_materials, uint from, uint count, __global uint *fragments,
                          __global uint4 *values, __global uint *materials, volatile __global uint *marks, uint to)
{
    const size_t first_word = (size_t)from * SVO_FRAGMENT_WORDS;
    const size_t to_word = (size_t)to * SVO_FRAGMENT_WORDS;
    for (uint i = 0; i < count * SVO_FRAGMENT_WORDS; ++i) {
        fragments[to_word + i] = from_fragments[first_word + i];
    }
    for (uint i = 0; i < count;) {
        const uint end = min(count, i + SVO_MERGE_STRIP - (to + i) % SVO_MERGE_STRIP);
        const uint block = (to + i) / SVO_MERGE_STRIP;
        uint found = 0u;
        for (; i < end; ++i) {
            const uint4 value = from_values[from + i];
            values[to + i] = value;
            found |= svo_mark_of(value);
        }
        atomic_or(marks + block, found);
    }
    for (uint i = 0; materials != 0 && i < count; ++i) {
        materials[to + i] = from_materials[from + i];
    }
}

#ifdef SVO_AREAS

static void svo_copy_areas(__global const uint4 *from, __global uint4 *to, uint count)
{
    for (uint i = 0; i < count; ++i) {
        to[i] = from[i];
    }
}

#endif

/* a_materials, b_materials, materials: NULL where none are needed. before: the sums of the counts. marks: zero at
   first. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_merge_write(__global const uint *a_fragments, __global const uint4 *a_values, __global const uint *a_materials,
                  __global const uint *b_fragments, __global const uint4 *b_values, __global const uint *b_materials,
                  __global const uint *a_count, __global const uint *b_count, __global const uint *dropped,
                  __global const uint *before, __global uint *fragments, __global uint4 *values,
                  __global uint *materials, volatile __global uint *marks,
                  svo_moving_params params SVO_AND_AREAS(const uint4, a_areas) SVO_AND_AREAS(const uint4, b_areas)
                      SVO_AND_AREAS(uint4, areas))
{
    const svo_kept_list a = {a_fragments, a_values, svo_kept_count(params.count, a_count)};
    const svo_kept_list b = {b_fragments, b_values, svo_kept_count(params.other_count, b_count)};
    const uint strip = (uint)get_global_id(0);
    if ((ulong)strip * SVO_MERGE_STRIP >= (ulong)a.count + b.count) {
        return;
    }
    const svo_merge_part part = svo_merge_part_of(a, b, strip);
    const uint written = before[strip + 1u] - before[strip];
    if (part.first.y == part.end.y && written == part.end.x - part.first.x) { /* as most strips of small changes are */
        svo_copy_kept(a_fragments, a_values, a_materials, part.first.x, written, fragments, values, materials, marks,
                      before[strip]);
#ifdef SVO_AREAS
        svo_copy_areas(a_areas + part.first.x, areas + before[strip], written);
#endif
        return;
    }
    if (written == 0u) {
        return;
    }
    uint2 next = part.first;
    uint slot = before[strip];
    uint found = 0u; /* marks of the pairs of this block of the output */
    while (next.x < part.end.x || next.y < part.end.y) {
        const bool of_a =
            next.y == part.end.y || (next.x < part.end.x && svo_merge_key(a, next.x) <= svo_merge_key(b, next.y));
        if (of_a && svo_is_dropped(dropped, a, next.x)) {
            ++next.x;
            continue;
        }
        const uint from = of_a ? next.x : next.y;
        svo_fragment_store(fragments, slot, svo_fragment_code(of_a ? a_fragments : b_fragments, from),
                           svo_fragment_triangle(of_a ? a_fragments : b_fragments, from));
        const uint4 value = (of_a ? a_values : b_values)[from];
        values[slot] = value;
        found |= svo_mark_of(value);
        if (materials != 0) {
            materials[slot] = (of_a ? a_materials : b_materials)[from];
        }
#ifdef SVO_AREAS
        areas[slot] = (of_a ? a_areas : b_areas)[from];
#endif
        ++slot;
        if (slot % SVO_MERGE_STRIP == 0u || slot == before[strip + 1u]) {
            atomic_or(marks + (slot - 1u) / SVO_MERGE_STRIP, found);
            found = 0u;
        }
        next += of_a ? (uint2)(1u, 0u) : (uint2)(0u, 1u);
    }
}
