/* SPDX-License-Identifier: MIT */
/* The programs of kernels/solid. */
#include "solid/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_solid[];

const svo_i_program svo_i_program_solid = {.name = "solid", .source = svo_i_source_solid};
