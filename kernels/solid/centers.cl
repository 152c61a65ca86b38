/* SPDX-License-Identifier: MIT */
/*
 * Which leaves have their center inside: along each axis, the crossings of the leaf's own list from its center on, and
 * the winding number in front of the next crossed leaf behind it; two of three axes decide. Of a closed mesh one does.
 *
 * Launch: one work-item per leaf, rounded up to whole groups. Reads the tree, its lists, codes, carries, crossings and
 * windings; writes a byte per leaf. No atomics, no local memory.
 */
#include "shared/nodes.clh"
#include "solid/column.clh"
#include "solid/voxel_sums.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_centers(__global const uchar *child_mask, __global const uint *first_child, __global const int *vertices,
                    __global const uint *indices, __global const uint *positions, __global const uint *list_begin,
                    __global const uint *list, __global const ulong *codes, __global const uchar *carries,
                    __global const uint *crossings, __global const uint *windings, __global uchar *inside_leaf,
                    svo_decide_params grid, svo_solid_params params)
{
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.count) {
        return;
    }
    const svo_solid_tree tree = {child_mask,   first_child,       carries,          crossings,
                                 params.depth, params.leaf_begin, params.leaf_count};
    const svo_crossing_mesh mesh = {vertices, indices, positions, &grid};
    uint sums[3] = {0, 0, 0};
    uint voxel[3];
    uint votes = 0;
    svo_column_walk start;
    svo_deinterleave(codes[params.leaf_begin + leaf], voxel);
    for (uint i = list_begin[leaf]; i < list_begin[leaf + 1u]; ++i) {
        svo_add_crossings(&mesh, list[i], voxel, &params, params.axes, true, sums);
    }
    svo_walk_begin(&tree, voxel, 0u, &start);
    for (uint axis = 0; params.axes >> axis != 0u; ++axis) {
        svo_column_walk walk = start;
        const uint next = svo_walk_on(&tree, axis, &walk);
        const uint winding =
            sums[axis] + (next != SVO_SOLID_NO_LEAF ? windings[axis * (size_t)params.leaf_count + next] : 0u);
        votes += svo_sum_is_inside(winding, params.rule) ? 1u : 0u;
    }
    inside_leaf[leaf] = 2u * votes > popcount(params.axes) ? 1 : 0;
}
