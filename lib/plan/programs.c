/* SPDX-License-Identifier: MIT */
/* The programs of kernels/plan. */
#include "plan/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_plan[];

const svo_i_program svo_i_program_plan = {.name = "plan", .source = svo_i_source_plan};
