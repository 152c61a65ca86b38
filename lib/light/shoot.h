/* SPDX-License-Identifier: MIT */
/* From sources to lit leaves. */
#ifndef SVO_LIB_LIGHT_SHOOT_H
#define SVO_LIB_LIGHT_SHOOT_H

#include "light/radiance_filter.h"

/* Shoots the photons of a setup that has been checked, and makes the radiance of the leaves. The light has been dark.
   caster: casts the photons; NULL: rays of the tree do. lit: its buffers belong to the work. */
svo_status svo_i_light_shine(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup,
                             const svo_i_photon_caster *caster, svo_i_lit_leaves *lit);

#endif
