/* SPDX-License-Identifier: MIT */
/*
 * Reduces the rows of the groups, and writes the kept triangles: those in the order of the mesh, and their draw items
 * by class. Counts of classes before a group come from the reduction, so the order is that of a stable counting sort.
 *
 * Launch: svo_k_plan_totals one group; svo_k_plan_keep one work-item per SVO_PLAN_RUN triangles; svo_k_plan_clear and
 * svo_k_plan_positions one per vertex, in whole groups. Atomics: the counter of large triangles, whose list the host
 * sorts by item.
 */
#include "plan/plan.clh"

#define SVO_CLASSES 4u

/* Replaces each column of sums by the exclusive prefix sums over the groups; totals receives the sums. With
   params.largest, totals receives the largest numbers and the rows stay. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_totals(__global ulong *partials, __global ulong *totals, svo_plan_total_params params,
                  __local ulong *scratch)
{
    const uint item = (uint)get_local_id(0);
    const uint run = params.groups / SVO_GROUP_ITEMS + 1u;
    const uint first = min(item * run, params.groups);
    const uint end = min(first + run, params.groups);
    for (uint column = 0; column < params.columns; ++column) {
        ulong result = 0;
        for (uint group = first; group < end; ++group) {
            const ulong x = partials[(size_t)group * params.columns + column];
            result = params.largest != 0u ? max(result, x) : result + x;
        }
        scratch[item] = result;
        barrier(CLK_LOCAL_MEM_FENCE);
        ulong before = 0;
        ulong total = 0;
        for (uint k = 0; k < SVO_GROUP_ITEMS; ++k) {
            before = k == item ? total : before;
            total = params.largest != 0u ? max(total, scratch[k]) : total + scratch[k];
        }
        for (uint group = first; group < (params.largest != 0u ? first : end); ++group) {
            const ulong x = partials[(size_t)group * params.columns + column];
            partials[(size_t)group * params.columns + column] = before;
            before += x;
        }
        if (item == 0u) {
            totals[column] = total;
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

/* Counts of the classes in 16 bits each: a group has SVO_SCAN_TILE triangles. */
static ulong svo_class_counts(__global const uchar *fates, uint2 run)
{
    ulong counts = 0;
    for (uint t = run.x; t < run.y; ++t) {
        const uint fate = fates[t] & SVO_FATE_MASK;
        counts += fate < SVO_CLASSES ? 1ul << (16u * fate) : 0ul;
    }
    return counts;
}

/* Counts of the work-items before this one. */
static ulong svo_counts_before(ulong counts, __local ulong *scratch)
{
    const uint item = (uint)get_local_id(0);
    scratch[item] = counts;
    barrier(CLK_LOCAL_MEM_FENCE);
    ulong before = 0;
    for (uint k = 0; k < (item == 0u ? SVO_GROUP_ITEMS : 0u); ++k) {
        const ulong own = scratch[k];
        scratch[k] = before;
        before += own;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    return scratch[item];
}

static svo_large_item svo_describe(__global const int *vertices, const uint corners[3], uint slot, uint axis,
                                   float fragments)
{
    const svo_snapped q = svo_snapped_triangle(vertices, corners);
    svo_large_item large;
    large.item = slot;
    large.axis = axis;
    large.fragments = fragments;
    vstore3(q.a, 0, large.corners);
    vstore3(q.b, 1, large.corners);
    vstore3(q.c, 2, large.corners);
    return large;
}

/* before: the rows of svo_k_plan_totals. large: NULL if nobody reads it. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_keep(__global const int *vertices, __global const uint *mesh_indices, __global const uchar *fates,
                __global const float *fragments, __global const ulong *before, __global uint *indices,
                __global uint *triangle_ids, __global svo_draw_item *items, __global float *item_fragments,
                __global svo_large_item *large, volatile __global uint *large_count, __global uchar *kept,
                svo_plan_params params, __local ulong *scratch)
{
    const uint2 run = svo_own_run(params.triangle_count);
    const ulong counts = svo_counts_before(svo_class_counts(fates, run), scratch);
    uint slots[SVO_CLASSES];
    uint next = 0;
    for (uint c = 0; c < SVO_CLASSES; ++c) {
        const uint inside = (uint)(counts >> (16u * c)) & 0xffffu;
        const uint rank = inside + (uint)before[(size_t)get_group_id(0) * SVO_PLAN_SUMS + c];
        slots[c] = params.class_begin[c] + rank;
        next += rank;
    }
    for (uint t = run.x; t < run.y; ++t) {
        const uint fate = fates[t];
        if ((fate & SVO_FATE_MASK) >= SVO_CLASSES) {
            continue;
        }
        const uint slot = slots[fate & SVO_FATE_MASK]++;
        const uint flags = fate >> SVO_FATE_DRAW_LOG2 & (SVO_DRAW_AXIS_MASK | SVO_DRAW_BOUNDS);
        uint corners[3];
        (void)svo_mesh_corners(mesh_indices, &params, t, corners);
        for (uint corner = 0; corner < 3; ++corner) {
            indices[(size_t)next * 3 + corner] = corners[corner];
            if ((params.flags & SVO_PLAN_SOME) != 0u) {
                kept[corners[corner]] = 1;
            }
        }
        triangle_ids[next] = t;
        items[slot].triangle = next++;
        items[slot].flags = flags;
        item_fragments[slot] = fragments[t];
        if ((fate & SVO_FATE_LARGE) != 0u && large != 0) {
            large[atomic_inc(large_count)] =
                svo_describe(vertices, corners, slot, flags & SVO_DRAW_AXIS_MASK, fragments[t]);
        }
    }
}

/* Sets vertices that no kept triangle uses to 0, since they may be out of range. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_clear(__global const uchar *kept, __global int *vertices, svo_plan_params params)
{
    const uint vertex = (uint)get_global_id(0);
    for (uint axis = 0; axis < (vertex < params.vertex_count && kept[vertex] == 0 ? 3u : 0u); ++axis) {
        vertices[(size_t)vertex * 3 + axis] = 0;
    }
}

/* Copies the positions of marked vertices; the others become 0, since they may not be finite. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_positions(__global const uint *from, __global const uchar *marks, __global uint *to, svo_plan_params params)
{
    const uint vertex = (uint)get_global_id(0);
    const uint words = (params.flags & SVO_PLAN_DOUBLES) != 0u ? 6u : 3u;
    for (uint k = 0; k < (vertex < params.vertex_count ? words : 0u); ++k) {
        const size_t at = (size_t)vertex * words + k;
        to[at] = marks[vertex] != 0 ? from[at] : 0u;
    }
}
