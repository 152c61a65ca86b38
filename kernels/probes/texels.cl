/* SPDX-License-Identifier: MIT */
/*
 * Texels of probes: their rays, and what the rays met.
 *
 * Rays come probe by probe, and in a probe by blocks of 16 x 16 texels, row by row, in Morton order inside a block, so
 * that near rays are traced and lit together. Probes that are off have rays without a direction, which meet nothing.
 *
 * Directions are whole numbers, and distances are compared as squares: nothing stored here depends on how a device
 * divides or takes roots.
 *
 * Launch: one work-item per ray. svo_k_probe_rays reads the places; svo_k_probe_texels reads hits and writes texels'
 * first words, svo_k_probe_light reads radiance and writes their second words. No atomics, no local memory.
 */
#include "probes/encoding.clh"
#include "probes/item.clh"

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_rays(__global const svo_probe *places, __global svo_ray *rays, svo_probes_params params,
                 svo_probe_step step)
{
    const uint i = (uint)get_global_id(0);
    if (i >= step.count) {
        return;
    }
    const svo_probe_item item = svo_probe_find_item(&params, &step, i);
    const svo_probe place = places[item.probe];
    const int3 vector = svo_probe_texel_vector(params.resolution, item.column, item.row);
    const float3 direction = place.state != SVO_PROBE_OFF ? convert_float3(vector) : (float3)(0.0f);
    svo_ray ray;
    ray.origin[0] = place.position[0];
    ray.origin[1] = place.position[1];
    ray.origin[2] = place.position[2];
    vstore3(direction, 0, ray.direction);
    ray.t_min = 0.0f;
    ray.t_max = INFINITY;
    rays[i] = ray;
}

/* hits: records of step.hit_words words, which begin with t and have the normal in words 4 .. 6. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_texels(__global const uint *hits, __global const ulong *thresholds, __global uint *texels,
                   svo_probes_params params, svo_probe_step step)
{
    const uint i = (uint)get_global_id(0);
    if (i >= step.count) {
        return;
    }
    const svo_probe_item item = svo_probe_find_item(&params, &step, i);
    __global const uint *hit = hits + (size_t)i * step.hit_words;
    const float t = as_float(hit[0]);
    const int3 vector = svo_probe_texel_vector(params.resolution, item.column, item.row);
    const float3 direction = convert_float3(vector);
    const float3 met = as_float3(vload3(0, hit + 4));
    const float along = met.x * direction.x + met.y * direction.y + met.z * direction.z;
    const bool has_normal = met.x != 0.0f || met.y != 0.0f || met.z != 0.0f;
    const float3 normal = !has_normal || t == INFINITY ? -direction : along > 0.0f ? -met : met;
    const uint length2 = (uint)(vector.x * vector.x + vector.y * vector.y + vector.z * vector.z);
    const uint code =
        t < INFINITY ? svo_probe_distance_code(svo_probe_distance_key(t, length2), thresholds) : SVO_PROBE_NOTHING;
    texels[2u * item.texel] = svo_probe_encode_normal(normal) | code;
    texels[2u * item.texel + 1u] = 0u;
}

/* radiance: three floats per ray. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_light(__global const float *radiance, __global uint *texels, svo_probes_params params, svo_probe_step step)
{
    const uint i = (uint)get_global_id(0);
    if (i >= step.count) {
        return;
    }
    const svo_probe_item item = svo_probe_find_item(&params, &step, i);
    texels[2u * item.texel + 1u] = svo_probe_encode_radiance(vload3(i, radiance));
}
