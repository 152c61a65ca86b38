/* SPDX-License-Identifier: MIT */
/*
 * Accepts triangles, finds the bounds of the vertices that they use, and snaps these: lib/plan/grid.c explains the
 * rules and has the same steps for the host.
 *
 * Launch: one work-item per SVO_PLAN_RUN triangles or vertices, in whole groups. Groups write partial results, which
 * svo_k_plan_totals reduces. No atomics: the marks of vertices are only ever set.
 */
#include "plan/plan.clh"
#include "shared/fine.clh"
#include "shared/snap.clh"

static bool svo_is_finite(__global const uint *positions, uint flags, uint vertex)
{
    return all(isfinite(svo_mesh_vertex(positions, flags, vertex)));
}

/* Marks the vertices that accepted triangles use. A triangle is accepted if its corners are in range and finite, so
   from then on: if its corners are in range and marked. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_accept(__global const uint *positions, __global const uint *indices, __global uchar *used,
                  svo_plan_params params)
{
    const uint2 run = svo_own_run(params.triangle_count);
    for (uint t = run.x; t < run.y; ++t) {
        uint corners[3];
        if (svo_mesh_corners(indices, &params, t, corners) && svo_is_finite(positions, params.flags, corners[0]) &&
            svo_is_finite(positions, params.flags, corners[1]) && svo_is_finite(positions, params.flags, corners[2])) {
            used[corners[0]] = 1;
            used[corners[1]] = 1;
            used[corners[2]] = 1;
        }
    }
}

/* An integer above 0 that orders as the finite double x. */
static ulong svo_key(double x)
{
    const ulong bits = as_ulong(x);
    return (bits >> 63) != 0ul ? ~bits : bits | 1ul << 63;
}

/* Largest keys of -x, -y, -z, x, y, z over the used vertices; 0: there are none. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_bounds(__global const uint *positions, __global const uchar *used, __global ulong *partials,
                  svo_plan_params params, __local ulong *scratch)
{
    const uint2 run = svo_own_run(params.vertex_count);
    double3 low = (double3)(INFINITY, INFINITY, INFINITY);
    double3 high = -low;
    bool any = false;
    for (uint v = run.x; v < run.y; ++v) {
        if (used[v] != 0) {
            const double3 x = svo_mesh_vertex(positions, params.flags, v);
            low = fmin(low, x);
            high = fmax(high, x);
            any = true;
        }
    }
    const ulong used_bits = any ? ~0ul : 0ul;
    const ulong keys[6] = {svo_key(-low.x) & used_bits, svo_key(-low.y) & used_bits, svo_key(-low.z) & used_bits,
                           svo_key(high.x) & used_bits, svo_key(high.y) & used_bits, svo_key(high.z) & used_bits};
    svo_group_columns(keys, 6u, true, scratch, partials);
}

/* Snaps the used vertices; the others become 0. remainders: NULL if nobody wants them. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_snap(__global const uint *positions, __global const uchar *used, __global int *vertices,
                __global ulong *remainders, svo_plan_params params)
{
    const uint2 run = svo_own_run(params.vertex_count);
    const double origin[3] = {svo_double_from(params.origin[0], params.origin[1]),
                              svo_double_from(params.origin[2], params.origin[3]),
                              svo_double_from(params.origin[4], params.origin[5])};
    const svo_snap snap = svo_make_snap(svo_double_from(params.scale[0], params.scale[1]),
                                        svo_double_from(params.edge[0], params.edge[1]), (int)params.snap_bits);
    for (uint v = run.x; v < run.y; ++v) {
        int parts[3];
        for (uint axis = 0; axis < 3u; ++axis) {
            const double x =
                used[v] != 0 ? svo_mesh_coordinate(positions, params.flags, (size_t)v * 3 + axis) : origin[axis];
            const int q = svo_snap_coordinate(&snap, x, origin[axis]);
            vertices[(size_t)v * 3 + axis] = q;
            parts[axis] = svo_snap_remainder(&snap, x, origin[axis], q, SVO_SUB_LOG2 - (int)params.voxel_log2);
        }
        if (remainders != 0) {
            remainders[v] = svo_pack_remainders(parts[0], parts[1], parts[2]);
        }
    }
}
