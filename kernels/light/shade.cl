/* SPDX-License-Identifier: MIT */
/*
 * Radiance along rays in a lit tree, without specular light: what surfaces send everywhere. Rays that meet nothing see
 * the sky, and so do rays without a direction.
 *
 * Launch: one work-item per SVO_SHADE_RAYS consecutive rays, which share what cones gather. Reads tree, light, sources
 * and rays; writes three floats per ray. params.width: rays. No atomics, no local memory.
 */
#include "light/shading.clh"

#define SVO_SHADE_RAYS 64u

/* Rays share what cones gather within this many leaf edges. */
#define SVO_SHADE_NEAR 4.0f

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_light_shade(SVO_LIT_PARAMETERS, __global const svo_ray *rays, __global float *radiance)
{
    const uint first = (uint)get_global_id(0) * SVO_SHADE_RAYS;
    const uint end = min(first + SVO_SHADE_RAYS, params.width);
    SVO_LIT_MAKE(picture);
    SVO_LIT_CACHE(cache, SVO_SHADE_NEAR);
    for (uint i = first; i < end; ++i) {
        const svo_ray ray = rays[i];
        float3 seen = vload3(0, params.sky);
        svo_lit_look(&picture, &ray, &cache, &seen);
        vstore3(seen, i, radiance);
    }
}
