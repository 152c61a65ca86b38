/* SPDX-License-Identifier: MIT */
/* The radiance of texels. */
#ifndef SVO_LIB_PROBES_RADIANCE_H
#define SVO_LIB_PROBES_RADIANCE_H

#include "probes/bands.h"

/* What the light of the probes shows along the rays of all texels. */
svo_status svo_i_probes_radiance(const svo_i_probe_bands *bands);

#endif
