/* SPDX-License-Identifier: MIT */
/* The programs of kernels/scene. */
#ifndef SVO_LIB_SCENE_PROGRAMS_H
#define SVO_LIB_SCENE_PROGRAMS_H

#include "core/program.h"

extern const svo_i_program svo_i_program_scene_build;
extern const svo_i_program svo_i_program_scene_bounds;
extern const svo_i_program svo_i_program_scene_trace;
extern const svo_i_program svo_i_program_scene_cast;
extern const svo_i_program svo_i_program_scene_see;

#endif
