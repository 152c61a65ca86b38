/* SPDX-License-Identifier: MIT */
/*
 * Splits ranges of more than params.subtree_items items, all of a level of the binary tree at once, as subtree.cl
 * splits smaller ones: the result does not depend on which of the two does it, nor on the chunks.
 *
 *   svo_k_bvh_bin    per chunk of a range: fills bins
 *   svo_k_bvh_cut    per range: joins the bins of its chunks and chooses the split; per chunk, where its items go. The
 *                    parts become ranges of the next level, smaller ones jobs of subtree.cl
 *   svo_k_bvh_part   per chunk: moves the items to the other buffer, in order, and joins the centers of the parts
 *
 * Launch: a group of SVO_BVH_LANES per range or chunk, or more groups: the state says how many there are. Atomics:
 * minima and maxima, which no order changes, and the order of ranges and jobs, which changes no result.
 */
#include "bvh/binning.clh"

/* The items of a chunk, as their indices in the range: first and one past last. */
static uint2 svo_bvh_chunk(__global const svo_bvh_range *range, uint chunk, uint chunk_items)
{
    const uint begin = (chunk - range->chunk_begin) * chunk_items;
    return (uint2)(begin, min(begin + chunk_items, range->count));
}

/* chunk_ranges: the range of each chunk. chunk_boxes, chunk_counts: receive its bins. */
SVO_BVH_LANES_KERNEL svo_k_bvh_bin(__global const svo_bvh_range *ranges, __global const uint *chunk_ranges,
                                   __global const float8 *items, __global float8 *chunk_boxes,
                                   __global uint *chunk_counts, __global const svo_bvh_state *state,
                                   svo_bvh_params params, __local svo_bvh_room *room)
{
    const uint chunk = (uint)get_group_id(0);
    if (chunk >= state->chunk_count[params.level]) {
        return;
    }
    __global const svo_bvh_range *range = ranges + chunk_ranges[chunk];
    const uint2 part = svo_bvh_chunk(range, chunk, params.chunk_items);
    const svo_bvh_binning by = svo_bvh_place_bins(range->count, svo_bvh_centers_of(range));
    svo_bvh_fill_bins(items + range->first + part.x, part.y - part.x, &by, room);
    const size_t to = (size_t)chunk * SVO_BVH_CELLS;
    for (uint k = svo_bvh_lane(); k < SVO_BVH_CELLS; k += SVO_BVH_LANES) {
        chunk_boxes[to + k] = room->boxes[k];
        chunk_counts[to + k] = room->counts[k];
    }
}

/* The bins of a range, from those of its chunks. */
SVO_INLINED void svo_bvh_join_bins(__global const float8 *chunk_boxes, __global const uint *chunk_counts,
                                   uint chunk_count, __local svo_bvh_room *room)
{
    for (uint k = svo_bvh_lane(); k < SVO_BVH_CELLS; k += SVO_BVH_LANES) {
        float8 box = SVO_BVH_EMPTY_BIN;
        uint count = 0u;
        for (uint chunk = 0; chunk < chunk_count; ++chunk) {
            box = min(box, chunk_boxes[(size_t)chunk * SVO_BVH_CELLS + k]);
            count += chunk_counts[(size_t)chunk * SVO_BVH_CELLS + k];
        }
        room->boxes[k] = box;
        room->counts[k] = count;
    }
    svo_bvh_meet();
}

/* Items of a chunk in the first part. chunk: its number in the range, with the counts of its bins. */
static uint svo_bvh_chunk_front(const svo_bvh_cut *cut, __global const uint *counts, uint chunk, uint chunk_items)
{
    if (cut->axis == SVO_BVH_BY_COUNT) {
        const uint before = chunk * chunk_items;
        return cut->front > before ? min(cut->front - before, chunk_items) : 0u;
    }
    uint front = 0u;
    for (uint k = 0; k < cut->at; ++k) {
        front += counts[(size_t)chunk * SVO_BVH_CELLS + cut->axis * SVO_BVH_BINS + k];
    }
    return front;
}

/* Per chunk of a range, the range and the items of the first part before the chunk. */
SVO_INLINED void svo_bvh_place_chunks(uint2 range_and_chunks, const svo_bvh_cut *cut, __global const uint *counts,
                                      __global uint2 *places, uint chunk_items, __local uint *scratch)
{
    const uint2 strip = svo_bvh_strip(0u, range_and_chunks.y);
    uint sum = 0u;
    for (uint i = strip.x; i < strip.y; ++i) {
        sum += svo_bvh_chunk_front(cut, counts, i, chunk_items);
    }
    uint front = svo_bvh_before(sum, scratch);
    for (uint i = strip.x; i < strip.y; ++i) {
        places[i] = (uint2)(range_and_chunks.x, front);
        front += svo_bvh_chunk_front(cut, counts, i, chunk_items);
    }
}

