/* SPDX-License-Identifier: MIT */
/*
 * The field: for each of its cells the nearest probes that see the cell's center, nearest first, ties by index. A probe
 * sees a point that is nearer than the surface of the texel in whose square the point's direction is.
 *
 * Distances are compared as squares; the code of a texel stands for the least distance that has it.
 *
 * Launch: one work-item per cell. Reads places, texels and thresholds (encoding.clh); writes SVO_PROBE_FIELD_ENTRIES
 * entries per cell. No atomics, no local memory.
 */
#include "probes/encoding.clh"
#include "shared/layout.h"

/* Whether a probe sees a point. way: from the probe to the point, of any unit; key: of its squared length; texels: of
   this probe. */
static bool svo_probe_sees(float3 way, ulong key, __global const uint *texels, uint resolution,
                           __global const ulong *thresholds)
{
    if (key == 0ul) {
        return true;
    }
    const uint code = texels[2u * svo_probe_texel_of(way, resolution)] & 0xffffu;
    return code == SVO_PROBE_NOTHING || key < thresholds[code];
}

/* The nearest so far, with their squared distances. */
typedef struct svo_field_entries {
    float squared[SVO_PROBE_FIELD_ENTRIES];
    ushort probe[SVO_PROBE_FIELD_ENTRIES];
} svo_field_entries;

/* Puts a probe where it belongs; later ones of the same distance stand behind. */
static void svo_field_insert(svo_field_entries *entries, uint probe, float squared)
{
    uint place = SVO_PROBE_FIELD_ENTRIES - 1u;
    while (place > 0u && squared < entries->squared[place - 1u]) {
        entries->squared[place] = entries->squared[place - 1u];
        entries->probe[place] = entries->probe[place - 1u];
        --place;
    }
    entries->squared[place] = squared;
    entries->probe[place] = (ushort)probe;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_field(__global const svo_probe *places, __global const uint *texels, __global const ulong *thresholds,
                  __global ushort *field, svo_probes_params params, svo_probe_step step)
{
    const uint cell = step.first + (uint)get_global_id(0);
    if ((uint)get_global_id(0) >= step.count) {
        return;
    }
    const uint n = params.field_size;
    const uint texel_count = params.resolution * params.resolution;
    const float3 half_cell = (float3)(step.half_cell[0], step.half_cell[1], step.half_cell[2]);
    const float3 center = (float3)(params.low[0], params.low[1], params.low[2]) +
                          convert_float3((uint3)(cell % n, cell / n % n, cell / n / n) * 2u + 1u) * half_cell;
    const float scale = ldexp(1.0f, step.scale_log2); /* keeps squares in the range of floats */
    svo_field_entries entries;
    for (uint k = 0; k < SVO_PROBE_FIELD_ENTRIES; ++k) {
        entries.squared[k] = INFINITY;
        entries.probe[k] = SVO_PROBE_NONE;
    }
    for (uint probe = 0; probe < params.probe_count; ++probe) {
        const float4 place = vload4(probe, (__global const float *)places);
        const float3 way = (center - place.xyz) * scale;
        const float squared = way.x * way.x + way.y * way.y + way.z * way.z;
        if (squared < entries.squared[SVO_PROBE_FIELD_ENTRIES - 1u] && as_uint(place.w) != SVO_PROBE_OFF &&
            svo_probe_sees(way, svo_probe_square_key(squared, step.scale_log2),
                           texels + 2u * (size_t)probe * texel_count, params.resolution, thresholds)) {
            svo_field_insert(&entries, probe, squared);
        }
    }
    vstore4((ushort4)(entries.probe[0], entries.probe[1], entries.probe[2], entries.probe[3]), cell, field);
}
