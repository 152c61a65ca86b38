/* SPDX-License-Identifier: MIT */
/*
 * The signed crossings of the columns' center lines, gathered by leaf. Every point of the surface lies in one voxel,
 * half-open, and that voxel's list has the triangle; so each crossing is found once, without a search and without a
 * grid. Voxels of coverage closed list more triangles, whose crossings lie in their neighbors and are not counted here.
 * That is why the lists of a thin tree do not suffice. The mesh is the one that the lists are exact against: as it was
 * given, or the snapped one in trees of old files.
 *
 * Launch: svo_k_solid_cross, one work-item per leaf: lists up to SVO_SHORT_LIST_MAX; longer ones are noted.
 * svo_k_solid_cross_long, a group per noted leaf. Both are rounded up to whole groups. Each leaf is written by one
 * item. Atomics: places in the array of long lists, whose order no result depends on. Local memory, of the last kernel:
 * a word per work-item.
 */
#include "shared/solid_layout.h"

#include "shared/group.clh"
#include "shared/nodes.clh"
#include "solid/voxel_sums.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_cross(__global const int *vertices, __global const uint *indices, __global const uint *positions,
                  __global const uint *list_begin, __global const uint *list, __global const ulong *codes,
                  __global uint *crossings, __global uint *long_lists, volatile __global uint *counters,
                  svo_decide_params grid, svo_solid_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.count) {
        return;
    }
    const uint begin = list_begin[leaf];
    const uint end = list_begin[leaf + 1u];
    const svo_crossing_mesh mesh = {vertices, indices, positions, &grid};
    uint sums[3] = {0, 0, 0};
    if (end - begin > SVO_SHORT_LIST_MAX) {
        long_lists[atomic_inc(counters + SVO_SOLID_LONG_LISTS)] = leaf;
        return;
    }
    uint voxel[3];
    svo_deinterleave(codes[params.leaf_begin + leaf], voxel);
    for (uint i = begin; i < end; ++i) {
        svo_add_crossings(&mesh, list[i], voxel, &params, params.axes, false, sums);
    }
    for (uint axis = 0; axis < 3u; ++axis) {
        crossings[axis * (size_t)params.leaf_count + leaf] = sums[axis];
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_cross_long(__global const int *vertices, __global const uint *indices, __global const uint *positions,
                       __global const uint *list_begin, __global const uint *list, __global const ulong *codes,
                       __global uint *crossings, __global const uint *long_lists, __local uint *scratch,
                       svo_decide_params grid, svo_solid_params params)
{
    const uint leaf = long_lists[get_group_id(0)];
    const uint end = list_begin[leaf + 1u];
    const svo_crossing_mesh mesh = {vertices, indices, positions, &grid};
    uint sums[3] = {0, 0, 0};
    uint voxel[3];
    svo_deinterleave(codes[params.leaf_begin + leaf], voxel);
    for (uint i = list_begin[leaf] + (uint)get_local_id(0); i < end; i += SVO_GROUP_ITEMS) {
        svo_add_crossings(&mesh, list[i], voxel, &params, params.axes, false, sums);
    }
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint sum = svo_group_sum(sums[axis], scratch);
        barrier(CLK_LOCAL_MEM_FENCE);
        if (get_local_id(0) == 0u) {
            crossings[axis * (size_t)params.leaf_count + leaf] = sum;
        }
    }
}
