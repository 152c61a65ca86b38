/* SPDX-License-Identifier: MIT */
/* Radiance of the leaves from the flux of photons and from what materials emit: kernels/light/exchange.cl. */
#ifndef SVO_LIB_LIGHT_EXCHANGE_H
#define SVO_LIB_LIGHT_EXCHANGE_H

#include "light/radiance_filter.h"

/* Gives slots to the leaves of materials that emit, and makes the radiance of all lit leaves. Makes the light's flux
   buffer. finishes: by material; lit->leaves and lit->radiance belong to the work. */
svo_status svo_i_light_exchange(svo_i_photons *photons, svo_light *light, const svo_finish *finishes,
                                size_t finish_count, svo_i_lit_leaves *lit);

#endif
