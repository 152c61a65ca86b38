/* SPDX-License-Identifier: MIT */
/* The programs of kernels/compact. */
#include "compact/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_compact[];
extern const char svo_i_source_minimize[];
extern const char svo_i_source_expand[];

const svo_i_program svo_i_program_compact = {.name = "compact", .source = svo_i_source_compact};
const svo_i_program svo_i_program_minimize = {.name = "minimize", .source = svo_i_source_minimize};
const svo_i_program svo_i_program_expand = {.name = "expand", .source = svo_i_source_expand};
