/* SPDX-License-Identifier: MIT */
/*
 * Nodes from a sorted list, in two passes over it: where the code of a pair differs from the one before it first, nodes
 * begin, there and on all levels below. Makes the nodes of bottom_up.cl.
 *
 *   svo_k_moving_begins  per strip: how many nodes begin in it, level by level
 *   scan.cl              exclusive sums over (level, strip): the index of each strip's first node of a level among all
 *   svo_k_moving_levels  one work-item per level: where it begins; a list without pairs has a root alone
 *   svo_k_moving_nodes   per strip: masks and first children of the inner nodes, the ranges of the leaves' pairs
 *
 * Launch: one work-item per SVO_NODE_STRIP pairs, rounded up to whole groups, and at least one. Strips that begin after
 * the pairs that the device has counted (svo_kept_count) are empty.
 * Atomics: the bits of a node's mask are joined by atomic_or, since its children may begin in several strips. The order
 * does not matter. Masks are bytes; four lie in a word, the first in its low byte.
 */
#include "moving/kept.clh"

/* The first level on which a pair's node is not that of the pair before it; depth + 1: they are in one leaf. */
static uint svo_first_level(svo_code code, svo_code before, uint depth)
{
    const ulong differing = (ulong)(code ^ before);
    return differing == 0UL ? depth + 1u : depth - (63u - (uint)clz(differing)) / 3u;
}

/* The pairs of a strip, from x to y. */
static uint2 svo_node_strip(uint strip, uint count)
{
    const uint begin = (uint)min((ulong)strip * SVO_NODE_STRIP, (ulong)count);
    return (uint2)(begin, begin + min(count - begin, (uint)SVO_NODE_STRIP));
}

/* counted: see svo_kept_count. counts: of level l and strip s at l * params.strips + s. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_begins(__global const uint *fragments, __global const uint *counted, __global uint *counts,
                    svo_node_params params)
{
    const uint strip = (uint)get_global_id(0);
    if (strip >= params.strips) {
        return;
    }
    const uint2 part = svo_node_strip(strip, svo_kept_count(params.count, counted));
    const uint begin = part.x;
    const uint end = part.y;
    uint begins[SVO_NODE_LEVELS];
    for (uint level = 0; level <= params.depth; ++level) {
        begins[level] = 0u;
    }
    svo_code before = begin > 0u && begin < end ? svo_fragment_code(fragments, begin - 1u) : 0u;
    for (uint i = begin; i < end; ++i) {
        const svo_code code = svo_fragment_code(fragments, i);
        const uint level = i == 0u ? 0u : svo_first_level(code, before, params.depth);
        if (level <= params.depth) {
            ++begins[level];
        }
        before = code;
    }
    uint sum = 0u;
    for (uint level = 0; level <= params.depth; ++level) {
        sum += begins[level];
        counts[level * params.strips + strip] = sum;
    }
}

/* before: the sums of the counts. state: receives the counts of the tree. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_levels(__global const uint *before, __global const uint *counted, __global svo_build_state *state,
                    svo_node_params params)
{
    const uint level = (uint)get_global_id(0);
    const uint count = svo_kept_count(params.count, counted);
    if (level <= params.depth + 1u) {
        state->level_begin[level] = count > 0u ? before[level * params.strips] : min(level, 1u);
    }
    if (level == 0u) {
        state->overflow = 0u;
        state->fragments_low = count;
        state->fragments_high = 0u;
        state->triangle_count = ~0u;
        state->long_lists = 0u;
        state->fragment_limit = count;
    }
}

/* Adds bits to the mask of a node. */
static void svo_add_mask(volatile __global uint *masks, uint node, uint bits)
{
    if (bits != 0u) {
        atomic_or(masks + (node >> 2), bits << 8u * (node & 3u));
    }
}

/* masks: zero at first. list_begin: of the leaves, and one more, which the strip that ends the list writes. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_moving_nodes(__global const uint *fragments, __global const uint *counted, __global const uint *before,
                   volatile __global uint *masks, __global uint *first_child, __global uint *list_begin,
                   svo_node_params params)
{
    const uint strip = (uint)get_global_id(0);
    const uint count = svo_kept_count(params.count, counted);
    if (strip == 0u && count == 0u) {
        first_child[0] = 1u;
        list_begin[0] = 0u;
    }
    const uint2 part = svo_node_strip(strip, count);
    const uint begin = part.x;
    const uint end = part.y;
    if (begin == end) {
        return;
    }
    uint next[SVO_NODE_LEVELS]; /* the node of the level that begins next */
    uint bits[SVO_NODE_LEVELS]; /* children of the one before it that have begun in this strip */
    for (uint level = 0; level <= params.depth; ++level) {
        next[level] = before[level * params.strips + strip];
        bits[level] = 0u;
    }
    const uint leaf_begin = before[params.depth * params.strips];
    svo_code last = begin > 0u ? svo_fragment_code(fragments, begin - 1u) : 0u;
    for (uint i = begin; i < end; ++i) {
        const svo_code code = svo_fragment_code(fragments, i);
        const uint first = i == 0u ? 0u : svo_first_level(code, last, params.depth);
        last = code;
        if (first > params.depth) {
            continue;
        }
        if (first > 0u) {
            bits[first - 1u] |= 1u << svo_octant(code, params.depth, first - 1u);
        }
        for (uint level = first; level < params.depth; ++level) {
            svo_add_mask(masks, next[level] - 1u, bits[level]);
            first_child[next[level]++] = next[level + 1u];
            bits[level] = 1u << svo_octant(code, params.depth, level);
        }
        list_begin[next[params.depth]++ - leaf_begin] = i;
    }
    for (uint level = 0; level < params.depth; ++level) {
        svo_add_mask(masks, next[level] - 1u, bits[level]);
    }
    if (end == count) {
        list_begin[next[params.depth] - leaf_begin] = count;
    }
}
