/* SPDX-License-Identifier: MIT */
/* The programs of kernels/light. */
#ifndef SVO_LIB_LIGHT_PROGRAMS_H
#define SVO_LIB_LIGHT_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_light;
extern const svo_i_program svo_i_program_photons;
extern const svo_i_program svo_i_program_sent_photons, svo_i_program_voxel_photons;
extern const svo_i_program svo_i_program_kept_photons;
extern const svo_i_program svo_i_program_gather, svo_i_program_gather_rays, svo_i_program_screen;
extern const svo_i_program svo_i_program_light_picture;
extern const svo_i_program svo_i_program_light_shade;

#endif
