/* SPDX-License-Identifier: MIT */
/*
 * Splits ranges of at most params.subtree_items items down to leaves, by the surface area heuristic; the binary tree
 * that results is stored as branches (layout.h), and the items' triangles in their order.
 *
 * Launch: one work-item per job. Reads and sorts the items of the job, in that of two buffers where they are. Writes
 * branches and the order. No atomics, no local memory.
 */
#include "bvh/binning.clh"

/* Moves the items of the first part to the front; all stay in order. spare: room for as many items. */
static void svo_bvh_part_items(__global float8 *items, __global float8 *spare, uint count, const svo_bvh_cut *cut,
                               const svo_bvh_binning *by)
{
    uint front = 0u;
    uint back = 0u;
    for (uint i = 0; i < count; ++i) {
        const float8 item = items[i];
        const bool is_first = svo_bvh_is_first(cut, by, item, i);
        items[front] = item;
        spare[back] = item;
        front += is_first ? 1u : 0u;
        back += is_first ? 0u : 1u;
    }
    for (uint i = 0; i < back; ++i) {
        items[front + i] = spare[i];
    }
}

/* Splits a range of more items than a leaf holds. */
static svo_bvh_cut svo_bvh_split(__global float8 *items, __global float8 *spare, uint count, uint halvings, float area)
{
    if (!svo_bvh_is_free(count, halvings)) {
        return svo_bvh_cut_by_count(count, area);
    }
    svo_bvh_bins bins;
    svo_bvh_centers centers = SVO_BVH_NO_CENTERS;
    for (uint i = 0; i < count; ++i) {
        svo_bvh_centers_grow(&centers, svo_bvh_center(items[i]));
    }
    const svo_bvh_binning by = svo_bvh_place_bins(count, centers);
    svo_bvh_fill_bins(items, count, &by, &bins);
    const svo_bvh_cut cut = svo_bvh_find_cut(&bins, by.bin_count, count, area);
    if (cut.axis != SVO_BVH_BY_COUNT) {
        svo_bvh_part_items(items, spare, count, &cut, &by);
    }
    return cut;
}

/* A leaf: no branch. */
static void svo_bvh_end_range(svo_bvh_job range, __global const float8 *items, __global svo_bvh_branch *branches,
                              __global uint *order)
{
    branches[range.link >> 1].part[range.link & 1u] = 0u;
    for (uint i = range.first; i < range.first + range.count; ++i) {
        order[i] = svo_bvh_item_triangle(items[i]);
    }
}

__kernel void svo_k_bvh_subtrees(__global const svo_bvh_job *jobs, __global float8 *items_a, __global float8 *items_b,
                                 __global svo_bvh_branch *branches, __global uint *order, uint job_count)
{
    if (get_global_id(0) >= job_count) {
        return;
    }
    svo_bvh_job stack[SVO_BVH_DEPTH_MAX + 1];
    uint height = 1u;
    stack[0] = jobs[get_global_id(0)];
    const bool in_b = (stack[0].halvings & SVO_BVH_IN_B) != 0u;
    __global float8 *items = in_b ? items_b : items_a;
    __global float8 *spare = in_b ? items_a : items_b;
    stack[0].halvings &= ~SVO_BVH_IN_B;
    while (height > 0u) {
        const svo_bvh_job range = stack[--height];
        if (range.count <= SVO_RAY_LEAF_TRIANGLES) {
            svo_bvh_end_range(range, items, branches, order);
            continue;
        }
        const float area = branches[range.link >> 1].area[range.link & 1u];
        const svo_bvh_cut cut =
            svo_bvh_split(items + range.first, spare + range.first, range.count, range.halvings, area);
        const uint split = range.first + cut.front;
        svo_bvh_write_branch(branches, range.link, split, cut.areas[0], cut.areas[1]);
        stack[height++] = svo_bvh_second_part(range, split);
        stack[height++] = svo_bvh_first_part(range, split);
    }
}
