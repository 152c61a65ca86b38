/* SPDX-License-Identifier: MIT */
/*
 * The payload of the leaves from kept pairs: what the gather kernels of filter.cl and pairs.cl do for pairs that nobody
 * has weighed yet.
 *
 *   svo_k_moving_long     a group per SVO_KEPT_LONG pairs, on GPUs: if the first of them is also the first such one of
 *                         a leaf with more pairs, sums up that leaf and writes its projected areas
 *   svo_k_moving_gather   per node of the deepest inner level: sums up the pairs of its leaves, writes the leaves'
 *                         payload, their projected areas and the node's sums
 *   svo_k_moving_entries  per pair: its entry for material.cl
 *
 * Launch: one work-item per node or pair, rounded up to whole groups. No atomics: one work-item writes a node's sums.
 */
#include "moving/areas.clh"
#include "moving/kept.clh"
#include "shared/calls.clh"
#include "shared/state.clh"
#include "stages/payload.clh"

#ifdef SVO_NODE_PAYLOAD

/* Adds a pair of that weight. */
static void svo_add_kept(svo_sums *sums, ulong weight, uint4 value)
{
    sums->weight += weight;
#ifdef SVO_COLOR
    sums->color += svo_color_share(weight, svo_unpack(value.y));
#endif
#ifdef SVO_NORMAL
    const int3 normal = svo_kept_normal(value);
    sums->x += (long)weight * normal.x;
    sums->y += (long)weight * normal.y;
    sums->z += (long)weight * normal.z;
#endif
}

/* Whether two pairs have the same color and normal. */
static bool svo_is_alike(uint4 a, uint4 b)
{
    return ((a.y ^ b.y) | (a.z ^ b.z) | ((a.w ^ b.w) & 0xffffu)) == 0u;
}

/* Sums up the pairs of a leaf and writes its payload. The mean of pairs that are alike is that of each. */
static svo_sums svo_sum_kept(__global const uint4 *values, uint first, uint last, uint leaf, svo_payload payload,
                             uint fill_shift)
{
    svo_sums sums = svo_no_sums();
    const uint4 one = values[first];
    ulong weight = 0;
    bool alike = true;
    for (uint pair = first; pair < last; ++pair) {
        const uint4 value = values[pair];
        weight += value.x;
        alike = alike && svo_is_alike(value, one);
    }
    if (alike && weight != 0) {
        svo_add_kept(&sums, weight, one);
#ifdef SVO_COLOR
        payload.colors[leaf] = one.y >> 24 != 0u ? one.y : 0u;
#endif
#ifdef SVO_NORMAL
        vstore3(convert_short3(svo_kept_normal(one)), leaf, payload.normals);
#endif
#ifdef SVO_FILL
        payload.fills[leaf] = svo_fill_of(weight, fill_shift);
#endif
        return sums;
    }
    for (uint pair = first; pair < last; ++pair) {
        svo_add_kept(&sums, values[pair].x, values[pair]);
    }
    svo_store_payload(sums, leaf, payload, fill_shift);
    return sums;
}

#endif

#ifdef SVO_GATHERED

