/* SPDX-License-Identifier: MIT */
/*
 * Cones for a batch of points, or for each point of a picture: one work-item a point.
 *
 * Reads: the light, svo_gather_point. Writes: svo_gather_result. No local memory, no atomics.
 */
#include "light/gather.clh"
#include "light/published.clh"

__kernel void svo_k_gather(SVO_LIGHT_PARAMETERS, __global const svo_gather_point *points,
                           __global svo_gather_result *results, uint count, svo_gather_params params)
{
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    SVO_LIGHT_MAKE(light);
    const svo_gather_point point = points[i];
#ifdef SVO_LIGHT_BRICKS
    if (params.published != 0u) {
        results[i] = svo_gather_published(&light, &point, &params);
        return;
    }
#endif
    results[i] = svo_gather_by(&light, &point, &params);
}
