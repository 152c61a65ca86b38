/* SPDX-License-Identifier: MIT */
/*
 * Counts that only the device knows, in updates that do not wait.
 *
 *   svo_k_moving_take    per place of an object's list: the places after its pairs get the largest key, which a stable
 *                        sort leaves behind them; the first work-item takes the count, which is 0 where not all fit
 *   svo_k_moving_listed  one work-item: how many triangles of an object that moved are in leaf lists
 *   svo_k_moving_edges   one work-item: adds the sums of the edges of an object that moved to those of the scene
 *
 * Launch: one work-item per place, rounded up to whole groups. No atomics.
 */
#include "moving/kept.clh"

/* counters: low and high word of the pairs that the object has. Where they did not fit, there are gaps between those
   that did, and the list is of no use. params.count: the places. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_take(__global const uint *counters, __global uint *fragments, __global uint *counted,
                  svo_moving_params params)
{
    const uint index = (uint)get_global_id(0);
    const uint count = counters[1] == 0u && counters[0] <= params.count ? counters[0] : 0u;
    if (index == 0u) {
        counted[0] = count;
    }
    if (index >= count && index < params.count) {
        svo_fragment_store(fragments, index, (svo_code)~0UL, ~0u);
    }
}

/* sums: of the object's plan. listed: one of each object. params.count: the triangles of the object. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_listed(__global const ulong *sums, __global uint *listed, svo_moving_params params)
{
    if (get_global_id(0) == 0u) {
        listed[params.object] =
            params.count - (uint)(sums[SVO_FATE_REFUSED] + sums[SVO_FATE_FAR] + sums[SVO_FATE_OUTSIDE]);
    }
}

#ifdef SVO_AREAS

/* edges: of the object's plan. total: of the scene. Both as in kernels/plan/closed.cl. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_edges(__global const ulong *edges, __global ulong *total)
{
    if (get_global_id(0) == 0u) {
        total[0] += edges[0];
        total[1] += edges[1];
    }
}

#endif
