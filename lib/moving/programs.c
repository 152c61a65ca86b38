/* SPDX-License-Identifier: MIT */
/* The programs of kernels/moving. */
#include "moving/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_moving[];

const svo_i_program svo_i_program_moving = {.name = "moving", .source = svo_i_source_moving};
