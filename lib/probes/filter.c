/* SPDX-License-Identifier: MIT */
/* The host side of kernels/probes/filter.cl. */
#include "probes/filter.h"

#include "probes/encoding.h"
#include "probes/programs.h"

/* Moments of a launch. */
#define BAND_MOMENTS (UINT32_C(1) << 16)
/* Fewest cells that irradiance adds up, along a side of a map. */
#define LEAST_CELLS 16u

_Static_assert(sizeof(svo_ray) >= sizeof(cl_float4), "cells fit into the buffer of rays");

/* The edge of these cells in texels: it divides every resolution. */
static uint32_t cell_edge(uint32_t resolution)
{
    uint32_t edge = SVO_PROBES_RESOLUTION_STEP;
    while (edge > 1 && resolution / edge < LEAST_CELLS) {
        edge /= 2;
    }
    return edge;
}

/* Some probes: cells, in the buffer of rays, then their irradiance. */
static svo_status filter_some(const svo_i_probe_bands *bands, svo_probe_step *step, uint32_t probe_count,
                              uint32_t cells)
{
    const svo_probes *probes = bands->probes;
    step->count = probe_count * cells;
    const svo_i_argument average[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]), SVO_I_ARGUMENT(bands->rays),
                                      SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_cells", SVO_I_ARGUMENTS(average), step->count));
    step->count = probe_count * SVO_PROBES_IRRADIANCE_TEXELS * SVO_PROBES_IRRADIANCE_TEXELS;
    const svo_i_argument add[] = {SVO_I_ARGUMENT(bands->rays), SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_IRRADIANCE]),
                                  SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    return svo_i_work_launch(bands->work, "svo_k_probe_irradiance", SVO_I_ARGUMENTS(add), step->count);
}

svo_status svo_i_probes_irradiance_maps(const svo_i_probe_bands *bands)
{
    const svo_probe_info *info = &bands->probes->info;
    svo_probe_step step = {.cell_edge = cell_edge(info->resolution)};
    const uint32_t across = info->resolution / step.cell_edge;
    const uint32_t cells = across * across;
    const uint32_t most = bands->most_rays / cells;
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probe_filter, ""));
    for (uint32_t first = 0; first < info->probe_count; first += most) {
        const uint32_t left = info->probe_count - first;
        step.first = first;
        SVO_I_TRY(filter_some(bands, &step, left < most ? left : most, cells));
    }
    return SVO_OK;
}

/* ---- moments ---- */

static svo_status make_lengths(const svo_i_probe_bands *bands, cl_mem *out)
{
    const svo_probe_info *info = &bands->probes->info;
    svo_i_device_work *work = bands->work;
    uint32_t *lengths = svo_i_alloc(&work->device->memory, SVO_I_PROBE_CODES * sizeof *lengths);
    if (lengths == NULL) {
        return svo_i_device_fail(work->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for codes", work->function);
    }
    svo_i_probe_lengths(info->farthest, info->leaf_edge, lengths);
    const svo_status status = svo_i_probe_table(work, "lengths", lengths, sizeof *lengths, out);
    svo_i_free(lengths);
    return status;
}

svo_status svo_i_probes_moments(const svo_i_probe_bands *bands)
{
    const svo_probes *probes = bands->probes;
    const uint64_t moments = (uint64_t)probes->info.probe_count * SVO_PROBES_MOMENT_TEXELS * SVO_PROBES_MOMENT_TEXELS;
    cl_mem lengths = NULL;
    SVO_I_TRY(make_lengths(bands, &lengths));
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probe_filter, ""));
    for (uint64_t first = 0; first < moments; first += BAND_MOMENTS) {
        const uint64_t left = moments - first;
        const svo_probe_step step = {.first = (uint32_t)first,
                                     .count = left < BAND_MOMENTS ? (uint32_t)left : BAND_MOMENTS};
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]), SVO_I_ARGUMENT(lengths),
                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_MOMENTS]),
                                            SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(step)};
        SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_moments", SVO_I_ARGUMENTS(arguments), step.count));
    }
    return SVO_OK;
}
