/* SPDX-License-Identifier: MIT */
/* From sources to lit leaves. */
#ifndef SVO_LIB_LIGHT_SOURCES_H
#define SVO_LIB_LIGHT_SOURCES_H

#include "light/filter.h"
#include "light/state.h"

/* Shoots the photons of a setup that has been checked, and makes the radiance of the leaves. The light has been dark.
   lit: its buffers belong to the work. */
svo_status svo_i_light_shine(svo_i_device_work *work, svo_light *light, const svo_light_setup *setup,
                             svo_i_lit_leaves *lit);
/* Lights a dark light by a setup that has been checked, and keeps the setup. name: of the public function. The light is
   dark after a failure. */
svo_status svo_i_light_set(svo_light *light, const char *name, const svo_light_setup *setup, cl_command_queue queue);

#endif