/* The leaf that has a pair. */
static uint svo_leaf_of_pair(__global const uint *list_begin, uint leaf_count, uint pair)
{
    uint low = 0u;
    uint high = leaf_count;
    while (high - low > 1u) {
        const uint middle = low + (high - low) / 2u;
        if (list_begin[middle] <= pair) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* Sum over the group's items; all receive it. */
SVO_INLINED ulong svo_sum_in_group(ulong value, __local ulong *scratch)
{
    const uint item = (uint)get_local_id(0);
    scratch[item] = value;
    for (uint reach = SVO_GROUP_ITEMS / 2; reach > 0u; reach /= 2) {
        barrier(CLK_LOCAL_MEM_FENCE);
        if (item < reach) {
            scratch[item] += scratch[item + reach];
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    const ulong sum = scratch[0];
    barrier(CLK_LOCAL_MEM_FENCE);
    return sum;
}

/* long_weights, long_colors, long_normals: sums of long leaves, by the group that makes them. edges: the sums of the
   scene's edges (kernels/plan/closed.cl), zero where they cancel. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_long(__global const uint4 *values, __global const uint *list_begin, __global ulong *long_weights,
                  __global ulong *long_colors, __global long *long_normals, __global const svo_build_state *state,
                  svo_filter_params params,
                  __local ulong *scratch SVO_AND_AREAS(const uint4, pair_areas) SVO_AND_AREAS(const ulong, edges)
                      SVO_AND_AREAS(ushort, areas))
{
    svo_make_current(&params, state);
    const uint group = (uint)get_group_id(0);
    const uint pair = group * SVO_KEPT_LONG;
    if (pair >= params.fragment_count) {
        return;
    }
    const uint leaf = svo_leaf_of_pair(list_begin, params.leaf_count, pair);
    const uint first = list_begin[leaf];
    const uint last = list_begin[leaf + 1u];
    if (last - first <= SVO_KEPT_LONG || pair - first >= SVO_KEPT_LONG) {
        return;
    }
    svo_sums sums = svo_no_sums();
    SVO_UNUSED(values);
#ifdef SVO_NODE_PAYLOAD
    for (uint i = first + (uint)get_local_id(0); i < last; i += SVO_GROUP_ITEMS) {
        svo_add_kept(&sums, values[i].x, values[i]);
    }
#endif
#ifdef SVO_AREAS
    const bool both_sides = (edges[0] | edges[1]) != 0;
    sums.areas = svo_sum_kept_areas(pair_areas, first + (uint)get_local_id(0), last, SVO_GROUP_ITEMS, both_sides);
    for (uint i = 0; i < 6u; ++i) {
        sums.areas.of[i] = svo_sum_in_group(sums.areas.of[i], scratch);
    }
#endif
    sums.weight = svo_sum_in_group(sums.weight, scratch);
#ifdef SVO_COLOR
    sums.color = (ulong4)(svo_sum_in_group(sums.color.x, scratch), svo_sum_in_group(sums.color.y, scratch),
                          svo_sum_in_group(sums.color.z, scratch), svo_sum_in_group(sums.color.w, scratch));
#endif
#ifdef SVO_NORMAL
    sums.x = (long)svo_sum_in_group((ulong)sums.x, scratch);
    sums.y = (long)svo_sum_in_group((ulong)sums.y, scratch);
    sums.z = (long)svo_sum_in_group((ulong)sums.z, scratch);
#endif
    if (get_local_id(0) == 0u) {
        svo_store_sums(sums, group, long_weights, long_colors, long_normals);
#ifdef SVO_AREAS
        svo_store_areas(sums.areas, leaf, areas);
#endif
    }
}

/* long_weights, long_colors, long_normals: NULL where work-items sum up all leaves. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_gather(__global const uint4 *values, __global const uint *list_begin, __global const ulong *long_weights,
                    __global const ulong *long_colors, __global const long *long_normals, __global ulong *weights,
                    __global ulong *color_sums, __global long *normal_sums, __global const uchar *masks,
                    __global const uint *first_child, __global uint *colors, __global short *normals,
                    __global ushort *fills, __global const svo_build_state *state,
                    svo_filter_params params SVO_AND_AREAS(const uint4, pair_areas) SVO_AND_AREAS(const ulong, edges)
                        SVO_AND_AREAS(ushort, areas))
{
    svo_make_current(&params, state);
    const uint index = (uint)get_global_id(0);
    if (index >= params.level_count) {
        return;
    }
    const svo_payload payload = {colors, normals, fills};
    const uint node = params.level_begin + index;
    const uint begin = first_child[node];
    const uint end = begin + popcount((uint)masks[node]);
    svo_sums sums = svo_no_sums();
    SVO_UNUSED(values);
#ifdef SVO_AREAS
    const bool both_sides = (edges[0] | edges[1]) != 0;
#endif
    for (uint leaf = begin; leaf < end; ++leaf) {
        const uint first = list_begin[leaf - params.leaf_begin];
        const uint last = list_begin[leaf - params.leaf_begin + 1u];
        const bool is_long = long_weights != 0 && last - first > SVO_KEPT_LONG;
#ifdef SVO_NODE_PAYLOAD
        const uint place = leaf - params.payload_begin;
        svo_sums part;
        if (is_long) {
            const uint group = (first + SVO_KEPT_LONG - 1u) / SVO_KEPT_LONG;
            part = svo_load_sums(group, long_weights, long_colors, long_normals);
            svo_store_payload(part, place, payload, params.fill_shift);
        } else {
            part = svo_sum_kept(values, first, last, place, payload, params.fill_shift);
        }
        sums = svo_join_sums(sums, part);
#endif
#ifdef SVO_AREAS
        if (!is_long) {
            const svo_areas sum = svo_sum_kept_areas(pair_areas, first, last, 1u, both_sides);
            svo_store_areas(sum, leaf - params.leaf_begin, areas);
        }
#endif
    }
    svo_store_sums(sums, index, weights, color_sums, normal_sums);
    if (params.payload_begin == 0u) {
        svo_store_root(sums, node, payload, params.fill_shift);
    }
}

#endif

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_entries(__global const uint4 *values, __global const uint *materials, __global ulong *entries,
                     svo_moving_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index < params.count) {
        entries[index] = (ulong)materials[index] << SVO_ENTRY_SHIFT | values[index].x;
    }
}
