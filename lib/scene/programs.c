/* SPDX-License-Identifier: MIT */
/* The programs of kernels/scene. */
#include "scene/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_scene_build[];
extern const char svo_i_source_scene_bounds[];
extern const char svo_i_source_scene_trace[];
extern const char svo_i_source_scene_cast[];

const svo_i_program svo_i_program_scene_build = {.name = "scene_build", .source = svo_i_source_scene_build};
const svo_i_program svo_i_program_scene_bounds = {.name = "scene_bounds", .source = svo_i_source_scene_bounds};
const svo_i_program svo_i_program_scene_trace = {.name = "scene_trace", .source = svo_i_source_scene_trace};
const svo_i_program svo_i_program_scene_cast = {.name = "scene_cast", .source = svo_i_source_scene_cast};
