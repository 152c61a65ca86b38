/* SPDX-License-Identifier: MIT */
/*
 * The signed crossings of the columns' center lines, gathered by leaf. Every point of the surface lies in one voxel,
 * half-open, and that voxel's list has the triangle; so each crossing is found once, without a search and without a
 * grid. Voxels of coverage closed list more triangles, whose crossings lie in their neighbors and are not counted here.
 * That is why the lists of a thin tree do not suffice. The mesh is the one that the lists are exact against: as it was
 * given, or the snapped one in trees of old files.
 *
 * Launch: svo_k_solid_outside, one work-item per triangle: counts triangles that reach outside the grid, whose
 * crossings no leaf would find. svo_k_solid_cross, one per leaf: lists up to SVO_SHORT_LIST_MAX; longer ones are
 * noted. svo_k_solid_cross_long, a group per noted leaf. All are rounded up to whole groups. Each leaf is written by
 * one item. Atomics: a count, and places in the array of long lists, whose order no result depends on. Local memory,
 * of the last kernel: a word per work-item.
 */
#include "shared/solid_layout.h"

#include "shared/calls.clh"
#include "shared/decide.clh"
#include "shared/group.clh"
#include "shared/nodes.clh"
#include "solid/crossing.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_outside(__global const int *vertices, __global const uint *indices, volatile __global uint *counters,
                    svo_solid_params params)
{
    const uint triangle = (uint)get_global_id(0);
    if (triangle >= params.count) {
        return;
    }
    bool outside = false;
    for (uint k = 0; k < 9u; ++k) {
        const int at = vertices[3u * (size_t)indices[3u * (size_t)triangle + k / 3u] + k % 3u];
        outside = outside || at < 0 || (uint)at >> (params.depth + params.voxel_log2) != 0u;
    }
    if (outside) {
        atomic_inc(counters + SVO_SOLID_OUTSIDE);
    }
}

/* The mesh that crosses. positions: as it was given, on the grid; not read if it is the snapped one. */
typedef struct svo_crossing_mesh {
    __global const int *vertices;
    __global const uint *indices;
    __global const uint *positions;
    const svo_decide_params *grid;
} svo_crossing_mesh;

/* Adds the crossings along the axes of a mask, by the caller's numbers. */
static void svo_add_given(const svo_crossing_mesh *mesh, uint triangle, const uint *voxel, uint axes, uint *sums)
{
    svo_decided_pair pair;
    svo_load_pair(mesh->positions, mesh->indices, triangle, voxel, mesh->grid, &pair);
#ifdef SVO_DECIDES_IN_DOUBLES
    if (svo_doubles_hold(mesh->grid)) {
        svo_near_triangle near;
        svo_make_near(&pair, mesh->grid, &near);
        for (uint axis = 0; axis < 3u; ++axis) {
            const int said = (axes >> axis & 1u) != 0u ? svo_cross_near(&near, axis) : SVO_CROSSING_UNDECIDED;
            if (said != SVO_CROSSING_UNDECIDED) {
                sums[axis] += (uint)said;
                axes &= ~(1u << axis);
            }
        }
    }
#endif
    if (axes == 0u) {
        return;
    }
    const svo_short width = svo_decided_width(mesh->grid);
    svo_exact_triangle placed;
    svo_place_exactly(&pair, mesh->grid, width, &placed);
    for (uint axis = 0; axis < 3u; ++axis) {
        if ((axes >> axis & 1u) != 0u) {
            sums[axis] += (uint)svo_cross_exactly(&placed, width, axis);
        }
    }
}

/* Adds the triangle's crossings inside the voxel to the sums, for each axis. */
SVO_INLINED void svo_add_crossings(const svo_crossing_mesh *mesh, uint triangle, const uint *voxel,
                                   const svo_solid_params *params, uint *sums)
{
    int corners[9];
    int errors[3];
    uint undecided = 0;
    for (uint i = 0; i < 3u; ++i) {
        const size_t first = 3u * (size_t)mesh->indices[3u * (size_t)triangle + i];
        for (uint axis = 0; axis < 3u; ++axis) {
            corners[3u * i + axis] = mesh->vertices[first + axis];
        }
    }
    for (uint axis = 0; axis < 3u; ++axis) {
        errors[axis] = (corners[axis] | corners[3u + axis] | corners[6u + axis]) & (int)params->rounded_to_odd;
    }
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint middle = 1u << (params->voxel_log2 - 1u);
        const int point[2] = {(int)((voxel[(axis + 1u) % 3u] << params->voxel_log2) + middle),
                              (int)((voxel[(axis + 2u) % 3u] << params->voxel_log2) + middle)};
        const int low = (int)(voxel[axis] << params->voxel_log2);
        const int sense = svo_cross_snapped(corners, errors, axis, point, low, low + (int)(1u << params->voxel_log2));
        if (sense == SVO_CROSSING_UNDECIDED) {
            undecided |= 1u << axis;
        } else {
            sums[axis] += (uint)sense;
        }
    }
    if (undecided != 0u) {
        svo_add_given(mesh, triangle, voxel, undecided, sums);
    }
}

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
        svo_add_crossings(&mesh, list[i], voxel, &params, sums);
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
        svo_add_crossings(&mesh, list[i], voxel, &params, sums);
    }
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint sum = svo_group_sum(sums[axis], scratch);
        barrier(CLK_LOCAL_MEM_FENCE);
        if (get_local_id(0) == 0u) {
            crossings[axis * (size_t)params.leaf_count + leaf] = sum;
        }
    }
}
