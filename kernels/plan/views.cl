/* SPDX-License-Identifier: MIT */
/*
 * Packs a mesh that lies in a caller's buffers, for the plan's other kernels: arrays with gaps or at odd offsets, and
 * indices of 16 bits.
 *
 * Launch: one work-item per element, rounded up to whole groups. Each writes its own element.
 */
#include "plan/plan.clh"

/* Copies elements byte by byte, since a caller's strides need not be multiples of any type. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_pack(__global const uchar *from, __global uchar *to, svo_plan_view view)
{
    const ulong element = get_global_id(0);
    const ulong offset = (ulong)view.offset[1] << 32 | view.offset[0];
    const ulong stride = (ulong)view.stride[1] << 32 | view.stride[0];
    const ulong count = (ulong)view.count[1] << 32 | view.count[0];
    for (uint byte = 0; byte < (element < count ? view.element_bytes : 0u); ++byte) {
        to[element * view.element_bytes + byte] = from[offset + stride * element + byte];
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_widen(__global const ushort *from, __global uint *to, ulong count)
{
    const ulong element = get_global_id(0);
    if (element < count) {
        to[element] = from[element];
    }
}
