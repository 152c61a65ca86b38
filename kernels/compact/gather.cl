/* SPDX-License-Identifier: MIT */
/*
 * Copies the elements of an array in another order.
 *
 * Launch: one work-item per element of the copy, rounded up to whole groups. No atomics, no local memory.
 */
#include "shared/layout.h"

/* origins: for each element of to the index of its original. from and to in units of two bytes. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_compact_gather(__global const uint *origins, __global const ushort *from, __global ushort *to,
                     svo_compact_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    const size_t source = (size_t)origins[item] * params.element_halves;
    const size_t target = (size_t)item * params.element_halves;
    for (uint k = 0; k < params.element_halves; ++k) {
        to[target + k] = from[source + k];
    }
}
