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
#include "light/opacity.clh"
#include "light/radiance.clh"

#ifdef SVO_LIGHT_BRICKS

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_lit_bricks(__global const uchar *colors, __global const ushort *areas, __global const uint *leaves,
                       __global const uint *values, __global uint *premultiplied, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    if (item < params.count) {
        const uint opacity = svo_leaf_opacity_any(colors, areas, leaves[item], params);
        vstore3(svo_radiance_times(vload3(item, values), opacity), item, premultiplied);
    }
}

/* Stores the samples of a brick, as sums of 2^shift. sums: red, green, blue of each sample. */
static void svo_brick_store(const ulong *sums, ulong shift, size_t place, __global uint *radiance)
{
    for (uint sample = 0; sample < SVO_BRICK_SAMPLES; ++sample) {
        const ulong3 sum = vload3(sample, sums) + (1ul << shift >> 1);
        radiance[SVO_BRICK_SAMPLES * place + sample] = svo_radiance_encode(convert_uint3_sat(sum >> shift));
    }
}

/* lit_leaves: the place of each leaf among the lit ones, or SVO_NO_NODE. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_deep(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                       __global const uint *lit_leaves, __global const uint *premultiplied, __global const uint *lit,
                       __global uint *radiance, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    const uint node = params.first + item;
    if (item >= params.count || lit[node] == SVO_NO_NODE) {
        return;
    }
    uint cells[64];
    ulong sums[3 * SVO_BRICK_SAMPLES];
    svo_brick_cells(child_mask, first_child, codes, node, params.level, cells);
    for (uint k = 0; k < 64u; ++k) {
        cells[k] = cells[k] != SVO_NO_NODE ? lit_leaves[cells[k] - params.leaf_begin] : SVO_NO_NODE;
    }
    for (uint sample = 0; sample < SVO_BRICK_SAMPLES; ++sample) {
        ulong3 sum = (ulong3)(0ul);
        for (uint k = 0; k < 8u; ++k) {
            const uint leaf = cells[svo_brick_cell_at(sample, k)];
            sum += leaf != SVO_NO_NODE ? convert_ulong3(vload3(leaf, premultiplied)) : (ulong3)(0ul);
        }
        vstore3(sum, sample, sums);
    }
    svo_brick_store(sums, 3ul, lit[node], radiance);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_light(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                        __global const uint *lit, __global uint *radiance, svo_light_step params)
{
    const uint item = (uint)get_global_id(0);
    const uint node = params.first + item;
    if (item >= params.count || lit[node] == SVO_NO_NODE) {
        return;
    }
    uint cells[64];
    ulong sums[3 * SVO_BRICK_SAMPLES];
    svo_brick_cells(child_mask, first_child, codes, node, params.level, cells);
    /* A dark brick has no sample that is not 0 in the lit ones beside it. */
    for (uint k = 0; k < 64u; ++k) {
        cells[k] = cells[k] != SVO_NO_NODE ? lit[cells[k]] : SVO_NO_NODE;
    }
    for (uint k = 0; k < 3u * SVO_BRICK_SAMPLES; ++k) {
        sums[k] = 0ul;
    }
    for (int point = 0; point < 343; ++point) {
        const int3 at = (int3)(point % 7, point / 7 % 7, point / 49);
        const size_t place = svo_brick_point(cells, at);
        const uint word = place != SVO_BRICK_NO_POINT ? radiance[place] : 0u;
        if (word != 0u) {
            svo_brick_add_point(convert_ulong3(svo_radiance_decode(word)), at, sums);
        }
    }
    svo_brick_store(sums, 6ul, lit[node], radiance);
}

#endif
