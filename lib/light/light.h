/* SPDX-License-Identifier: MIT */
/* Lights whose photons are cast by others, and those that are made of what was stored. */
#ifndef SVO_LIB_LIGHT_LIGHT_H
#define SVO_LIB_LIGHT_LIGHT_H

#include "core/memory.h"
#include "light/handle.h"

/* A light of a tree that has no buffers yet: checks tree and options. */
svo_status svo_i_light_new(svo_tree *tree, const char *function, const svo_light_options *options, svo_light **out);
/* Checks a setup and keeps it, without light. The light has none yet. */
svo_status svo_i_light_take_setup(svo_light *light, const char *function, const svo_light_setup *setup);

SVO_I_SHARED_BEGIN

/* svo_light_set_sources with a caster. The light's tree must have triangles that rays meet. */
svo_status svo_i_light_set_sources_by(const svo_i_photon_caster *caster, svo_light *light, const svo_light_setup *setup,
                                      cl_command_queue queue);

SVO_I_SHARED_END

#endif
