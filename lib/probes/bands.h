/* SPDX-License-Identifier: MIT */
/* Launches of rays of texels: their scratch buffers. */
#ifndef SVO_LIB_PROBES_BANDS_H
#define SVO_LIB_PROBES_BANDS_H

#include "probes/plan.h"

typedef struct svo_i_probe_bands {
    svo_probes *probes;
    svo_i_device_work *work;
    uint32_t most_rays; /* of a band */
    uint32_t hit_words;
    cl_mem rays, hits; /* of most_rays; hits: NULL where none are needed */
    cl_mem thresholds; /* svo_i_probe_thresholds; NULL like hits */
} svo_i_probe_bands;

/* Makes the buffers, which the work owns. with_hits: not for radiance alone. */
svo_status svo_i_probe_bands_begin(svo_probes *probes, svo_i_device_work *work, bool with_hits, svo_i_probe_bands *out);
/* Launches svo_k_probe_rays for the band that begins with texel ray step->first. Sets step->count and hit_words. */
svo_status svo_i_probe_bands_aim(const svo_i_probe_bands *bands, svo_probe_step *step);
/* Texel rays of all probes. */
uint64_t svo_i_probe_texels(const svo_probes *probes);
/* A table of codes as a buffer of the work. */
svo_status svo_i_probe_table(svo_i_device_work *work, const char *name, const void *table, size_t entry_bytes,
                             cl_mem *out);

#endif
