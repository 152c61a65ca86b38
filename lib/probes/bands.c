/* SPDX-License-Identifier: MIT */
/* Scratch buffers and rays of bands. */
#include "probes/bands.h"

#include "probes/encoding.h"
#include "probes/programs.h"

uint64_t svo_i_probe_texels(const svo_probes *probes)
{
    return (uint64_t)probes->info.probe_count * probes->info.resolution * probes->info.resolution;
}

svo_status svo_i_probe_table(svo_i_device_work *work, const char *name, const void *table, size_t entry_bytes,
                             cl_mem *out)
{
    const uint64_t bytes = SVO_I_PROBE_CODES * entry_bytes;
    SVO_I_TRY(svo_i_work_alloc(work, name, bytes, out));
    return svo_i_work_write(work, *out, table, bytes);
}

static svo_status make_thresholds(svo_i_probe_bands *bands)
{
    const svo_probe_info *info = &bands->probes->info;
    svo_i_device_work *work = bands->work;
    uint64_t *thresholds = svo_i_alloc(&work->device->memory, SVO_I_PROBE_CODES * sizeof *thresholds);
    if (thresholds == NULL) {
        return svo_i_device_fail(work->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for codes", work->function);
    }
    svo_i_probe_thresholds(info->farthest, info->leaf_edge, thresholds);
    const svo_status status = svo_i_probe_table(work, "thresholds", thresholds, sizeof *thresholds, &bands->thresholds);
    svo_i_free(thresholds);
    return status;
}

svo_status svo_i_probe_bands_begin(svo_probes *probes, svo_i_device_work *work, bool with_hits, svo_i_probe_bands *out)
{
    const svo_i_sight sight = {probes->tree, probes->scene};
    *out = (svo_i_probe_bands){.probes = probes,
                               .work = work,
                               .most_rays = svo_i_probes_band_rays(&probes->info),
                               .hit_words = svo_i_sight_hit_words(&sight)};
    const uint64_t hit_bytes = (uint64_t)out->hit_words * sizeof(cl_uint);
    SVO_I_TRY(svo_i_work_alloc(work, "rays", out->most_rays * sizeof(svo_ray), &out->rays));
    if (!with_hits) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_alloc(work, "hits", out->most_rays * hit_bytes, &out->hits));
    return make_thresholds(out);
}

svo_status svo_i_probe_bands_aim(const svo_i_probe_bands *bands, svo_probe_step *step)
{
    const svo_probes *probes = bands->probes;
    const uint64_t left = svo_i_probe_texels(probes) - step->first;
    step->count = left < bands->most_rays ? (uint32_t)left : bands->most_rays;
    step->hit_words = bands->hit_words;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(probes->buffers[SVO_PROBES_PLACES]), SVO_I_ARGUMENT(bands->rays),
                                        SVO_I_ARGUMENT(probes->params), SVO_I_ARGUMENT(*step)};
    SVO_I_TRY(svo_i_work_use(bands->work, &svo_i_program_probes, ""));
    return svo_i_work_launch(bands->work, "svo_k_probe_rays", SVO_I_ARGUMENTS(arguments), step->count);
}
