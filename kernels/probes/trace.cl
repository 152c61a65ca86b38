/* SPDX-License-Identifier: MIT */
/*
 * Rays from a buffer, what probes know of them into a buffer. See choose.clh.
 *
 * Launch: one work-item per ray. Reads the probes and the rays; writes one record per ray. No atomics, no local memory.
 */
#include "probes/choose.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_trace(SVO_PROBES_PARAMETERS, __global const svo_ray *rays, __global svo_probe_hit *hits, uint ray_count,
                  float thickness)
{
    const uint i = (uint)get_global_id(0);
    if (i >= ray_count) {
        return;
    }
    SVO_PROBES_MAKE(probes);
    const svo_ray ray = rays[i];
    svo_probe_hit hit;
    svo_trace_probes(&probes, &ray, thickness, &hit);
    hits[i] = hit;
}
