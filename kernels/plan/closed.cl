/* SPDX-License-Identifier: MIT */
/*
 * Whether a mesh is closed: the edges of its accepted triangles cancel. An edge is two positions as the mesh has them;
 * it counts 1 in one direction and -1 in the other. Instead of the counts, their products with 128-bit hashes of the
 * edges are summed, modulo 2^128 in two halves. A closed mesh gives zero; another one does not, up to a chance of
 * 2^-128 (Carter and Wegman, "Universal classes of hash functions", 1979). lib/plan/closed.c counts edge by edge on the
 * host.
 *
 * Launch: one work-item per SVO_PLAN_RUN triangles, in whole groups. Writes a row of two sums per group. No atomics.
 */
#include "plan/plan.clh"

/* A vertex's coordinates as bits of doubles; + 0.0 turns -0 into 0, which equals it. */
static ulong3 svo_position_bits(__global const uint *positions, uint flags, uint vertex)
{
    return as_ulong3(svo_mesh_vertex(positions, flags, vertex) + 0.0);
}

/* Below 0, 0 or above 0 as position a comes before, is or comes after b, in some order. */
static int svo_compare_positions(ulong3 a, ulong3 b)
{
    const int3 order = convert_int3(a > b) - convert_int3(a < b); /* -1 is true */
    return -(order.x != 0 ? order.x : order.y != 0 ? order.y : order.z);
}

/* A hash of two positions, by the mixing function of Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
   Generators", 2014. */
static ulong svo_mix(ulong hash, ulong x)
{
    hash += 0x9e3779b97f4a7c15ul + x;
    hash = (hash ^ hash >> 30) * 0xbf58476d1ce4e5b9ul;
    hash = (hash ^ hash >> 27) * 0x94d049bb133111ebul;
    return hash ^ hash >> 31;
}

static ulong svo_hash_edge(ulong3 a, ulong3 b, ulong seed)
{
    return svo_mix(svo_mix(svo_mix(svo_mix(svo_mix(svo_mix(seed, a.x), a.y), a.z), b.x), b.y), b.z);
}

static ulong2 svo_signed_edge(ulong3 from, ulong3 to)
{
    const int order = svo_compare_positions(from, to);
    const ulong3 low = order < 0 ? from : to;
    const ulong3 high = order < 0 ? to : from;
    if (order == 0) {
        return (ulong2)(0, 0);
    }
    const ulong2 hash = (ulong2)(svo_hash_edge(low, high, 1ul), svo_hash_edge(low, high, 2ul));
    return order < 0 ? hash : (ulong2)(0, 0) - hash;
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
