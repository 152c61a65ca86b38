/* SPDX-License-Identifier: MIT */
/*
 * The payload of the leaves from kept pairs: what the gather kernels of filter.cl and pairs.cl do for pairs that nobody
 * has weighed yet.
 *
 *   svo_k_moving_gather   per node of the deepest inner level: sums up the pairs of its leaves, writes the leaves'
 *                         payload and the node's sums
 *   svo_k_moving_entries  per pair: its entry for material.cl
 *
 * Launch: one work-item per node or pair, rounded up to whole groups. No atomics: one work-item writes a node's sums.
 */
#include "moving/kept.clh"
#include "shared/state.clh"
#include "stages/payload.clh"

#ifdef SVO_NODE_PAYLOAD

static void svo_add_kept(svo_sums *sums, uint4 value)
{
    const ulong weight = value.x;
    sums->weight += weight;
#ifdef SVO_COLOR
    sums->color += weight * convert_ulong4(svo_unpack(value.y));
#endif
#ifdef SVO_NORMAL
    const int3 normal = svo_kept_normal(value);
    sums->x += (long)weight * normal.x;
    sums->y += (long)weight * normal.y;
    sums->z += (long)weight * normal.z;
#endif
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_gather(__global const uint4 *values, __global const uint *list_begin, __global ulong *weights,
                    __global ulong *color_sums, __global long *normal_sums, __global const uchar *masks,
                    __global const uint *first_child, __global uint *colors, __global short *normals,
                    __global ushort *fills, __global const svo_build_state *state, svo_filter_params params)
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
    for (uint leaf = begin; leaf < end; ++leaf) {
        svo_sums part = svo_no_sums();
        const uint last = list_begin[leaf - params.leaf_begin + 1u];
        for (uint pair = list_begin[leaf - params.leaf_begin]; pair < last; ++pair) {
            svo_add_kept(&part, values[pair]);
        }
        svo_store_payload(part, leaf - params.payload_begin, payload, params.fill_shift);
        sums = svo_join_sums(sums, part);
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
