/* SPDX-License-Identifier: MIT */
/*
 * Maps for diffuse light: irradiance, and mean distances with their mean squares (as in Majercik et al., "Dynamic
 * Diffuse Global Illumination with Ray-Traced Irradiance Fields", 2019).
 *
 * Irradiance adds up cells of texels, whose radiance was averaged by solid angle before: a square da of the map at the
 * point v of the octahedron has the solid angle da / |v|^3. Moments add up integers, so they are the same everywhere.
 *
 * Launch: svo_k_probe_cells has a work-item per cell, the others have one per texel they write. No atomics, no local
 * memory.
 */
#include "probes/encoding.clh"
#include "shared/probe_layout.h"

/* Cells of one probe along a side of its map. step.cell_edge: in texels. step.first: the first probe of the launch. */
static uint svo_filter_cells(const svo_probes_params *params, const svo_probe_step *step)
{
    return params->resolution / step->cell_edge;
}

/* Mean radiance of a cell, and its solid angle. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_cells(__global const uint *texels, __global float4 *cells, svo_probes_params params, svo_probe_step step)
{
    const uint i = (uint)get_global_id(0);
    if (i >= step.count) {
        return;
    }
    const uint across = svo_filter_cells(&params, &step);
    const uint column = i % across * step.cell_edge;
    const uint row = i / across % across * step.cell_edge;
    const size_t first = (size_t)(step.first + i / (across * across)) * params.resolution * params.resolution;
    const float pixel = 2.0f / (float)params.resolution;
    float4 sum = (float4)(0.0f);
    for (uint k = 0; k < step.cell_edge * step.cell_edge; ++k) {
        const uint x = column + k % step.cell_edge;
        const uint y = row + k / step.cell_edge;
        const int3 vector = svo_probe_texel_vector(params.resolution, x, y);
        const float far = length(convert_float3(vector)) / (float)params.resolution;
        const float angle = pixel * pixel / (far * far * far);
        const uint word = texels[2u * (first + (size_t)y * params.resolution + x) + 1u];
        sum += angle * (float4)(svo_probe_radiance_of(word), 1.0f);
    }
    cells[i] = sum;
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_irradiance(__global const float4 *cells, __global uint *irradiance, svo_probes_params params,
                       svo_probe_step step)
{
    const uint i = (uint)get_global_id(0);
    if (i >= step.count) {
        return;
    }
    const uint texel = i % (SVO_PROBE_IRRADIANCE_TEXELS * SVO_PROBE_IRRADIANCE_TEXELS);
    const uint probe = i / (SVO_PROBE_IRRADIANCE_TEXELS * SVO_PROBE_IRRADIANCE_TEXELS);
    const uint across = svo_filter_cells(&params, &step);
    const float3 normal = normalize(convert_float3(svo_probe_texel_vector(
        SVO_PROBE_IRRADIANCE_TEXELS, texel % SVO_PROBE_IRRADIANCE_TEXELS, texel / SVO_PROBE_IRRADIANCE_TEXELS)));
    __global const float4 *own = cells + (size_t)probe * across * across;
    float3 sum = (float3)(0.0f);
    for (uint k = 0; k < across * across; ++k) {
        const float3 direction = normalize(convert_float3(svo_probe_texel_vector(across, k % across, k / across)));
        sum += fmax(dot(normal, direction), 0.0f) * own[k].xyz;
    }
    const size_t out = (size_t)step.first * SVO_PROBE_IRRADIANCE_TEXELS * SVO_PROBE_IRRADIANCE_TEXELS + i;
    irradiance[out] = svo_probe_encode_radiance(sum);
}

/* lengths: of each code, in 1 / SVO_PROBE_LENGTH_UNIT leaf edges. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_moments(__global const uint *texels, __global const uint *lengths, __global float2 *moments,
                    svo_probes_params params, svo_probe_step step)
{
    if ((uint)get_global_id(0) >= step.count) {
        return;
    }
    const uint i = step.first + (uint)get_global_id(0);
    const uint edge = params.resolution / SVO_PROBE_MOMENT_TEXELS;
    /* i / SVO_PROBE_MOMENT_TEXELS: the row of the map, among those of all probes. */
    const size_t first =
        ((size_t)(i / SVO_PROBE_MOMENT_TEXELS) * params.resolution + i % SVO_PROBE_MOMENT_TEXELS) * edge;
    ulong sum = 0ul;
    ulong squares = 0ul;
    for (uint k = 0; k < edge * edge; ++k) {
        const size_t texel = first + (size_t)(k / edge) * params.resolution + k % edge;
        const ulong length = lengths[min(texels[2u * texel] & 0xffffu, SVO_PROBE_CODE_MAX)];
        sum += length;
        squares += length * length;
    }
    const float unit = 1.0f / (float)SVO_PROBE_LENGTH_UNIT;
    moments[i] =
        (float2)(convert_float(sum / (edge * edge)) * unit, convert_float(squares / (edge * edge)) * unit * unit);
}
