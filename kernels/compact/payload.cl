/* SPDX-License-Identifier: MIT */
/*
 * The payload of a compact tree in its form's order. The children of a node lie side by side, in the order of their
 * parents' words; bases, beside the words, has where.
 *
 * Launch: one work-item per inner node of the tree, rounded up to whole groups. No atomics, no local memory.
 */
#include "shared/layout.h"

/* Counts the children that have payload, beside their parent's word; the other counts are 0 before. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_compact_counts(__global const uchar *valid, __global const uint *places, __global uint *counts,
                     svo_compact_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node < params.node_count && node >= params.payload_parents) {
        counts[places[node]] = popcount((uint)valid[node]);
    }
}

/* From the exclusive sums of the counts to bases, which are 0 before, and to targets, the same by node. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_compact_bases(__global const uint *places, __global const uint *sums, __global uint *bases,
                    __global uint *targets, svo_compact_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node < params.node_count) {
        const uint word = places[node];
        const uint base = node < params.payload_parents ? SVO_NO_NODE : sums[word] + params.root_payload;
        bases[word] = base;
        targets[node] = base;
    }
}

/* Copies one payload array; from and to in units of two bytes. targets: where the payload of a node's children goes. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_compact_payload(__global const uchar *valid, __global const uint *first_payload, __global const uint *targets,
                      __global const ushort *from, __global ushort *to, svo_compact_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node >= params.node_count) {
        return;
    }
    for (uint k = 0; node == 0u && k < params.root_payload * params.element_halves; ++k) {
        to[k] = from[k];
    }
    if (node < params.payload_parents) {
        return;
    }
    const size_t source = (size_t)(first_payload[node] - params.payload_begin) * params.element_halves;
    const size_t target = (size_t)targets[node] * params.element_halves;
    const uint count = popcount((uint)valid[node]) * params.element_halves;
    for (uint k = 0; k < count; ++k) {
        to[target + k] = from[source + k];
    }
}
