/* SPDX-License-Identifier: MIT */
/* probe.clh in OpenCL C: one work-item per record. */
#include "probe.clh"

__kernel void probe_all(__global const probe_input *given, __global probe_output *found, uint item_count)
{
    const uint i = (uint)get_global_id(0);
    if (i < item_count) {
        found[i] = probe(given[i]);
    }
}
