/* SPDX-License-Identifier: MIT */
/* Light of a sampler's mesh: a sun and a sky, points spread over the mesh by area, and their true light by paths. */
#ifndef SVOCL_TOOLS_TUNE_LIGHT_ERRORS_H
#define SVOCL_TOOLS_TUNE_LIGHT_ERRORS_H

#include "tune/sampler.h"

/* The svo_need bits of a setting's tree, where need is what --need says. */
uint32_t sampler_need(const sampler *made, const tune_setting *setting, uint32_t need);
/* The light of a setting's tree; NULL on failure, with the device's message. */
svo_light *sampler_light(const sampler *made, session *opened, svo_tree *tree, const tune_setting *setting);
/* Gathers at the sampler's points: openness alone, or light. results: SAMPLER_LIGHT_POINTS. */
svo_status sampler_gather(const sampler *made, session *opened, svo_light *light, const tune_setting *setting,
                          bool with_light, svo_gather_result *results);
/* Makes points and their true light, once for each seed. Returns the exit code. */
int sampler_light_truth(sampler *made, uint32_t seed);

#endif
