/* SPDX-License-Identifier: MIT */
/*
 * The payload of a solid, one array: breadth-first like that of the built tree, with the given value for interior
 * leaves.
 *
 * Launch: one work-item per inner node, rounded up to whole groups. Reads the tree's masks, indices and payload, the
 * mask of interior leaves and the sums of the numbers of children; writes the payload of the children, and the first
 * work-item that of the root. Elements are copied by 16 bits. No atomics, no local memory.
 */
#include "shared/solid_layout.h"

static void svo_copy_element(__global const ushort *from, size_t source, __global ushort *to, size_t target,
                             const svo_solid_params *params)
{
    const uint halves = params->element_halves;
    const size_t first = params->repeats != 0u ? 0 : source * halves;
    for (uint k = 0; k < halves; ++k) {
        to[target * halves + k] = from[first + k];
    }
}

static void svo_set_element(__global ushort *to, size_t target, const svo_solid_params *params)
{
    for (uint k = 0; k < params->element_halves; ++k) {
        to[target * params->element_halves + k] = (ushort)(params->value[k / 2u] >> 16u * (k % 2u));
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_solid_payload(__global const uchar *child_mask, __global const uint *first_child,
                    __global const uchar *inside_mask, __global const uint *first_payload, __global const ushort *from,
                    __global ushort *to, svo_solid_params params)
{
    const uint node = (uint)get_global_id(0);
    if (node >= params.count) {
        return;
    }
    if (node == 0u) {
        svo_copy_element(from, 0, to, 0, &params);
    }
    uint source = first_child[node];
    uint target = first_payload[node];
    for (uint octant = 0; octant < 8u; ++octant) {
        if ((child_mask[node] >> octant & 1u) != 0u) {
            svo_copy_element(from, source++, to, target++, &params);
        } else if ((inside_mask[node] >> octant & 1u) != 0u) {
            svo_set_element(to, target++, &params);
        }
    }
}
