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
 * Launch: of brick.clh, on CPUs one work-item per node, rounded up to whole groups, on GPUs one group per node. No
 * atomics.
 */
#include "light/brick.clh"

#ifdef SVO_LIGHT_BRICKS

SVO_BRICK_GATHER(svo_brick_gather_opacity, ushort)

static uint svo_brick_sum_cells(SVO_BRICK_MEMORY const uint *cells, int sample)
{
    const int first = svo_brick_first_cell(sample);
    uint sum = 0u;
    for (int k = 0; k < 8; ++k) {
        sum += cells[first + svo_brick_next_cell(k)];
    }
    return sum;
}

static uint svo_brick_sum_points(SVO_BRICK_MEMORY const uint *points, int sample)
{
    const int first = svo_brick_first_point(sample);
    uint sum = 0u;
    for (int k = 0; k < 27; ++k) {
        uint weight_log2;
        const int next = svo_brick_next_point(k, &weight_log2);
        sum += points[first + next] << weight_log2;
    }
    return sum;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_leaves(__global const uchar *child_mask, __global const uint *first_child,
                         __global const ulong *codes, __global const ushort *leaves, __global const uint *origins,
                         __global ushort *samples, SVO_BRICK_PARAMETERS)
{
    const uint item = SVO_BRICK_ITEM;
    const uint node = params.first + item;
    if (item >= params.count || svo_light_is_kept(origins, node)) {
        return;
    }
    SVO_BRICK_MAKE(cells, points);
    svo_brick_cells(child_mask, first_child, codes, node, params.level, cells);
    for (int k = SVO_BRICK_LANE; k < SVO_BRICK_CELL_COUNT; k += SVO_BRICK_LANES) {
        cells[k] = cells[k] != SVO_NO_NODE ? leaves[cells[k] - params.leaf_begin] : 0u;
    }
    SVO_BRICK_SYNC();
    for (int k = SVO_BRICK_LANE; k < SVO_BRICK_SAMPLES; k += SVO_BRICK_LANES) {
        samples[SVO_BRICK_SAMPLES * (size_t)node + k] = (ushort)((svo_brick_sum_cells(cells, k) + 4u) >> 3);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_level(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                        __global const uint *origins, __global ushort *samples, SVO_BRICK_PARAMETERS)
{
    const uint item = SVO_BRICK_ITEM;
    const uint node = params.first + item;
    if (item >= params.count || svo_light_is_kept(origins, node)) {
        return;
    }
    SVO_BRICK_MAKE(cells, points);
    svo_brick_cells(child_mask, first_child, codes, node, params.level, cells);
    SVO_BRICK_SYNC();
    svo_brick_gather_opacity(cells, samples, points);
    for (int k = SVO_BRICK_LANE; k < SVO_BRICK_SAMPLES; k += SVO_BRICK_LANES) {
        samples[SVO_BRICK_SAMPLES * (size_t)node + k] = (ushort)((svo_brick_sum_points(points, k) + 32u) >> 6);
    }
}

#endif
