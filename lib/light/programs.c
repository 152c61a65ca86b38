/* SPDX-License-Identifier: MIT */
/* The programs of kernels/light. */
#include "light/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_light[];
extern const char svo_i_source_photons[];
extern const char svo_i_source_kept_photons[];
extern const char svo_i_source_gather[];
extern const char svo_i_source_light_picture[];
extern const char svo_i_source_light_shade[];

const svo_i_program svo_i_program_light = {.name = "light", .source = svo_i_source_light};
const svo_i_program svo_i_program_photons = {.name = "photons", .source = svo_i_source_photons};
const svo_i_program svo_i_program_kept_photons = {.name = "kept_photons", .source = svo_i_source_kept_photons};
const svo_i_program svo_i_program_gather = {.name = "gather", .source = svo_i_source_gather};
const svo_i_program svo_i_program_light_picture = {.name = "light_picture", .source = svo_i_source_light_picture};
const svo_i_program svo_i_program_light_shade = {.name = "light_shade", .source = svo_i_source_light_shade};
