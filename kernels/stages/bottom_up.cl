/* SPDX-License-Identifier: MIT */
/*
 * Nodes from sorted fragments, from the leaves up: builds the same nodes as subdivide.cl (as in Karras, "Maximizing
 * Parallelism in the Construction of BVHs, Octrees, and k-d Trees", 2012, but level by level).
 *
 *   svo_k_bottom_up_count   per fragment, once: the levels on which it is the first of its node. The sums give all
 *                           levels' sizes, and so every node's place before the first node is made
 *   svo_k_bottom_up_flags   per entry of a level's codes: 1 where another node of the level above begins
 *   scan.cl                 exclusive sums of the flags: the nodes' indices (svo_k_scan_lists_*)
 *   svo_k_bottom_up_leaves  per fragment: its leaf, and the leaves' codes
 *   svo_k_bottom_up_nodes   per child: its parent's code, mask and first child
 *   svo_k_bottom_up_lists   per fragment: leaf lists, packed in the order of the fragments
 *
 * Invariant: codes of a level are sorted, so nodes come out in Morton order and the children of a parent are adjacent.
 * Launch: one work-item per fragment or child, rounded up to whole groups.
 * Atomics: svo_k_bottom_up_count adds to one counter per level; sums do not depend on the order.
 */
#include "shared/fragment.clh"

/* Codes of the nodes of a level lie in words of their own; those of the fragments have the triangle beside them. */
static svo_code svo_bottom_up_code(__global const uint *codes, size_t index, svo_bottom_up_params params)
{
    if (params.of_fragments != 0u) {
        return svo_fragment_code(codes, index);
    }
#ifdef SVO_CODE48
    return (ulong)codes[2 * index] | (ulong)codes[2 * index + 1] << 32;
#else
    return codes[index];
#endif
}

static void svo_bottom_up_store(__global uint *codes, size_t index, svo_code code)
{
#ifdef SVO_CODE48
    codes[2 * index] = (uint)code;
    codes[2 * index + 1] = (uint)(code >> 32);
#else
    codes[index] = code;
#endif
}

/* Counts the fragment on the first level on which its node differs from that of the fragment before it: there and on
   all levels below it begins a node. counts: one per level, 0 at first, then the number of impossible fragments, such
   as a faulty driver writes. scratch: as many, for the group's sums. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bottom_up_count(__global const uint *fragments, volatile __global uint *counts, svo_bottom_up_params params,
                      volatile __local uint *scratch)
{
    const uint index = (uint)get_global_id(0);
    const uint item = (uint)get_local_id(0);
    const uint damaged = params.depth + 1u;
    if (item <= damaged) {
        scratch[item] = 0u;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (index < params.count) {
        const svo_code code = svo_fragment_code(fragments, index);
        const svo_code before = index > 0u ? svo_fragment_code(fragments, index - 1u) : ~code;
        uint level = 0;
        while (index > 0u && level <= params.depth && (code ^ before) >> (3u * (params.depth - level)) == 0) {
            ++level;
        }
        if (level <= params.depth) {
            atomic_inc(scratch + level);
        }
        if (code >> (3u * params.depth) != 0 || svo_fragment_triangle(fragments, index) >= params.triangle_count) {
            atomic_inc(scratch + damaged);
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item <= damaged && scratch[item] != 0u) {
        atomic_add(counts + item, scratch[item]);
    }
}

/* Whether a node of the next level begins here. params.shift: code bits between the two: 0 from fragments to leaves, 3
   from a level to the one above. */
static bool svo_bottom_up_begins(__global const uint *codes, uint index, svo_bottom_up_params params)
{
    return index == 0u || svo_bottom_up_code(codes, index, params) >> params.shift !=
                              svo_bottom_up_code(codes, index - 1u, params) >> params.shift;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bottom_up_flags(__global const uint *codes, __global uint *flags, svo_bottom_up_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index < params.count) {
        flags[index] = svo_bottom_up_begins(codes, index, params) ? 1u : 0u;
    }
}

/* before: the sum of the flags before each fragment. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bottom_up_leaves(__global const uint *fragments, __global const uint *before, __global uint *cursors,
                       __global uint *codes, svo_bottom_up_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index < params.count) {
        const bool begins = svo_bottom_up_begins(fragments, index, params);
        const uint leaf = before[index] - (begins ? 0u : 1u);
        cursors[index] = params.node_begin + leaf;
        if (begins) {
            svo_bottom_up_store(codes, leaf, svo_fragment_code(fragments, index));
        }
    }
}

/* Leaf lists are the sorted fragments' triangles. list: NULL where only the ranges are needed. params.node_begin: the
   first leaf, params.child_begin: the number of leaves. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bottom_up_lists(__global const uint *fragments, __global const uint *cursors, __global uint *list_begin,
                      __global uint *list, svo_bottom_up_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index >= params.count) {
        return;
    }
    if (index == 0u || cursors[index] != cursors[index - 1u]) {
        list_begin[cursors[index] - params.node_begin] = index;
    }
    if (index == params.count - 1u) {
        list_begin[params.child_begin] = params.count;
    }
    if (list != 0) {
        list[index] = svo_fragment_triangle(fragments, index);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bottom_up_nodes(__global const uint *children, __global const uint *before, __global uint *codes,
                      __global uchar *masks, __global uint *first_child, svo_bottom_up_params params)
{
    const uint index = (uint)get_global_id(0);
    if (index >= params.count || !svo_bottom_up_begins(children, index, params)) {
        return;
    }
    const svo_code code = svo_bottom_up_code(children, index, params) >> 3;
    uint mask = 0;
    for (uint child = index; child < params.count; ++child) {
        const svo_code of_child = svo_bottom_up_code(children, child, params);
        if (of_child >> 3 != code) {
            break;
        }
        mask |= 1u << ((uint)of_child & 7u);
    }
    const uint node = before[index];
    svo_bottom_up_store(codes, node, code);
    masks[params.node_begin + node] = (uchar)mask;
    first_child[params.node_begin + node] = params.child_begin + index;
}
