/* SPDX-License-Identifier: MIT */
/*
 * A packed array of payload (shared/packed.clh) as it was before; with -DSVO_PACKED, for trees that have one.
 *
 * Launch: one work-item per element, rounded up to whole groups. No atomics, no local memory.
 */
#include "shared/layout.h"

#include "shared/packed.clh"

#ifdef SVO_PACKED

/* to: in units of two bytes. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_unpack(__global const uint *packed, __global ushort *to, svo_compact_params params)
{
    const uint item = (uint)get_global_id(0);
    if (item >= params.node_count) {
        return;
    }
    uint halves[4];
    const size_t target = (size_t)item * params.element_halves;
    svo_packed_halves(packed, item, params.element_halves, halves);
    for (uint k = 0; k < params.element_halves; ++k) {
        to[target + k] = (ushort)halves[k];
    }
}

#endif
