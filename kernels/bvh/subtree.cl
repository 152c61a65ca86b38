/* SPDX-License-Identifier: MIT */
/*
 * Splits ranges of at most params.subtree_items items down to leaves, by the surface area heuristic; the binary tree
 * that results is stored as branches (layout.h), and the items' triangles in their order.
 *
 * Launch: a group of SVO_BVH_LANES per job. Each split moves the items of its range from one of two buffers to the
 * other. Writes branches and the order. Atomics in local memory: minima, maxima and counts, which no order changes.
 */
#include "bvh/binning.clh"

/* Splits a range of more items than a leaf holds. from, to: its first item. */
SVO_INLINED void svo_bvh_split(__global const float8 *from, __global float8 *to, uint count, uint halvings, float area,
                               __local svo_bvh_room *room, svo_bvh_cut *cut)
{
    *cut = svo_bvh_cut_by_count(count, area);
    if (!svo_bvh_is_free(count, halvings)) {
        return;
    }
    svo_bvh_centers centers = SVO_BVH_NO_CENTERS;
    for (uint i = svo_bvh_lane(); i < count; i += SVO_BVH_LANES) {
        svo_bvh_centers_grow(&centers, svo_bvh_center(from[i]));
    }
    svo_bvh_join_centers(&centers, room->scratch);
    const svo_bvh_binning by = svo_bvh_place_bins(count, centers);
    svo_bvh_fill_bins(from, count, &by, room);
    svo_bvh_find_cut(room, by.bin_count, count, area, cut);
    if (cut->axis != SVO_BVH_BY_COUNT) {
        svo_bvh_halves unused = {SVO_BVH_NO_CENTERS, SVO_BVH_NO_CENTERS};
        svo_bvh_part_items(from, to, (uint2)(0u, count), 0u, cut, &by, room->scratch, &unused);
    }
}

/* A leaf: no branch. */
static void svo_bvh_end_range(svo_bvh_job range, __global const float8 *items, __global svo_bvh_branch *branches,
                              __global uint *order)
{
    const uint lane = svo_bvh_lane();
    if (lane == 0u) {
        branches[range.link >> 1].part[range.link & 1u] = 0u;
    }
    for (uint i = range.first + lane; i < range.first + range.count; i += SVO_BVH_LANES) {
        order[i] = svo_bvh_item_triangle(items[i]);
    }
}

SVO_BVH_LANES_KERNEL svo_k_bvh_subtrees(__global const svo_bvh_job *jobs, __global float8 *items_a,
                                        __global float8 *items_b, __global svo_bvh_branch *branches,
                                        __global uint *order, __local svo_bvh_room *room)
{
    uint height = 1u;
    if (svo_bvh_lane() == 0u) {
        room->stack[0] = jobs[get_group_id(0)];
    }
    svo_bvh_meet();
    while (height > 0u) {
        svo_bvh_job range = room->stack[--height];
        const uint in_b = range.halvings & SVO_BVH_IN_B;
        __global float8 *items = in_b != 0u ? items_b : items_a;
        __global float8 *others = in_b != 0u ? items_a : items_b;
        range.halvings &= ~SVO_BVH_IN_B;
        if (range.count <= SVO_RAY_LEAF_TRIANGLES) {
            svo_bvh_end_range(range, items, branches, order);
        } else {
            const float area = branches[range.link >> 1].area[range.link & 1u];
            svo_bvh_cut cut;
            svo_bvh_split(items + range.first, others + range.first, range.count, range.halvings, area, room, &cut);
            svo_bvh_meet();
            range.halvings |= cut.axis != SVO_BVH_BY_COUNT ? in_b ^ SVO_BVH_IN_B : in_b;
            if (svo_bvh_lane() == 0u) {
                const uint split = range.first + cut.front;
                svo_bvh_write_branch(branches, range.link, split, cut.areas[0], cut.areas[1]);
                room->stack[height] = svo_bvh_second_part(range, split);
                room->stack[height + 1u] = svo_bvh_first_part(range, split);
            }
            height += 2u;
            svo_bvh_meet();
        }
    }
}
