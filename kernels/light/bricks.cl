/* SPDX-License-Identifier: MIT */
/*
 * Bricks: 27 samples for each inner node, at the corners of its children, index x + 3 y + 9 z. Each point of a level's
 * lattice has one value, which all bricks that touch the point hold; a node's brick finds it from the nodes around.
 *
 *   svo_k_light_brick_leaves  per node above the leaves: a sample is the mean of the eight leaf cells around its corner
 *   svo_k_light_brick_level   per node of a level above, upwards: every second point of the level below, by weights
 *                             (1, 2, 1) / 4 per axis. So the sum over the points of a level is an eighth of the sum
 *                             over those below, but for rounding
 *
 * Launch: one work-item per node, rounded up to whole groups. No atomics, no local memory.
 */
#include "light/brick.clh"

#ifdef SVO_LIGHT_BRICKS

SVO_BRICK_GATHER(svo_brick_gather_opacity, ushort)

/* Sums of weight 2^weight_log2 to the samples of a brick, rounded half up. */
static void svo_brick_store(const ulong *sums, uint weight_log2, uint node, __global ushort *samples)
{
    for (uint k = 0; k < SVO_BRICK_SAMPLES; ++k) {
        const ulong half_unit = 1ul << (weight_log2 - 1u);
        samples[SVO_BRICK_SAMPLES * (size_t)node + k] = (ushort)((sums[k] + half_unit) >> weight_log2);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_leaves(__global const uchar *child_mask, __global const uint *first_child,
                         __global const ulong *codes, __global const ushort *leaves, __global const uint *origins,
                         __global ushort *samples, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count || svo_light_is_kept(origins, params.first + item)) {
        return;
    }
    uint cells[SVO_BRICK_CELL_COUNT];
    ulong sums[SVO_BRICK_SAMPLES];
    svo_brick_cells(child_mask, first_child, codes, params.first + item, params.level, cells);
    for (uint k = 0; k < SVO_BRICK_CELL_COUNT; ++k) {
        cells[k] = cells[k] != SVO_NO_NODE ? leaves[cells[k] - params.leaf_begin] : 0u;
    }
    svo_brick_sum_cells(cells, sums);
    svo_brick_store(sums, 3u, params.first + item, samples);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_level(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                        __global const uint *origins, __global ushort *samples, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count || svo_light_is_kept(origins, params.first + item)) {
        return;
    }
    uint cells[SVO_BRICK_CELL_COUNT];
    uint points[SVO_BRICK_POINT_COUNT];
    ulong sums[SVO_BRICK_SAMPLES];
    svo_brick_cells(child_mask, first_child, codes, params.first + item, params.level, cells);
    svo_brick_gather_opacity(cells, samples, points);
    svo_brick_sum_points(points, sums);
    svo_brick_store(sums, 6u, params.first + item, samples);
}

#endif
