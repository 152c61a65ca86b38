/* SPDX-License-Identifier: MIT */
/* The host side of kernels/probes/texels.cl and least.cl. */
#include "probes/texels.h"

#include "probes/programs.h"

/* Blocks of a launch. */
#define BAND_BLOCKS (UINT32_C(1) << 20)

static svo_status make_band(const svo_i_probe_bands *bands, svo_probe_step *step)
{
    svo_probes *probes = bands->probes;
    SVO_I_TRY(svo_i_probe_bands_aim(bands, step));
    SVO_I_TRY(svo_i_sight_trace(probes, bands->work, bands->rays, bands->hits, step->count));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(bands->hits), SVO_I_ARGUMENT(bands->thresholds),
                                        SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                        SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    return svo_i_work_launch(bands->work, "svo_k_probe_texels", SVO_I_ARGUMENTS(arguments), step->count);
}

svo_status svo_i_probes_texels(const svo_i_probe_bands *bands)
{
    const uint64_t texels = svo_i_probe_texels(bands->probes);
    for (uint64_t first = 0; first < texels; first += bands->most_rays) {
        svo_probe_step step = {.first = (uint32_t)first};
        SVO_I_TRY(make_band(bands, &step));
    }
    return SVO_OK;
}

svo_status svo_i_probes_least(const svo_i_probe_bands *bands)
{
    const svo_probes *probes = bands->probes;
    const uint64_t blocks = svo_i_probe_texels(probes) / SVO_PROBE_BLOCK / SVO_PROBE_BLOCK;
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probes, ""));
    for (uint64_t first = 0; first < blocks; first += BAND_BLOCKS) {
        const uint64_t left = blocks - first;
        const svo_probe_step step = {.first = (uint32_t)first,
                                     .count = left < BAND_BLOCKS ? (uint32_t)left : BAND_BLOCKS};
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                            SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_LEAST]),
                                            SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(step)};
        SVO_I_TRY(svo_i_work_launch(bands->work, "svo_k_probe_least", SVO_I_ARGUMENTS(arguments), step.count));
    }
    return SVO_OK;
}