/* A part of a range: a range of the next level, whose index is returned, or a job. */
static uint svo_bvh_add_part(svo_bvh_job part, __global svo_bvh_range *next, __global svo_bvh_job *jobs,
                             __global svo_bvh_state *state, svo_bvh_params params)
{
    if (part.count <= params.subtree_items) {
        part.halvings |= params.level % 2u == 0u ? SVO_BVH_IN_B : 0u; /* where the items go */
        jobs[atomic_inc(&state->job_count)] = part;
        return SVO_BVH_NO_RANGE;
    }
    const uint index = atomic_inc(&state->range_count[params.level + 1u]);
    const uint chunks = svo_bvh_chunks_of(part.count, params.chunk_items);
    svo_bvh_begin_range(next + index, part, atomic_add(&state->chunk_count[params.level + 1u], chunks));
    return index;
}

/* Tells the chunks of a range which one theirs is, for all lanes. */
static void svo_bvh_mark_chunks(__global const svo_bvh_range *ranges, uint index, __global uint *chunk_ranges,
                                uint chunk_items)
{
    const uint chunks = svo_bvh_chunks_of(ranges[index].count, chunk_items);
    for (uint i = svo_bvh_lane(); i < chunks; i += SVO_BVH_LANES) {
        chunk_ranges[ranges[index].chunk_begin + i] = index;
    }
}

/* chunk_places: receives the range of each chunk, and the items of its first part before the chunk. chunk_ranges: of
   the next level. */
SVO_BVH_LANES_KERNEL svo_k_bvh_cut(__global svo_bvh_range *ranges, __global svo_bvh_range *next,
                                   __global svo_bvh_job *jobs, __global svo_bvh_branch *branches,
                                   __global const float8 *chunk_boxes, __global const uint *chunk_counts,
                                   __global uint2 *chunk_places, __global uint *chunk_ranges,
                                   __global svo_bvh_state *state, svo_bvh_params params, __local svo_bvh_room *room)
{
    const uint index = (uint)get_group_id(0);
    if (index >= state->range_count[params.level]) {
        return;
    }
    __global svo_bvh_range *range = ranges + index;
    const uint chunk_count = svo_bvh_chunks_of(range->count, params.chunk_items);
    const size_t chunk = range->chunk_begin;
    const size_t cell = chunk * SVO_BVH_CELLS;
    const float area = branches[range->link >> 1].area[range->link & 1u];
    svo_bvh_cut cut = svo_bvh_cut_by_count(range->count, area);
    if (svo_bvh_is_free(range->count, range->halvings)) {
        svo_bvh_join_bins(chunk_boxes + cell, chunk_counts + cell, chunk_count, room);
        svo_bvh_find_cut(room, SVO_BVH_BINS, range->count, area, &cut);
    }
    const uint split = range->first + cut.front;
    if (svo_bvh_lane() == 0u) {
        const svo_bvh_job all = {range->first, range->count, range->halvings, range->link};
        range->axis = cut.axis;
        range->at = cut.at;
        range->front = cut.front;
        svo_bvh_write_branch(branches, all.link, split, cut.areas[0], cut.areas[1]);
        range->part[0] = svo_bvh_add_part(svo_bvh_first_part(all, split), next, jobs, state, params);
        range->part[1] = svo_bvh_add_part(svo_bvh_second_part(all, split), next, jobs, state, params);
    }
    svo_bvh_meet();
    svo_bvh_place_chunks((uint2)(index, chunk_count), &cut, chunk_counts + cell, chunk_places + chunk,
                         params.chunk_items, room->scratch);
    for (uint i = 0; i < 2u; ++i) {
        if (range->part[i] != SVO_BVH_NO_RANGE) {
            svo_bvh_mark_chunks(next, range->part[i], chunk_ranges, params.chunk_items);
        }
    }
}

SVO_BVH_LANES_KERNEL svo_k_bvh_part(__global const svo_bvh_range *ranges, __global svo_bvh_range *next,
                                    __global const float8 *from, __global float8 *to,
                                    __global const uint2 *chunk_places, __global const svo_bvh_state *state,
                                    svo_bvh_params params, __local uint *scratch)
{
    const uint chunk = (uint)get_group_id(0);
    if (chunk >= state->chunk_count[params.level]) {
        return;
    }
    const uint2 place = chunk_places[chunk];
    __global const svo_bvh_range *range = ranges + place.x;
    const uint2 part = svo_bvh_chunk(range, chunk, params.chunk_items);
    const svo_bvh_binning by = svo_bvh_place_bins(range->count, svo_bvh_centers_of(range));
    const svo_bvh_cut cut = {0.0f, range->axis, range->at, range->front, {0.0f, 0.0f}};
    svo_bvh_halves halves = {SVO_BVH_NO_CENTERS, SVO_BVH_NO_CENTERS};
    svo_bvh_part_items(from + range->first, to + range->first, part, place.y, &cut, &by, scratch, &halves);
    if (range->part[0] != SVO_BVH_NO_RANGE) {
        svo_bvh_publish_centers(halves.first, next + range->part[0], scratch);
    }
    if (range->part[1] != SVO_BVH_NO_RANGE) {
        svo_bvh_publish_centers(halves.second, next + range->part[1], scratch);
    }
}
