/* SPDX-License-Identifier: MIT */
/* Light of a sampler's mesh: points spread over it by area, their true light by paths, and what settings gather. */
#ifndef SVOCL_TOOLS_TUNE_LIGHT_ERRORS_H
#define SVOCL_TOOLS_TUNE_LIGHT_ERRORS_H

#include "svocl/probes.h"
#include "tune/sampler.h"

/* The light of a setting's tree; NULL on failure, with the device's message. */
svo_light *sampler_light(const sampler *made, session *opened, svo_tree *tree, const tune_setting *setting);
/* The probes of a setting with some; NULL likewise. */
svo_probes *sampler_probes(session *opened, svo_tree *tree, svo_light *light, const tune_setting *setting);
/* Gathers at the sampler's points. probes: NULL where the setting has none. results: GATHER_POINTS; what probes do not
   hold is not a number. Returns false on failure, with the device's message. */
bool sampler_gather(const sampler *made, session *opened, svo_light *light, svo_probes *probes,
                    const tune_setting *setting, svo_gather_result *results);
/* Makes points and their true light, once for each seed. Returns the exit code. */
int sampler_light_truth(sampler *made, uint32_t seed);
/* Adds results at the points. */
void light_errors_add(const sampler *made, const tune_setting *setting, const svo_gather_result *results,
                      tune_errors *errors);

/* Whether something of a quantity is there to be gathered: light of the lights, or what surfaces reflect and emit. */
bool sampler_is_lit(const sampler *made, tune_quantity quantity);

#endif
