/* SPDX-License-Identifier: MIT */
/*
 * Diffuse light of probes for a batch of points. See diffuse.clh.
 *
 * Launch: one work-item per point. Reads the probes and the points; writes one record per point. No atomics, no local
 * memory.
 */
#include "probes/diffuse.clh"
#include "svocl/light_types.h"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_gather(SVO_PROBES_PARAMETERS, __global const svo_gather_point *points,
                   __global svo_probe_irradiance *results, uint count)
{
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    SVO_PROBES_MAKE(probes);
    const svo_gather_point point = points[i];
    results[i] = svo_gather_probes(&probes, vload3(0, point.position), vload3(0, point.normal));
}
