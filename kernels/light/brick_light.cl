/* SPDX-License-Identifier: MIT */
/*
 * Radiance in bricks: as opacity in bricks.cl, for the lit bricks and three channels, all premultiplied by opacity.
 *
 *   svo_k_light_lit_bricks   per lit leaf: its radiance times its opacity, unrounded but for the product
 *   svo_k_light_brick_deep   per lit brick above the leaves
 *   svo_k_light_brick_light  per lit brick of a level above, upwards
 *
 * Launch: one work-item per lit leaf or node, rounded up to whole groups. No atomics, no local memory.
 */
#include "light/brick.clh"
#include "light/kept_light.clh"
#include "light/opacity.clh"
#include "light/radiance.clh"

#ifdef SVO_LIGHT_BRICKS

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_lit_bricks(__global const uchar *colors, __global const ushort *areas, __global const uint *leaves,
                       __global const uint *slots, __global const uint *values, __global uint *premultiplied,
                       svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item < params.count) {
        const uint opacity = svo_leaf_opacity_any(colors, areas, leaves[item], params);
        const uint3 value = vload3(svo_light_value_place(leaves, slots, item), values);
        vstore3(svo_radiance_times(value, opacity), item, premultiplied);
    }
}

SVO_BRICK_GATHER(svo_brick_gather_light, uint)

/* Sums of weight 2^weight_log2 to the samples of a brick. sums: of red, then of green, then of blue. */
static void svo_brick_store_light(const ulong *sums, ulong weight_log2, uint place, __global uint *radiance)
{
    for (uint k = 0; k < SVO_BRICK_SAMPLES; ++k) {
        const ulong3 sum = (ulong3)(sums[k], sums[k + SVO_BRICK_SAMPLES], sums[k + 2u * SVO_BRICK_SAMPLES]);
        const ulong3 mean = (sum + (1ul << weight_log2 >> 1)) >> weight_log2;
        radiance[SVO_BRICK_SAMPLES * (size_t)place + k] = svo_radiance_encode(convert_uint3_sat(mean));
    }
}

/* lit_leaves: the place of each leaf among the lit ones, or SVO_NO_NODE. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_deep(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                       __global const uint *lit_leaves, __global const uint *premultiplied, __global const uint *lit,
                       SVO_KEPT_LIGHT_PARAMETERS, __global uint *radiance, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    const uint node = params.first + item;
    if (item >= params.count || lit[node] == SVO_NO_NODE) {
        return;
    }
    if (svo_light_stays(origins, fresh, node)) {
        svo_copy_radiance(old_radiance, old_lit[origins[node]], radiance, lit[node], SVO_BRICK_SAMPLES);
        return;
    }
    uint cells[SVO_BRICK_CELL_COUNT];
    uint channel_cells[SVO_BRICK_CELL_COUNT];
    ulong sums[3 * SVO_BRICK_SAMPLES];
    svo_brick_cells(child_mask, first_child, codes, node, params.level, cells);
    for (uint k = 0; k < SVO_BRICK_CELL_COUNT; ++k) {
        cells[k] = cells[k] != SVO_NO_NODE ? lit_leaves[cells[k] - params.leaf_begin] : SVO_NO_NODE;
    }
    for (uint channel = 0; channel < 3u; ++channel) {
        for (uint k = 0; k < SVO_BRICK_CELL_COUNT; ++k) {
            channel_cells[k] = cells[k] != SVO_NO_NODE ? premultiplied[3u * (size_t)cells[k] + channel] : 0u;
        }
        svo_brick_sum_cells(channel_cells, sums + SVO_BRICK_SAMPLES * channel);
    }
    svo_brick_store_light(sums, 3ul, lit[node], radiance);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_light(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                        __global const uint *lit, SVO_KEPT_LIGHT_PARAMETERS, __global uint *radiance,
                        svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    const uint node = params.first + item;
    if (item >= params.count || lit[node] == SVO_NO_NODE) {
        return;
    }
    if (svo_light_stays(origins, fresh, node)) {
        svo_copy_radiance(old_radiance, old_lit[origins[node]], radiance, lit[node], SVO_BRICK_SAMPLES);
        return;
    }
    uint cells[SVO_BRICK_CELL_COUNT];
    uint points[SVO_BRICK_POINT_COUNT];
    uint channel_points[SVO_BRICK_POINT_COUNT];
    ulong sums[3 * SVO_BRICK_SAMPLES];
    svo_brick_cells(child_mask, first_child, codes, node, params.level, cells);
    for (uint k = 0; k < SVO_BRICK_CELL_COUNT; ++k) {
        cells[k] = cells[k] != SVO_NO_NODE ? lit[cells[k]] : SVO_NO_NODE;
    }
    svo_brick_gather_light(cells, radiance, points);
    for (uint channel = 0; channel < 3u; ++channel) {
        for (uint k = 0; k < SVO_BRICK_POINT_COUNT; ++k) {
            channel_points[k] = svo_radiance_channel(points[k], channel);
        }
        svo_brick_sum_points(channel_points, sums + SVO_BRICK_SAMPLES * channel);
    }
    svo_brick_store_light(sums, 6ul, lit[node], radiance);
}

#endif
