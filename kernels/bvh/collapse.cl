/* SPDX-License-Identifier: MIT */
/*
 * Collapses the binary tree of branches into nodes of eight children, from the root, a level of nodes at a time: a node
 * opens the largest of its parts until it has eight, or all are leaves (Wald, Benthin and Boulos, "Getting Rid of
 * Packets", 2008). Nodes are numbered level by level, and in the order of their parents.
 *
 *   svo_k_bvh_root     the first node
 *   svo_k_bvh_open     per node of a level: its children
 *   svo_k_bvh_number   numbers the children that are nodes, which are the next level
 *
 * Launch: root: one work-item; the others: a work-item per node, in groups of SVO_GROUP_ITEMS, or more: the state says
 * where levels begin. No atomics. Local memory is an argument, see group.clh.
 */
#include "bvh/ranges.clh"
#include "shared/group.clh"

/* The largest part that is no leaf; count: none. */
static uint svo_bvh_largest(const uint *branch, const float *area, uint count)
{
    uint best = count;
    for (uint i = 0; i < count; ++i) {
        if (branch[i] != 0u && (best == count || area[i] > area[best])) {
            best = i;
        }
    }
    return best;
}

__kernel void svo_k_bvh_root(__global const svo_bvh_branch *branches, __global uint *nodes,
                             __global svo_bvh_state *state, uint item_count)
{
    nodes[0] = 0u;
    nodes[1] = item_count;
    nodes[2] = branches[0].part[0];
    state->node_begin[0] = 0u;
    state->node_begin[1] = 1u;
}

/* Writes the children of a node, and returns how many of them are nodes. */
static uint svo_bvh_open_node(__global const uint *node, __global const svo_bvh_branch *branches,
                              __global svo_bvh_children *children, __global uint *item_counts)
{
    uint first[8], items[8], branch[8];
    float area[8];
    uint count = 1u;
    first[0] = node[0];
    items[0] = node[1];
    branch[0] = node[2];
    area[0] = 0.0f;
    for (uint best = svo_bvh_largest(branch, area, 1u); best < count && count < 8u;
         best = svo_bvh_largest(branch, area, count)) {
        const uint split = branch[best];
        const svo_bvh_branch parts = branches[split];
        first[count] = split;
        items[count] = first[best] + items[best] - split;
        branch[count] = parts.part[1];
        area[count] = parts.area[1];
        items[best] = split - first[best];
        branch[best] = parts.part[0];
        area[best] = parts.area[0];
        ++count;
    }
    uint inner = 0u;
    for (uint i = 0; i < 8u; ++i) {
        const bool is_there = i < count && items[i] != 0u;
        children->first[i] = is_there ? first[i] : 0u;
        children->count[i] = is_there ? items[i] : 0u;
        children->node[i] = is_there ? branch[i] : 0u;
        inner += is_there && branch[i] != 0u ? 1u : 0u;
        if (is_there && branch[i] == 0u) {
            item_counts[first[i]] = items[i];
        }
    }
    return inner;
}

/* nodes: per node its first item, its items and its branch. counts: per group of nodes their children that are nodes.
   item_counts: the items of each leaf, at its first item; 0 elsewhere. */
__kernel void svo_k_bvh_open(__global const uint *nodes, __global const svo_bvh_branch *branches,
                             __global svo_bvh_children *children, __global uint *counts, __global uint *item_counts,
                             __global const svo_bvh_state *state, uint level, __local uint *scratch)
{
    const uint node = state->node_begin[level] + (uint)get_global_id(0);
    uint inner = 0u;
    if (node < state->node_begin[level + 1u]) {
        inner = svo_bvh_open_node(nodes + 3 * (size_t)node, branches, children + node, item_counts);
    }
    const uint sum = svo_group_sum(inner, scratch);
    if (get_local_id(0) == 0u) {
        counts[get_group_id(0)] = sum;
    }
}

/* Numbers a node's children from an index on, and tells them of their items. */
static void svo_bvh_number_children(__global svo_bvh_children *children, __global uint *nodes, uint index)
{
    for (uint i = 0; i < 8u; ++i) {
        if (children->node[i] != 0u) {
            nodes[3 * (size_t)index] = children->first[i];
            nodes[3 * (size_t)index + 1] = children->count[i];
            nodes[3 * (size_t)index + 2] = children->node[i];
            children->node[i] = index++;
        }
    }
}

/* The children of a node that are nodes. */
static uint svo_bvh_count_inner(__global const svo_bvh_children *children)
{
    uint inner = 0u;
    for (uint i = 0; i < 8u; ++i) {
        inner += children->node[i] != 0u ? 1u : 0u;
    }
    return inner;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_bvh_number(__global uint *nodes, __global svo_bvh_children *children, __global const uint *counts,
                 __global svo_bvh_state *state, uint level, __local uint *scratch)
{
    const uint begin = state->node_begin[level];
    const uint end = state->node_begin[level + 1u];
    const uint group = (uint)get_group_id(0);
    const uint last_group = (max(end - begin, 1u) - 1u) / SVO_GROUP_ITEMS;
    if (group > last_group) {
        return;
    }
    uint sum = 0u;
    for (uint i = (uint)get_local_id(0); i < group; i += SVO_GROUP_ITEMS) {
        sum += counts[i];
    }
    uint before, own;
    svo_group_exclusive(sum, scratch, &before);
    const uint node = begin + (uint)get_global_id(0);
    const uint inner = node < end ? svo_bvh_count_inner(children + node) : 0u;
    const uint index = end + before + svo_group_exclusive(inner, scratch, &own);
    if (inner != 0u) {
        svo_bvh_number_children(children + node, nodes, index);
    }
    if (group == last_group && get_local_id(0) == 0u) {
        state->node_begin[level + 2u] = end + before + own;
    }
}
