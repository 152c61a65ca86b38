/* SPDX-License-Identifier: MIT */
/*
 * Whether a mesh is closed: the edges of its accepted triangles cancel, by the sums of shared/edges.clh.
 * lib/plan/closed.c counts edge by edge on the host.
 *
 * Launch: one work-item per SVO_PLAN_RUN triangles, in whole groups. Writes a row of two sums per group. No atomics.
 */
#include "plan/plan.clh"
#include "shared/edges.clh"

/* A vertex's coordinates as bits of doubles; + 0.0 turns -0 into 0, which equals it. */
static ulong3 svo_position_bits(__global const uint *positions, uint flags, uint vertex)
{
    return as_ulong3(svo_mesh_vertex(positions, flags, vertex) + 0.0);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_closed(__global const uint *positions, __global const uint *indices, __global const ushort *fates,
                  __global ulong *partials, svo_plan_params params, __local ulong *scratch)
{
    const uint2 run = svo_own_run(params.triangle_count);
    ulong2 sum = (ulong2)(0, 0);
    for (uint t = run.x; t < run.y; ++t) {
        const uint fate = fates[t] & SVO_FATE_MASK;
        if (fate == SVO_FATE_REFUSED || fate == SVO_FATE_FAR) {
            continue;
        }
        uint corners[3];
        (void)svo_mesh_corners(indices, &params, t, corners);
        const ulong3 a = svo_position_bits(positions, params.flags, corners[0]);
        const ulong3 b = svo_position_bits(positions, params.flags, corners[1]);
        const ulong3 c = svo_position_bits(positions, params.flags, corners[2]);
        sum += svo_signed_edge(a, b) + svo_signed_edge(b, c) + svo_signed_edge(c, a);
    }
    const ulong columns[2] = {sum.x, sum.y};
    svo_group_columns(columns, 2u, false, scratch, partials);
}
