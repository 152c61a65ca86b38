/* SPDX-License-Identifier: MIT */
/*
 * The field: for each of its cells the nearest probes that see the cell's center, nearest first, ties by index. A probe
 * sees a point that is nearer than the surface of the texel in whose square the point's direction is.
 *
 * Distances are compared as squares; the code of a texel stands for the least distance that has it. Probes are tried in
 * shells around the cell's place in the grid, until none of the next shell can be nearer than the fourth entry.
 *
 * Launch: one work-item per cell. Reads places, texels and thresholds (encoding.clh); writes SVO_PROBE_FIELD_ENTRIES
 * entries per cell. No atomics, no local memory.
 */
#include "probes/encoding.clh"
#include "shared/probe_layout.h"

/* What is known of a cell. */
typedef struct svo_field_cell {
    float3 center; /* world */
    float squared[SVO_PROBE_FIELD_ENTRIES]; /* distances of the entries so far, scaled */
    uint probe[SVO_PROBE_FIELD_ENTRIES];
} svo_field_cell;

/* What is read. */
typedef struct svo_field_source {
    __global const svo_probe *places;
    __global const uint *texels;
    __global const ulong *thresholds;
    svo_probes_params params;
    int scale_log2;
    float scale; /* 2^scale_log2: keeps squares in the range of floats */
} svo_field_source;

/* Whether a probe sees a point. way: from the probe to the point, of any unit; key: of its squared length. */
static bool svo_field_sees(const svo_field_source *source, uint probe, float3 way, ulong key)
{
    const uint resolution = source->params.resolution;
    if (key == 0ul) {
        return true;
    }
    const size_t first = (size_t)probe * resolution * resolution;
    const uint code = source->texels[2u * (first + svo_probe_texel_of(way, resolution))] & 0xffffu;
    return code == SVO_PROBE_NOTHING || key < source->thresholds[code];
}

/* Whether a probe stands before an entry. */
static bool svo_field_is_before(const svo_field_cell *cell, uint entry, float squared, uint probe)
{
    return squared < cell->squared[entry] || (squared == cell->squared[entry] && probe < cell->probe[entry]);
}

/* Puts a probe where it belongs, if it belongs there and sees the center. */
static void svo_field_try(const svo_field_source *source, uint probe, svo_field_cell *cell)
{
    const float4 place = vload4(probe, (__global const float *)source->places);
    const float3 way = (cell->center - place.xyz) * source->scale;
    const float squared = way.x * way.x + way.y * way.y + way.z * way.z;
    uint entry = SVO_PROBE_FIELD_ENTRIES - 1u;
    if (!svo_field_is_before(cell, entry, squared, probe) || as_uint(place.w) == SVO_PROBE_OFF ||
        !svo_field_sees(source, probe, way, svo_probe_square_key(squared, source->scale_log2))) {
        return;
    }
    while (entry > 0u && svo_field_is_before(cell, entry - 1u, squared, probe)) {
        cell->squared[entry] = cell->squared[entry - 1u];
        cell->probe[entry] = cell->probe[entry - 1u];
        --entry;
    }
    cell->squared[entry] = squared;
    cell->probe[entry] = probe;
}

/* The probes whose places in the grid are so many steps from a place, along the axis on which they are farthest. */
static void svo_field_try_shell(const svo_field_source *source, int3 middle, int steps, svo_field_cell *cell)
{
    const int3 counts =
        convert_int3((uint3)(source->params.counts[0], source->params.counts[1], source->params.counts[2]));
    const int3 low = max(middle - steps, (int3)(0));
    const int3 high = min(middle + steps, counts - 1);
    for (int z = low.z; z <= high.z; ++z) {
        for (int y = low.y; y <= high.y; ++y) {
            const bool whole = abs_diff(z, middle.z) == (uint)steps || abs_diff(y, middle.y) == (uint)steps;
            /* Of other rows only the ends. */
            const int stride = whole || steps == 0 ? 1 : 2 * steps;
            for (int x = whole ? low.x : middle.x - steps; x <= high.x; x += stride) {
                if (x >= 0) {
                    svo_field_try(source, (uint)(x + counts.x * (y + counts.y * z)), cell);
                }
            }
        }
    }
}

/* No probe so many steps away is nearer than this, scaled: half a step to the cell's own place, half that it may have
   been moved, and a little for rounding. */
static float svo_field_least(const svo_field_source *source, int steps)
{
    float step = INFINITY;
    for (uint axis = 0; axis < 3u; ++axis) {
        step = source->params.counts[axis] > 1u ? fmin(step, source->params.step[axis]) : step;
    }
    return steps > 1 ? ((float)steps - 1.01f) * step * source->scale : 0.0f;
}

static void svo_field_fill(const svo_field_source *source, svo_field_cell *cell)
{
    const svo_probes_params *params = &source->params;
    const int3 counts = convert_int3((uint3)(params->counts[0], params->counts[1], params->counts[2]));
    const float3 first = (float3)(params->start[0], params->start[1], params->start[2]);
    const float3 step = (float3)(params->step[0], params->step[1], params->step[2]);
    const int3 middle = clamp(convert_int3_sat_rtn((cell->center - first) / step + 0.5f), (int3)(0), counts - 1);
    const int most = max(counts.x, max(counts.y, counts.z));
    for (int steps = 0; steps < most; ++steps) {
        const float least = svo_field_least(source, steps);
        if (cell->squared[SVO_PROBE_FIELD_ENTRIES - 1u] < least * least) {
            return;
        }
        svo_field_try_shell(source, middle, steps, cell);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_probe_field(__global const svo_probe *places, __global const uint *texels, __global const ulong *thresholds,
                  __global ushort *field, svo_probes_params params, svo_probe_step step)
{
    const uint i = step.first + (uint)get_global_id(0);
    if ((uint)get_global_id(0) >= step.count) {
        return;
    }
    const uint n = params.field_size;
    const float3 half_cell = (float3)(step.half_cell[0], step.half_cell[1], step.half_cell[2]);
    const float3 low = (float3)(params.low[0], params.low[1], params.low[2]);
    const svo_field_source source = {places, texels, thresholds, params, step.scale_log2, ldexp(1.0f, step.scale_log2)};
    svo_field_cell cell;
    cell.center = low + convert_float3((uint3)(i % n, i / n % n, i / n / n) * 2u + 1u) * half_cell;
    for (uint k = 0; k < SVO_PROBE_FIELD_ENTRIES; ++k) {
        cell.squared[k] = INFINITY;
        cell.probe[k] = SVO_PROBE_NONE;
    }
    svo_field_fill(&source, &cell);
    vstore4(convert_ushort4((uint4)(cell.probe[0], cell.probe[1], cell.probe[2], cell.probe[3])), i, field);
}
