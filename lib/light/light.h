/* SPDX-License-Identifier: MIT */
/* Lights whose photons are cast by others. */
#ifndef SVO_LIB_LIGHT_LIGHT_H
#define SVO_LIB_LIGHT_LIGHT_H

#include "core/memory.h"
#include "light/handle.h"

SVO_I_SHARED_BEGIN

/* svo_light_set_sources with a caster. The light's tree must have triangles that rays meet. */
svo_status svo_i_light_set_sources_by(const svo_i_photon_caster *caster, svo_light *light, const svo_light_setup *setup,
                                      cl_command_queue queue);

SVO_I_SHARED_END

#endif
