/* SPDX-License-Identifier: MIT */
/*
 * Radiance in bricks: as opacity in bricks.cl, for the lit bricks and three channels, all premultiplied by opacity.
 *
 *   svo_k_light_lit_bricks   per lit leaf: its radiance times its opacity, unrounded but for the product
 *   svo_k_light_brick_deep   per lit brick above the leaves
 *   svo_k_light_brick_light  per lit brick of a level above, upwards
 *
 * Launch: one work-item per lit leaf, rounded up to whole groups; of brick.clh, for nodes that are lit or not, on CPUs
 * the same per node, on GPUs one group per node. No atomics.
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

/* The radiance of a sample by the lit leaves in the cells around it. leaves: their places, or SVO_NO_NODE. */
static uint3 svo_brick_mean_of_leaves(SVO_BRICK_MEMORY const uint *leaves, __global const uint *premultiplied,
                                      int sample)
{
    const int first = svo_brick_first_cell(sample);
    ulong3 sum = (ulong3)(0ul);
    for (int k = 0; k < 8; ++k) {
        const uint leaf = leaves[first + svo_brick_next_cell(k)];
        if (leaf != SVO_NO_NODE) {
            sum += convert_ulong3(vload3(leaf, premultiplied));
        }
    }
    return convert_uint3((sum + 4ul) >> 3ul);
}

/* The same by the points around it. */
static uint3 svo_brick_mean_of_points(SVO_BRICK_MEMORY const uint *points, int sample)
{
    const int first = svo_brick_first_point(sample);
    ulong3 sum = (ulong3)(0ul);
    for (int k = 0; k < 27; ++k) {
        uint weight_log2;
        const int next = svo_brick_next_point(k, &weight_log2);
        sum += convert_ulong3(svo_radiance_decode(points[first + next])) << (ulong)weight_log2;
    }
    return convert_uint3((sum + 32ul) >> 6ul);
}

static void svo_brick_copy(__global const uint *from, __global uint *to)
{
    for (int k = SVO_BRICK_LANE; k < SVO_BRICK_SAMPLES; k += SVO_BRICK_LANES) {
        to[k] = from[k];
    }
}

/* lit_leaves: the place of each leaf among the lit ones, or SVO_NO_NODE. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_deep(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                       __global const uint *lit_leaves, __global const uint *premultiplied, __global const uint *lit,
                       SVO_KEPT_LIGHT_PARAMETERS, __global uint *radiance, SVO_BRICK_PARAMETERS)
{
    const uint item = SVO_BRICK_ITEM;
    const uint node = params.first + item;
    if (item >= params.count || lit[node] == SVO_NO_NODE) {
        return;
    }
    __global uint *const brick = radiance + SVO_BRICK_SAMPLES * (size_t)lit[node];
    if (svo_light_stays(origins, fresh, node)) {
        svo_brick_copy(old_radiance + SVO_BRICK_SAMPLES * (size_t)old_lit[origins[node]], brick);
        return;
    }
    SVO_BRICK_MAKE(cells, points);
    svo_brick_cells(child_mask, first_child, codes, node, params.level, cells);
    for (int k = SVO_BRICK_LANE; k < SVO_BRICK_CELL_COUNT; k += SVO_BRICK_LANES) {
        cells[k] = cells[k] != SVO_NO_NODE ? lit_leaves[cells[k] - params.leaf_begin] : SVO_NO_NODE;
    }
    SVO_BRICK_SYNC();
    for (int k = SVO_BRICK_LANE; k < SVO_BRICK_SAMPLES; k += SVO_BRICK_LANES) {
        brick[k] = svo_radiance_encode(svo_brick_mean_of_leaves(cells, premultiplied, k));
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_brick_light(__global const uchar *child_mask, __global const uint *first_child, __global const ulong *codes,
                        __global const uint *lit, SVO_KEPT_LIGHT_PARAMETERS, __global uint *radiance,
                        SVO_BRICK_PARAMETERS)
{
    const uint item = SVO_BRICK_ITEM;
    const uint node = params.first + item;
    if (item >= params.count || lit[node] == SVO_NO_NODE) {
        return;
    }
    __global uint *const brick = radiance + SVO_BRICK_SAMPLES * (size_t)lit[node];
    if (svo_light_stays(origins, fresh, node)) {
        svo_brick_copy(old_radiance + SVO_BRICK_SAMPLES * (size_t)old_lit[origins[node]], brick);
        return;
    }
    SVO_BRICK_MAKE(cells, points);
    svo_brick_cells(child_mask, first_child, codes, node, params.level, cells);
    for (int k = SVO_BRICK_LANE; k < SVO_BRICK_CELL_COUNT; k += SVO_BRICK_LANES) {
        cells[k] = cells[k] != SVO_NO_NODE ? lit[cells[k]] : SVO_NO_NODE;
    }
    SVO_BRICK_SYNC();
    svo_brick_gather_light(cells, radiance, points);
    for (int k = SVO_BRICK_LANE; k < SVO_BRICK_SAMPLES; k += SVO_BRICK_LANES) {
        brick[k] = svo_radiance_encode(svo_brick_mean_of_points(points, k));
    }
}

#endif
