/* SPDX-License-Identifier: MIT */
/*
 * The material of every node: the one of largest weight over the triangles in it; of equal weights the smaller
 * material.
 *
 *   svo_k_material_scatter  per fragment: (material, weight) into its leaf's range of entries, in any order
 *   svo_k_material_leaves   per leaf: sorts its entries by material and adds up those of one material
 *   svo_k_material_long     per leaf of more than SVO_LONG_LEAF entries, one work-group: the same, by a radix sort with
 *                           four bits a pass. On GPUs (SVO_LONG_LEAVES)
 *   svo_k_material_merge    per node of a level: merges its children's entries, up to eight adjacent sorted runs, in
 *                           place of the first
 *   svo_k_material_top      the same for the few nodes of the top levels, by one group
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
 * Launch: one work-item per fragment, leaf or node, rounded up to whole groups; any number of groups, among which the
 * long leaves are divided. Reads the fragments, their cursors and the surface; writes entries and materials. Atomics: a
 * counter per leaf hands out each slot once, another one the places in long_leaves; shared_sum.clh.
 */
#include "shared/group.clh"
#include "shared/state.clh"
#include "stages/attribute.clh"
#include "stages/digits.clh"
#include "stages/shared_sum.clh"

#ifdef SVO_MATERIAL

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
                       __global const ulong *remainders, __global const uint *indices,
                       __global const svo_triangle_record *records, __global const uint *list_begin,
                       volatile __global uint *counts, __global ulong *entries, __global const svo_build_state *state,
                       svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint index = (uint)get_global_id(0);
    if (index < params.fragment_count) {
        const svo_surface surface = {vertices, remainders, indices, records, 0, 0, 0, 0, 0};
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
   long_leaves: the number of leaves that are left out, then these. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_material_leaves(__global const uint *list_begin, __global uint *counts, __global ulong *entries,
                      __global ulong *spare, __global uint *long_leaves, __global ushort *materials,
                      __global const svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= params.leaf_count) {
        return;
    }
    const uint begin = list_begin[leaf];
    const uint end = list_begin[leaf + 1u];
#ifdef SVO_LONG_LEAVES
    if (end - begin > SVO_LONG_LEAF) {
        long_leaves[1u + atomic_inc(long_leaves)] = leaf;
        return;
    }
#else
    (void)long_leaves;
#endif
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

#ifdef SVO_LONG_LEAVES

/* One stable pass over the leaf's entries by a digit of their materials. */
SVO_INLINED void svo_material_pass(__global const ulong *from, __global ulong *to, uint2 leaf, uint digit,
                                   __local uint *counts, __local uint *scratch)
{
    const uint item = (uint)get_local_id(0);
    const uint shift = digit * SVO_DIGIT_BITS;
    const uint2 strip = svo_strip(leaf.x, leaf.y);
    for (uint k = 0; k < SVO_DIGITS; ++k) {
        counts[k * SVO_GROUP_ITEMS + item] = 0u;
    }
    for (uint i = strip.x; i < strip.y; ++i) {
        ++counts[(svo_entry_material(from[i]) >> shift & (SVO_DIGITS - 1u)) * SVO_GROUP_ITEMS + item];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    svo_scan_digits(counts, scratch);
    for (uint i = strip.x; i < strip.y; ++i) {
        const ulong entry = from[i];
        const uint place = (svo_entry_material(entry) >> shift & (SVO_DIGITS - 1u)) * SVO_GROUP_ITEMS + item;
        to[leaf.x + counts[place]++] = entry;
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

/* Whether another material begins at an entry of the sorted leaf. */
static uint svo_begins_material(__global const ulong *entries, uint2 leaf, uint i)
{
    return i == leaf.x || svo_entry_material(entries[i]) != svo_entry_material(entries[i - 1u]) ? 1u : 0u;
}

/* Adds up the sorted entries of each material, in place, with the help of spare; returns how many materials there
   are. */
SVO_INLINED uint svo_join_materials(__global ulong *entries, __global ulong *spare, uint2 leaf, __local uint *scratch)
{
    const uint item = (uint)get_local_id(0);
    const uint2 strip = svo_strip(leaf.x, leaf.y);
    uint begun = 0;
    for (uint i = strip.x; i < strip.y; ++i) {
        begun += svo_begins_material(entries, leaf, i);
        spare[i] = 0UL;
    }
    uint count;
    uint place = leaf.x + svo_group_exclusive(begun, scratch, &count);
    barrier(CLK_GLOBAL_MEM_FENCE);
    ulong sum = 0;
    for (uint i = strip.x; i < strip.y; ++i) {
        const bool begins = svo_begins_material(entries, leaf, i) != 0u;
        if (begins && i > strip.x) {
            svo_add_shared(spare + place - 1u, sum);
            sum = 0;
        }
        place += begins ? 1u : 0u;
        sum += begins ? entries[i] : entries[i] & ((1UL << SVO_ENTRY_SHIFT) - 1UL);
    }
    if (strip.x < strip.y) {
        svo_add_shared(spare + place - 1u, sum);
    }
    barrier(CLK_GLOBAL_MEM_FENCE);
    for (uint i = leaf.x + item; i < leaf.x + count; i += SVO_GROUP_ITEMS) {
        entries[i] = spare[i];
    }
    return count;
}

/* counts: SVO_DIGITS * SVO_GROUP_ITEMS words, scratch: SVO_GROUP_ITEMS; arguments, see group.clh. params.digit_passes:
   over the materials, an even number. One call of the pass: Intel's driver crashes now and then at two
   (tests/drivers/barriers.c). */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_material_long(__global const uint *list_begin, __global uint *leaf_counts, __global ulong *entries,
                    __global ulong *spare, __global const uint *long_leaves, __global ushort *materials,
                    __global const svo_build_state *state, svo_filter_params params, __local uint *counts,
                    __local uint *scratch)
{
    svo_make_current(&params, state);
    const uint long_count = long_leaves[0];
    for (uint k = (uint)get_group_id(0); k < long_count; k += (uint)get_num_groups(0)) {
        const uint leaf = long_leaves[1u + k];
        const uint2 range = (uint2)(list_begin[leaf], list_begin[leaf + 1u]);
        __global ulong *from = entries;
        __global ulong *to = spare;
        for (uint pass = 0; pass < params.digit_passes; ++pass) {
            svo_material_pass(from, to, range, pass, counts, scratch);
            __global ulong *const sorted = to;
            to = from;
            from = sorted;
        }
        const uint count = svo_join_materials(entries, spare, range, scratch);
        barrier(CLK_GLOBAL_MEM_FENCE);
        if (get_local_id(0) == 0u) {
            leaf_counts[leaf] = count;
            materials[params.leaf_begin + leaf - params.payload_begin] =
                svo_heaviest(entries, range.x, range.x + count);
        }
    }
}

#endif

/* The entries of a level's nodes, indexed from its first node. */
typedef struct svo_level_entries {
    __global uint *begins;
    __global uint *counts;
    __global ulong *entries;
} svo_level_entries;

/* index: from the level's first node. */
SVO_CALLED void svo_merge_node(uint index, __global const uchar *masks, __global const uint *first_child,
                               svo_level_entries children, svo_level_entries nodes, __global ushort *materials,
                               svo_filter_params params)
{
    const uint node = params.level_begin + index;
    const uint child = first_child[node] - params.child_begin;
    const uint child_count = popcount((uint)masks[node]);
    uint next[8];
    uint last[8];
    for (uint i = 0; i < child_count; ++i) {
        next[i] = children.begins[child + i];
        last[i] = next[i] + children.counts[child + i];
    }
    const uint begin = next[0];
    uint end = begin;
    for (;;) {
        uint chosen = 0;
        ulong least = SVO_NO_ENTRY;
        for (uint i = 0; i < child_count; ++i) {
            const ulong entry = next[i] < last[i] ? children.entries[next[i]] : SVO_NO_ENTRY;
            chosen = entry < least ? i : chosen;
            least = min(least, entry);
        }
        if (least == SVO_NO_ENTRY) {
            break;
        }
        ++next[chosen];
        end = svo_put_entry(nodes.entries, begin, end, least);
    }
    nodes.begins[index] = begin;
    nodes.counts[index] = end - begin;
    materials[node - params.payload_begin] = svo_heaviest(nodes.entries, begin, end);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_material_merge(__global const uchar *masks, __global const uint *first_child, __global uint *child_begins,
                     __global uint *child_counts, __global ulong *child_entries, __global uint *begins,
                     __global uint *counts, __global ulong *entries, __global ushort *materials,
                     __global const svo_build_state *state, svo_filter_params params)
{
    svo_make_current(&params, state);
    const uint index = (uint)get_global_id(0);
    if (index < params.level_count) {
        const svo_level_entries children = {child_begins, child_counts, child_entries};
        const svo_level_entries nodes = {begins, counts, entries};
        svo_merge_node(index, masks, first_child, children, nodes, materials, params);
    }
}

/* params.level: the first of the levels, which is at most SVO_TOP_LEVEL and not the one above the leaves, since their
   entries begin where list_begin says. Launch: one group. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_material_top(__global const uchar *masks, __global const uint *first_child, __global uint *child_begins,
                   __global uint *child_counts, __global ulong *child_entries, __global uint *begins,
                   __global uint *counts, __global ulong *entries, __global ushort *materials,
                   __global const svo_build_state *state, svo_filter_params params)
{
    svo_level_entries children = {child_begins, child_counts, child_entries};
    svo_level_entries nodes = {begins, counts, entries};
    for (uint level = params.level + 1u; level-- > params.payload_level;) {
        svo_filter_params current = params; /* of which drivers may have one for all work-items */
        current.level = level;
        svo_make_current(&current, state);
        for (uint index = (uint)get_local_id(0); index < current.level_count; index += SVO_GROUP_ITEMS) {
            svo_merge_node(index, masks, first_child, children, nodes, materials, current);
        }
        barrier(CLK_GLOBAL_MEM_FENCE);
        const svo_level_entries above = children;
        children = nodes;
        nodes = above;
    }
}

#endif
