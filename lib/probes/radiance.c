/* SPDX-License-Identifier: MIT */
/* Shades the rays of texels by the room light, and stores what they bring. */
#include "probes/radiance.h"

#include "light/cones.h"

static svo_status shade_band(const svo_i_probe_bands *bands, const svo_i_light_shade *shade, cl_mem radiance,
                             svo_probe_step *step)
{
    const svo_probes *probes = bands->probes;
    SVO_I_TRY(svo_i_probe_bands_aim(bands, step));
    SVO_I_TRY(svo_i_light_shade_rays(shade, bands->rays, radiance, step->count));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(radiance), SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_TEXELS]),
                                        SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    return svo_i_work_launch(bands->work, "svo_k_probe_light", SVO_I_ARGUMENTS(arguments), step->count);
}

svo_status svo_i_probes_radiance(const svo_i_probe_bands *bands)
{
    const uint64_t texels = svo_i_probe_texels(bands->probes);
    svo_i_light_shade shade = {.gather = {.cones = 0}};
    cl_mem radiance = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_work_alloc(bands->work, "radiance", bands->most_rays * sizeof(cl_float) * 3, &radiance));
    SVO_I_TRY_CLEANUP(svo_i_light_shade_begin(bands->work, bands->probes->light, bands->probes->cones, &shade));
    for (uint64_t first = 0; first < texels; first += bands->most_rays) {
        svo_probe_step step = {.first = (uint32_t)first};
        SVO_I_TRY_CLEANUP(shade_band(bands, &shade, radiance, &step));
    }

cleanup:
    svo_i_light_shade_end(&shade);
    return status;
}
