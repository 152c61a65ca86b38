/* SPDX-License-Identifier: MIT */
/* The programs of kernels/stages. */
#include "stages/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_subdivide[];
extern const char svo_i_source_sort[];
extern const char svo_i_source_pack[];
extern const char svo_i_source_filter[];
extern const char svo_i_source_voxelize[];

const svo_i_program svo_i_program_subdivide = {.name = "subdivide", .source = svo_i_source_subdivide};
const svo_i_program svo_i_program_sort = {.name = "sort", .source = svo_i_source_sort};
const svo_i_program svo_i_program_pack = {.name = "pack", .source = svo_i_source_pack};
const svo_i_program svo_i_program_filter = {.name = "filter", .source = svo_i_source_filter};
const svo_i_program svo_i_program_voxelize = {.name = "voxelize", .source = svo_i_source_voxelize};
