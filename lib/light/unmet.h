/* SPDX-License-Identifier: MIT */
/* Leaves that should have met a photon: what is wrong with a light view that is too coarse. */
#ifndef SVO_LIB_LIGHT_UNMET_H
#define SVO_LIB_LIGHT_UNMET_H

#include "light/photons.h"
#include "svocl/light.h"

/* Counts the leaves without a slot that a ray from one of the sources to their center meets first. */
svo_status svo_i_photons_count_unmet(svo_i_photons *photons, const svo_light_setup *setup, uint64_t *count);

#endif
