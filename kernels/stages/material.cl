/* SPDX-License-Identifier: MIT */
/*
 * The material of every node: the one of largest weight over the triangles in it; of equal weights the smaller
 * material.
 *
 *   svo_k_material_scatter  per fragment: (material, weight) into its leaf's range of entries, in any order
 *   svo_k_material_leaves   per leaf: sorts its entries by material and adds up those of one material
 *   svo_k_material_merge    per node of a level: merges its children's entries, up to eight adjacent sorted runs, in
 *                           place of the first
 *
 * An entry is a material and a sum of weights in one word, so that words sort by material:
 *
 *   63        48 47                     0
 *   [ material ][ weight, below 2^47     ]
 *
 * Invariant: the entries of a node are its materials, each once and ascending. So levels never grow, and no result
 * depends on the order of the fragments. Sorting is near-linear: a run of sums is no longer than the number of
 * materials.
 *
 * Launch: one work-item per fragment, leaf or node, rounded up to whole groups. Reads the fragments, their cursors and
 * the surface; writes entries and materials. Atomics: a counter per leaf hands out each slot once.
 */
#include "shared/state.clh"
#include "stages/attribute.clh"

#ifdef SVO_MATERIAL

#define SVO_ENTRY_SHIFT 48
/* Sorts after all materials, which are below 65535. */
#define SVO_NO_ENTRY (~0UL)

static uint svo_entry_material(ulong entry)
{
    return (uint)(entry >> SVO_ENTRY_SHIFT);
}

/* Appends an entry, or adds its weight to the last one if that has its material. Returns the new end. */
static uint svo_put_entry(__global ulong *entries, uint begin, uint end, ulong entry)
{
    if (end > begin && svo_entry_material(entries[end - 1u]) == svo_entry_material(entry)) {
        entries[end - 1u] += entry & ((1UL << SVO_ENTRY_SHIFT) - 1UL);
        return end;
    }
    entries[end] = entry;
    return end + 1u;
}

static ushort svo_heaviest(__global const ulong *entries, uint begin, uint end)
{
    ulong most = 0;
    uint material = 0;
    for (uint i = begin; i < end; ++i) {
        const ulong weight = entries[i] & ((1UL << SVO_ENTRY_SHIFT) - 1UL);
        material = weight > most ? svo_entry_material(entries[i]) : material;
        most = max(most, weight);
    }
    return (ushort)material;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_material_scatter(__global const uint *fragments, __global const uint *cursors, __global const int *vertices,
                       __global const uint *indices, __global const svo_triangle_record *records,
                       __global const uint *list_begin, volatile __global uint *counts, __global ulong *entries,
                       __global const svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint index = (uint)get_global_id(0);
    if (index < params.fragment_count) {
        const svo_surface surface = {vertices, indices, records, 0, 0, 0, 0, 0};
        const uint triangle = svo_fragment_triangle(fragments, index);
        const svo_share share = svo_pair_share(surface, triangle, svo_fragment_code(fragments, index), params);
        const uint leaf = cursors[index] - params.leaf_begin;
        entries[list_begin[leaf] + atomic_inc(counts + leaf)] =
            (ulong)records[triangle].material << SVO_ENTRY_SHIFT | share.weight;
    }
}

/* Merges two adjacent runs, whose unused slots hold SVO_NO_ENTRY, into one. */
static void svo_merge_pair(__global const ulong *from, __global ulong *to, uint begin, uint middle, uint end)
{
    uint a = begin;
    uint b = middle;
    uint written = begin;
    for (;;) {
        const ulong first = a < middle ? from[a] : SVO_NO_ENTRY;
        const ulong second = b < end ? from[b] : SVO_NO_ENTRY;
        const ulong least = min(first, second);
        if (least == SVO_NO_ENTRY) {
            break;
        }
        a += first == least ? 1u : 0u;
        b += first == least ? 0u : 1u;
        written = svo_put_entry(to, begin, written, least);
    }
    for (; written < end; ++written) {
        to[written] = SVO_NO_ENTRY;
    }
}

/* Bottom-up merge sort, alternating between entries and spare; after an odd number of passes the result is copied back.
   */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_material_leaves(__global const uint *list_begin, __global uint *counts, __global ulong *entries,
                      __global ulong *spare, __global ushort *materials, __global const svo_build_state *state,
                      svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.leaf_count) {
        return;
    }
    const uint begin = list_begin[leaf];
    const uint end = list_begin[leaf + 1u];
    __global ulong *from = entries;
    __global ulong *to = spare;
    for (ulong width = 1; width < end - begin; width *= 2) {
        for (ulong run = begin; run < end; run += 2 * width) {
            svo_merge_pair(from, to, (uint)run, (uint)min(run + width, (ulong)end),
                           (uint)min(run + 2 * width, (ulong)end));
        }
        __global ulong *written = to;
        to = from;
        from = written;
    }
    uint count = 0;
    while (count < end - begin && from[begin + count] != SVO_NO_ENTRY) {
        entries[begin + count] = from[begin + count];
        ++count;
    }
    counts[leaf] = count;
    materials[params.leaf_begin + leaf - params.payload_begin] = svo_heaviest(entries, begin, begin + count);
}

/* child_begins and child_counts are indexed from the first node of their level. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_material_merge(__global const uchar *masks, __global const uint *first_child, __global const uint *child_begins,
                     __global const uint *child_counts, __global const ulong *child_entries, __global uint *begins,
                     __global uint *counts, __global ulong *entries, __global ushort *materials,
                     __global const svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint index = (uint)get_global_id(0);
    if (index >= params.level_count) {
        return;
    }
    const uint node = params.level_begin + index;
    const uint child = first_child[node] - params.child_begin;
    const uint children = popcount((uint)masks[node]);
    uint next[8];
    uint last[8];
    for (uint i = 0; i < children; ++i) {
        next[i] = child_begins[child + i];
        last[i] = next[i] + child_counts[child + i];
    }
    const uint begin = next[0];
    uint end = begin;
    for (;;) {
        uint chosen = 0;
        ulong least = SVO_NO_ENTRY;
        for (uint i = 0; i < children; ++i) {
            const ulong entry = next[i] < last[i] ? child_entries[next[i]] : SVO_NO_ENTRY;
            chosen = entry < least ? i : chosen;
            least = min(least, entry);
        }
        if (least == SVO_NO_ENTRY) {
            break;
        }
        ++next[chosen];
        end = svo_put_entry(entries, begin, end, least);
    }
    begins[index] = begin;
    counts[index] = end - begin;
    materials[node - params.payload_begin] = svo_heaviest(entries, begin, end);
}

#endif
