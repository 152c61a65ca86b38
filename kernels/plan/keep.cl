/* SPDX-License-Identifier: MIT */
/*
 * Reduces the rows of the groups, and writes the kept triangles: those in the order of the mesh, and their draw items
 * by class and, within the triangles of a group, by size. Counts of classes before a group come from the reduction, and
 * those of sizes from a table in local memory, so the order is that of stable counting sorts. lib/plan/grid.c has the
 * same on the host.
 *
 * Launch: svo_k_plan_totals one group; svo_k_plan_keep one work-item per SVO_PLAN_RUN triangles; svo_k_plan_clear and
 * svo_k_plan_positions one per vertex, in whole groups. Atomics: the counter of large triangles, whose list the host
 * sorts by item.
 */
#include "plan/plan.clh"

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
            result = svo_reduce(result, x, params.largest != 0u);
        }
        scratch[item] = result;
        barrier(CLK_LOCAL_MEM_FENCE);
        ulong before = 0;
        ulong total = 0;
        for (uint k = 0; k < SVO_GROUP_ITEMS; ++k) {
            before = k == item ? total : before;
            total = svo_reduce(total, scratch[k], params.largest != 0u);
        }
        for (uint group = first; group < (params.largest != 0u ? first : end); ++group) {
            const ulong x = partials[(size_t)group * params.columns + column];
            partials[(size_t)group * params.columns + column] = before;
            before += x;
        }
        if (item == 0u) {
            totals[params.first_total + column] = total;
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

/* Counts of the classes in 16 bits each: a group has SVO_SCAN_TILE triangles. */
static ulong svo_class_counts(__global const ushort *fates, uint2 run)
{
    ulong counts = 0;
    for (uint t = run.x; t < run.y; ++t) {
        const uint fate = fates[t] & SVO_FATE_MASK;
        counts += fate < SVO_PLAN_CLASSES ? 1ul << (16u * fate) : 0ul;
    }
    return counts;
}

/* The first class from c on of which a group has triangles. */
static uint svo_next_class(ulong counts, uint c)
{
    while (c < SVO_PLAN_CLASSES && (counts >> (16u * c) & 0xffffu) == 0u) {
        ++c;
    }
    return c;
}

/* Counts of the work-items before this one; total: of all. */
SVO_INLINED ulong svo_counts_before(ulong counts, __local ulong *scratch, ulong *total)
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
    before = scratch[item];
    if (item == SVO_GROUP_ITEMS - 1u) {
        scratch[item] = before + counts;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    *total = scratch[SVO_GROUP_ITEMS - 1];
    barrier(CLK_LOCAL_MEM_FENCE);
    return before;
}

/* Ranks the group's triangles of a class by size, then in the order of the mesh; ranks: receives those of the run. A
   row of the table is for a size, its columns are for the work-items. */
SVO_INLINED void svo_rank_sizes(__global const ushort *fates, uint2 run, uint class_id, __local ulong *scratch,
                                __local ushort *table, ushort ranks[SVO_PLAN_RUN])
{
    const uint item = (uint)get_local_id(0);
    __local ushort *column = table + item; /* of this work-item's triangles */
    __local ushort *row = table + item * SVO_SIZE_PITCH; /* of the size that it sums up */
    for (uint size = 0; size < SVO_SIZE_COUNT; ++size) {
        column[size * SVO_SIZE_PITCH] = 0;
    }
    for (uint t = run.x; t < run.y; ++t) {
        if ((fates[t] & SVO_FATE_MASK) == class_id) {
            ++column[(fates[t] >> SVO_FATE_SIZE_LOG2) * SVO_SIZE_PITCH];
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    uint count = 0;
    for (uint k = 0; k < SVO_GROUP_ITEMS; ++k) {
        count += row[k];
    }
    ulong total;
    uint rank = (uint)svo_counts_before(count, scratch, &total);
    for (uint k = 0; k < SVO_GROUP_ITEMS; ++k) {
        const uint own = row[k];
        row[k] = (ushort)rank;
        rank += own;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint t = run.x; t < run.y; ++t) {
        if ((fates[t] & SVO_FATE_MASK) == class_id) {
            ranks[t - run.x] = column[(fates[t] >> SVO_FATE_SIZE_LOG2) * SVO_SIZE_PITCH]++;
        }
    }
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
svo_k_plan_keep(__global const int *vertices, __global const uint *mesh_indices, __global const ushort *fates,
                __global const float *fragments, __global const ulong *before, __global uint *indices,
                __global uint *triangle_ids, __global svo_draw_item *items, __global float *item_fragments,
                __global svo_large_item *large, volatile __global uint *large_count, __global uchar *kept,
                svo_plan_params params, __local ulong *scratch, __local ushort *table)
{
    const uint2 run = svo_own_run(params.triangle_count);
    ulong total;
    const ulong counts = svo_counts_before(svo_class_counts(fates, run), scratch, &total);
    uint begin[SVO_PLAN_CLASSES]; /* the group's first slot of each class */
    ushort ranks[SVO_PLAN_RUN];
    uint next = 0;
    for (uint c = 0; c < SVO_PLAN_CLASSES; ++c) {
        const uint before_group = (uint)before[(size_t)get_group_id(0) * SVO_PLAN_SUMS + c];
        next += before_group + ((uint)(counts >> (16u * c)) & 0xffffu);
        begin[c] = params.class_begin[c] + before_group;
    }
    for (uint c = svo_next_class(total, 0u); c < SVO_PLAN_CLASSES; c = svo_next_class(total, c + 1u)) {
        svo_rank_sizes(fates, run, c, scratch, table, ranks);
    }
    for (uint t = run.x; t < run.y; ++t) {
        const uint fate = fates[t];
        if ((fate & SVO_FATE_MASK) >= SVO_PLAN_CLASSES) {
            continue;
        }
        const uint slot = begin[fate & SVO_FATE_MASK] + ranks[t - run.x];
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
        if (svo_fate_is_large(fate) && large != 0) {
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
