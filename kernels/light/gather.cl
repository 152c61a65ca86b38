/* SPDX-License-Identifier: MIT */
/*
 * Cones for a batch of points, or for each point of a picture: one work-item a point.
 *
 * Reads: the light, svo_gather_point. Writes: svo_gather_result. No local memory, no atomics.
 */
#include "light/gather.clh"

__kernel void svo_k_gather(SVO_LIGHT_PARAMETERS, __global const svo_gather_point *points,
                           __global svo_gather_result *results, uint count, svo_gather_params params)
{
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    SVO_LIGHT_MAKE(light);
    const svo_gather_point point = points[i];
    results[i] = svo_gather_by(&light, &point, &params);
}
