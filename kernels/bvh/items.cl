/* SPDX-License-Identifier: MIT */
/*
 * The first step of a BVH: which triangles it holds, and their boxes.
 *
 *   svo_k_bvh_reach   the largest coordinate of a vertex, whether one lies outside the grid, and whether the device
 *                     fuses operations
 *   svo_k_bvh_mark    only then: a one for each triangle that the tree lists; scan.cl turns them into places
 *   svo_k_bvh_begin   the root: a range, or a job if it is small
 *   svo_k_bvh_items   an item per triangle, and the bounds of all centers
 *
 * Launch: reach: any number of work-items, each of which takes a strip; mark: one per entry of the list; begin: one;
 * items: a group of SVO_BVH_LANES per chunk of params.chunk_items triangles. Atomics: maxima, minima and bits, which no
 * order changes.
 */
#include "bvh/fusion.clh"
#include "bvh/lanes.clh"
#include "bvh/triangles.clh"

/* factors: for svo_bvh_fuses. */
__kernel void svo_k_bvh_reach(__global const int *vertices, __global svo_bvh_state *state, uint first_vertex,
                              uint vertex_count, uint snap_bits, float4 factors)
{
    const ulong all = 3 * (ulong)vertex_count;
    const ulong length = all / get_global_size(0) + 1u;
    const ulong before = 3 * (ulong)first_vertex;
    const ulong begin = before + min(get_global_id(0) * length, all);
    const ulong end = min(begin + length, before + all);
    uint reach = 0u;
    uint outside = 0u;
    for (ulong i = begin; i < end; ++i) {
        reach = max(reach, abs(vertices[i]));
        outside |= (uint)vertices[i] >> snap_bits;
    }
    if (get_global_id(0) == 0u) {
        state->fuses = svo_bvh_fuses(factors) ? 1u : 0u;
    }
    atomic_max(&state->reach, reach);
    atomic_or(&state->outside, outside != 0u ? 1u : 0u);
}

/* Of the triangle_count triangles from first_triangle on. */
__kernel void svo_k_bvh_mark(__global const uint *list, __global uint *listed, uint list_count, uint first_triangle,
                             uint triangle_count)
{
    const uint i = (uint)get_global_id(0);
    if (i < list_count && list[i] - first_triangle < triangle_count) {
        listed[list[i] - first_triangle] = 1u;
    }
}

__kernel void svo_k_bvh_begin(__global svo_bvh_range *ranges, __global svo_bvh_job *jobs,
                              __global svo_bvh_branch *branches, __global svo_bvh_state *state, svo_bvh_params params)
{
    const svo_bvh_job root = {0u, params.item_count, params.halvings, 0u};
    const bool is_job = params.item_count <= params.subtree_items;
    svo_bvh_begin_range(ranges, root, 0u);
    jobs[0] = root;
    state->range_count[0] = is_job ? 0u : 1u;
    state->chunk_count[0] = is_job ? 0u : svo_bvh_chunks_of(params.item_count, params.chunk_items);
    state->job_count = is_job ? 1u : 0u;
    branches[0].part[0] = 0u;
    branches[0].area[0] = 1.0f;
}

/* listed, places: the triangle's mark and the number of those before it, where params.use_list is set. */
SVO_BVH_LANES_KERNEL svo_k_bvh_items(SVO_BVH_MESH_PARAMETERS, uint first_triangle, __global const uint *listed,
                                     __global const uint *places, __global float8 *items,
                                     __global svo_bvh_range *ranges, svo_bvh_params params, __local uint *scratch)
{
    SVO_BVH_MESH_MAKE(mesh, first_triangle);
    const uint begin = (uint)get_group_id(0) * params.chunk_items;
    const uint end = min(begin + params.chunk_items, params.triangle_count);
    svo_bvh_centers centers = SVO_BVH_NO_CENTERS;
    for (uint i = begin + svo_bvh_lane(); i < end; i += SVO_BVH_LANES) {
        if (params.use_list == 0u || listed[i] != 0u) {
            float8 item = svo_bvh_triangle_box(&mesh, i, params.snap_bits);
            svo_bvh_centers_grow(&centers, svo_bvh_center(item));
            item.s3 = as_float(i);
            items[params.use_list != 0u ? places[i] : i] = item;
        }
    }
    svo_bvh_publish_centers(centers, ranges, scratch);
}
