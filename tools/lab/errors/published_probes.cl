/* SPDX-License-Identifier: MIT */
/*
 * Rays through light field probes as published, for comparison (McGuire et al., "Real-Time Global Illumination using
 * Precomputed Light Field Probes", 2017): by the eight probes around the ray's origin, nearest first, then (i + 3) mod
 * 8, each as far as the ray goes.
 *
 * Behind the source of probes, of which it takes more than callers are promised: how a ray begins, asks a probe and
 * ends. Launch: one work-item per ray. Reads: the probes, svo_ray. Writes: svo_probe_hit. No local memory, no atomics.
 */

static void published_eight(const svo_probes *probes, svo_probe_search *search)
{
    int3 cell;
    const float3 at = svo_probe_grid_point(probes, search->origin, &cell) - convert_float3(cell);
    const uint nearest = (at.x > 0.5f ? 1u : 0u) | (at.y > 0.5f ? 2u : 0u) | (at.z > 0.5f ? 4u : 0u);
    const uint *counts = probes->params.counts;
    /* Axes with one probe have no far one. */
    const uint absent = (counts[0] == 1u ? 1u : 0u) | (counts[1] == 1u ? 2u : 0u) | (counts[2] == 1u ? 4u : 0u);
    for (uint i = 0; i < 8u; ++i) {
        const uint corner = (nearest + 3u * i) % 8u;
        const uint probe = svo_probe_corner(probes, cell, corner);
        if ((corner & absent) == 0u && as_uint(svo_probe_place(probes, probe).w) != SVO_PROBE_OFF) {
            const svo_probe_ray ray = svo_probe_aim(probes, probe, search);
            if (svo_probe_ask(probes, probe, &ray, search)) {
                return;
            }
            search->t_min = fmax(search->t_min, search->walk.t);
        }
    }
}

__kernel __attribute__((reqd_work_group_size(64, 1, 1))) void
trace_as_published(SVO_PROBES_PARAMETERS, __global const svo_ray *rays, __global svo_probe_hit *hits, uint count)
{
    const uint i = (uint)get_global_id(0);
    if (i < count) {
        SVO_PROBES_MAKE(probes);
        const svo_ray ray = rays[i];
        svo_probe_search search;
        svo_probe_hit hit;
        if (svo_probe_begin(&probes, &ray, 1.0f, &search)) {
            published_eight(&probes, &search);
        }
        svo_probe_end(&probes, &search, &hit);
        hits[i] = hit;
    }
}
