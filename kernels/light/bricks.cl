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

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_leaves(__global const uchar *child_mask, __global const uint *first_child,
                         __global const ulong *codes, __global const ushort *leaves, __global ushort *samples,
                         svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    uint cells[64];
    svo_brick_cells(child_mask, first_child, codes, params.first + item, params.level, cells);
    for (uint k = 0; k < 64u; ++k) {
        cells[k] = cells[k] != SVO_NO_NODE ? leaves[cells[k] - params.leaf_begin] : 0u;
    }
    for (uint sample = 0; sample < SVO_BRICK_SAMPLES; ++sample) {
        uint sum = 4u;
        for (uint k = 0; k < 8u; ++k) {
            sum += cells[svo_brick_cell_at(sample, k)];
        }
        samples[SVO_BRICK_SAMPLES * (size_t)(params.first + item) + sample] = (ushort)(sum / 8u);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_level(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                        __global ushort *samples, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.count) {
        return;
    }
    uint cells[64];
    uint sums[SVO_BRICK_SAMPLES];
    svo_brick_cells(child_mask, first_child, codes, params.first + item, params.level, cells);
    for (uint sample = 0; sample < SVO_BRICK_SAMPLES; ++sample) {
        sums[sample] = 32u;
    }
    for (int z = 0; z < 7; ++z) {
        uint plane[49];
        for (int k = 0; k < 49; ++k) {
            const size_t at = svo_brick_point(cells, (int3)(k % 7, k / 7, z));
            plane[k] = at != SVO_BRICK_NO_POINT ? samples[at] : 0u;
        }
        svo_brick_add_plane(plane, z, sums);
    }
    for (uint sample = 0; sample < SVO_BRICK_SAMPLES; ++sample) {
        samples[SVO_BRICK_SAMPLES * (size_t)(params.first + item) + sample] = (ushort)(sums[sample] / 64u);
    }
}

#endif
