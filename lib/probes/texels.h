/* SPDX-License-Identifier: MIT */
/* The texels of probes, and least distances. */
#ifndef SVO_LIB_PROBES_TEXELS_H
#define SVO_LIB_PROBES_TEXELS_H

#include "probes/bands.h"

/* Traces the rays of all texels: SVO_PROBES_TEXELS without radiance. */
svo_status svo_i_probes_texels(const svo_i_probe_bands *bands);
/* SVO_PROBES_LEAST, of the texels. */
svo_status svo_i_probes_least(const svo_i_probe_bands *bands);

#endif
