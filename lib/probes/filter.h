/* SPDX-License-Identifier: MIT */
/* Maps for diffuse light. */
#ifndef SVO_LIB_PROBES_FILTER_H
#define SVO_LIB_PROBES_FILTER_H

#include "probes/bands.h"

/* SVO_PROBES_IRRADIANCE, of the radiance of texels. */
svo_status svo_i_probes_irradiance_maps(const svo_i_probe_bands *bands);
/* SVO_PROBES_MOMENTS, of the distances of texels. */
svo_status svo_i_probes_moments(const svo_i_probe_bands *bands);

#endif
