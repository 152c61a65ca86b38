/* SPDX-License-Identifier: MIT */
/* The programs of kernels/rays. */
#include "rays/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_bvh[];
extern const char svo_i_source_trace[];
extern const char svo_i_source_trace_voxels[];
extern const char svo_i_source_cast[];
extern const char svo_i_source_view[];

const svo_i_program svo_i_program_bvh = {.name = "bvh", .source = svo_i_source_bvh};
const svo_i_program svo_i_program_trace = {.name = "trace", .source = svo_i_source_trace};
const svo_i_program svo_i_program_trace_voxels = {.name = "trace_voxels", .source = svo_i_source_trace_voxels};
const svo_i_program svo_i_program_cast = {.name = "cast", .source = svo_i_source_cast};
const svo_i_program svo_i_program_view = {.name = "view", .source = svo_i_source_view};
