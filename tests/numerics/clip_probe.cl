/* SPDX-License-Identifier: MIT */
/* clip_probe.clh in OpenCL C: one work-item per record. And svo_share_of of pairs of numbers. */
#include "clip_probe.clh"

__kernel void clip_probe_all(__global const clip_probe_input *given, __global clip_probe_output *found, uint item_count)
{
    const uint i = (uint)get_global_id(0);
    if (i < item_count) {
        found[i] = clip_probe(given[i]);
    }
}

__kernel void clip_share_all(__global const ulong2 *given, __global uint *found, uint item_count)
{
    const uint i = (uint)get_global_id(0);
    if (i < item_count) {
        found[i] = (uint)svo_share_of(given[i].x, given[i].y);
    }
}
