/* SPDX-License-Identifier: MIT */
/*
 * Splits ranges of more than params.subtree_items items, all of a level of the binary tree at once, as subtree.cl
 * splits smaller ones: the result does not depend on which of the two does it, nor on the chunks.
 *
 *   svo_k_bvh_bin    per chunk of a range: fills bins
 *   svo_k_bvh_cut    per range: joins the bins of its chunks and chooses the split; per chunk, where its items go
 *   svo_k_bvh_next   the ranges of the next level; smaller parts become jobs of subtree.cl
 *   svo_k_bvh_part   per chunk: moves the items to the other buffer, in order, and joins the centers of the parts
 *
 * Launch: bin, part: a work-item per chunk; cut: a group of SVO_GROUP_ITEMS per range; next: one work-item. Atomics:
 * minima and maxima of centers, which no order changes. Local memory is an argument, see group.clh.
 */
#include "bvh/binning.clh"
#include "shared/group.clh"

/* The range of a chunk. */
static uint svo_bvh_range_of(__global const svo_bvh_range *ranges, uint range_count, uint chunk)
{
    uint low = 0u;
    uint high = range_count;
    while (high - low > 1u) {
        const uint middle = (low + high) / 2u;
        if (ranges[middle].chunk_begin <= chunk) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* The items of a chunk, as their indices in the range: first and one past last. */
static uint2 svo_bvh_chunk(__global const svo_bvh_range *range, uint chunk, uint chunk_items)
{
    const uint begin = (chunk - range->chunk_begin) * chunk_items;
    return (uint2)(begin, min(begin + chunk_items, range->count));
}

__kernel void svo_k_bvh_bin(__global const svo_bvh_range *ranges, __global const float8 *items,
                            __global float8 *chunk_boxes, __global uint *chunk_counts, svo_bvh_params params)
{
    const uint chunk = (uint)get_global_id(0);
    if (chunk >= params.chunk_count) {
        return;
    }
    __global const svo_bvh_range *range = ranges + svo_bvh_range_of(ranges, params.range_count, chunk);
    const uint2 part = svo_bvh_chunk(range, chunk, params.chunk_items);
    const svo_bvh_binning by = svo_bvh_place_bins(range->count, svo_bvh_centers_of(range));
    svo_bvh_bins bins;
    svo_bvh_fill_bins(items + range->first + part.x, part.y - part.x, &by, &bins);
    const size_t to = (size_t)chunk * SVO_BVH_CELLS;
    for (uint k = 0; k < SVO_BVH_CELLS; ++k) {
        chunk_boxes[to + k] = bins.boxes[k];
        chunk_counts[to + k] = bins.counts[k];
    }
}

/* One bin over all chunks of a range. */
static void svo_bvh_join_bin(__global const float8 *chunk_boxes, __global const uint *chunk_counts, uint chunk_count,
                             uint k, __local float8 *boxes, __local uint *counts)
{
    float8 box = SVO_BVH_EMPTY_BOX;
    uint count = 0u;
    for (uint chunk = 0; chunk < chunk_count; ++chunk) {
        box = min(box, chunk_boxes[(size_t)chunk * SVO_BVH_CELLS + k]);
        count += chunk_counts[(size_t)chunk * SVO_BVH_CELLS + k];
    }
    boxes[k] = box;
    counts[k] = count;
}

/* Chooses the split of a range from all its bins. */
static void svo_bvh_choose(__global svo_bvh_range *range, __global svo_bvh_branch *branches,
                           __local const float8 *boxes, __local const uint *counts)
{
    const float area = branches[range->link >> 1].area[range->link & 1u];
    svo_bvh_cut cut = svo_bvh_cut_by_count(range->count, area);
    if (svo_bvh_is_free(range->count, range->halvings)) {
        svo_bvh_bins bins;
        for (uint k = 0; k < SVO_BVH_CELLS; ++k) {
            bins.boxes[k] = boxes[k];
            bins.counts[k] = counts[k];
        }
        cut = svo_bvh_find_cut(&bins, SVO_BVH_BINS, range->count, area);
    }
    range->axis = cut.axis;
    range->at = cut.at;
    range->front = cut.front;
    svo_bvh_write_branch(branches, range->link, range->first + cut.front, cut.areas[0], cut.areas[1]);
}

/* Items of a chunk in the first part. chunk: its number in the range, with the counts of its bins. */
static uint svo_bvh_chunk_front(__global const svo_bvh_range *range, __global const uint *counts, uint chunk,
                                uint chunk_items)
{
    if (range->axis == SVO_BVH_BY_COUNT) {
        const uint before = chunk * chunk_items;
        return range->front > before ? min(range->front - before, chunk_items) : 0u;
    }
    uint front = 0u;
    for (uint k = 0; k < range->at; ++k) {
        front += counts[(size_t)chunk * SVO_BVH_CELLS + range->axis * SVO_BVH_BINS + k];
    }
    return front;
}

/* Per chunk, the items of the first part before it. Each work-item of the group takes a strip of chunks. */
static void svo_bvh_place_chunks(__global const svo_bvh_range *range, __global const uint *counts,
                                 __global uint *fronts, uint chunk_items, __local uint *scratch)
{
    const uint chunk_count = svo_bvh_chunks_of(range->count, chunk_items);
    const uint length = (chunk_count + SVO_GROUP_ITEMS - 1u) / SVO_GROUP_ITEMS;
    const uint begin = min((uint)get_local_id(0) * length, chunk_count);
    const uint end = min(begin + length, chunk_count);
    uint sum = 0u;
    for (uint i = begin; i < end; ++i) {
        const uint front = svo_bvh_chunk_front(range, counts, i, chunk_items);
        fronts[i] = sum;
        sum += front;
    }
    uint total;
    const uint before = svo_group_exclusive(sum, scratch, &total);
    for (uint i = begin; i < end; ++i) {
        fronts[i] += before;
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bvh_cut(__global svo_bvh_range *ranges, __global svo_bvh_branch *branches, __global const float8 *chunk_boxes,
              __global const uint *chunk_counts, __global uint *chunk_fronts, svo_bvh_params params,
              __local float8 *boxes, __local uint *counts)
{
    __global svo_bvh_range *range = ranges + get_group_id(0);
    const uint item = (uint)get_local_id(0);
    const size_t chunk = range->chunk_begin;
    const size_t cell = chunk * SVO_BVH_CELLS;
    if (item < SVO_BVH_CELLS) {
        svo_bvh_join_bin(chunk_boxes + cell, chunk_counts + cell, svo_bvh_chunks_of(range->count, params.chunk_items),
                         item, boxes, counts);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item == 0u) {
        svo_bvh_choose(range, branches, boxes, counts);
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    svo_bvh_place_chunks(range, chunk_counts + cell, chunk_fronts + chunk, params.chunk_items, counts);
}

/* A part of a range: a range of the next level, whose index is returned, or a job. */
static uint svo_bvh_add_part(svo_bvh_job part, __global svo_bvh_range *next, __global svo_bvh_job *jobs,
                             __global svo_bvh_state *state, svo_bvh_params params)
{
    if (part.count <= params.subtree_items) {
        part.halvings |= params.in_b != 0u ? 0u : SVO_BVH_IN_B; /* where the items go */
        jobs[state->job_count++] = part;
        return SVO_BVH_NO_RANGE;
    }
    const uint index = state->range_count++;
    svo_bvh_begin_range(next + index, part, state->chunk_count);
    state->chunk_count += svo_bvh_chunks_of(part.count, params.chunk_items);
    return index;
}

__kernel void svo_k_bvh_next(__global svo_bvh_range *ranges, __global svo_bvh_range *next, __global svo_bvh_job *jobs,
                             __global svo_bvh_state *state, svo_bvh_params params)
{
    state->range_count = 0u;
    state->chunk_count = 0u;
    for (uint i = 0; i < params.range_count; ++i) {
        __global svo_bvh_range *range = ranges + i;
        const svo_bvh_job all = {range->first, range->count, range->halvings, range->link};
        const uint split = range->first + range->front;
        range->part[0] = svo_bvh_add_part(svo_bvh_first_part(all, split), next, jobs, state, params);
        range->part[1] = svo_bvh_add_part(svo_bvh_second_part(all, split), next, jobs, state, params);
    }
}

__kernel void svo_k_bvh_part(__global const svo_bvh_range *ranges, __global svo_bvh_range *next,
                             __global const float8 *from, __global float8 *to, __global const uint *chunk_fronts,
                             svo_bvh_params params)
{
    const uint chunk = (uint)get_global_id(0);
    if (chunk >= params.chunk_count) {
        return;
    }
    __global const svo_bvh_range *range = ranges + svo_bvh_range_of(ranges, params.range_count, chunk);
    const uint2 part = svo_bvh_chunk(range, chunk, params.chunk_items);
    const svo_bvh_binning by = svo_bvh_place_bins(range->count, svo_bvh_centers_of(range));
    const svo_bvh_cut cut = {0.0f, range->axis, range->at, range->front, {0.0f, 0.0f}};
    svo_bvh_centers first_centers = SVO_BVH_NO_CENTERS;
    svo_bvh_centers second_centers = SVO_BVH_NO_CENTERS;
    uint first = chunk_fronts[chunk];
    uint second = range->front + part.x - first;
    for (uint i = part.x; i < part.y; ++i) {
        const float8 item = from[range->first + i];
        if (svo_bvh_is_first(&cut, &by, item, i)) {
            to[range->first + first++] = item;
            svo_bvh_centers_grow(&first_centers, svo_bvh_center(item));
        } else {
            to[range->first + second++] = item;
            svo_bvh_centers_grow(&second_centers, svo_bvh_center(item));
        }
    }
    if (range->part[0] != SVO_BVH_NO_RANGE) {
        svo_bvh_centers_publish(&first_centers, next + range->part[0]);
    }
    if (range->part[1] != SVO_BVH_NO_RANGE) {
        svo_bvh_centers_publish(&second_centers, next + range->part[1]);
    }
}
