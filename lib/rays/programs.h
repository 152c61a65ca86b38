/* SPDX-License-Identifier: MIT */
/* The programs of kernels/bvh and kernels/rays. */
#ifndef SVO_LIB_RAYS_PROGRAMS_H
#define SVO_LIB_RAYS_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_bvh;
extern const svo_i_program svo_i_program_trace;
extern const svo_i_program svo_i_program_trace_voxels;
extern const svo_i_program svo_i_program_cast;
extern const svo_i_program svo_i_program_view;

#endif
