/* SPDX-License-Identifier: MIT */
/*
 * What the triangles themselves say: whether they lie in the grid, and whether they are closed, so that all lines from
 * a point give the same winding number, and neighboring empty cells have the same (regions.cl). The positions are those
 * that decide: as they were given, or snapped.
 *
 * Launch: one work-item per triangle, rounded up to whole groups. Counts triangles that reach outside the grid, whose
 * crossings no leaf would find, and adds up the hashes of edges (shared/edges.clh) in four counters. Atomics: these
 * sums, which do not depend on their order. Local memory: a word per work-item.
 */
#include "shared/solid_layout.h"

#include "shared/edges.clh"
#include "shared/group.clh"

/* A coordinate's bits, in 64; those of -0 are those of 0. */
static ulong svo_coordinate_bits(__global const uint *positions, size_t index, uint kind)
{
    if (kind == SVO_SOLID_DOUBLES) {
        const ulong bits = (ulong)positions[2u * index + 1u] << 32 | positions[2u * index];
        return bits << 1 == 0ul ? 0ul : bits;
    }
    const uint bits = positions[index];
    return kind == SVO_SOLID_FLOATS && bits << 1 == 0u ? 0ul : (ulong)bits;
}

static ulong3 svo_corner_bits(__global const uint *positions, uint vertex, uint kind)
{
    const size_t first = 3u * (size_t)vertex;
    return (ulong3)(svo_coordinate_bits(positions, first, kind), svo_coordinate_bits(positions, first + 1u, kind),
                    svo_coordinate_bits(positions, first + 2u, kind));
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_closed(__global const int *vertices, __global const uint *indices, __global const uint *positions,
                   volatile __global uint *counters, svo_solid_params params, __local uint *scratch)
{
    const size_t triangle = get_global_id(0);
    uint4 edges = (uint4)(0, 0, 0, 0);
    if (triangle < params.count) {
        const uint3 corners = vload3(triangle, indices);
        const int3 a = vload3(corners.x, vertices);
        const int3 b = vload3(corners.y, vertices);
        const int3 c = vload3(corners.z, vertices);
        /* A negative coordinate is a large one. */
        const uint3 largest = max(as_uint3(a), max(as_uint3(b), as_uint3(c)));
        if (max(largest.x, max(largest.y, largest.z)) >> (params.depth + params.voxel_log2) != 0u) {
            atomic_inc(counters + SVO_SOLID_OUTSIDE);
        }
        const ulong3 p = svo_corner_bits(positions, corners.x, params.positions);
        const ulong3 q = svo_corner_bits(positions, corners.y, params.positions);
        const ulong3 r = svo_corner_bits(positions, corners.z, params.positions);
        edges = svo_signed_edge_quarters(p, q) + svo_signed_edge_quarters(q, r) + svo_signed_edge_quarters(r, p);
    }
    const uint parts[4] = {edges.x, edges.y, edges.z, edges.w};
    for (uint k = 0; k < 4u; ++k) {
        const uint sum = svo_group_sum(parts[k], scratch);
        barrier(CLK_LOCAL_MEM_FENCE);
        if (get_local_id(0) == 0u) {
            atomic_add(counters + SVO_SOLID_EDGES + k, sum);
        }
    }
}
